// SPDX-License-Identifier: Apache-2.0
// The only table of options, and how the value of a row is parsed and printed.
#include "render/options_table.h"

#include <ctype.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"

#define AT(field) offsetof(satin_options, field)

const struct option options_table[] = {
    {"quality", OPTION_CHOICE, AT(quality), false, "draft|preview|production",
     "Preset of samples, photons and accuracies, which every single option overrides. A time limit "
     "chooses these values itself, as functions of the time per pixel through the presets."},
    {"integrator", OPTION_CHOICE, AT(integrator), false, "two-pass|path|direct|photons|sppm",
     "The algorithm: photon maps and cached final gathering (two-pass), path tracing as the "
     "reference (path), emitted and direct light alone (direct), the radiance of the photon map "
     "itself "
     "(photons), or stochastic progressive photon mapping, a reference for caustics that path "
     "tracing does not find (sppm)."},
    {"first-pass", OPTION_CHOICE, AT(first_pass), false,
     "precomputed|photons|path|none|recursive|reverse",
     "The radiance that a gather ray reads at its hit: from irradiance precomputed at photons "
     "(precomputed), by a density estimate (photons), by path tracing from the hit (path), direct "
     "light alone (none), or direct light and the records of the next bounce (recursive). With "
     "reverse, irradiance is precomputed at the first batch of photons, and further batches are "
     "added to it and freed, so that photons need not fit into memory."},
    {"spp", OPTION_INT, AT(spp), false, "0..1048576",
     "Samples per pixel; of integrator sppm, passes. With 0 a time limit decides; without a time "
     "limit, integrators path and sppm take the scene's number, and the others take 9, 25 or 64 by "
     "the quality."},
    {"adaptive-sampling", OPTION_BOOL, AT(adaptive_sampling), false, "off|on",
     "Three quarters of the samples go to noisy pixels, so that spp is the mean. If off, with "
     "integrators path and sppm, or with a film filter that has negative values, every pixel gets "
     "spp samples."},
    {"denoise", OPTION_BOOL, AT(denoise), false, "off|on",
     "Denoises reflected light, with albedo and normals as auxiliary images, as far as noise "
     "explains what that changes: light that records carry has little, and is changed little. "
     "Emitters that are seen are not changed. The noisy image is kept in channels of its own. "
     "It needs Open Image Denoise 2: `./bootstrap denoiser` installs it, or the environment "
     "variable SATIN_OIDN names its file. It gets at most half of a time limit."},
    {"width", OPTION_INT, AT(width), false, "0..65536",
     "Width of the whole film in pixels; 0 is the scene's, or follows from the height by the "
     "scene's "
     "aspect ratio. A crop window of the scene is scaled with the film and shows the same region; "
     "its borders are rounded to whole pixels."},
    {"height", OPTION_INT, AT(height), false, "0..65536",
     "Height of the whole film in pixels, likewise."},
    {"crop-x", OPTION_INT, AT(crop_x), false, "0..65535",
     "First column of the film that is rendered, if any of the four options of a crop is not 0."},
    {"crop-y", OPTION_INT, AT(crop_y), false, "0..65535",
     "First row of the film that is rendered, likewise."},
    {"crop-width", OPTION_INT, AT(crop_width), false, "0..65536",
     "Width of the part of the film that is rendered, in pixels; 0 is all from crop-x on. Without "
     "a crop, the scene's crop window is rendered."},
    {"crop-height", OPTION_INT, AT(crop_height), false, "0..65536",
     "Height of the part of the film that is rendered, in pixels; 0 is all from crop-y on."},
    {"seed", OPTION_SEED, AT(seed), false, "0..18446744073709551615",
     "Seed of all random numbers. Another seed gives an image with independent noise."},
    {"threads", OPTION_INT, AT(threads), false, "0..1024",
     "Number of threads; 0 is one per core. The image does not depend on it."},
    {"time", OPTION_DOUBLE, AT(time), false, "0..1e9",
     "Time limit in wall seconds for the whole render, which then ends with the best image so far; "
     "0 is no limit. Pixels without a sample get the values of their neighbours. A coarse "
     "first image and writing are never left out: they take .2 s, and .5 s more per million "
     "pixels. If a sixteenth of the photons takes more than half of the limit, two passes "
     "are replaced by path tracing, with a warning; integrators photons and sppm take the photons "
     "that fit."},
    {"memory", OPTION_BYTES, AT(memory), false, "0..1P",
     "Limit of the memory of the process in bytes, with K, M, G or T for 2^10, 2^20, 2^30 or 2^40 "
     "of them, such as 4G; 0 is no limit. Photons and records, and threads, are as many as fit, "
     "textures become coarser, the largest first, until they take at most half, and where a sky "
     "is visible is learned if that fits. A scene and an image that do not fit are refused, with "
     "the bytes that they need, before the render begins. Reading meshes, checkpoints, several "
     "processes and Open Image Denoise may need more. Textures do not change if a scene sets this, "
     "as they are read before."},
    {"max-depth", OPTION_INT, AT(max_depth), false, "-2..1000000",
     "Length of the longest light path in segments: 0 is a black image, 1 emitted light alone, 2 "
     "direct light too. -1 is no limit, and -2 the scene's limit, if it has one."},
    {"rr-depth", OPTION_INT, AT(rr_depth), false, "0..1000000",
     "Path depth at which Russian roulette starts; 0 is the scene's, or 5 if it has none."},
    {"hide-emitters", OPTION_INT, AT(hide_emitters), false, "-1..1",
     "Whether emitters that are seen directly are black: 1 is yes, 0 is no, and -1 is as the scene "
     "has it, or no."},
    {"light-samples", OPTION_INT, AT(light_samples), true, "1..1024",
     "Light samples at the first hit of an eye ray, and BRDF samples of each glossy lobe that find "
     "lights there, for the first samples of each pixel. Later samples take 2 to 16 of either, the "
     "number with the least noise for its cost. If adaptive-sampling is off, all samples take this "
     "number. A time limit of less than 32 microseconds of a core for each pixel makes it less."},
    {"glossy-samples", OPTION_INT, AT(glossy_samples), true, "1..256",
     "Gather rays per pixel sample for glossy reflection that is not cached. With a time limit it "
     "is 2, or 1 if the image is denoised, unless the user sets another number."},

    {"photons", OPTION_COUNT, AT(photons), true, "0..1000000000000",
     "Photon paths for the global map; of integrator sppm, in each pass. A number that a quality "
     "sets grows up to eightfold if few photons of indirect light are stored, and up to 2.5 times "
     "in a large image that is not denoised, and falls if a path stores more than 16; another "
     "number that the user sets does not, nor does that of sppm."},
    {"caustic-photons", OPTION_COUNT, AT(caustic_photons), true, "0..1000000000000",
     "Photon paths for the caustic map; of integrator sppm, in each pass. 0 is no caustics. A "
     "number that a quality sets grows up to fourfold in a large image where caustics are much of "
     "the light; another number that the user sets does not, nor does that of sppm."},
    {"photon-batch", OPTION_COUNT, AT(photon_batch), false, "1..1000000000000",
     "Photon paths that first pass reverse traces at a time. The first batch decides where "
     "irradiance is precomputed and the radius of its estimates, and memory grows with it."},
    {"photon-k", OPTION_INT, AT(photon_k), false, "10..10000",
     "Number of photons in a density estimate of the global map; of integrator sppm, in its "
     "initial pass, after which estimates become smaller. Light is 3 % too bright by 10, and "
     "within .3 % from 20 on."},
    {"caustic-k", OPTION_INT, AT(caustic_k), false, "10..10000",
     "Number of photons in a density estimate of the caustic map, for sppm likewise."},
    {"caustic-smooth", OPTION_BOOL, AT(caustic_smooth), false, "off|on",
     "Averages estimates of the caustic map over a wider neighbourhood where they differ by no "
     "more than their noise."},
    {"recursive-bounces", OPTION_INT, AT(recursive_bounces), false, "1..8",
     "Number of indirect bounces for which first pass recursive makes records; the first is where "
     "gather rays from what the image shows hit. Beyond the last of them it traces paths."},
    {"photon-area", OPTION_BOOL, AT(photon_area), false, "off|on",
     "Divides density estimates by the area of the surface that lies inside the disc, not by the "
     "area of the disc."},

    {"final-gather", OPTION_BOOL, AT(final_gather), false, "off|on",
     "Gathers indirect light at what is seen. If off, the image shows the first pass directly: all "
     "light is what a gather ray reads where it hits. First pass path then is integrator path, and "
     "none is integrator direct."},
    {"gather-near", OPTION_BOOL, AT(gather_near), false, "off|on",
     "Gather rays whose hit is nearer than the photon lookup radius continue by diffuse bounces, "
     "until a segment is longer than the diameter of the lookup at its end."},
    {"gather-direct", OPTION_BOOL, AT(gather_direct), false, "off|on",
     "Direct light at the hits of gather rays comes from light samples, drawn there or where "
     "irradiance is precomputed. If off, it comes from photons."},
    {"refine-lookups", OPTION_BOOL, AT(refine_lookups), false, "off|on",
     "Gathers precomputed irradiance anew where glossy lobes of what is seen read it so often that "
     "the noise of its photons shows. It has an effect with integrator two-pass and "
     "gather-direct."},
    {"guide-clusters", OPTION_BOOL, AT(guide_clusters), false, "off|on",
     "Adds gather rays, at most half as many as a hemisphere has, towards clusters of photons, "
     "which are small and brightly lit areas. The photons that are searched for clusters are "
     "traced with the others, which have other paths then."},
    {"guide-visibility", OPTION_BOOL, AT(guide_visibility), false, "off|on",
     "Samples direct light by the fraction of each light that is visible near the point, for "
     "example of the sky through windows, and starts photons of the sky and of the sun through "
     "these openings. It has an effect with integrator two-pass."},
    {"noise-filter", OPTION_BOOL, AT(noise_filter), false, "off|on",
     "Averages direct light, and glossy light that no record carries, over pixels up to 5 away "
     "that look the same within their noise, by non-local means. It has an effect with integrator "
     "two-pass, if the image is not denoised and if it takes less than a quarter of a time limit."},
    {"edge-rays", OPTION_INT, AT(edge_rays), false, "0..1024",
     "Eye rays, or more, that find how much of a pixel each surface at an edge covers, for which "
     "its light is corrected, with integrator two-pass if the image is not denoised."},
    {"texture-filter", OPTION_BOOL, AT(texture_filter), false, "off|on",
     "Averages bitmaps over the footprint of an eye ray or gather ray, and widens glossy lobes at "
     "the hits of a record's rays to the solid angle for which the ray stands. Integrator path "
     "does neither."},

    {"irradiance-cache", OPTION_BOOL, AT(irradiance_cache), false, "off|on",
     "Interpolates diffuse indirect light between records. If off, every sample gathers."},
    {"irradiance-filter", OPTION_BOOL, AT(irradiance_filter), false, "off|on",
     "Where no record is near, averages the irradiance that samples gather over the pixels "
     "around, until they have half of irradiance-rays: over 3.75 % of the film's longer side, but "
     "at most 32 pixels, and at least the radius at which the least records are read "
     "(irradiance-min-pixels times irradiance-widen). It has no effect if the image is denoised, "
     "or if it would take more than a tenth of a time limit."},
    {"irradiance-gradients", OPTION_CHOICE, AT(irradiance_gradients), false,
     "none|stratified|solid-angle|differences|ward-heckbert",
     "Translational gradients of irradiance records: none, from the light that crosses the "
     "boundaries of strata (stratified), from the change of the solid angles of the hit surfaces "
     "in closed form (solid-angle) or by finite differences (differences), or from strata with the "
     "weights of Ward and Heckbert (ward-heckbert)."},
    {"irradiance-rays", OPTION_INT, AT(irradiance_rays), true, "4..1048576",
     "Number of gather rays of an irradiance record."},
    {"irradiance-noise", OPTION_FLOAT, AT(irradiance_noise), false, "0..1",
     "Target noise of a record: the standard deviation over the irradiance. A record gets between "
     "a quarter of irradiance-rays and four times as many, by the variance measured at the records "
     "around it. With 0 all records get irradiance-rays."},
    {"irradiance-a", OPTION_FLOAT, AT(irradiance_a), true, "0.01..2",
     "Accuracy a with which the irradiance cache is filled; a smaller a means more records."},
    {"irradiance-widen", OPTION_FLOAT, AT(irradiance_widen), true, "1..2",
     "The image pass interpolates irradiance with this factor times the accuracy a."},
    {"irradiance-radius", OPTION_CHOICE, AT(irradiance_radius), false,
     "harmonic|least|tabellion|hessian",
     "How the radius R of a record is computed: as the harmonic mean of the distances of "
     "its hits (harmonic), as the least distance (least), as the least without grazing rays "
     "(tabellion), or as an ellipse from the Hessian of the irradiance (hessian)."},
    {"irradiance-gradient-clamp", OPTION_BOOL, AT(irradiance_gradient_clamp), false, "off|on",
     "Limits the radius R of a record to the distance at which its gradient is valid."},
    {"irradiance-neighbour-clamp", OPTION_BOOL, AT(irradiance_neighbour_clamp), false, "off|on",
     "Limits the difference between the radii R of two records to their distance."},
    {"irradiance-min-pixels", OPTION_FLOAT, AT(irradiance_min_pixels), true, "0..1000",
     "Least influence radius a R of an irradiance record in projected pixels. With a time limit it "
     "is from 4 to 1.5, by the time per pixel. irradiance-max-pixels and record-max-radius take "
     "precedence."},
    {"irradiance-max-pixels", OPTION_FLOAT, AT(irradiance_max_pixels), false, "1..100000",
     "Largest influence radius a R of an irradiance record in projected pixels. At most an eighth "
     "of the film's longer side, or 8."},

    {"radiance-cache", OPTION_BOOL, AT(radiance_cache), false, "off|on",
     "Interpolates glossy indirect light between records. If off, every sample gathers."},
    {"radiance-gradients", OPTION_CHOICE, AT(radiance_gradients), false,
     "none|stratified|solid-angle|differences",
     "Translational gradients of radiance records, as irradiance-gradients. Stratified gradients "
     "include changes of occlusion."},
    {"radiance-diffuse", OPTION_BOOL, AT(radiance_diffuse), false, "off|on",
     "Uses radiance records instead of irradiance records on diffuse surfaces too, for "
     "comparison."},
    {"radiance-basis", OPTION_CHOICE, AT(radiance_basis), false, "hsh|sh",
     "Harmonics of radiance records: hemispherical (hsh) or spherical (sh)."},
    {"radiance-order", OPTION_INT, AT(radiance_order), true, "1..14",
     "Largest order n of a radiance record. Order n has n * n coefficients."},
    {"radiance-error", OPTION_FLOAT, AT(radiance_error), false, "0.0001..1",
     "Largest relative error of the radiance that a BRDF in harmonics reflects, under light as it "
     "is in rooms. BRDFs with a larger error are sampled instead."},
    {"radiance-rotation", OPTION_FLOAT, AT(radiance_rotation), false, "0..4",
     "Angle between normals [rad] up to which records are aligned by the fast approximate "
     "rotation; 0 is never."},
    {"radiance-rays", OPTION_INT, AT(radiance_rays), true, "4..1048576",
     "Number of gather rays of a radiance record. Half of them are drawn by the glossy lobes of "
     "its "
     "site."},
    {"radiance-noise", OPTION_FLOAT, AT(radiance_noise), false, "0..1",
     "Target noise of a radiance record, as irradiance-noise, for the vector of its coefficients."},
    {"radiance-a", OPTION_FLOAT, AT(radiance_a), true, "0.01..2",
     "Accuracy a with which the radiance cache is filled; a smaller a means more records."},
    {"radiance-widen", OPTION_FLOAT, AT(radiance_widen), true, "1..2",
     "The image pass interpolates radiance with this factor times the accuracy a."},
    {"radiance-radius", OPTION_CHOICE, AT(radiance_radius), false, "harmonic|least|tabellion",
     "How the radius R of a record is computed, as irradiance-radius."},
    {"radiance-gradient-clamp", OPTION_BOOL, AT(radiance_gradient_clamp), false, "off|on",
     "Limits the radius R of a record to the distance at which its gradient is valid."},
    {"radiance-curvature-clamp", OPTION_BOOL, AT(radiance_curvature_clamp), false, "off|on",
     "Limits the radius R of a record to the distance within which the light that its surface "
     "reflects to the eye is almost linear."},
    {"radiance-neighbour-clamp", OPTION_BOOL, AT(radiance_neighbour_clamp), false, "off|on",
     "Limits the difference between the radii R of two records to their distance."},
    {"radiance-min-pixels", OPTION_FLOAT, AT(radiance_min_pixels), true, "0..1000",
     "Least influence radius a R of a radiance record in projected pixels. radiance-max-pixels and "
     "record-max-radius take precedence."},
    {"radiance-max-pixels", OPTION_FLOAT, AT(radiance_max_pixels), false, "1..100000",
     "Largest influence radius a R of a radiance record in projected pixels."},

    {"adaptive-cache", OPTION_BOOL, AT(adaptive_cache), false, "off|on",
     "Shrinks and adds records until no two of them disagree perceptibly at a point that is seen. "
     "A render with a time limit refines records in rounds instead."},
    {"origin-shift", OPTION_BOOL, AT(origin_shift), false, "off|on",
     "Moves the positions of records away from the edges of triangles, by at most half a pixel."},
    {"record-max-radius", OPTION_FLOAT, AT(record_max_radius), false, "0..1e30",
     "Largest radius R of all records, in scene units. It takes precedence over radii in "
     "pixels; 0 is no limit."},
    {"gather-radius-ratio", OPTION_FLOAT, AT(gather_radius_ratio), false, "0..1",
     "The image pass gathers instead of interpolating where the radius R that records should have "
     "is below this fraction of the least R, as near contacts of surfaces, and records disagree by "
     "more than the noise of gathering; 0 is nowhere."},
    {"leak-test", OPTION_BOOL, AT(leak_test), false, "off|on",
     "Records do not contribute to points from which a wall separates them."},
    {"record-maps", OPTION_BOOL, AT(record_maps), false, "off|on",
     "Adds channels to the image that show the records, for `satin maps`."},
    {"cryptomatte", OPTION_CHOICE, AT(cryptomatte), false, "off|object|material|both",
     "Adds Cryptomatte layers, by which other programs mask objects (shapes and instances, by "
     "their ids) or "
     "materials (by the ids of their BRDFs), whatever layers there are beside."},
    {"layers", OPTION_TEXT, AT(layers), false, "NAME,...",
     "Layers that the image has beside the beauty, such as direct,albedo; fewer layers take less "
     "memory and a smaller file. Without a name it has all, and with none, the beauty alone."},
    {"material-cache", OPTION_TEXT, AT(material_cache), false, "NAME=on|off,...",
     "Materials, by the ids of their BRDFs, whose gloss is always cached (on) or always sampled "
     "(off), whatever radiance-error is. The name material.NAME.cache, with value on or off, adds "
     "one material."},
};
const int options_table_count = sizeof options_table / sizeof *options_table;

const struct option *options_find(const char *name) {
    for (int i = 0; i < options_table_count; i++)
        if (text_same_name(options_table[i].name, name)) return &options_table[i];
    return NULL;
}

// Names of options in earlier versions, and their names now.
static const struct {
    const char *before, *now;
} renamed[] = {
    {"adaptive", "adaptive-sampling"},      {"gather-bounce", "gather-near"},
    {"gather-guide", "guide-clusters"},     {"gather-room", "gather-radius-ratio"},
    {"gather-shadow", "gather-direct"},     {"irradiance-neighbours", "irradiance-neighbour-clamp"},
    {"light-guide", "guide-visibility"},    {"radiance-neighbours", "radiance-neighbour-clamp"},
    {"radiance-turn", "radiance-rotation"}, {"recursive-levels", "recursive-bounces"},
};

const char *options_renamed(const char *name) {
    for (size_t i = 0; i < sizeof renamed / sizeof *renamed; i++)
        if (text_same_name(renamed[i].before, name)) return renamed[i].now;
    return NULL;
}

static void *field(const struct option *option, satin_options *options) {
    return (char *)options + option->offset;
}

static bool parse_word(const char *range, const char *value, int *out) {
    char word[32];
    for (int i = 0; *range; i++) {
        size_t n = strcspn(range, "|");
        snprintf(word, sizeof word, "%.*s", (int)n, range);
        if (text_same_name(word, value)) {
            *out = i;
            return true;
        }
        range += n + (range[n] == '|');
    }
    return false;
}

static bool parse_bool(const char *value, int *out) {
    return parse_word("off|on", value, out) || parse_word("false|true", value, out) ||
           parse_word("no|yes", value, out) || parse_word("0|1", value, out);
}

// Reads all 64 bits, for which a double is too short.
static bool parse_seed(const char *value, uint64_t *out) {
    if (!value[0] || strspn(value, "0123456789") != strlen(value)) return false;
    uint64_t seed = 0;
    for (; *value; value++) {
        uint64_t digit = (uint64_t)(*value - '0');
        if (seed > (UINT64_MAX - digit) / 10) return false;
        seed = 10 * seed + digit;
    }
    *out = seed;
    return true;
}

static const char byte_units[] = "KMGTP";

// Reads a number of bytes with at most one unit after it, which may be followed by B or iB.
static bool parse_bytes(const char *value, double *out) {
    char digits[32];
    const size_t length = strspn(value, "0123456789.");
    if (length == 0 || length >= sizeof digits) return false;
    snprintf(digits, sizeof digits, "%.*s", (int)length, value);
    if (!text_double(digits, out)) return false;
    const char *unit = value + length;
    const char *known = *unit ? strchr(byte_units, toupper((unsigned char)*unit)) : NULL;
    if (known) {
        *out = ldexp(*out, 10 * (int)(known - byte_units + 1));
        unit++;
    }
    if (known && strncmp(unit, "iB", 2) == 0) unit++;
    if (*unit == 'B') unit++;
    *out = ceil(*out);  // a fraction of a byte is not 0, which is no limit
    return *unit == 0;
}

// Prints the bytes with the largest unit of which they are a multiple.
static void print_bytes(int64_t value, char *out, size_t bytes) {
    int unit = 0;
    while (value && value % 1024 == 0 && byte_units[unit]) {
        value /= 1024;
        unit++;
    }
    const char suffix[2] = {unit > 0 ? byte_units[unit - 1] : '\0'};
    snprintf(out, bytes, "%" PRId64 "%s", value, suffix);
}

// Reads words NAME=on or NAME=off, separated by commas.
static bool parse_materials(const char *value, char *out) {
    size_t length = strlen(value);
    if (length >= OPTION_TEXT_SIZE) return false;
    for (const char *at = value; *at;) {
        size_t word = strcspn(at, ","), name = strcspn(at, "=");
        bool on = name + 3 == word && strncmp(at + name, "=on", 3) == 0;
        bool off = name + 4 == word && strncmp(at + name, "=off", 4) == 0;
        if (name == 0 || !(on || off)) return false;
        at += word + (at[word] == ',');
    }
    memcpy(out, value, length + 1);
    return true;
}

// Reads words with commas between them, none of them empty.
static bool parse_names(const char *value, char *out) {
    const size_t length = strlen(value);
    if (length >= OPTION_TEXT_SIZE || value[strcspn(value, " \t\r\n=")]) return false;
    if (value[0] == ',' || strstr(value, ",,") || (length && value[length - 1] == ','))
        return false;
    memcpy(out, value, length + 1);
    return true;
}

// Reads a bound of a range.
static bool parse_bound(const struct option *option, const char *text, double *out) {
    return option->kind == OPTION_BYTES ? parse_bytes(text, out) : text_double(text, out);
}

// The least and the highest value, read from the text of the range.
static double lowest_value(const struct option *option) {
    char low[32];
    double bound;
    snprintf(low, sizeof low, "%.*s", (int)(strstr(option->range, "..") - option->range),
             option->range);
    return parse_bound(option, low, &bound) ? bound : -INFINITY;
}

double option_highest(const struct option *option) {
    double bound;
    return parse_bound(option, strstr(option->range, "..") + 2, &bound) ? bound : INFINITY;
}

bool option_parse(const struct option *option, const char *value, satin_options *options) {
    void *out = field(option, options);
    double number = 0.0;
    int word = 0;
    if (option->kind == OPTION_SEED) return parse_seed(value, out);
    if (option->kind == OPTION_TEXT)
        return strchr(option->range, '=') ? parse_materials(value, out) : parse_names(value, out);
    if (option->kind == OPTION_CHOICE) {
        if (!parse_word(option->range, value, &word)) return false;
        memcpy(out, &word, sizeof word);  // an enum of the public header has the size of int
        return true;
    }
    if (option->kind == OPTION_BOOL) {
        if (!parse_bool(value, &word)) return false;
        *(bool *)out = word;
        return true;
    }
    if (!parse_bound(option, value, &number)) return false;
    if (number < lowest_value(option) || number > option_highest(option)) return false;
    if (option->kind == OPTION_FLOAT) {
        *(float *)out = (float)number;
        return true;
    }
    if (option->kind == OPTION_DOUBLE) {
        *(double *)out = number;
        return true;
    }
    if (number != floor(number)) return false;
    if (option->kind == OPTION_INT)
        *(int *)out = (int)number;
    else
        *(int64_t *)out = (int64_t)number;
    return true;
}

static void print_word(const char *range, int index, char *out, size_t bytes) {
    for (; index > 0 && *range; index--) {
        range += strcspn(range, "|");
        range += *range == '|';
    }
    snprintf(out, bytes, "%.*s", (int)strcspn(range, "|"), range);
}

void option_print(const struct option *option, const satin_options *options, char *out,
                  size_t bytes) {
    const void *in = (const char *)options + option->offset;
    int word = 0;
    switch (option->kind) {
        case OPTION_CHOICE:
            memcpy(&word, in, sizeof word);
            print_word(option->range, word, out, bytes);
            break;
        case OPTION_BOOL:
            print_word("off|on", *(const bool *)in, out, bytes);
            break;
        case OPTION_INT:
            snprintf(out, bytes, "%d", *(const int *)in);
            break;
        case OPTION_COUNT:
            snprintf(out, bytes, "%" PRId64, *(const int64_t *)in);
            break;
        case OPTION_BYTES:
            print_bytes(*(const int64_t *)in, out, bytes);
            break;
        case OPTION_SEED:
            snprintf(out, bytes, "%" PRIu64, *(const uint64_t *)in);
            break;
        case OPTION_FLOAT: {
            // The shortest form that is read back as the same float.
            float value = *(const float *)in;
            for (int digits = 6; digits <= 9; digits++) {
                snprintf(out, bytes, "%.*g", digits, (double)value);
                if (strtof(out, NULL) == value) break;
            }
            break;
        }
        case OPTION_TEXT:
            snprintf(out, bytes, "%s", (const char *)in);
            break;
        case OPTION_DOUBLE: {
            double value = *(const double *)in;
            for (int digits = 6; digits <= 17; digits++) {
                snprintf(out, bytes, "%.*g", digits, value);
                if (strtod(out, NULL) == value) break;
            }
            break;
        }
    }
}
