// SPDX-License-Identifier: Apache-2.0
// Animations: the cameras of all frames, for which photons, records and all else is made, and then
// the frames, one after the other. An image changes nothing that another one reads.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "base/fileio.h"
#include "render/render_image.h"

// ---- Cameras ------------------------------------------------------------------------------------

// The camera of a view: the sensor of the scene elsewhere, and perhaps with another angle.
static satin_status make_camera(const struct render *r, const satin_view *view, int number,
                                struct camera *out) {
    *out = r->scene.camera;
    if (out->orthographic || out->spherical)
        return log_fail(r->log, SATIN_ERROR_INPUT,
                        "views of an animation need a perspective sensor");
    if (!mat4_look_at(v3_of_doubles(view->origin), v3_of_doubles(view->target),
                      v3_of_doubles(view->up), &out->to_world))
        return log_fail(r->log, SATIN_ERROR_INPUT,
                        "frame %d has no view: origin and target coincide, or up is along the view",
                        number);
    if (view->fov == 0.0) return SATIN_OK;
    if (!(view->fov >= (double)SCENE_FOV_MIN && view->fov < 180.0))
        return log_fail(r->log, SATIN_ERROR_INPUT,
                        "frame %d: the angle of view is %g, but must be in [%g, 180) degrees",
                        number, view->fov, (double)SCENE_FOV_MIN);
    out->tan_x = (float)tan(view->fov * 3.14159265358979323846 / 360.0);
    out->tan_y = r->scene.camera.tan_y / r->scene.camera.tan_x * out->tan_x;
    return SATIN_OK;
}

// Sets the cameras of `count` frames.
static satin_status set_views(struct render *r, const satin_animation *a, int count) {
    const struct camera *own = &r->scene.camera;
    // With the size of the film, that of the options too, the ratio of height and width changed.
    const float film = (float)r->scene.film.height / (float)r->scene.film.width;
    const float aspect = own->spherical ? film : own->tan_y / own->tan_x;
    satin_status status = SATIN_OK;
    for (int i = 0; i < count && status == SATIN_OK; i++) {
        struct camera *view = &r->frames.view[i];
        if (a->views) {
            status = make_camera(r, &a->views[i], a->number + i, view);
            continue;
        }
        *view = r->scene.sensor[i];
        if (!view->spherical) view->tan_y = aspect * view->tan_x;
    }
    return status;
}

static satin_status check_animation(const struct render *r, const satin_animation *a, int count) {
    if (count < 1 || !a->frame || a->number < 0 || a->number > INT32_MAX - count)
        return log_fail(r->log, SATIN_ERROR_ARGUMENT, "the animation has no frames or no function");
    if (a->first < a->number || a->last >= a->number + count || a->first > a->last)
        return log_fail(r->log, SATIN_ERROR_INPUT,
                        "frames %d to %d are not all of the frames %d to %d", a->first, a->last,
                        a->number, a->number + count - 1);
    if (r->options.time > 0.0)
        return log_fail(r->log, SATIN_ERROR_INPUT,
                        "an animation has no time limit, as its frames would depend on the time "
                        "that others take; set spp instead of time");
    if (r->options.integrator == SATIN_SPPM)
        return log_fail(r->log, SATIN_ERROR_INPUT, "the integrator sppm renders no animations");
    return SATIN_OK;
}

satin_status render_views(struct render *r) {
    const satin_animation *a = r->callbacks.animation;
    if (r->motion.at_rest) {
        // Photons are aimed at what all views see, as those of the scene at rest: what the records
        // of the two are compared by has the same noise.
        r->scene.camera = *r->motion.camera;
        r->scene.view = r->motion.at_rest->scene.view;
        r->scene.view_count = r->motion.at_rest->scene.view_count;
    }
    if (!a) return SATIN_OK;
    const int count = a->views ? a->count : (int)r->scene.sensor_count;
    satin_status status = check_animation(r, a, count);
    if (status != SATIN_OK) return status;
    r->frames.view = array_new((size_t)count, sizeof *r->frames.view);
    r->frames.records = array_new((size_t)count, sizeof *r->frames.records);
    r->frames.complete = array_new((size_t)count, sizeof *r->frames.complete);
    if (!r->frames.view || !r->frames.records || !r->frames.complete) return SATIN_ERROR_MEMORY;
    status = set_views(r, a, count);
    r->scene.view = r->frames.view;
    r->scene.view_count = (uint32_t)count;
    return status;
}

void render_views_free(struct render *r) {
    free(r->frames.view);
    free(r->frames.records);
    free(r->frames.complete);
    // That of a frame is the animation's.
    if (!r->motion.at_rest) free(r->frames.job);
}

uint64_t render_views_hash(const struct render *r) {
    if (!r->frames.view) return 0;
    uint64_t hash = FILEIO_HASH;
    for (uint32_t i = 0; i < r->scene.view_count; i++) {
        const struct camera *c = &r->frames.view[i];
        const float values[] = {
            c->tan_x,    c->tan_y,    c->near_clip,
            c->far_clip, c->aperture, c->focus_distance,
            c->shift.x,  c->shift.y,  c->orthographic ? 1.0f : c->spherical ? 2.0f : 0.0f};
        hash = fileio_hash(hash, values, sizeof values);
        hash = fileio_hash(hash, &c->to_world, sizeof c->to_world);
    }
    return hash;
}

// ---- Frames -------------------------------------------------------------------------------------

int render_frames_count(const struct render *r) { return r->frames.wanted; }

double render_frames_left(const struct render *r, double left, double elapsed) {
    const struct render_frames *f = &r->frames;
    const int later = render_frames_count(r) - f->begun;
    // Each later image takes the mean time of those before; the first one, as long as it will.
    const double mean = (f->start - f->images_start) / fmax(f->begun - 1, 1.0);
    if (f->begun <= 1) return left + later * (elapsed - f->start + left);
    // A short frame shows no speed of its own.
    return (isfinite(left) ? left : fmax(mean - (elapsed - f->start), 0.0)) + later * mean;
}

// The words of all that the images depend on, and which view is that of a frame. The records of a
// file do not count if they are those that this render would make.
static satin_status find_job(struct render *r) {
    char *words = render_identity(r), *identity = NULL;
    if (words &&
        asprintf(&identity, "%s first-frame=%d", words, r->callbacks.animation->number) < 0)
        identity = NULL;
    free(words);
    if (!identity) return SATIN_ERROR_MEMORY;
    char *job = identity;
    struct identity_word word;
    for (const char *at = identity; render_identity_next(&at, &word);) {
        if (render_identity_is(&word, "records") && (!r->second_pass.file || render_cache_whole(r)))
            continue;
        if (job > identity) *job++ = ' ';
        memmove(job, word.at, word.length);
        job += word.length;
    }
    *job = 0;
    r->frames.job = identity;
    return SATIN_OK;
}

// A status of the caller's own functions, who reports what has failed there.
static satin_status callers_status(struct render *r, satin_status status) {
    if (status != SATIN_OK) r->outcome.error_logged = true;
    return status;
}

satin_status render_frames_ask(struct render *r) {
    const satin_animation *a = r->callbacks.animation;
    struct render_frames *f = &r->frames;
    if (!a) return SATIN_OK;
    satin_status status = find_job(r);
    for (int i = a->first; i <= a->last && status == SATIN_OK; i++) {
        bool *complete = &f->complete[i - a->number];
        if (a->complete && render_is_first(r))
            status = callers_status(r, a->complete(a->user, i, f->job, complete));
        *complete = render_agreed(r, *complete) > 0.0;
        f->wanted += !*complete;
        status = render_ranks_status(r, status);
    }
    return status;
}

void render_frames_skip(struct render *r) {
    if (r->callbacks.animation && !r->frames.wanted) render_take_course(r, COURSE_DIRECT);
}

void render_frames_begin(struct render *r) {
    struct render_frames *f = &r->frames;
    render_stage_begin(r, STAGE_SETUP, 0.0);
    f->common = r->stats;
    f->next = r->callbacks.animation->first;
    f->images_start = render_elapsed(r);
}

bool render_frame_next(struct render *r, satin_status *status) {
    struct render_frames *f = &r->frames;
    const satin_animation *a = r->callbacks.animation;
    while (f->next <= a->last && f->complete[f->next - a->number]) f->next++;
    if (f->next > a->last) return false;
    const int number = f->next++;
    r->scene.camera = f->view[number - a->number];
    r->stats = f->common;
    f->start = render_elapsed(r);
    f->begun++;
    stats_set(&r->stats, "frame.number", number);
    stats_set(&r->stats, "frame.records", f->records[number - a->number]);
    // The image was made before all else; a frame in which objects move has a render of its own.
    if (f->begun == 1 || a->moved) return true;
    render_snapshot_free(r->snapshot);
    r->snapshot = NULL;
    *status = render_image_renew(r);
    return *status == SATIN_OK;
}

satin_status render_frame_scene(struct render *r, satin_scene **scene) {
    const satin_animation *a = r->callbacks.animation;
    return callers_status(r, a->moved(a->user, r->frames.next - 1, scene));
}

satin_status render_frame_done(struct render *r, struct satin_film *film) {
    const satin_animation *a = r->callbacks.animation;
    const satin_status status = a->frame(a->user, r->frames.next - 1, film);
    return render_ranks_status(r, callers_status(r, status));
}
