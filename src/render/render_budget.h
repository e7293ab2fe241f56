// SPDX-License-Identifier: Apache-2.0
// Private to render/: the budgets, that is how much work a render does, and when. What divides time
// between stages, or decides how many photons, records, rays, samples or pixels a stage may use, is
// here, in render_budget.c, render_budget_photons.c, render_budget_records.c and
// render_budget_rims.c, also for stages of other folders, which get such numbers in their
// arguments. Elsewhere are: the values of the options by quality and by effort, which is core
// seconds per pixel (options_quality.c), and these are the base of all decisions; the limit of
// memory (render_memory.c); and what is a property of an algorithm: the size of a sample from which
// its accuracy follows, as of the pilot in photon_stored.c, the sizes of blocks and batches, and
// how work is distributed among pixels or photons that are given.
//
// All seconds are wall clock times. Without a time limit the remaining time is INFINITY, no limit
// is set, and the decisions depend only on the options and the film, never on the number of cores,
// which must not change an image. With one, they are fractions of time and of measured speeds, or
// grow with core seconds, so that they scale with the cores. Only the relative costs of rays are
// not measured while rendering: they are those on the data scenes (render_budget_sample_cost).
#ifndef RENDER_BUDGET_H
#define RENDER_BUDGET_H

#include <stdbool.h>

#include "cache/cache.h"
#include "photon/photon.h"
#include "shade/shade.h"

struct render;
struct shade_counts;

// To be called when the image is allocated: measures how long the film will take, if the time is
// limited.
void render_budget_begin(struct render *r);
// Seconds since the render began; the same on all ranks, which must all call it.
double render_elapsed(const struct render *r);
// The seconds of a time limit times the cores of all ranks, which is what a budget of work grows
// with; 0 without a limit. The cores are those that the threads may have, and of two passes those
// that they have had so far.
double render_core_seconds(const struct render *r);
// The seconds that the loops since parallel_loop_seconds was `before` would take, by their CPU time
// and the cores that the threads have had: a short loop may have all of them.
double render_loop_seconds(const struct render *r, double before);
// The seconds that remain of options.time.
double render_time_left(const struct render *r);

// The seconds from the end of a snapshot that took so long until the next one.
double render_budget_snapshot(double seconds, int threads);

// The pilots (render_image_pilot.c): the largest number of its pixels along a side of the image,
// and of the samples of each. This number of pixels shows V within 5 % and q within .2 % from seed
// to seed (cornell-glossy and indirect-room; with 1024 pixels V within 20 %), and takes .02 to .04
// core seconds in either scene. render_adaptive_compare needs at least two halves of two samples.
enum { RENDER_PILOT_SIDE = 64, RENDER_PILOT_LEAST = 16, RENDER_PILOT_SAMPLES = 4 };
// The number of its pixels along a side for which there is time, at so many samples per second.
int render_budget_pilot(const struct render *r, double samples);
// Whether paths are to be traced, as no more samples of the image than these per second fit.
bool render_budget_traces_paths(const struct render *r, double samples);
// Measurements of a pilot.
struct render_pace {
    double rays, samples;  // per second: gather rays of records, samples of the image
    double variance;       // V: the image's variance by n samples per pixel is V n^-1.5
    double direct;         // variance of direct light and caustics, by one sample
    double indirect2;      // q: the mean square of a pixel's indirect light
};

// ---- Limits. Each holds for the loops that follow, until the next one or render_limit_end.

void render_limit_photon_pilot(struct render *r);  // a sixteenth of the photons
void render_limit_tables(struct render *r);        // BRDFs in harmonics
// Records of indirect bounces, which began at `start` [s since the render began], up to the
// fraction `done` of them.
void render_limit_bounces(struct render *r, double start, double done);
// Records. Their limit is the fraction of the remaining time that minimises the error of the image:
// the sum of its variance by n samples per pixel and of ERROR_RAYS q / rays, by the number of its
// records' gather rays per pixel. NULL: nothing is measured yet.
void render_limit_records(struct render *r, const struct render_pace *measured);
// Records of the first round, as soon as a few are measured: by the variance of direct light
// alone, and with time to cover the image even if that takes longer.
void render_limit_first_records(struct render *r, const struct render_pace *measured);
void render_limit_image(struct render *r);
void render_limit_coarse(struct render *r);  // after a cancellation, even without a time limit
// Lifts the limit for the following loops, which are short. It is set again by
// render_limit_restore.
double render_limit_lift(struct render *r);
void render_limit_restore(struct render *r, double before);
// Ends the time limit, so that it does not stop later loops. Returns SATIN_OK instead of the
// SATIN_CANCELLED of a loop that the limit stopped, but a cancellation by the caller as it is.
satin_status render_limit_end(struct render *r, satin_status status);
// Whether the limit is not reached.
bool render_time_remains(const struct render *r);

// ---- Photons (render_budget_photons.c)

// The numbers of light paths for options->photons and options->caustic_photons, which may be those
// of the options or a fraction of them; `core_seconds` as render_core_seconds.
struct photon_paths render_budget_paths(const satin_options *options, double core_seconds);
// With how many paths and rays the visibility of the lights is measured, by a fraction of the
// paths.
struct guide_visibility_samples render_budget_visibility(const satin_options *options,
                                                         double fraction);
// The fraction with which a render begins.
double render_budget_first_visibility(const satin_options *options);
// The fraction for the next attempt, after `fraction` took `seconds`; `fraction` itself if that is
// the last. `small`: whether light comes through small openings alone.
double render_budget_more_visibility(const satin_options *options, double fraction, double seconds,
                                     bool small);
// The number of light samples at each entry of irradiance, where those of a render without a time
// limit would take `seconds` at all entries. With 4, means of single images were .5 % off in a room
// lit through a door; 16 gain nothing. Where the environment is drawn by what is visible, the few
// samples that are not are many times as bright, and gloss shows the entry that meets one as a
// bright disc: in living-room, with 33 times, 8, 16, 32, 64 and 128 samples leave 69, 50, 18, 2 and
// 0 of 3,700 entries that are read with more than six times the light around them.
struct gather_entry_samples render_budget_entry_samples(const struct render *r, double seconds);
// The seconds that these take.
double render_budget_direct(const struct render *r, double seconds);
// The fraction of its photons that a render traces first, to measure their time or light.
double render_budget_first_photons(void);
// The factor by which the paths of a global map should grow that has `kept` photons of indirect
// light from `paths` paths: 1, or up to 8 if it is starved; less than 1, if 8 times as many would
// be too few to be read, too.
// With a time limit it is at least 2.5, unless the image is denoised.
double render_budget_starved(const satin_options *options, double paths, double kept);
// The factor of the photons of the global map without a time limit, in a film of so many pixels.
double render_budget_photons_most(const satin_options *options, double pixels);
// The factor of the paths by which a starved map is traced again without a time limit; 1: it is
// not.
double render_budget_grow(double starved);
// What matters of caustics: 0, up to 1 where they are CAUSTIC_LIGHT of the light or more.
// `fraction`: photon_caustic_fraction.
double render_budget_caustics(double fraction);
// The factor by which caustic photons may grow without a time limit, in a film of so many pixels,
// if render_budget_caustics is 1.
double render_budget_caustics_most(const satin_options *options, double pixels);
// The numbers of photons of maps.
struct render_photon_counts {
    double fraction;         // of the options' photons
    double global, caustic;  // factors of those of either map
};
// The photons that replace the first ones with a time limit, where all of the options are expected
// to take `seconds`, `starved` is the factor for the global map, and `caustics` is
// render_budget_caustics. Fraction 0: the first ones are kept.
struct render_photon_counts render_budget_photons(const struct render *r, double seconds,
                                                  double starved, double caustics);
// Integrators photons and sppm trace some photons, and then more until those fit.
// The fraction of the options' photons with which they begin: a thousand paths, or all without a
// time limit.
double render_budget_least_photons(const satin_options *options);
// The seconds that these photons may take from now on; INFINITY without a time limit. Of sppm it is
// the time of one pass, of which several follow.
double render_budget_photon_seconds(const struct render *r);
// The fraction for the next attempt, after the fraction `made` took `seconds`, if `allowed` seconds
// are for it: at most all photons; `made` itself if hardly more fit.
double render_budget_more_photons(double made, double seconds, double allowed);
// The factor by which the radius of a lookup is less if all photons are traced than if the fraction
// `made` of them is, as it falls with the square root of their number; 1 if none or all are.
float render_budget_lookup(double made);

// ---- Records

// Records are made on grids of pixels, which are called levels: at every 32nd pixel in both
// directions, then between these, down to every pixel.
enum { RENDER_LEVELS = 6, RENDER_COARSEST = 1 << (RENDER_LEVELS - 1) };

// Factors of the options' accuracies a, by kind of record.
struct render_factors {
    float of[CACHE_KINDS];
};
// The factors of a round of records with a time limit, which are not less than those of the next
// round.
struct render_factors render_budget_round(const satin_options *options, int round);
// The factors of a at which the image may read the records of a round: if it is not finished, those
// of the round before, widened. Points near few records, which the first two rounds may leave, read
// theirs at CACHE_WIDER times that.
struct render_factors render_budget_search(const satin_options *options, int round);
// The number of rounds until the next one would not be finer.
int render_budget_rounds(const satin_options *options);
// The fraction of the options' least radius for records at this factor of a.
float render_budget_least_radius(float factor);
// The fraction of their rays below which records do not count; 0 if they all do, as in the round
// that covers the image.
float render_budget_rays_least(bool covering);
// The largest factor of a at which records may be read by the image pass.
float render_budget_largest_factor(const satin_options *options);

// The seconds that the first round may still take.
double render_budget_first_round(const struct render *r);
// Whether another round should follow the first one, whose records take `seconds` by all their
// rays. It takes longer, being finer; without one there is more time for the image.
bool render_budget_next_round(const struct render *r, double seconds);
// Otherwise: the records of the next round end after so short a time that only the coarsest ones,
// which are seen most, have all rays.
void render_limit_coarse_records(struct render *r);

// What the first round has made so far, and the rays of its records. It must cover the image within
// its time, whatever the number of records: in furnished rooms it is some thousand.
struct render_covering {
    float rays;  // fraction of the options' gather rays for records of the coarsest level; from
                 // RENDER_COARSEST on, records of all levels get all
    double last, made;      // numbers of records of the last level, and so far of this one
    double full, seconds;   // records, each weighted by its fraction of the rays, and the time for
                            // them; earlier ones count less
    double all, all_full;   // those of all levels, neither counting less
    double pixels, search;  // pixels that were searched for sites, and the time for that [s]
};

// The fraction of the options' gather rays for records of the level of this stride.
float render_covering_rays(const satin_options *options, const struct render_covering *covering,
                           int stride);
// The seconds that the search for sites takes in `pixels` pixels.
double render_covering_search(const struct render_covering *covering, double pixels);
// Whether the level of this stride, of `pixels` pixels, is filled although its sites have to be
// searched, if `left` seconds remain for it and for the finer levels.
bool render_covering_pays(const struct render_covering *covering, double pixels, double left);
// Sets the rays of records of the level of this stride and of finer ones. At most `needed` more
// records cover this level, of `pixels` pixels; `left` seconds remain. Without a measured speed
// they get all.
void render_covering_plan(const satin_options *options, struct render_covering *covering,
                          int stride, double pixels, double needed, double left);
// To be called with the time for `made` records of the level of this stride [s].
void render_covering_filled(const satin_options *options, struct render_covering *covering,
                            int stride, double made, double seconds);
// The seconds that all records of the first round, which took `seconds`, take by all their rays.
double render_covering_by_all_rays(const struct render_covering *covering, double seconds);
// To be called after a level.
void render_covering_next(struct render_covering *covering);

// Pixels whose sites are found together. With a time limit the first block of the first level has
// RENDER_FIRST_PIXELS, because nothing is known about the time until its records are made: in
// living-room at 1280x720 and 12 CPU seconds, the first round ended in time with 2 and 8, but not
// with 64 and with all pixels for one of two seeds each. In a view after the first one, most of
// what it sees is covered by the records of others, so the first block of a level has
// RENDER_VIEW_PIXELS: in a walk of 60 frames, 1024, 4096, 16384 and all pixels took 4.9, 5.2, 6.8
// and 6.9 CPU seconds for records that cover the frames equally (docs/experiments/animations.md).
enum { RENDER_FIRST_PIXELS = 8, RENDER_VIEW_PIXELS = 4096 };
// The largest block, and the sites at which it ends: what is seen through glass has several sites
// in a pixel. They take 28 MB.
enum { RENDER_BLOCK_PIXELS = 65536, RENDER_BLOCK_SITES = 81920 };
// The pixels of a block whose sites are searched at a time: 128 chunks, in 11 MB.
enum { RENDER_TRACED_PIXELS = 8192 };
// Whether the rest of a level is filled in a view after the first one, of whose last `pixels`
// pixels `made` records were made: at least one per RENDER_VIEW_PIXELS.
bool render_budget_view_pays(double made, double pixels);

// The distance of the pixels whose points adaptive caching compares, in both directions.
int render_budget_adaptive_stride(int width, int height);

// The number of random walks that search sites for records, for each indirect bounce; a power of
// two. Records are made only at uncovered sites: 2048, 8192, 32768 and 131072 walks made 843, 1151,
// 1245 and 1246 in cornell-glossy and 1231, 1737, 1912 and 1921 in indirect-room (draft at 64x64).
// The first block of sites is from RENDER_WALKS_FIRST walks; each further block doubles their
// number.
enum { RENDER_WALKS = 32768, RENDER_WALKS_FIRST = 512 };
// Makes *options, those of the image, the options of records of that indirect bounce: fewer gather
// rays and a larger accuracy a with each bounce.
void render_budget_bounce(satin_options *options, int bounce);

// ---- The image

// Samples per pixel of a render with a time limit, if the options have none: more than fit into any
// limit.
enum { RENDER_TIMED_SPP = 1 << 20 };
// The distance of the pixels with the first samples of an image, a power of two.
int render_budget_first_stride(int width, int height);
// The light samples of each of the first samples, if one with those of the options takes so many
// seconds.
uint32_t render_budget_lights(const struct render *r, double sample_seconds);
// The gather rays of the very first samples where no record is near; all samples have as many
// without a time limit.
int render_budget_first_gathers(const satin_options *options);
// The gather rays of the other first samples with a time limit, if a sample takes so many seconds.
uint32_t render_budget_gathers(const struct render *r, double sample_seconds);
// Samples per pixel that are distributed equally.
uint32_t render_budget_equal_samples(const satin_options *options);
// The number of samples of all pixels in the next pass, after `done` samples, if one takes
// `sample_seconds`: as many as there are already, and at most half of those that fit, so that the
// time of the last ones is known well. Integrator sppm takes one sample per pixel in each. 0: no
// further pass.
uint64_t render_budget_pass(const struct render *r, uint64_t done, double sample_seconds);
// How samples gather where no record is near; `core_seconds` as render_core_seconds.
struct shade_missing render_budget_missing(const satin_options *options, double core_seconds);
// The cost of a sample without light samples, over that of a light sample, by the counts of all
// samples so far. Each pixel divides its time between both by it. With `gathers` also without the
// gather rays where no record is near, as pixels choose their number too.
float render_budget_sample_cost(const struct shade_counts *counts, bool gathers);
// What is known of the pixels at rims.
struct render_rim_rays {
    double fraction;  // of all pixels
    double seconds;   // of one core for one ray at each of them; 0: not known
    uint32_t first;   // rays for emission in other pixels
    bool late;        // whether the time limit is over
};
// The number of eye rays for emission alone in each of them, a power of two or 0.
uint32_t render_budget_rim_rays(const satin_options *options, double core_seconds,
                                const struct render_rim_rays *rims);
// By how much the number of samples of a noisy pixel may grow in one pass, as a factor: half of its
// number, as many samples show its noise well enough for more, within these limits. The tail of a
// filter beside an edge needs hundreds of samples (docs/experiments/direct-light.md).
enum { RENDER_GROWTH_LEAST = 4, RENDER_GROWTH_MOST = 16 };
// The largest number of light samples per sample: beyond it they dominate the cost, and are
// stratified well enough.
enum { RENDER_LIGHT_SAMPLES_MOST = 16 };
// That of gather rays where no record is near, and the cost of one with its lookups, over that of a
// light sample.
enum { RENDER_GATHERS_MOST = 8, RENDER_GATHER_COST = 6 };
// The seconds between two states of the image in a checkpoint, unless the caller gives them: the
// most that an interruption costs. Writing that of 1920x1080 pixels, 431 MB, takes .9 CPU seconds
// and 1.6 s with the disk, so 60 cost 1.5 to 3 % of such a render, and 10 would cost 9 to 16 %.
enum { RENDER_CHECKPOINT_SECONDS = 60 };
// The seconds of the time limit before what comes after the image, INFINITY without a limit; and
// those of them that are left.
double render_budget_usable(const struct render *r);
double render_budget_left(const struct render *r);
// The seconds that are left to edges once the filters have run.
double render_budget_for_edges(const struct render *r);
// Whether the image is denoised: always, unless the render is cancelled and it would take too long.
bool render_budget_denoises(const struct render *r);
// The fraction of the pixels that will have no sample if one takes so long, and whether noise is
// filtered in spite of that.
double render_budget_unsampled(const struct render *r, double sample_seconds);
bool render_budget_fits_noise(double unsampled);
// The seconds that emission will take which is sampled after a limit; 0: it was sampled before, or
// would take too long and is left out.
double render_budget_late_rims(const struct render *r);
// With a time limit, measures how long it takes by some rays. To be called when samples can be
// shaded.
void render_budget_time_rims(struct render *r);
// The radius in pixels up to which irradiance is filtered where no record is near, so that it does
// not take too long.
float render_budget_filter_radius(const struct render *r);
// Whether noise is filtered, unless it would take too long.
bool render_budget_filters_noise(const struct render *r);

#endif
