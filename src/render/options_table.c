// SPDX-License-Identifier: Apache-2.0
// The one table of options, and how a row of it is read and printed.
#include "render/options_table.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"

#define AT(field) offsetof(satin_options, field)

const struct option options_table[] = {
    {"quality", OPTION_CHOICE, AT(quality), false, "draft|preview|production",
     "Preset of samples, photons and accuracies; every single option overrides it. A time limit "
     "chooses them itself, along the curve of which the presets are points."},
    {"integrator", OPTION_CHOICE, AT(integrator), false, "two-pass|path|direct|photons",
     "Photon map and cached final gathering; path tracing, the reference; emitted and direct light "
     "alone; the photon map seen directly."},
    {"first-pass", OPTION_CHOICE, AT(first_pass), false, "precomputed|photons|path|none|recursive",
     "What a gather ray reads where it hits: irradiance precomputed at photons, a density estimate "
     "there, path tracing from there, direct light alone, or direct light and records of the next "
     "bounce."},
    {"spp", OPTION_INT, AT(spp), false, "0..1048576",
     "Samples per pixel; 0: as many as a time limit allows; without one the scene's for path, else "
     "9, 16 or 36 by the quality."},
    {"adaptive-sampling", OPTION_BOOL, AT(adaptive_sampling), false, "off|on",
     "spp is the mean: three quarters of the samples go where the image is noisy; off, and with "
     "path, or where the film's filter is negative somewhere, always: the same number to every "
     "pixel."},
    {"denoise", OPTION_BOOL, AT(denoise), false, "off|on",
     "Denoises the light that no record carries, with the help of albedo and normal: direct light, "
     "caustics, gloss that is not cached, gathering without records; with path all that is "
     "reflected. Interpolated light and emitters that are seen stay as they are; the noisy image "
     "stays as channels. It needs Open Image Denoise 2: `./bootstrap denoiser` gets it, or the "
     "environment variable SATIN_OIDN names the file. Of a time limit it gets half at most."},
    {"width", OPTION_INT, AT(width), false, "0..65536", "Film width in pixels; 0: the scene's."},
    {"height", OPTION_INT, AT(height), false, "0..65536", "Film height in pixels; 0: the scene's."},
    {"seed", OPTION_SEED, AT(seed), false, "0..18446744073709551615",
     "Seed of all random numbers; another seed gives an independent image."},
    {"threads", OPTION_INT, AT(threads), false, "0..1024",
     "Threads; 0: one per core. The image does not depend on it."},
    {"time", OPTION_DOUBLE, AT(time), false, "0..1e9",
     "Wall seconds for the whole render, which then ends with the best image so far, pixels "
     "without a sample filled from their neighbours; 0: no limit. A first look and the writing are "
     "never left out: they take .2 s, and .5 s more per million pixels. Where a sixteenth of the "
     "photons takes more than half of it, the image is path-traced, with a warning."},
    {"max-depth", OPTION_INT, AT(max_depth), false, "-2..1000000",
     "Longest light path in path segments, 1: emission alone, 0: black; -1: no limit; -2: the "
     "scene's, else no limit."},
    {"rr-depth", OPTION_INT, AT(rr_depth), false, "0..1000000",
     "Path depth at which Russian roulette starts; 0: the scene's, else 5."},
    {"hide-emitters", OPTION_INT, AT(hide_emitters), false, "-1..1",
     "1: emitters seen directly are black; 0: they are not; -1: the scene's, else 0."},
    {"light-samples", OPTION_INT, AT(light_samples), true, "1..1024",
     "Light samples at the first hit of each of a pixel's first samples; later ones take 2 to 16, "
     "as many as cost least by the noise of lights and of all else. With adaptive-sampling off all "
     "take "
     "these."},
    {"glossy-samples", OPTION_INT, AT(glossy_samples), true, "1..256",
     "Gather rays per pixel sample for glossy reflection that is not cached."},

    {"photons", OPTION_COUNT, AT(photons), true, "0..1000000000000",
     "Photon paths emitted for the global map; the number of a quality, not another, grows up to "
     "eightfold where few photons of indirect light are kept."},
    {"caustic-photons", OPTION_COUNT, AT(caustic_photons), true, "0..1000000000000",
     "Photon paths emitted for the caustic map; 0: no caustics."},
    {"photon-k", OPTION_INT, AT(photon_k), false, "1..10000",
     "Photons in one density estimate of the global map."},
    {"caustic-k", OPTION_INT, AT(caustic_k), false, "1..10000",
     "Photons in one density estimate of the caustic map."},
    {"caustic-smooth", OPTION_BOOL, AT(caustic_smooth), false, "off|on",
     "Estimates of the caustic map that differ by no more than noise are averaged over a wider "
     "neighbourhood."},
    {"recursive-bounces", OPTION_INT, AT(recursive_bounces), false, "1..8",
     "Indirect bounces that first pass recursive keeps records for, counted from the image; from "
     "the last of them on it traces paths."},
    {"photon-area", OPTION_BOOL, AT(photon_area), false, "off|on",
     "Divide density estimates by the surface that is really there, not by the whole disc."},

    {"gather-near", OPTION_BOOL, AT(gather_near), false, "off|on",
     "Gather rays that hit nearer than the photon lookup radius go on for one more bounce."},
    {"gather-direct", OPTION_BOOL, AT(gather_direct), false, "off|on",
     "Direct light at gather hits by light samples, there or where photons' irradiance is "
     "precomputed; off: by photons."},
    {"guide-clusters", OPTION_BOOL, AT(guide_clusters), false, "off|on",
     "Hemispheres get more rays, up to half as many again, towards clusters of photons, where "
     "light comes down densely."},
    {"guide-visibility", OPTION_BOOL, AT(guide_visibility), false, "off|on",
     "Direct light is sampled by what is visible of the lights around a point, as of the sky "
     "through windows; with integrator two-pass."},
    {"texture-filter", OPTION_BOOL, AT(texture_filter), false, "off|on",
     "Colours from bitmaps are averaged over the footprint of an eye ray or gather ray, and rays "
     "of records see glossy lobes as at least as wide as the directions for which they stand; "
     "integrator path takes both as they are."},

    {"irradiance-cache", OPTION_BOOL, AT(irradiance_cache), false, "off|on",
     "Interpolate diffuse indirect light between records; off: gather at every sample."},
    {"irradiance-gradients", OPTION_CHOICE, AT(irradiance_gradients), false,
     "none|stratified|solid-angle|differences|ward-heckbert",
     "Gradients by which irradiance records are interpolated: none; by the light that crosses the "
     "boundaries of strata; by how the solid angles of what was hit change, in closed form or by "
     "finite differences; or by strata as Ward and Heckbert weigh them."},
    {"irradiance-rays", OPTION_INT, AT(irradiance_rays), true, "4..1048576",
     "Gather rays per irradiance record."},
    {"irradiance-noise", OPTION_FLOAT, AT(irradiance_noise), false, "0..1",
     "Noise of a record, as standard deviation over E, for which it gets rays: from a quarter of "
     "irradiance-rays to four times as many, by the variance that the records around it have "
     "measured; 0: all get irradiance-rays."},
    {"irradiance-a", OPTION_FLOAT, AT(irradiance_a), true, "0.01..2",
     "Error a at which the irradiance cache is filled; less means more records."},
    {"irradiance-widen", OPTION_FLOAT, AT(irradiance_widen), true, "1..2",
     "The image pass interpolates irradiance with the error a times this."},
    {"irradiance-radius", OPTION_CHOICE, AT(irradiance_radius), false,
     "harmonic|least|tabellion|hessian",
     "How the radius of a record is found: the harmonic mean or the least distance of what its "
     "rays hit, the least without grazing rays, or from the Hessian of its irradiance, elliptic."},
    {"irradiance-gradient-clamp", OPTION_BOOL, AT(irradiance_gradient_clamp), false, "off|on",
     "The radius of a record is limited to where its gradient holds."},
    {"irradiance-neighbour-clamp", OPTION_BOOL, AT(irradiance_neighbour_clamp), false, "off|on",
     "Radii of neighbouring records differ by no more than their distance."},
    {"irradiance-min-pixels", OPTION_FLOAT, AT(irradiance_min_pixels), true, "0..1000",
     "Least radius of an irradiance record in projected pixels; where it is more than the largest "
     "or than record-max-radius allows, those hold."},
    {"irradiance-max-pixels", OPTION_FLOAT, AT(irradiance_max_pixels), false, "1..100000",
     "Largest radius of an irradiance record in projected pixels."},

    {"radiance-cache", OPTION_BOOL, AT(radiance_cache), false, "off|on",
     "Interpolate glossy indirect light between records; off: gather at every sample."},
    {"radiance-gradients", OPTION_CHOICE, AT(radiance_gradients), false,
     "none|stratified|solid-angle|differences",
     "Gradients by which radiance records are interpolated, as for irradiance-gradients; "
     "stratified ones include changes in occlusion."},
    {"radiance-diffuse", OPTION_BOOL, AT(radiance_diffuse), false, "off|on",
     "Diffuse surfaces use radiance records too, instead of irradiance records; for comparison."},
    {"radiance-basis", OPTION_CHOICE, AT(radiance_basis), false, "hsh|sh",
     "Harmonics of radiance records: on the hemisphere or on the sphere."},
    {"radiance-order", OPTION_INT, AT(radiance_order), true, "1..14",
     "Largest order n of a radiance record, which then has n * n coefficients."},
    {"radiance-error", OPTION_FLOAT, AT(radiance_error), false, "0.0001..1",
     "Largest relative error of what a BRDF reflects in harmonics, expected of the light of "
     "rooms; glossier ones are sampled instead."},
    {"radiance-rotation", OPTION_FLOAT, AT(radiance_rotation), false, "0..4",
     "Angle of normals [rad] up to which records are aligned by the fast rotation; 0: none."},
    {"radiance-rays", OPTION_INT, AT(radiance_rays), true, "4..1048576",
     "Gather rays per radiance record."},
    {"radiance-noise", OPTION_FLOAT, AT(radiance_noise), false, "0..1",
     "As irradiance-noise, for radiance records and the vector of their coefficients."},
    {"radiance-a", OPTION_FLOAT, AT(radiance_a), true, "0.01..2",
     "Error a at which the radiance cache is filled; less means more records."},
    {"radiance-widen", OPTION_FLOAT, AT(radiance_widen), true, "1..2",
     "The image pass interpolates radiance with the error a times this."},
    {"radiance-radius", OPTION_CHOICE, AT(radiance_radius), false, "harmonic|least|tabellion",
     "How the radius of a record is found, as for irradiance-radius."},
    {"radiance-gradient-clamp", OPTION_BOOL, AT(radiance_gradient_clamp), false, "off|on",
     "The radius of a record is limited to where its gradient holds."},
    {"radiance-neighbour-clamp", OPTION_BOOL, AT(radiance_neighbour_clamp), false, "off|on",
     "Radii of neighbouring records differ by no more than their distance."},
    {"radiance-min-pixels", OPTION_FLOAT, AT(radiance_min_pixels), true, "0..1000",
     "Least radius of a radiance record in projected pixels; where it is more than the largest or "
     "than record-max-radius allows, those hold."},
    {"radiance-max-pixels", OPTION_FLOAT, AT(radiance_max_pixels), false, "1..100000",
     "Largest radius of a radiance record in projected pixels."},

    {"adaptive-cache", OPTION_BOOL, AT(adaptive_cache), false, "off|on",
     "Records are shrunk and added until no two disagree visibly at a point that the eye sees. A "
     "render with a time limit refines them in rounds instead."},
    {"origin-shift", OPTION_BOOL, AT(origin_shift), false, "off|on",
     "Records are made off the edges of triangles, by half a pixel at most."},
    {"record-max-radius", OPTION_FLOAT, AT(record_max_radius), false, "0..1e30",
     "Largest R of a record of either cache, in scene units, whatever the radii in pixels; 0: no "
     "limit."},
    {"gather-radius-ratio", OPTION_FLOAT, AT(gather_radius_ratio), false, "0..1",
     "Where the radius that records should have is below this fraction of the least radius, as "
     "near contacts, the image pass gathers instead of interpolating; 0: nowhere."},
    {"leak-test", OPTION_BOOL, AT(leak_test), false, "off|on",
     "Records do not serve points that a wall hides from them."},
    {"record-maps", OPTION_BOOL, AT(record_maps), false, "off|on",
     "The image gets channels that show the records, for `satin maps`."},
    {"material-cache", OPTION_TEXT, AT(material_cache), false, "NAME=on|off,...",
     "Materials, by the ids of their BRDFs, whose gloss is cached whatever its error, or sampled; "
     "material.NAME.cache=on|off adds one."},
};
const int options_table_count = sizeof options_table / sizeof *options_table;

const struct option *options_find(const char *name) {
    for (int i = 0; i < options_table_count; i++)
        if (text_same_name(options_table[i].name, name)) return &options_table[i];
    return NULL;
}

// Names that options had in earlier versions, and those that they have now.
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

// All 64 bits, which a double does not hold.
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

// Words NAME=on or NAME=off, separated by commas.
static bool parse_text(const char *value, char *out) {
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

// The range as the numbers of its text; the dots end the first number.
static double lowest(const struct option *option) {
    char low[32];
    double bound;
    snprintf(low, sizeof low, "%.*s", (int)(strstr(option->range, "..") - option->range),
             option->range);
    return text_double(low, &bound) ? bound : -INFINITY;
}

double option_highest(const struct option *option) {
    double bound;
    return text_double(strstr(option->range, "..") + 2, &bound) ? bound : INFINITY;
}

bool option_parse(const struct option *option, const char *value, satin_options *options) {
    void *out = field(option, options);
    double number = 0.0;
    int word = 0;
    if (option->kind == OPTION_SEED) return parse_seed(value, out);
    if (option->kind == OPTION_TEXT) return parse_text(value, out);
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
    if (!text_double(value, &number)) return false;
    if (number < lowest(option) || number > option_highest(option)) return false;
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
        case OPTION_SEED:
            snprintf(out, bytes, "%" PRIu64, *(const uint64_t *)in);
            break;
        case OPTION_FLOAT: {
            // The shortest of the forms that read back to the same float.
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
