// SPDX-License-Identifier: Apache-2.0
// Checks whether a render could begin: what satin_render does before its first stage, without
// threads and memory for an image.
#include "render/render.h"

#include <stdlib.h>

#include "render/render_image.h"

satin_status render_check(const satin_scene *scene, const satin_options *options, struct log log) {
    struct render *r = calloc(1, sizeof *r);
    if (!r) return log_fail(log, SATIN_ERROR_MEMORY, "not enough memory");
    r->log = log;
    satin_status status = render_resolve(r, scene, options);
    render_take_course(r, render_first_course(&r->options));
    if (status == SATIN_OK) status = render_memory_begin(r);
    if (status == SATIN_OK && r->options.denoise) status = film_denoiser_open(1, log, &r->denoiser);
    if (status == SATIN_OK) status = render_film_check(&r->scene, &r->options, log);
    film_denoiser_free(r->denoiser);
    free(r);
    return status;
}
