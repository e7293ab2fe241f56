// SPDX-License-Identifier: Apache-2.0
// Makes and frees the common state of a render.
#include <stdlib.h>

#include "render/render_image.h"

// Passes messages on to the caller's log, and records whether one of them was an error.
static void log_through(void *user, satin_log_severity severity, const char *message) {
    struct render *r = user;
    if (severity == SATIN_LOG_ERROR) r->outcome.error_logged = true;
    if (r->callbacks.log) r->callbacks.log(r->callbacks.log_user, severity, message);
}

struct render *render_new(const satin_callbacks *callbacks) {
    struct render *r = calloc(1, sizeof *r);
    if (!r) return NULL;
    r->progress = (struct render_progress){.start = stats_wall(), .deadline = INFINITY};
    if (callbacks) r->callbacks = *callbacks;
    r->log = (struct log){log_through, r};
    return r;
}

satin_status render_final_status(struct render *r, const satin_callbacks *callbacks,
                                 satin_status status) {
    if (r) render_checkpoint_end(r);
    if (status == SATIN_OK) status = r->outcome.saved;
    if (status == SATIN_OK) status = r->outcome.checkpointed;
    if (status != SATIN_ERROR_MEMORY || (r && r->outcome.error_logged)) return status;
    const struct log log = {callbacks ? callbacks->log : NULL,
                            callbacks ? callbacks->log_user : NULL};
    log_message(log, SATIN_LOG_ERROR, "not enough memory");
    return status;
}

void render_free(struct render *r) {
    if (!r) return;
    render_snapshot_free(r->snapshot);
    render_checkpoint_free(r);
    render_image_free(r->image);
    shade_destroy(&r->second_pass.shade);
    fill_free(r->second_pass.fill);
    cache_free(r->second_pass.cache);
    render_cache_free(r);
    render_recursive_bounces_free(r);
    cache_tables_free(&r->second_pass.tables);
    render_views_free(r);
    render_tests_free(r->motion.tests);
    photon_maps_free(r->first_pass.maps);
    photon_sppm_free(r->first_pass.sppm);
    gather_direct_free(&r->first_pass.direct);
    guide_visibility_free(r->first_pass.visibility);
    guide_emission_free(r->first_pass.emission);
    film_denoiser_free(r->denoiser);
    parallel_free(r->pool);
    free(r);
}
