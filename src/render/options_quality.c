// SPDX-License-Identifier: Apache-2.0
// The options as functions of effort: a table of three presets, each at an effort whose time limit
// has its options, but for those that `by_time` lists. Between them options are power laws, which
// are straight lines over the logarithm of effort. With less time than the first preset takes, its
// records are coarser (render_budget.c). The efforts are about what presets take in closed rooms;
// with half of them, limits have 1.02 times the relMSE at 4 and 12 CPU seconds (geometric mean of
// six scenes, 200x200), and 1.15 times in living-room. Beyond the last preset they continue by
// powers of effort, so that many cores or much time are spent where that lowers the error. The time
// and the error of the presets, and of 16 times the effort of the last one, are in
// docs/experiments/error-against-time.md.
#include "render/options_quality.h"

#include <math.h>
#include <string.h>

#include "render/options_table.h"

// Only the fields that quality decides are used.
static const struct {
    double effort;  // core seconds per pixel
    int spp;
    satin_options options;
} preset[] = {
    [SATIN_DRAFT] = {1.2e-4,
                     9,
                     {.light_samples = 8,
                      .glossy_samples = 2,
                      .photons = 100000,
                      .caustic_photons = 200000,
                      .irradiance_rays = 400,
                      .irradiance_a = 0.3f,
                      .irradiance_widen = 2.0f,
                      .irradiance_min_pixels = 4.0f,
                      .radiance_order = 12,
                      .radiance_rays = 1000,
                      .radiance_a = 0.3f,
                      .radiance_widen = 2.0f,
                      .radiance_min_pixels = 4.0f}},
    [SATIN_PREVIEW] = {2.6e-4, 25, {OPTIONS_QUALITY_PREVIEW}},
    [SATIN_PRODUCTION] = {9e-4,
                          64,
                          {.light_samples = 8,
                           .glossy_samples = 4,
                           .photons = 1200000,
                           .caustic_photons = 2000000,
                           .irradiance_rays = 4000,
                           .irradiance_a = 0.15f,
                           .irradiance_widen = 2.0f,
                           .irradiance_min_pixels = 1.5f,
                           .radiance_order = 14,
                           .radiance_rays = 5000,
                           .radiance_a = 0.2f,
                           .radiance_widen = 1.6f,
                           .radiance_min_pixels = 2.0f}},
};
enum { PRESETS = sizeof preset / sizeof *preset };

// Beyond the last preset: its options times powers of effort over its effort. Other options are
// constant: records become finer in rounds while there is time (render_budget.c), and the
// image takes the samples that fit. By renders of 64x64, relative squared errors of cornell-glossy
// and of indirect-room:
// - Twice the rays at 16 times the effort: .86 and .84 times the error. At 4 times the effort,
//   where time does not suffice for all rounds, 1.4 times the rays: 1.3 and 1.4 times the error. So
//   rays begin to grow later.
// - Photons: 2.4 times as many changed the error by -11 and +4 %. So little gain allows a small
//   power alone; option memory limits their number besides, which this function does not.
static const struct {
    size_t offset;  // of the option's field
    double from;    // effort from which it grows, in units of that of the last preset
    double power;
} beyond[] = {
    {offsetof(satin_options, photons), 1.0, 1.0 / 3.0},
    {offsetof(satin_options, caustic_photons), 1.0, 1.0 / 3.0},
    {offsetof(satin_options, irradiance_rays), 8.0, 0.5},
    {offsetof(satin_options, radiance_rays), 8.0, 0.5},
};
enum { BEYOND = sizeof beyond / sizeof *beyond };

// Below this effort light samples fall in proportion, as few pixel samples fit. With 3 instead of 8
// at 1.25e-5 vase, sphere-on-floor and cornell-metal have .36, .40 and .44 times the error; with 6
// at 2.5e-5 six scenes have .95 times that with 8, and .85 times that with 4 (geometric means).
static const double LIGHTS_EFFORT = 3.2e-5;
// With fewer, the variance by one of them is not known.
static const double LIGHTS_LEAST = 2.0;

// Gather rays per pixel sample for glossy reflection, if the image takes the samples that fit: each
// of these has light samples, too. Measured with 4, 2 and 1 of them in two furnished rooms, relMSE
// .047, .037 and .045, .0109, .0105 and .0117. If the image is denoised, edges need samples more:
// with 1 and 4, .0086 and .0096, .0015 and .0018.
static const double TIMED_GLOSSY = 2.0, DENOISED_GLOSSY = 1.0;

// Options of time limits at the effort of a preset that are not the preset's own.
//
// At that of draft: radiance records of the preset's accuracy are 5 % of its time at most and vary
// less from seed to seed: a block of 8x8 pixels in glossy-room by 2 % instead of 11. Limits gain
// nothing by them, having finer rounds.
//
// At that of production: the image takes the samples that fit, so more photons do not lack any, and
// finer rounds follow, so records have fewer rays. With these rays and 1.5 million photons the
// preset had 1.25 times the error of a limit as long in indirect-room, now it has 1.06 times.
static const struct {
    satin_quality quality;
    size_t offset;  // of the option's field
    double value;
} by_time[] = {
    {SATIN_DRAFT, offsetof(satin_options, radiance_a), 0.4},
    {SATIN_PRODUCTION, offsetof(satin_options, photons), 2500000.0},
    {SATIN_PRODUCTION, offsetof(satin_options, caustic_photons), 4000000.0},
    {SATIN_PRODUCTION, offsetof(satin_options, irradiance_rays), 2000.0},
};
enum { BY_TIME = sizeof by_time / sizeof *by_time };

// Photons serve the whole image, so their number depends on its total time; that of the presets on
// the time of an image of this many pixels.
static const double PRESET_PIXELS = 80000.0;

int options_quality_spp(satin_quality quality) { return preset[quality].spp; }

// ---- A field of an option -----------------------------------------------------------------------

static void *preset_field(satin_options *options, const struct option *o) {
    return (char *)options + o->offset;
}
static const void *preset_field_of(const satin_options *options, const struct option *o) {
    return (const char *)options + o->offset;
}

static size_t preset_field_size(const struct option *o) {
    switch (o->kind) {
        case OPTION_COUNT:
            return sizeof(int64_t);
        case OPTION_FLOAT:
            return sizeof(float);
        default:
            return sizeof(int);  // quality decides no switch, seed, text or double
    }
}

static bool same_value(const satin_options *a, const satin_options *b, const struct option *o) {
    return memcmp(preset_field_of(a, o), preset_field_of(b, o), preset_field_size(o)) == 0;
}

static void copy_value(satin_options *to, const satin_options *from, const struct option *o) {
    memcpy(preset_field(to, o), preset_field_of(from, o), preset_field_size(o));
}

static double number_value(const satin_options *options, const struct option *o) {
    const void *in = preset_field_of(options, o);
    if (o->kind == OPTION_COUNT) return (double)*(const int64_t *)in;
    return o->kind == OPTION_FLOAT ? (double)*(const float *)in : (double)*(const int *)in;
}

static void set_number(satin_options *options, const struct option *o, double value) {
    void *out = preset_field(options, o);
    if (o->kind == OPTION_FLOAT)
        *(float *)out = (float)value;
    else if (o->kind == OPTION_COUNT)
        *(int64_t *)out = llround(value);
    else
        *(int *)out = (int)lround(value);
}

// ---- Options by effort --------------------------------------------------------------------------

// The last preset at or below the effort, and the position between it and the next one, in [0, 1).
static int find_preset(double effort, double *fraction) {
    int i = 0;
    *fraction = 0.0;
    while (i + 1 < PRESETS && effort >= preset[i + 1].effort) i++;
    if (i + 1 < PRESETS && effort > preset[i].effort)
        *fraction = log(effort / preset[i].effort) / log(preset[i + 1].effort / preset[i].effort);
    return i;
}

// `times` is the effort over that of the last preset, whose options are set.
static void extrapolate_option(satin_options *options, const struct option *o, double times) {
    for (int i = 0; i < BEYOND; i++) {
        if (beyond[i].offset != o->offset) continue;
        const double wanted =
            number_value(options, o) * pow(fmax(times / beyond[i].from, 1.0), beyond[i].power);
        set_number(options, o, fmin(wanted, option_highest(o)));
    }
}

// The value of an option of a time limit at the effort of that preset.
static double timed_value(int quality, const struct option *o) {
    for (int i = 0; i < BY_TIME; i++)
        if ((int)by_time[i].quality == quality && by_time[i].offset == o->offset)
            return by_time[i].value;
    return number_value(&preset[quality].options, o);
}

static void set_by_effort(satin_options *options, const struct option *o, double effort) {
    double fraction;
    const int i = find_preset(effort, &fraction);
    set_number(options, o, timed_value(i, o));
    if (o->offset == offsetof(satin_options, light_samples) && effort < LIGHTS_EFFORT)
        set_number(options, o, fmax(timed_value(i, o) * effort / LIGHTS_EFFORT, LIGHTS_LEAST));
    if (i == PRESETS - 1) extrapolate_option(options, o, effort / preset[i].effort);
    if (fraction == 0.0) return;
    const double from = log(timed_value(i, o)), to = log(timed_value(i + 1, o));
    set_number(options, o, exp(from + fraction * (to - from)));
}

void options_quality_copy(satin_options *to, const satin_options *from) {
    for (int i = 0; i < options_table_count; i++)
        if (options_table[i].by_quality) copy_value(to, from, &options_table[i]);
}

void options_quality_preset(satin_options *options, satin_quality quality) {
    options_quality_copy(options, &preset[quality].options);
}

bool options_quality_chooses(const satin_options *options, const struct option *o) {
    return o->by_quality && same_value(options, &preset[options->quality].options, o);
}

bool options_quality_chooses_photons(const satin_options *options) {
    return options->photons == preset[options->quality].options.photons;
}

bool options_quality_chooses_lights(const satin_options *options) {
    return options->light_samples == preset[options->quality].options.light_samples;
}

bool options_quality_chooses_caustics(const satin_options *options) {
    return options->caustic_photons == preset[options->quality].options.caustic_photons;
}

// A pass of integrator sppm has the photons of the first preset, however long the render takes: its
// error falls with the number of passes. With photons that grew with time, caustic had 11, 7 and 9
// passes in 10, 30 and 100 s, and its error rose (docs/experiments/caustics.md).
static double effort_of(const satin_options *options, const struct option *o, double seconds,
                        double pixels) {
    if (o->kind != OPTION_COUNT) return seconds / pixels;
    return options->integrator == SATIN_SPPM ? preset[0].effort : seconds / PRESET_PIXELS;
}

void options_quality_seconds(satin_options *options, double seconds, double pixels) {
    for (int i = 0; i < options_table_count; i++) {
        const struct option *o = &options_table[i];
        if (!options_quality_chooses(options, o)) continue;
        set_by_effort(options, o, effort_of(options, o, seconds, pixels));
        if (o->offset == offsetof(satin_options, glossy_samples))
            set_number(options, o, options->denoise ? DENOISED_GLOSSY : TIMED_GLOSSY);
    }
}
