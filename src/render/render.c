// SPDX-License-Identifier: Apache-2.0
// THE main path: scene and options in, film out, in the order of the light. There are two passes
// [K05 2.1, 3.5]: photons give a first-pass radiance estimate; final gathering reads it and fills
// the caches; the image interpolates between their records.
#include "satin/render.h"

#include "render/render_image.h"

static satin_status start_threads(struct render *r) {
    r->pool = parallel_new(r->options.threads);
    if (!r->pool) return log_fail(r->log, SATIN_ERROR_MEMORY, "threads could not be started");
    render_progress_install(r);
    render_ranks_install(r);
    return SATIN_OK;
}

// Checks everything that can be wrong, before any long computation.
static satin_status prepare(struct render *r, const satin_scene *scene,
                            const satin_options *options) {
    satin_status status = render_resolve(r, scene, options);
    if (status == SATIN_OK) status = render_views(r);
    render_take_course(r, render_first_course(&r->options));
    if (status == SATIN_OK) status = render_memory_begin(r);
    if (status == SATIN_OK) status = render_cache_open(r);
    if (status == SATIN_OK) status = start_threads(r);
    if (status == SATIN_OK) status = render_denoiser(r);
    if (status != SATIN_OK) return status;
    status = render_film_check(&r->scene, &r->options, r->log);
    if (status != SATIN_OK) return status;
    for (uint32_t i = 0; i < scene_camera_count(&r->scene); i++)
        if (scene_camera_check(&r->scene, scene_camera_at(&r->scene, i), r->log)) break;
    // Now, so that memory does not run out after all other work is done.
    status = render_image_renew(r);
    if (status == SATIN_OK) render_budget_begin(r);
    return status;
}

// Traces photons and makes the first-pass radiance estimate that gather rays read at their hits. If
// there is no time for that, paths are traced instead.
static satin_status first_pass(struct render *r) {
    if (!render_has_stage(r, STAGE_PHOTONS)) return SATIN_OK;
    render_stage_begin(r, STAGE_PHOTONS, (double)(r->options.photons + r->options.caustic_photons));
    satin_status status = render_visibility(r);
    if (status == SATIN_OK) status = render_reduce_photons(r);
    if (status == SATIN_OK) status = render_memory_photons(r);
    if (status == SATIN_OK) status = render_photons(r);
    const bool paths = r->progress.course == COURSE_PATHS;
    return status == SATIN_OK && paths ? render_trace_paths(r) : status;
}

// Makes the constants of gathering, with what the first pass has made, and samples direct light
// where gather rays read it together with the photons.
static satin_status prepare_gathering(struct render *r) {
    r->second_pass.gather = render_gather(r);
    return render_direct(r);
}

// Projects the scene's glossy BRDFs onto harmonics. If there is no time for that, all are sampled
// instead.
static satin_status make_tables(struct render *r) {
    if (!render_has_stage(r, STAGE_TABLES)) return SATIN_OK;
    render_stage_begin(r, STAGE_TABLES, (double)r->scene.material_count);
    render_limit_tables(r);
    satin_status status =
        cache_tables_build(&r->scene, &r->options, r->pool, r->log, &r->second_pass.tables);
    return render_limit_end(r, status);
}

// If gather rays read them, makes the records of the indirect bounces, beginning with the last.
static satin_status bounce_records(struct render *r) {
    return render_has_stage(r, STAGE_BOUNCES) ? render_recursive_bounces(r) : SATIN_OK;
}

// Makes an empty cache, and what the image and the search for sites need.
static satin_status prepare_second_pass(struct render *r) {
    struct render_second_pass *pass = &r->second_pass;
    pass->cache = cache_new(pass->gather.scene, pass->gather.options, pass->tables.order);
    if (!pass->cache) return SATIN_ERROR_MEMORY;
    render_memory_limit_cache(r, pass->cache, r->second_pass.bounce_count + 1);
    pass->fill = fill_new(pass->cache, &pass->gather, r->pool);
    if (!pass->fill) return SATIN_ERROR_MEMORY;
    satin_status status =
        render_shading(r, render_has_stage(r, STAGE_RECORDS) ? pass->cache : NULL);
    if (status == SATIN_OK) render_budget_time_rims(r);
    return status;
}

// What stands between the photons and the records of the image.
static satin_status prepare_records(struct render *r) {
    satin_status status = prepare_gathering(r);
    if (status == SATIN_OK) status = make_tables(r);
    if (status == SATIN_OK) status = bounce_records(r);
    if (status == SATIN_OK) status = prepare_second_pass(r);
    if (status == SATIN_OK) status = render_refine(r);
    if (status == SATIN_OK) status = render_lookup_noise(r);
    return status;
}

// Samples the image by eye paths, whose indirect light is interpolated between the records.
static satin_status sample_image(struct render *r) {
    render_limit_image(r);
    const satin_status status = render_checkpoint_add_samples(r);
    return status == SATIN_OK ? render_image_fill(r) : status;
}

// Makes the film of a render that has ended, denoised if the options include that. A cancelled
// render has a film if some pixel was sampled.
static satin_status finish_film(struct render *r, satin_status status, satin_film **out) {
    const bool has_image = status == SATIN_OK || status == SATIN_CANCELLED;
    if (has_image && r->denoiser && render_is_first(r)) render_denoise(r);
    render_stage_begin(r, STAGE_FILM, 0.0);
    if (!has_image) return status;
    if (render_steps(r)->coarse)
        log_message(r->log, SATIN_LOG_WARNING, "cancelled during %s: the image is coarse%s",
                    render_stage_name(r->progress.cancelled_in),
                    r->progress.course == COURSE_COARSE_DIRECT ? ", with direct light alone" : "");
    if (!render_irradiance_filter(r) || !render_noise_filter(r)) return SATIN_ERROR_MEMORY;
    if (status == SATIN_OK && !render_edges(r)) return SATIN_ERROR_MEMORY;
    bool any;
    render_image_film(r, &any);
    if (status == SATIN_CANCELLED && !any) return status;
    if (!render_metadata(r, r->image->film)) return SATIN_ERROR_MEMORY;
    *out = r->image->film;
    r->image->film = NULL;
    return status == SATIN_OK ? r->outcome.denoised : status;
}

// The image of a render that has one.
static satin_status make_image(struct render *r, satin_status status, satin_film **film) {
    if (status == SATIN_OK) status = sample_image(r);
    status = render_checkpoint_check(r, status);
    if (status == SATIN_CANCELLED) status = render_coarse(r);
    return finish_film(r, status, film);
}

static satin_status make_frame(struct render *r, satin_film **film) {
    const satin_status status = sample_image(r);
    return status == SATIN_OK ? finish_film(r, status, film) : status;
}

// All before the image, of a render within another one.
static satin_status make_inner(struct render *r) {
    satin_status status = first_pass(r);
    if (status == SATIN_OK) status = prepare_records(r);
    if (status == SATIN_OK && render_has_stage(r, STAGE_RECORDS)) status = render_records(r);
    return status;
}

// If the caller wants to know early how long the render will take, measures that by a small one.
static void forecast(struct render *r) {
    if (!render_forecasts(r)) return;
    satin_options options;
    satin_film *film = NULL;
    struct render *small = render_forecast_new(r, &options);
    satin_status status = small ? prepare(small, &r->scene, &options) : SATIN_ERROR_MEMORY;
    if (status == SATIN_OK) status = make_inner(small);
    if (status == SATIN_OK) status = make_frame(small, &film);
    if (status == SATIN_OK) render_forecast_take(r, small);
    satin_film_free(film);
    render_free(small);
}

// The image of a frame in which objects have moved, by a render of its own.
static satin_status make_moved_frame(struct render *at_rest, satin_film **film) {
    satin_scene *scene = NULL;
    struct render *r = render_frame_new(at_rest);
    satin_status status = r ? SATIN_OK : SATIN_ERROR_MEMORY;
    if (status == SATIN_OK) status = render_frame_scene(at_rest, &scene);
    if (status == SATIN_OK) status = prepare(r, scene, at_rest->motion.options);
    status = render_ranks_agree(at_rest, status);
    if (status == SATIN_OK) status = make_inner(r);
    if (status == SATIN_OK) status = make_frame(r, film);
    if (r && r->outcome.error_logged) at_rest->outcome.error_logged = true;
    render_free(r);
    satin_scene_free(scene);
    return status;
}

// The images of an animation. What they have in common is not changed by any of them. There is no
// image of a frame that was cancelled.
static satin_status make_frames(struct render *r, satin_status status) {
    const bool moved = r->callbacks.animation->moved;
    if (status == SATIN_OK && moved) status = render_tests_make(r);
    if (status == SATIN_OK) render_frames_begin(r);
    render_checkpoint_end_loops(r);
    while (status == SATIN_OK && render_frame_next(r, &status)) {
        satin_film *film = NULL;
        status = moved ? make_moved_frame(r, &film) : make_frame(r, &film);
        if (status == SATIN_OK) status = render_frame_done(r, film);
        satin_film_free(film);
    }
    if (status == SATIN_OK) render_checkpoint_remove(r);
    return render_checkpoint_check(r, status);
}

satin_status satin_render(const satin_scene *scene, const satin_options *options,
                          const satin_callbacks *callbacks, satin_film **out) {
    if (!scene || !options || !out) return SATIN_ERROR_ARGUMENT;
    struct render *r = render_new(callbacks);
    satin_film *film = NULL;
    if (r) r->motion.options = options;
    satin_status status = r ? prepare(r, scene, options) : SATIN_ERROR_MEMORY;
    if (r) status = render_ranks_agree(r, status);
    if (status == SATIN_OK) status = render_ranks_compare(r);
    if (status == SATIN_OK) status = render_frames_ask(r);
    if (status == SATIN_OK) status = render_checkpoint_open(r);
    if (status == SATIN_OK) render_frames_skip(r);
    if (status == SATIN_OK) forecast(r);
    if (status == SATIN_OK) status = first_pass(r);
    if (status == SATIN_OK) status = prepare_records(r);
    if (status == SATIN_OK && render_has_stage(r, STAGE_RECORDS)) status = render_records(r);
    if (r && r->callbacks.animation)
        status = make_frames(r, status);
    else if (r)
        status = make_image(r, status, &film);
    status = render_final_status(r, callbacks, status);
    render_free(r);
    if (film) *out = film;
    return status;
}
