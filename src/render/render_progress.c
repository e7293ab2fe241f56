// SPDX-License-Identifier: Apache-2.0
// The one place where progress is told and a cancellation is seen.
#include <stdio.h>
#include <string.h>

#include "render/render_state.h"

static const double TELL_EVERY = 0.1;  // seconds

// Compressing a pixel's channels on one core is most of writing a film.
static const double WRITE_SECONDS = 0.05, WRITE_PIXEL_SECONDS = 0.9e-6;

// Statistics names must be static text: one for each stage.
static const char *seconds_name(const char *stage) {
    static const char *const name[][2] = {
        {"photons", "time.photons_s"},       {"BRDF tables", "time.tables_s"},
        {"deeper records", "time.levels_s"}, {"records", "time.records_s"},
        {"image", "time.image_s"},           {"denoising", "time.denoise_s"},
    };
    for (size_t i = 0; i < sizeof name / sizeof *name; i++)
        if (strcmp(name[i][0], stage) == 0) return name[i][1];
    return NULL;
}

double render_elapsed(const struct render *r) { return stats_wall() - r->start; }

double render_time_left(const struct render *r) {
    return r->options.time > 0.0 ? r->options.time - render_elapsed(r) : INFINITY;
}

double render_write_seconds(const struct render *r) {
    double pixels = (double)r->options.width * (double)r->options.height;
    return WRITE_SECONDS + WRITE_PIXEL_SECONDS * pixels / parallel_threads(r->pool) +
           render_denoise_seconds(r);
}

static void tell(struct render *r, double done) {
    if (!r->callbacks.progress) return;
    double now = stats_wall();
    r->told = now;
    double seconds = now - r->stage_start;
    satin_progress progress = {
        .stage = r->stage,
        .unit = r->unit,
        .done = done,
        .rate = seconds > 0.0 ? done * r->stage_items / seconds : 0.0,
        .elapsed = now - r->start,
    };
    if (r->callbacks.progress(r->callbacks.progress_user, &progress)) r->cancelled = true;
}

static bool on_progress(void *user, double done) {
    struct render *r = user;
    if (!r->cancelled && stats_wall() - r->told >= TELL_EVERY)
        tell(r, r->share_done + done * r->share_span);
    return (r->cancelled && !r->sketch) || render_elapsed(r) > r->stop_at;
}

bool render_progress_tell(struct render *r, double done) {
    if (r->cancelled) return true;
    if (stats_wall() - r->told >= TELL_EVERY) tell(r, done);
    return !r->cancelled;
}

void render_progress_install(struct render *r) { parallel_set_progress(r->pool, on_progress, r); }

void render_stage(struct render *r, const char *stage, const char *unit, double items) {
    double now = stats_wall();
    if (r->stage) {
        const char *name = seconds_name(r->stage);
        if (name) stats_add(&r->stats, name, now - r->stage_start);
        if (!r->cancelled) tell(r, 1.0);
    }
    r->stage = stage;
    r->unit = unit;
    r->stage_start = now;
    r->stage_items = items;
    render_stage_part(r, 0.0, 1.0);
}

void render_stage_part(struct render *r, double done, double span) {
    r->share_done = done;
    r->share_span = span;
}
