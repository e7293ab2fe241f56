// SPDX-License-Identifier: Apache-2.0
// Builds photon maps for tests, with the numbers of paths that a render without a time limit has.
#ifndef PHOTON_CASE_H
#define PHOTON_CASE_H

#include "photon/photon.h"
#include "render/render_budget.h"

static inline satin_status photon_case_build(const struct satin_scene *scene,
                                             const satin_options *options, struct parallel *pool,
                                             struct stats *stats, struct photon_maps **out) {
    const struct photon_request request = {scene, options, render_budget_paths(options, 0.0)};
    return photon_maps_build(&request, pool, (struct log){0}, stats, out);
}

// A point with this BRDF, for which `frame` is around the geometric normal; wo is local.
static inline struct shading_point photon_case_point(vec3 p, const struct frame *frame,
                                                     const struct brdf *brdf, vec3 wo) {
    return (struct shading_point){
        .interaction.p = p, .brdf = *brdf, .frame = *frame, .wo_l = wo, .ng = frame->n};
}

#endif
