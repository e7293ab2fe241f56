// SPDX-License-Identifier: Apache-2.0
// The course of a render and its progress. The pool and the denoiser call functions of this file
// for the loops of all stages, which call the user's progress function; that may cancel the render.
#include "render/render_state.h"

#include <math.h>
#include <string.h>

#include "render/options_quality.h"

static const double REPORT_EVERY = 0.1;  // seconds

// A stage in reports: its name, the unit of its items, and the statistic for its seconds.
static const struct stage_report {
    const char *name, *unit, *seconds;
    const char *part;  // name of the part of the work, if the step does not begin one of its own
} stage_reports[] = {
    [STAGE_SETUP] = {"setup", "", NULL, "other"},
    [STAGE_FORECAST] = {"forecast", "", "time.forecast_s", "forecast"},
    [STAGE_PHOTONS] = {"photons", "photons", "time.photons_s", "photons"},
    [STAGE_TABLES] = {"BRDF tables", "materials", "time.tables_s", "tables"},
    [STAGE_BOUNCES] = {"indirect bounces", "", "time.bounces_s", "bounces"},
    [STAGE_RECORDS] = {"records", "", "time.records_s", "records"},
    [STAGE_IMAGE] = {"image", "samples", "time.image_s", "image"},
    [STAGE_DENOISE] = {"denoising", "pixels", "time.denoise_s", "denoise"},
    [STAGE_FILM] = {"film", "", NULL, "film"},
};

const char *render_stage_name(enum render_stage stage) { return stage_reports[stage].name; }

// The stages of a course. Where there are records, those of indirect bounces come before them.
enum {
    PHOTONS = 1 << STAGE_PHOTONS,
    TABLES = 1 << STAGE_TABLES,
    RECORDS = 1 << STAGE_BOUNCES | 1 << STAGE_RECORDS
};

static const struct course_steps steps_of[] = {
    [COURSE_TWO_PASS] = {SATIN_TWO_PASS, PHOTONS | TABLES | RECORDS},
    [COURSE_SHORT_PATHS] = {SATIN_TWO_PASS, TABLES},
    [COURSE_FIRST_PASS] = {SATIN_TWO_PASS, PHOTONS | TABLES | 1 << STAGE_BOUNCES},
    [COURSE_PHOTONS] = {SATIN_PHOTONS, PHOTONS},
    [COURSE_DIRECT] = {SATIN_DIRECT},
    [COURSE_PATHS] = {SATIN_PATH},
    [COURSE_SPPM] = {SATIN_SPPM, PHOTONS, .passes = true},
    [COURSE_COARSE] = {SATIN_TWO_PASS, .coarse = true},
    [COURSE_COARSE_DIRECT] = {SATIN_DIRECT, .coarse = true},
};

// The first pass of two, seen directly: paths and direct light are what their integrators show.
static enum render_course first_pass_course(satin_first_pass first_pass) {
    if (first_pass == SATIN_FIRST_PATH) return COURSE_PATHS;
    return first_pass == SATIN_FIRST_NONE ? COURSE_DIRECT : COURSE_FIRST_PASS;
}

enum render_course render_first_course(const satin_options *options) {
    switch (options->integrator) {
        case SATIN_PATH:
            return COURSE_PATHS;
        case SATIN_DIRECT:
            return COURSE_DIRECT;
        case SATIN_PHOTONS:
            return COURSE_PHOTONS;
        case SATIN_SPPM:
            return COURSE_SPPM;
        default:
            if (!options->final_gather) return first_pass_course(options->first_pass);
            return gather_indirect(options, 1) ? COURSE_TWO_PASS : COURSE_SHORT_PATHS;
    }
}

void render_take_course(struct render *r, enum render_course course) {
    r->progress.course = course;
    r->options.integrator = steps_of[course].integrator;
}

const struct course_steps *render_steps(const struct render *r) {
    return &steps_of[r->progress.course];
}

// A hundredth of a stage, and half a second, are the least by which its speed is known.
static const double SPEED_DONE = 0.01, SPEED_SECONDS = 0.5;

// The seconds of the image over those of all before it, with the samples of the preset: the median
// of .45 to 2.1, in the data scenes and the rooms by others at draft, preview and production, so
// that the whole is within .65 to 1.4 times what it is taken to be.
static const double IMAGE_OF_REST = 1.2;

// The seconds that the image will take, where all before it takes `rest`.
static double image_after(const struct render *r, double rest) {
    const satin_options *o = &r->options;
    if (r->progress.forecast.image > 0.0) return r->progress.forecast.image;
    return IMAGE_OF_REST * rest * (double)o->spp / options_quality_spp(o->quality);
}

// The seconds that the present stage is forecast to take; INFINITY: there is no forecast of it.
static double stage_forecast(const struct render_progress *at) {
    if (!(at->forecast.image > 0.0)) return INFINITY;
    if (at->stage == STAGE_TABLES) return 0.0;
    if (at->stage == STAGE_RECORDS) return at->forecast.records;
    return at->stage == STAGE_IMAGE ? at->forecast.image : INFINITY;
}

// The seconds until the present stage ends, `seconds` after it began: by the forecast, and the more
// of it is done, by its speed so far. At its beginning that is misleading: the first samples of
// pixels take less time than those of noisy pixels. INFINITY: not known.
static double stage_left(const struct render *r, double done, double seconds) {
    const double own = done - r->progress.skipped, forecast = stage_forecast(&r->progress);
    const bool measured = own > SPEED_DONE && seconds > SPEED_SECONDS;
    if (!measured) return fmax(forecast - seconds, 0.0);
    const double whole = seconds / own;
    return (1.0 - done) * (isfinite(forecast) ? (1.0 - done) * forecast + done * whole : whole);
}

double render_progress_left(const struct render *r, double done, double elapsed) {
    const struct render_progress *at = &r->progress;
    const double seconds = elapsed - (at->stage_start - at->start);
    const bool limited = r->options.time > 0.0;
    const double limit = limited ? fmax(r->options.time - elapsed, 0.0) : INFINITY;
    // Photons and tables say nothing of the cost of records and image.
    const bool records = at->stage == STAGE_RECORDS && !r->callbacks.animation;
    const bool early = at->stage < STAGE_RECORDS && at->forecast.image > 0.0;
    const bool late = at->stage == STAGE_IMAGE || at->stage == STAGE_DENOISE;
    double left = INFINITY;
    if (early || records || late) left = stage_left(r, done, seconds);
    if (early) left = fmax(left, at->photons_end - elapsed);
    if (early) left += at->forecast.records;
    if (early || records) left += image_after(r, elapsed + left);
    if (r->frames.view || r->motion.at_rest) left = render_frames_left(r, left, elapsed);
    left = fmin(left, limit);
    return isfinite(left) ? left : -1.0;
}

// The fraction of the stage that is done. A time limit ends the image, whatever the number of its
// samples.
static double fraction_done(const struct render *r, double done, double elapsed) {
    const struct render_progress *at = &r->progress;
    if (at->stage != STAGE_IMAGE || !(r->options.time > 0.0)) return done;
    const double begin = at->stage_start - at->start, end = fmax(r->options.time, begin);
    const double timed = elapsed < end ? (elapsed - begin) / (end - begin) : 1.0;
    return fmax(done, timed);
}

static void report_now(struct render *r, double done) {
    struct render_progress *at = &r->progress;
    at->last_report = stats_wall();
    if (!r->callbacks.progress) return;
    const double seconds = at->last_report - at->stage_start;
    const double elapsed = at->last_report - at->start;
    const satin_progress progress = {
        .stage = stage_reports[at->stage].name,
        .unit = stage_reports[at->stage].unit,
        .done = fraction_done(r, done, elapsed),
        .rate = seconds > 0.0 ? fmax(done - at->skipped, 0.0) * at->items / seconds : 0.0,
        .elapsed = elapsed,
        .left = render_progress_left(r, done, elapsed),
        .frame = r->frames.begun,
        .frames = render_frames_count(r),
    };
    if (!r->callbacks.progress(r->callbacks.progress_user, &progress)) return;
    if (at->stage != STAGE_SETUP) at->cancelled_in = at->stage;
}

bool render_progress_report(struct render *r, double done) {
    if (render_cancelled(r)) return true;
    if (stats_wall() - r->progress.last_report >= REPORT_EVERY) {
        report_now(r, done);
        render_snapshot_send(r);
    }
    return !render_cancelled(r);
}

// Parts of the work for a photon map in their order, and the fraction of it after which they begin:
// the median of the data scenes and the rooms by others at preview.
static const struct {
    const char *name;
    double begin;
} map_order[] = {{"visibility", 0.0}, {"emission", 0.06}, {"trace", 0.08},    {"sort", 0.4},
                 {"index", 0.42},     {"clusters", 0.46}, {"estimate", 0.49}, {"smooth", 0.87},
                 {"direct", 0.98},    {"", 1.0}};

static const double MAP_ESTIMATED = 0.49;  // from here on, an earlier part is that of another map

// The fraction of the photons that is done, when `done` of a loop is. A part has several loops. How
// many maps there will be is not known: each takes half of what is left.
static double photons_done(struct render_progress *at, const char *part, double done) {
    for (size_t i = 0; i + 1 < sizeof map_order / sizeof *map_order; i++) {
        if (strcmp(map_order[i].name, part) != 0) continue;
        const double begin = map_order[i].begin, end = map_order[i + 1].begin;
        if (begin < at->map_at && at->map_at >= MAP_ESTIMATED) {
            at->maps_done += 0.5 * (1.0 - at->maps_done);
            at->map_at = begin;
        }
        at->map_at = fmax(at->map_at, begin);
        return at->maps_done + 0.5 * (1.0 - at->maps_done) * (begin + done * (end - begin));
    }
    return 0.0;
}

// Estimates at photons of caustics, and their smoothing, over those at as many of indirect light.
static const double CAUSTICS_OF_REST = 1.4;

// When photons end at the earliest, as soon as those of caustics are traced: there may be many more
// of them than of indirect light, whose irradiance has been precomputed by then.
static void expect_caustics(struct render *r) {
    struct render_progress *at = &r->progress;
    const double indirect = stats_get(&r->stats, "photons.stored_indirect"),
                 caustic = stats_get(&r->stats, "photons.stored_caustic"),
                 seconds = stats_get(&r->stats, "photons.precompute_s");
    if (caustic == at->caustics || !(indirect > 0.0)) return;
    at->caustics = caustic;
    at->photons_end = render_elapsed(r) + CAUSTICS_OF_REST * seconds * caustic / indirect;
}

// The fraction of the current range that is done, when `done` of a loop is. A pass with photons of
// its own takes as long as the passes before it.
static double range_done(struct render *r, double done) {
    struct render_progress *at = &r->progress;
    if (render_steps(r)->passes && at->stage == STAGE_IMAGE) {
        const double own = at->loop_done - at->skipped;
        const double before = own > 0.0 ? (at->range_start - at->stage_start) / own : INFINITY;
        done = fmin((stats_wall() - at->range_start) / (before * at->loop_span), 1.0);
    } else if (at->stage == STAGE_PHOTONS) {
        done = photons_done(at, parallel_work_name(r->pool), done);
        expect_caustics(r);
    }
    return at->range_done = fmax(at->range_done, done);
}

// For the pool: whether the current loop must stop. A coarse image after a cancellation is
// completed.
static bool loop_must_end(void *user, double done) {
    struct render *r = user;
    const struct render_progress *at = &r->progress;
    render_progress_report(r, at->loop_done + range_done(r, done) * at->loop_span);
    const bool unwanted = render_cancelled(r) && !render_steps(r)->coarse;
    const bool late = stats_wall() - at->start > at->deadline;
    return unwanted || late || render_checkpoint_due(r);
}

void render_progress_install(struct render *r) { parallel_set_progress(r->pool, loop_must_end, r); }

void render_stage_begin(struct render *r, enum render_stage stage, double items) {
    const double now = stats_wall();
    struct render_progress *at = &r->progress;
    if (stage_reports[at->stage].seconds)
        stats_add(&r->stats, stage_reports[at->stage].seconds, now - at->stage_start);
    const bool reported = at->stage != STAGE_SETUP && at->stage != STAGE_FILM;
    if (reported && !render_cancelled(r)) report_now(r, 1.0);
    if (r->pool) parallel_begin_part(r->pool, stage_reports[stage].part);
    at->stage = stage;
    at->stage_start = now;
    at->items = items;
    at->skipped = 0.0;
    render_stage_range(r, 0.0, 1.0);
}

void render_stage_skip(struct render *r, double done) { r->progress.skipped = done; }

void render_stage_range(struct render *r, double done, double span) {
    struct render_progress *at = &r->progress;
    at->loop_done = done;
    at->loop_span = span;
    at->range_start = stats_wall();
    at->range_done = at->maps_done = at->map_at = at->photons_end = at->caustics = 0.0;
}
