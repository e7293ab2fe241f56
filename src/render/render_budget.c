// SPDX-License-Identifier: Apache-2.0
// How much work a render does, and how a time limit is divided. A step gets a fraction of what is
// usable of the limit or of the remaining time, and speeds are measured while it renders, so the
// same fractions are valid for any scene and any number of cores. In the order of the light:
//
//   photons           the first FIRST_PHOTONS, then as many as fit until PHOTONS_UNTIL, or with
//                     caustics until CAUSTICS_UNTIL
//   BRDF tables       until TABLES_UNTIL
//   indirect bounces  BOUNCES_FRACTION of the remaining time
//   records           the fraction of the remaining time at which the error of the image is least:
//                     by the first records, then by the first round of them
//   image             the rest, without the time for denoising and writing
//
// The time of records is divided into rounds, and that of the first round into levels, by
// render_budget_records.c. Before the render begins, options_quality.c has set the options by
// effort and quality.
#include "render/render_budget.h"
#include <stdio.h>
#include <stdlib.h>

#include "render/render_image.h"

// The first photons are abandoned if they take longer than this fraction of the remaining time.
// Some paths per pixel, denoised, are worth more than less than one sample that reads photons: in
// three rooms at 50 us per pixel relMSE is .18, .024 and .074 with .3, and 10, .024 and .083 with
// .5. With .22 it is .12, .020 and .055, but .0068 instead of .0024 in a scene with a caustic.
static const double PILOT_FRACTION = 0.5, PILOT_DENOISED = 0.3;
// The fraction of the usable time.
static const double TABLES_UNTIL = 0.45;
// Fractions of the remaining time.
static const double BOUNCES_FRACTION = 0.3, RECORDS_FRACTION = 0.5;
// The first round of records is planned for COVER_FRACTION of the time of all records, or for
// COVER_LEAST of that until its limit if it takes longer. The limit is COVER_MOST times that of all
// records, as an image that is not covered costs more than late records. With .3 and .5 of half of
// the remaining time, whatever the first records show, relMSE x 10^4 was 299 instead of 192 in
// living-room at 30 CPU seconds and 141 instead of 130 in veach-ajar at 20; with 1 for COVER_MOST
// it is 3.8 instead of 2.6 in cornell-glossy at 4.
static const double COVER_FRACTION = 0.3, COVER_LEAST = 0.1, COVER_MOST = 1.5;
// The least time for a whole second round, in units of that which the records of the first one take
// by all their rays. In living-room (640x360, 60 CPU seconds) it is .1 of that, and in a bathroom
// .12. In hall (200x200) it is .65 and .59 at 4 and 8 CPU seconds, with 1.3 and 1.5 times the error
// without the round, in closed rooms from 1 second on .9 and more.
static const double NEXT_ROUND = 0.3;
// The fraction of the remaining time for a second round that cannot be finished: its coarse records
// come first. Without them the ceiling of living-room has clouds, with .05 and .1 faint ones, with
// .15 none.
static const double COARSE_ROUND = 0.15;

// The largest fraction of the time limit that is kept for denoising: the render of a large image
// exceeds the limit rather than having no samples.
static const double DENOISE_FRACTION = 0.5;
// The time of the coarse image of a cancelled render, and of its denoising [s].
static const double COARSE_SECONDS = 0.5, DENOISE_SECONDS = 0.5;

// The time for the film beside that of compressing it, which is measured: a file of its metadata is
// written and renamed [s].
static const double WRITE_SECONDS = 0.05;
// That of edges at one pixel of the film [core s], until samples are planned: 1.9 to 3.5e-6 in
// three scenes, 9e-6 in a furnished room; and the largest fraction of the limit for it.
static const double EDGES_SECONDS = 3e-6, EDGES_MOST = 0.1;
// The time of a pixel in a kernel of irradiance, over that of a pixel in the filter of noise, which
// is measured: 58 times as long for a kernel of 24 pixels.
static const double KERNEL_PIXEL = 0.1;
// The largest fraction of the time limit for it: the last tenth of the samples lowers the error by
// a tenth, the filter by a quarter and more. And its longest time after a cancellation [s].
static const double FILTER_FRACTION = 0.1, FILTER_CANCELLED = 0.5;

// The largest fraction of the limit for the filter of noise, and that of its time by which it may
// exceed the limit: an image of one sample per pixel is worth little without it. Where less than
// NOISE_SAMPLED of the pixels will have a sample, more of them gain more.
static const double NOISE_FILTER_FRACTION = 0.25, NOISE_LATE = 0.5, NOISE_SAMPLED = 0.1;
// What follows the image leaves at least this fraction of the limit.
static const double USABLE_LEAST = 0.1;

enum {
    EQUAL_LEAST = 2,     // least number of samples per pixel that are distributed equally
    EQUAL_FRACTION = 4,  // of many samples, one in this number is distributed equally
    FIRST_STRIDE = 16,   // least distance of the pixels with the very first samples
    FIRST_MOST = 256,  // largest number of those pixels, so that an image of any size has its first
                       // samples after a moment; finer pixels follow until the time is over
    HEMISPHERE_RAYS_LEAST = 8  // of one sample where a cache is off
};
// The samples of a pixel that a core second per pixel allows, with all that is before the image:
// those that quality preview had. Their number is not known when it is first needed.
static const double CORE_SECOND_SAMPLES = 16.0 / 1.3e-4;
// The number of samples per pixel below which a denoised image is worse than one of paths, of which
// two to four times as many fit, by a pilot before there are records. With 1.5 the relMSE of
// living-room at 3 s (320x180) is .021 and .032 by two seeds, of which the first has paths, with 2
// it is .021 and .021; closed rooms at 1 CPU second have more, and .65 to .8 of the error of paths.
static const double PATHS_BELOW = 2.0;
// The number of samples per pixel below which another pass of the image costs more than it gains.
static const double PASS_LEAST = 0.1;

// The model of balance(). Measured on the data scenes at 10 to 20 gather rays and 6 to 15 samples
// per pixel: the relative squared error of a pixel with indirect light alone, times the rays per
// pixel, was 2.7e-3 to 1e-2. The variance of the image was less than V by a factor of 5 to 12 in
// closed rooms, and 2 to 3 in a furnished one: V is from two halves of two samples with few light
// samples, and of three colours. That of direct light by one sample of many light samples is larger
// than its variance in the image times n^1.5 by a factor of 1 in a furnished room, and 2 to 4 in
// closed ones.
static const double ERROR_RAYS = 5e-3, VARIANCE_GAIN = 5.0, DIRECT_GAIN = 2.0;
// The least and the largest fraction of the remaining time for the image.
static const double IMAGE_LEAST = 0.2, IMAGE_MOST = 0.8;
enum { BALANCE_STEPS = 40 };
// The largest fraction of the remaining time for the pilot of the image. Without a limit it took
// all of the image's time at 64x64 and .5 CPU seconds, where path tracing has 10 samples per pixel.
static const double IMAGE_PILOT = 0.1;

static double time_limit(const struct render *r) {
    return r->options.time > 0.0 ? r->options.time : INFINITY;
}

// The cores that this process has had. The other integrators make their photons again when they are
// resumed, and must not measure.
static double cores_had(const struct render *r) {
    const bool known = r->pool && r->options.time > 0.0 && r->options.integrator == SATIN_TWO_PASS;
    return known ? render_agreed(r, parallel_cores_had(r->pool))
                 : parallel_cores_of(r->options.threads);
}

double render_core_seconds(const struct render *r) {
    const int ranks = r->callbacks.ranks ? r->callbacks.ranks->count : 1;
    return r->options.time * ranks * cores_had(r);
}

double render_loop_seconds(const struct render *r, double before) {
    const double spent = parallel_loop_seconds(r->pool) - before;
    return render_agreed(r, spent / parallel_cores_had(r->pool));
}

double render_elapsed(const struct render *r) {
    return render_agreed(r, stats_wall() - r->progress.start);
}

double render_time_left(const struct render *r) { return time_limit(r) - render_elapsed(r); }

// ---- After the image ----------------------------------------------------------------------------

static double denoise_seconds(const struct render *r) {
    if (!r->denoiser) return 0.0;
    const double pixels = (double)r->options.width * (double)r->options.height;
    const bool clean = r->image && r->image->noisy.clean;
    const double seconds = film_denoiser_pixel_seconds(r->denoiser, clean) * pixels;
    return fmin(seconds, DENOISE_FRACTION * time_limit(r));
}

bool render_budget_denoises(const struct render *r) {
    return !render_cancelled(r) || denoise_seconds(r) <= DENOISE_SECONDS;
}

// The time of the filter of noise, which a render without a time limit needs to know only after it
// was cancelled.
static double noise_seconds(const struct render *r) {
    const double measured = r->progress.noise_pixel_seconds;
    const double pixels = (double)r->options.width * (double)r->options.height;
    return (measured > 0.0 ? measured : render_noise_pixel_seconds()) * pixels /
           parallel_cores_had(r->pool);
}

static double noise_filter_estimate(const struct render *r) {
    return r->image && r->image->noisy_light ? noise_seconds(r) : 0.0;
}

// The time of the filter of irradiance with kernels of the largest radius, if as many pixels gather
// as points have so far: in proportion to the number of pixels, and of those around each.
static double largest_filter(const struct render *r) {
    if (!r->image || !r->image->gathered || r->image->counts.points == 0) return 0.0;
    const struct shade_counts *counts = &r->image->counts;
    const double radius = render_irradiance_radius(r->image, &r->options);
    const double sampled = radius * (1.0 - r->image->unsampled);
    return KERNEL_PIXEL * sampled * sampled * noise_seconds(r) * (double)counts->gathered /
           (double)counts->points;
}

// The longest time of a filter that may take this fraction of the limit.
static double filter_most(const struct render *r, double fraction) {
    return render_cancelled(r) ? FILTER_CANCELLED : fraction * time_limit(r);
}

static double filter_estimate(const struct render *r) {
    return fmin(largest_filter(r), filter_most(r, FILTER_FRACTION));
}

float render_budget_filter_radius(const struct render *r) {
    const float radius = render_irradiance_radius(r->image, &r->options);
    const double most = filter_most(r, FILTER_FRACTION);
    if (isinf(most)) return radius;
    const double largest = largest_filter(r);
    return largest > most ? radius * sqrtf((float)(most / largest)) : radius;
}

bool render_budget_filters_noise(const struct render *r) {
    const double most = filter_most(r, NOISE_FILTER_FRACTION);
    if (r->options.time > 0.0 && !(r->image && r->image->noise_fits)) return false;
    return isinf(most) || noise_filter_estimate(r) <= most;
}

// The time for the filter of noise, if it is to run.
static double noise_filter_kept(const struct render *r) {
    return render_budget_filters_noise(r) ? noise_filter_estimate(r) : 0.0;
}

static double write_seconds(const struct render *r) {
    const double pixels = (double)r->options.width * (double)r->options.height;
    return WRITE_SECONDS + r->progress.write_pixel_seconds * pixels / parallel_cores_had(r->pool);
}

// The time after the image; 0 without a time limit.
static double finish_seconds(const struct render *r) {
    if (!(r->options.time > 0.0)) return 0.0;
    const bool first = r->image && r->image->taken == 0;
    const double noise = (first ? 1.0 - NOISE_LATE : 1.0) * noise_filter_kept(r);
    return filter_estimate(r) + noise + (r->image ? r->image->edge_seconds : 0.0) +
           render_budget_late_rims(r) + write_seconds(r) + denoise_seconds(r);
}

double render_budget_usable(const struct render *r) {
    const double limit = time_limit(r), edges = r->image ? r->image->edge_seconds : 0.0;
    if (isinf(limit)) return limit;
    return render_agreed(r, fmax(limit - (finish_seconds(r) - edges), USABLE_LEAST * limit));
}

double render_budget_left(const struct render *r) {
    return render_agreed(r, render_time_left(r) - finish_seconds(r));
}

double render_budget_for_edges(const struct render *r) {
    return render_agreed(r, fmax(render_time_left(r) - write_seconds(r), 0.0));
}

void render_budget_begin(struct render *r) {
    const satin_film *film = r->image->film;
    const bool full_float = film->full_float || r->callbacks.full_float;
    if (!(r->options.time > 0.0)) return;
    r->progress.write_pixel_seconds = film_exr_pixel_seconds(film->channel_count, full_float);
    r->progress.noise_pixel_seconds = render_noise_pixel_seconds();
    const double pixels = (double)r->options.width * (double)r->options.height;
    if (render_edges_on(&r->options))
        r->image->edge_seconds = fmin(EDGES_SECONDS * pixels / parallel_cores_had(r->pool),
                                      EDGES_MOST * r->options.time);
}

// ---- Limits of loops ----------------------------------------------------------------------------

// INFINITY if there is no time limit, as is any fraction of it.
void render_limit_photon_pilot(struct render *r) {
    const double fraction = r->denoiser ? PILOT_DENOISED : PILOT_FRACTION;
    r->progress.deadline = render_elapsed(r) + fraction * render_time_left(r);
}
void render_limit_tables(struct render *r) {
    r->progress.deadline = TABLES_UNTIL * render_budget_usable(r);
}

void render_limit_bounces(struct render *r, double start, double done) {
    r->progress.deadline = start + BOUNCES_FRACTION * (time_limit(r) - start) * done;
}

// The fraction of the time for records at which the error of the image is least, whose variance is
// `variance` by one sample.
static double balance(const struct render *r, const struct render_pace *pace, double variance) {
    const double left = render_budget_left(r);
    const double pixels = (double)r->options.width * (double)r->options.height;
    double least = INFINITY, best = RECORDS_FRACTION;
    for (int i = 0; left > 0.0 && i <= BALANCE_STEPS; i++) {
        const double image = IMAGE_LEAST + (IMAGE_MOST - IMAGE_LEAST) * i / BALANCE_STEPS;
        const double n = image * left * pace->samples / pixels;
        const double rays = (1.0 - image) * left * pace->rays / pixels;
        const double error =
            variance / (n * sqrt(n)) + ERROR_RAYS * pace->indirect2 / fmax(rays, 1e-9);
        if (!(error < least)) continue;
        least = error;
        best = 1.0 - image;
    }
    return best;
}

// Records end after the fraction `most` of the remaining time, their first round after `covered`.
static void limit_records(struct render *r, double most, double covered) {
    const double now = render_elapsed(r), left = render_budget_left(r);
    r->progress.deadline = now + most * left;
    r->progress.covered = now + covered * left;
}

void render_limit_records(struct render *r, const struct render_pace *measured) {
    const double variance = measured ? measured->variance / VARIANCE_GAIN : 0.0;
    const double fraction = measured ? balance(r, measured, variance) : RECORDS_FRACTION;
    limit_records(r, fraction, COVER_FRACTION * fraction);
}

void render_limit_first_records(struct render *r, const struct render_pace *measured) {
    const double fraction = balance(r, measured, measured->direct / DIRECT_GAIN);
    limit_records(r, fmin(COVER_MOST * fraction, RECORDS_FRACTION),
                  COVER_FRACTION * fmin(fraction, RECORDS_FRACTION));
}

bool render_budget_traces_paths(const struct render *r, double samples) {
    const double pixels = (double)r->options.width * (double)r->options.height;
    return render_can_trace_paths(r) && render_budget_left(r) * samples < PATHS_BELOW * pixels;
}

int render_budget_pilot(const struct render *r, double samples) {
    const double fit = IMAGE_PILOT * render_budget_left(r) * samples / RENDER_PILOT_SAMPLES;
    return (int)fmin(sqrt(fmax(fit, 0.0)), RENDER_PILOT_SIDE);
}

void render_limit_coarse_records(struct render *r) {
    r->progress.deadline = render_elapsed(r) + COARSE_ROUND * render_budget_left(r);
}

double render_budget_first_round(const struct render *r) {
    const double now = render_elapsed(r);
    return fmax(r->progress.covered - now, COVER_LEAST * (r->progress.deadline - now));
}

bool render_budget_next_round(const struct render *r, double seconds) {
    return r->progress.deadline - render_elapsed(r) > NEXT_ROUND * seconds;
}

void render_limit_image(struct render *r) {
    // No pixel is to miss its first sample for edges, which are planned after it.
    if (r->image && r->image->taken == 0) r->image->edge_seconds = 0.0;
    r->progress.deadline = render_elapsed(r) + render_budget_left(r);
}

bool render_budget_fits_noise(double unsampled) { return unsampled <= 1.0 - NOISE_SAMPLED; }

double render_budget_unsampled(const struct render *r, double sample_seconds) {
    const double pixels = (double)r->options.width * (double)r->options.height;
    const double fit = fmax(render_budget_left(r), 0.0) / sample_seconds;
    return fmax(1.0 - fit / pixels, 0.0);
}

void render_limit_coarse(struct render *r) {
    r->progress.deadline = render_elapsed(r) + COARSE_SECONDS;
}

satin_status render_limit_end(struct render *r, satin_status status) {
    r->progress.deadline = INFINITY;
    return status == SATIN_CANCELLED && !render_cancelled(r) ? SATIN_OK : status;
}

double render_limit_lift(struct render *r) {
    const double before = r->progress.deadline;
    r->progress.deadline = INFINITY;
    return before;
}

void render_limit_restore(struct render *r, double before) { r->progress.deadline = before; }

bool render_time_remains(const struct render *r) {
    return render_elapsed(r) < r->progress.deadline;
}

// ---- The image ----------------------------------------------------------------------------------

int render_budget_first_stride(int width, int height) {
    int stride = FIRST_STRIDE;
    while ((width / stride) * (height / stride) > FIRST_MOST) stride *= 2;
    return stride;
}

// A new picture each second is enough for a viewer.
static const double SNAPSHOT_SECONDS = 1.0;
// The largest fraction of the time of all threads that snapshots take, and of that of their own,
// which holds its tile for so long.
static const double SNAPSHOT_OF_ALL = 0.02, SNAPSHOT_OF_THREAD = 0.1;

double render_budget_snapshot(double seconds, int threads) {
    const double all = seconds / (SNAPSHOT_OF_ALL * (double)threads);
    return fmax(SNAPSHOT_SECONDS, fmax(all, seconds / SNAPSHOT_OF_THREAD));
}

uint32_t render_budget_equal_samples(const satin_options *o) {
    const uint32_t spp = (uint32_t)o->spp;
    if (!o->adaptive_sampling || gather_traces_paths(o)) return spp;
    if (spp < 2 * EQUAL_LEAST) return spp;
    if (o->time > 0.0) return EQUAL_LEAST;
    return spp / EQUAL_FRACTION > EQUAL_LEAST ? spp / EQUAL_FRACTION : EQUAL_LEAST;
}

// The number of samples that fit into the next pass.
static double fitting_samples(const struct render *r, double sample_seconds) {
    const double pixels = (double)r->options.width * (double)r->options.height;
    const double fit = render_budget_left(r) / sample_seconds;
    if (fit < PASS_LEAST * pixels) return 0.0;
    return fit > 2.0 * pixels ? 0.5 * fit : fit;
}

// Where fewer samples per pixel than LIGHTS_SPP fit, each has fewer light samples so that as many
// fit, as far as LIGHTS_FEWEST allows: with less the variance by one of them is not known. Pixels
// of one sample have no noise to go by. With 2 instead of 1.5, as when edges were ragged where
// pixels had few samples, relMSE is 1.16 times that at 2 CPU seconds and 200x200 (geometric mean of
// six scenes, four seeds), and in cornell-glossy, cornell-metal and caustic 1.6, 1.2 and 1.04 times
// at 8 and 400x400; with 1 it is .98, 1.04 and .88 times there, but one of eight seeds of
// cornell-metal at 2 seconds has 3 times as much. A sample without direct light takes LIGHTS_REST
// of the time of one with 8 light samples in bathroom.
static const double LIGHTS_SPP = 1.5, LIGHTS_FEWEST = 2.0, LIGHTS_REST = 0.5;

uint32_t render_budget_lights(const struct render *r, double sample_seconds) {
    const double pixels = (double)r->options.width * (double)r->options.height;
    const double left = render_budget_left(r) - NOISE_LATE * noise_filter_kept(r);
    const double samples = left / sample_seconds / pixels;
    const double all = (double)r->options.light_samples;
    const double fraction = (samples / LIGHTS_SPP - LIGHTS_REST) / (1.0 - LIGHTS_REST);
    return (uint32_t)fmax(fmin(all * fraction, all), fmin(all, LIGHTS_FEWEST));
}

uint64_t render_budget_pass(const struct render *r, uint64_t done, double sample_seconds) {
    const satin_options *o = &r->options;
    const uint64_t pixels = (uint64_t)o->width * (uint64_t)o->height;
    const uint64_t all = (uint64_t)o->spp * pixels;
    const uint64_t equal = render_budget_equal_samples(o) * pixels;
    if (done >= all) return 0;
    uint64_t want = done && o->integrator != SATIN_SPPM ? done : pixels;
    if (want > all - done) want = all - done;
    if (done < equal && want > equal - done) want = equal - done;
    const double fit = done ? fitting_samples(r, sample_seconds) : INFINITY;
    if (fit < (double)want) want = (uint64_t)fit;
    return o->integrator == SATIN_SPPM ? want - want % pixels : want;
}

int render_budget_first_gathers(const satin_options *o) {
    return o->time > 0.0 ? 1 : RENDER_GATHERS_MOST;
}

// Where at least GATHERS_SPP samples per pixel fit, the first ones show the noise of gather rays,
// by two of them. Where fewer do, more samples gain more than more rays of a sample.
static const double GATHERS_SPP = 2.0;

uint32_t render_budget_gathers(const struct render *r, double sample_seconds) {
    const double pixels = (double)r->options.width * (double)r->options.height;
    return render_budget_left(r) / sample_seconds < GATHERS_SPP * pixels ? 1 : 2;
}

// The standard deviation of light along one ray of a hemisphere is about its mean. With a time
// limit it is that of one ray per sample, however many it has: were it lower, fewer records would
// be interpolated, and a caustic has 1.3 times the variance. Where a cache is off, the rays of a
// record are distributed over the samples of the pixel.
struct shade_missing render_budget_missing(const satin_options *o, double core_seconds) {
    const int spp = o->spp > 1 ? o->spp : 1;
    const double pixels = (double)o->width * (double)o->height;
    const double timed = fmax(CORE_SECOND_SAMPLES * core_seconds / pixels, 1.0);
    const double rays = o->time > 0.0 ? timed : (double)spp * render_budget_first_gathers(o);
    const int hemisphere = o->irradiance_rays / spp;
    return (struct shade_missing){
        .hemisphere = hemisphere > HEMISPHERE_RAYS_LEAST ? hemisphere : HEMISPHERE_RAYS_LEAST,
        .deviation = 1.0f / sqrtf((float)rays)};
}

// About four for the eye ray and its surface, and two for interpolated light.
float render_budget_sample_cost(const struct shade_counts *c, bool gathers) {
    const uint64_t rays = c->rays - (gathers ? c->missing_rays : 0);
    const double work = 4.0 * (double)c->points + 2.0 * (double)c->interpolated +
                        (double)RENDER_GATHER_COST * (double)rays;
    return c->samples ? (float)(work / (double)c->samples) : 1.0f;
}
