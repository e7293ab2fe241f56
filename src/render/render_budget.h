// SPDX-License-Identifier: Apache-2.0
// Private to render/: how much work a render does, and when. Every decision that bounds the work of
// a stage is here: those by the clock, by photons and by pixels in render_budget.c, those of
// records in render_budget_records.c. All seconds are of wall clocks. Without a time limit what is
// left is INFINITY, no limit is set, and the decisions depend on the options and the film alone:
// never on the number of cores, which is not to change an image.
#ifndef RENDER_BUDGET_H
#define RENDER_BUDGET_H

#include <stdbool.h>

#include "cache/cache.h"

struct render;

// Seconds since the render began.
double render_elapsed(const struct render *r);
// Seconds that are left of options.time.
double render_time_left(const struct render *r);

// What a pilot of a few pixels measured (render_pilot.c).
struct render_pace {
    double rays, samples;  // per second: gather rays of records, samples of the image
    double variance;       // V: the image's variance by n samples per pixel is V n^-1.5
    double indirect2;      // q: the mean square of the indirect part of a pixel's light
};

// ---- Limits. Each holds for the loops that follow, until the next one or render_limit_end.

void render_limit_pilot(struct render *r);   // a sixteenth of the photons
void render_limit_tables(struct render *r);  // BRDFs in harmonics
// Deeper records, which began at `start` [s since the render began], up to the part `done` of them.
void render_limit_bounces(struct render *r, double start, double done);
// Records: of the time that is left for them and for the image, the fraction that makes the error
// of the image least, its variance by n samples per pixel and ERROR_RAYS q / rays by the gather
// rays per pixel of its records together. NULL: before anything is measured.
void render_limit_records(struct render *r, const struct render_pace *measured);
void render_limit_image(struct render *r);
void render_limit_look(struct render *r);  // after a cancellation, also without a time limit
// Nothing ends the next loops, which are short, until the limit before is set again.
double render_limit_lift(struct render *r);
void render_limit_restore(struct render *r, double before);
// Ends the time limit, so that it does not stop later loops. Returns SATIN_OK instead of the
// SATIN_CANCELLED of a loop that the limit stopped, but a cancellation by the caller as it is.
satin_status render_limit_end(struct render *r, satin_status status);
// Whether the limit is not over.
bool render_time_remains(const struct render *r);

// ---- Photons

// The fraction of its photons that a render traces first: all, or with a time limit a sixteenth.
double render_budget_first_photons(const struct render *r);
// How many times its paths a global map should have that kept `kept` photons of indirect light of
// so many paths: 1, or up to 8 where it is starved.
double render_budget_starved(double paths, double kept);
// The photons that replace the first ones.
struct render_more_photons {
    double fraction;  // of the photons that the options say; 0: the first ones serve
    double global;    // times as many of the global map, where that is starved
};
// After the first photons, which took so long and left the global map starved by such a factor.
struct render_more_photons render_budget_photons(const struct render *r, double seconds,
                                                 double starved);

// ---- Records (render_budget_records.c)

// Records are made at grids of pixels, which are called levels: at every 32nd pixel in both
// directions, then at those between, down to every pixel.
enum { RENDER_LEVELS = 6, RENDER_COARSEST = 1 << (RENDER_LEVELS - 1) };

// Factors of the options' accuracies a, by kind of record.
struct render_widths {
    float of[CACHE_KINDS];
};
// Of a round of records within a time limit: no less than those of the round after it.
struct render_widths render_budget_round(const satin_options *options, int round);
// Rounds until one would be as fine as the one before it.
int render_budget_rounds(const satin_options *options);
// The fraction of the options' least radius that records made at this factor of a may have.
float render_budget_least_radius(float width);
// The factor of a over which no record is read: what the image pass may use.
float render_budget_widest(const satin_options *options);

// How the levels of the first round go, which is to cover the image within its time.
struct render_covering {
    float rays;      // fraction of the options' gather rays that records of the coarsest level get;
                     // from RENDER_COARSEST on, records of all levels get all
    double records;  // that the last level made
    double full, seconds;  // of all levels: records, each weighed by its fraction of the rays; time
};
// Fraction of the options' gather rays that records of the level of this stride get.
float render_budget_rays(const satin_options *options, const struct render_covering *covering,
                         int stride);
// After the level of this stride, which made so many records in so many seconds: sets the rays of
// the finer ones, which have `left` seconds.
void render_budget_level(const satin_options *options, struct render_covering *covering, int stride,
                         double made, double seconds, double left);
// Seconds that the first round may still take.
double render_budget_first_round(const struct render *r);

// Pixels between those whose points adaptive caching compares, in both directions.
int render_budget_adaptive_stride(int width, int height);

// Random walks that look for sites of records, for each indirect bounce beyond the first; a power
// of two. Records are made only where none serves: 2048, 8192, 32768 and 131072 walks made 843,
// 1151, 1245 and 1246 in cornell-glossy and 1231, 1737, 1912 and 1921 in indirect-room (draft at
// 64x64).
enum { RENDER_WALKS = 32768 };

// ---- The image

// Pixels between the first samples of an image, a power of two.
int render_budget_first_stride(int width, int height);
// Samples per pixel that are distributed equally.
uint32_t render_budget_even_samples(const satin_options *options);
// Samples of all pixels that the next pass takes after `done`, if one takes so long: as many as are
// there, and at most half of those that fit, so that the last ones are well foreseen. While not all
// pixels have their equal samples, a multiple of the pixels. 0: no further pass.
uint64_t render_budget_pass(const struct render *r, uint64_t done, double sample_seconds);
// Eye rays for emission alone that each of the pixels at rims gets: a power of two.
uint32_t render_budget_rim_rays(size_t pixels, size_t at_rims);
// Whether there is time to denoise: always, unless the render is cancelled and it takes too long.
bool render_budget_denoises(const struct render *r);

#endif
