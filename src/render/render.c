// SPDX-License-Identifier: Apache-2.0
// THE main path: scene and options in, film out, in the order of the light. Two passes
// [K05 2.1, 3.5]: photons make a rough solution; final gathering fills the caches; the image
// interpolates.
#include "satin/render.h"

#include <stdlib.h>

#include "render/render_image.h"

// With a time limit, the part of it after which no more BRDF tables are made; and how long a first
// look may take after a cancellation.
static const double TABLES_UNTIL = 0.45, SKETCH_SECONDS = 0.5;

static bool two_pass(const struct render *r) { return r->options.integrator == SATIN_TWO_PASS; }

static bool needs_photons(const struct render *r) {
    if (r->options.integrator == SATIN_PHOTONS) return true;
    return two_pass(r) && (r->options.max_depth < 0 || r->options.max_depth > 2);
}

// Room for the image, so that it is not missing when all else is done.
static satin_status room(struct render *r) {
    const struct film_spec *film = &r->scene.film;
    r->image = render_image_new(&r->scene, &r->options);
    if (r->image) return SATIN_OK;
    return log_fail(r->log, SATIN_ERROR_MEMORY, "not enough memory for an image of %d x %d pixels",
                    film->crop_width, film->crop_height);
}

// 1, 2. Photons and the rough solution.
static satin_status photons(struct render *r) {
    render_stage(r, "photons", "photons",
                 (double)(r->options.photons + r->options.caustic_photons));
    return render_photons(r);
}

// Harmonics of the scene's glossy BRDFs. If there is no time for them all are sampled instead.
static satin_status tables(struct render *r) {
    render_stage(r, "BRDF tables", "materials", (double)r->scene.material_count);
    if (r->options.time > 0.0) r->stop_at = TABLES_UNTIL * r->options.time;
    satin_status status = shade_tables_build(&r->scene, &r->options, r->pool, r->log, &r->tables);
    r->stop_at = INFINITY;
    return status == SATIN_CANCELLED && !r->cancelled ? SATIN_OK : status;
}

// 3, 4. Shading points and records.
static satin_status records(struct render *r) {
    r->cache = cache_new(&r->gather, r->tables.order, r->pool);
    if (!r->cache) return SATIN_ERROR_MEMORY;
    satin_status status = shade_init(&r->shade, &r->gather, &r->tables, r->cache, r->pool);
    if (status != SATIN_OK) return status;
    if (!two_pass(r) || !needs_photons(r)) return SATIN_OK;
    status = render_records(r);
    cache_statistics(r->cache, &r->stats);
    return status;
}

// 5. The image.
static satin_status image(struct render *r) {
    r->image_begun = true;
    if (r->options.time > 0.0 && !r->sketch) r->stop_at = r->options.time - render_write_seconds(r);
    return render_image_fill(r);
}

// Cancelled before the image's first samples are there: one look within a moment, with the records
// that there are, or with direct light alone.
static satin_status sketch(struct render *r, bool direct) {
    if (!r->sketch) r->sketch = r->stage;
    r->sketch_direct = direct;
    if (direct) {
        shade_destroy(&r->shade);
        r->sketch_options = r->options;
        r->sketch_options.integrator = SATIN_DIRECT;
        r->gather = gather_make(&r->scene, &r->sketch_options, NULL);
        satin_status status = shade_init(&r->shade, &r->gather, &r->tables, NULL, r->pool);
        if (status != SATIN_OK) return status;
    }
    r->stop_at = render_elapsed(r) + SKETCH_SECONDS;
    satin_status status = image(r);
    return status == SATIN_OK ? SATIN_CANCELLED : status;
}

// 6. The film, denoised if that was asked for; a cancelled render has one if some pixel was
// sampled.
static satin_status film(struct render *r, satin_status status, satin_film **out) {
    const bool begun = r->image_begun && (status == SATIN_OK || status == SATIN_CANCELLED);
    if (begun && r->denoiser) render_denoise(r);
    render_stage(r, "film", "", 0.0);
    if (!begun) return status;
    if (r->sketch)
        log_message(r->log, SATIN_LOG_WARNING, "cancelled during %s: the image is a first look%s",
                    r->sketch, !r->sketch_direct ? "" : " at direct light alone");
    bool any;
    render_image_film(r, &any);
    if (status == SATIN_CANCELLED && !any) return status;
    if (!render_metadata(r, r->image->film)) return SATIN_ERROR_MEMORY;
    *out = r->image->film;
    r->image->film = NULL;
    return status;
}

// To the caller's log; an error that was told by who found it is not told again.
static void log_through(void *user, satin_log_level level, const char *message) {
    struct render *r = user;
    if (level == SATIN_LOG_ERROR) r->error_told = true;
    if (r->callbacks.log) r->callbacks.log(r->callbacks.log_user, level, message);
}

static void destroy(struct render *r) {
    render_image_free(r->image);
    shade_destroy(&r->shade);
    cache_free(r->cache);
    render_cache_free(r);
    render_levels_free(r);
    shade_tables_free(&r->tables);
    photon_maps_free(r->maps);
    guide_visibility_free(r->visibility);
    film_denoiser_free(r->denoiser);
    parallel_free(r->pool);
}

satin_status satin_render(const satin_scene *scene, const satin_options *options,
                          const satin_callbacks *callbacks, satin_film **out) {
    if (!scene || !options || !out) return SATIN_ERROR_ARGUMENT;
    struct render *r = calloc(1, sizeof *r);
    if (!r) {
        const struct log log = {callbacks ? callbacks->log : NULL,
                                callbacks ? callbacks->log_user : NULL};
        return log_fail(log, SATIN_ERROR_MEMORY, "not enough memory");
    }
    r->start = stats_wall();
    if (callbacks) r->callbacks = *callbacks;
    r->log = (struct log){log_through, r};
    r->stop_at = INFINITY;
    satin_film *made = NULL;

    satin_status status = render_resolve(r, scene, options);
    if (status == SATIN_OK) status = render_cache_open(r);
    if (status == SATIN_OK) {
        r->pool = parallel_new(r->options.threads);
        if (!r->pool) status = log_fail(r->log, SATIN_ERROR_MEMORY, "threads could not be started");
    }
    if (status == SATIN_OK) status = render_denoiser(r);
    if (status == SATIN_OK) {
        render_progress_install(r);
        camera_check(&r->scene, r->log);
        status = room(r);
        if (status == SATIN_OK && needs_photons(r)) status = photons(r);
        r->gather = render_gather(r);
    }
    if (status == SATIN_OK && two_pass(r)) status = tables(r);
    if (status == SATIN_OK && two_pass(r)) status = render_levels(r);
    if (status == SATIN_OK) status = records(r);
    if (status == SATIN_OK) status = image(r);
    // Where a sample takes long the first look does not come to its end; direct light does.
    if (status == SATIN_CANCELLED && !r->image->looked)
        status = sketch(r, !r->shade.g || r->image_begun);
    if (status == SATIN_CANCELLED && !r->image->looked) status = sketch(r, true);
    if (r->pool) status = film(r, status, &made);
    if (status == SATIN_OK) status = r->denoised;
    if (status == SATIN_OK) status = r->saved;
    if (status == SATIN_ERROR_MEMORY && !r->error_told)
        log_message(r->log, SATIN_LOG_ERROR, "not enough memory");

    destroy(r);
    free(r);
    if (made) *out = made;
    return status;
}
