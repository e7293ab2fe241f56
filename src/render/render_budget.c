// SPDX-License-Identifier: Apache-2.0
// What a time limit is divided into: every decision of a render that depends on its clock. A step
// gets a fraction of the limit, or of what is left of it, and paces are measured while it renders;
// so the same fractions hold for any scene and any number of cores. In the order of the light:
//
//   photons           a pilot of a sixteenth, then as many as fit until PHOTONS_UNTIL
//   BRDF tables       until TABLES_UNTIL
//   indirect bounces  BOUNCES_FRACTION of what is left then
//   records           RECORDS_FRACTION of what is left then, until their first round has been
//                     measured; then the fraction at which the error of the image is least
//   image             what is left, without the time that denoising and writing take
//
// What buys how much quality, before the render begins, is in options_budget.c.
#include "render/render_budget.h"

#include "render/render_state.h"

// Of the time limit. A pilot of photons that takes longer than PILOT_UNTIL is given up.
static const double PILOT_UNTIL = 0.5, PHOTONS_UNTIL = 0.3, TABLES_UNTIL = 0.45;
// Of the time that the pilot foretells for photons, what is used; and the number of times the
// pilot's photons from which on another pass gains more than it costs.
static const double PHOTONS_CAUTION = 0.9, PHOTONS_AGAIN = 3.0;
// Of the time that is left.
static const double BOUNCES_FRACTION = 0.3, RECORDS_FRACTION = 0.5;
// Of the time of records, what their first round is to take, so that all pixels have some.
static const double COVER_FRACTION = 0.5;

// Of the time limit, what is kept for denoising at most: a large image is late rather than left
// without samples.
static const double DENOISE_FRACTION = 0.5;
// A cancelled render is over within a moment: so long may its first look take, and so long its
// denoising [s].
static const double LOOK_SECONDS = 0.5, DENOISE_SECONDS = 0.5;

// Compressing a pixel's channels on one core is most of writing a film.
static const double WRITE_SECONDS = 0.05, WRITE_PIXEL_SECONDS = 0.9e-6;

// Samples per pixel below which another pass of the image is not worth its overhead.
static const double PASS_LEAST = 0.1;

// The model of balance(). Measured on the data scenes at 10 to 20 gather rays and 6 to
// 15 samples per pixel: the relative squared error of a pixel that is all indirect, times the rays
// per pixel, was 2.7e-3 to 1e-2. The image had a variance less than V by 5 to 12 in closed rooms, 2
// to 3 in a furnished one: V is of two halves of two samples with few light samples, and of three
// colours.
static const double ERROR_RAYS = 5e-3, VARIANCE_GAIN = 5.0;
// The image gets at least and at most so much of what is left.
static const double IMAGE_LEAST = 0.2, IMAGE_MOST = 0.8;
enum { BALANCE_STEPS = 40 };

static double time_limit(const struct render *r) {
    return r->options.time > 0.0 ? r->options.time : INFINITY;
}

double render_elapsed(const struct render *r) { return stats_wall() - r->budget.start; }

double render_time_left(const struct render *r) { return time_limit(r) - render_elapsed(r); }

// ---- After the image ----------------------------------------------------------------------------

static double denoise_seconds(const struct render *r) {
    if (!r->denoiser) return 0.0;
    const double pixels = (double)r->options.width * (double)r->options.height;
    const double seconds = film_denoiser_pace(r->denoiser) * pixels;
    return fmin(seconds, DENOISE_FRACTION * time_limit(r));
}

bool render_budget_denoises(const struct render *r) {
    return !render_cancelled(r) || denoise_seconds(r) <= DENOISE_SECONDS;
}

static double finish_seconds(const struct render *r) {
    const double pixels = (double)r->options.width * (double)r->options.height;
    return WRITE_SECONDS + WRITE_PIXEL_SECONDS * pixels / parallel_threads(r->pool) +
           denoise_seconds(r);
}

// Seconds that are left for records and image.
static double image_seconds(const struct render *r) {
    return render_time_left(r) - finish_seconds(r);
}

// ---- Limits of loops ----------------------------------------------------------------------------

// INFINITY where there is no time limit: a fraction of that is no limit either.
void render_limit_pilot(struct render *r) { r->budget.stop_at = PILOT_UNTIL * time_limit(r); }
void render_limit_tables(struct render *r) { r->budget.stop_at = TABLES_UNTIL * time_limit(r); }

void render_limit_bounces(struct render *r, double start, double done) {
    r->budget.stop_at = start + BOUNCES_FRACTION * (time_limit(r) - start) * done;
}

// The fraction of records at which the error of the image is least.
static double balance(const struct render *r, const struct render_pace *pace) {
    const double left = image_seconds(r);
    const double pixels = (double)r->options.width * (double)r->options.height;
    double least = INFINITY, best = RECORDS_FRACTION;
    for (int i = 0; left > 0.0 && i <= BALANCE_STEPS; i++) {
        const double image = IMAGE_LEAST + (IMAGE_MOST - IMAGE_LEAST) * i / BALANCE_STEPS;
        const double n = image * left * pace->samples / pixels;
        const double rays = (1.0 - image) * left * pace->rays / pixels;
        const double error = pace->variance / VARIANCE_GAIN / (n * sqrt(n)) +
                             ERROR_RAYS * pace->indirect2 / fmax(rays, 1e-9);
        if (!(error < least)) continue;
        least = error;
        best = 1.0 - image;
    }
    return best;
}

void render_limit_records(struct render *r, const struct render_pace *measured) {
    const double fraction = measured ? balance(r, measured) : RECORDS_FRACTION;
    r->budget.stop_at = render_elapsed(r) + fraction * image_seconds(r);
}

void render_limit_image(struct render *r) {
    r->budget.stop_at = render_elapsed(r) + image_seconds(r);
}

void render_limit_look(struct render *r) { r->budget.stop_at = render_elapsed(r) + LOOK_SECONDS; }

satin_status render_limit_end(struct render *r, satin_status status) {
    r->budget.stop_at = INFINITY;
    return status == SATIN_CANCELLED && !render_cancelled(r) ? SATIN_OK : status;
}

double render_limit_lift(struct render *r) {
    const double before = r->budget.stop_at;
    r->budget.stop_at = INFINITY;
    return before;
}

void render_limit_restore(struct render *r, double before) { r->budget.stop_at = before; }

bool render_time_remains(const struct render *r) { return render_elapsed(r) < r->budget.stop_at; }

// ---- Divisions ----------------------------------------------------------------------------------

double render_budget_photons(const struct render *r, double pilot_seconds) {
    const double left = PHOTONS_UNTIL * time_limit(r) - render_elapsed(r);
    const double times = PHOTONS_CAUTION * left / pilot_seconds;
    return times < PHOTONS_AGAIN ? 0.0 : times;
}

double render_budget_first_round(const struct render *r) {
    return COVER_FRACTION * (r->budget.stop_at - render_elapsed(r));
}

double render_budget_pass(const struct render *r, double sample_seconds) {
    const double pixels = (double)r->options.width * (double)r->options.height;
    const double fit = image_seconds(r) / sample_seconds;
    if (fit < PASS_LEAST * pixels) return 0.0;
    return fit > 2.0 * pixels ? 0.5 * fit : fit;
}
