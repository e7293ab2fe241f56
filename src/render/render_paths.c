// SPDX-License-Identifier: Apache-2.0
// Path tracing instead of two passes, where a time limit is too short for these: if not even the
// first photons fit into it, or if a denoised image would have too few samples.
#include "render/render_image.h"

bool render_can_trace_paths(const struct render *r) {
    const satin_callbacks *c = &r->callbacks;
    return r->options.integrator == SATIN_TWO_PASS && !c->save_cache && !c->load_cache;
}

// What the passes have made is dropped, but for the visibility of the lights.
satin_status render_trace_paths(struct render *r) {
    log_message(r->log, SATIN_LOG_WARNING,
                "the time is too short for photons here: paths are traced instead");
    render_take_course(r, COURSE_PATHS);
    r->progress.replaced = true;
    gather_direct_free(&r->first_pass.direct);
    photon_maps_free(r->first_pass.maps);
    r->first_pass.maps = NULL;
    r->second_pass.gather = render_gather(r);
    satin_status status = SATIN_OK;
    if (r->second_pass.shade.worker) {
        shade_destroy(&r->second_pass.shade);
        status = render_shading(r, NULL);
    }
    return status == SATIN_OK ? render_image_renew(r) : status;
}
