// SPDX-License-Identifier: Apache-2.0
// THE main path: scene and options in, film out, in the order of the light. Two passes
// [K05 2.1, 3.5]: photons make a rough solution; final gathering fills the caches; the image
// interpolates.
#include "satin/render.h"

#include <stdlib.h>

#include "render/render_state.h"

static bool two_pass(const struct render *r) { return r->options.integrator == SATIN_TWO_PASS; }

static bool needs_photons(const struct render *r) {
    if (r->options.integrator == SATIN_PHOTONS) return true;
    return two_pass(r) && (r->options.max_depth < 0 || r->options.max_depth > 2);
}

// 1, 2. Photons and the rough solution.
static satin_status photons(struct render *r) {
    render_stage(r, "photons", "photons",
                 (double)(r->options.photons + r->options.caustic_photons));
    return photon_maps_build(&r->scene, &r->options, r->pool, r->log, &r->stats, &r->maps);
}

// Harmonics of the scene's glossy BRDFs.
static satin_status tables(struct render *r) {
    render_stage(r, "BRDF tables", "materials", (double)r->scene.material_count);
    return shade_tables_build(&r->scene, &r->options, r->pool, r->log, &r->tables);
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
    r->image = render_image_new(r->scene.film.crop_width, r->scene.film.crop_height);
    if (!r->image) return SATIN_ERROR_MEMORY;
    return render_image_fill(r);
}

// 6. The film; a cancelled render has one if some pixel was sampled.
static satin_status film(struct render *r, satin_status status, satin_film **out) {
    render_stage(r, "film", "", 0.0);
    if (status != SATIN_OK && status != SATIN_CANCELLED) return status;
    if (!r->image) return status;
    bool any;
    struct satin_film *made = render_image_film(r, &any);
    if (!made) return SATIN_ERROR_MEMORY;
    if (!any || !render_metadata(r, made)) {
        satin_film_free(made);
        return any ? SATIN_ERROR_MEMORY : status;
    }
    *out = made;
    return status;
}

static void destroy(struct render *r) {
    render_image_free(r->image);
    shade_destroy(&r->shade);
    cache_free(r->cache);
    shade_tables_free(&r->tables);
    photon_maps_free(r->maps);
    parallel_free(r->pool);
}

satin_status satin_render(const satin_scene *scene, const satin_options *options,
                          const satin_callbacks *callbacks, satin_film **out) {
    if (!scene || !options || !out) return SATIN_ERROR_ARGUMENT;
    struct render *r = calloc(1, sizeof *r);
    if (!r) return SATIN_ERROR_MEMORY;
    r->start = stats_wall();
    if (callbacks) r->callbacks = *callbacks;
    r->log = (struct log){r->callbacks.log, r->callbacks.log_user};
    satin_film *made = NULL;

    satin_status status = render_resolve(r, scene, options);
    if (status == SATIN_OK) {
        r->pool = parallel_new(r->options.threads);
        if (!r->pool) status = log_fail(r->log, SATIN_ERROR_MEMORY, "threads could not be started");
    }
    if (status == SATIN_OK) {
        render_progress_install(r);
        if (needs_photons(r)) status = photons(r);
        r->gather = gather_make(&r->scene, &r->options, r->maps);
    }
    if (status == SATIN_OK && two_pass(r)) status = tables(r);
    if (status == SATIN_OK) status = records(r);
    if (status == SATIN_OK) status = image(r);
    if (r->pool) status = film(r, status, &made);
    if (status == SATIN_ERROR_MEMORY) log_message(r->log, SATIN_LOG_ERROR, "not enough memory");

    destroy(r);
    free(r);
    if (status == SATIN_OK || status == SATIN_CANCELLED) *out = made;
    return status;
}
