// SPDX-License-Identifier: Apache-2.0
// Photon maps and caustics for tests, with the numbers of paths that a render without a time limit
// has.
#ifndef PHOTON_CASE_H
#define PHOTON_CASE_H

#include "photon/photon.h"
#include "render/render_budget.h"
#include "test_scene.h"

static inline satin_status photon_case_build(const struct satin_scene *scene,
                                             const satin_options *options, struct parallel *pool,
                                             struct stats *stats, struct photon_maps **out) {
    struct photon_request request = {
        .scene = scene, .options = options, .paths = render_budget_paths(options, 0.0)};
    struct guide_emission *emission = NULL;
    satin_status status = photon_emission_build(&request, pool, (struct log){0}, &emission);
    request.emission = emission;
    if (status == SATIN_OK) status = photon_maps_build(&request, pool, (struct log){0}, stats, out);
    guide_emission_free(emission);
    return status;
}

// A point with this BRDF, for which `frame` is around the geometric normal; wo is local.
static inline struct shading_point photon_case_point(vec3 p, const struct frame *frame,
                                                     const struct brdf *brdf, vec3 wo) {
    return (struct shading_point){
        .interaction.p = p, .brdf = *brdf, .frame = *frame, .wo_l = wo, .ng = frame->n};
}

// A lamp of the given kind, three above the floor.
static inline void photon_case_lamp(struct test_scene *t, enum light_kind kind, uint32_t material) {
    struct light lamp = {.kind = kind, .value = rgb_grey(10.0f)};
    lamp.position = v3(0.2f, 0.3f, 3.0f);
    lamp.direction = v3_unit(v3(0.1f, -0.2f, -1.0f));
    lamp.cos_cutoff = cosf(0.5f);
    lamp.cos_beam = cosf(0.3f);
    if (kind == LIGHT_AREA) {
        struct mat4 high = test_transform(v3(0.2f, 0.3f, 3.0f), v3(0.2f, 0.2f, 0.2f)),
                    rotation = mat4_rotate(v3(1, 0, 0), 180.0f);
        test_area_light(t, test_rectangle(t, mat4_mul(&high, &rotation), material),
                        rgb_grey(10.0f));
    } else {
        test_light(t, lamp);
    }
}

// A glass ball and a mirror over a floor, with a lamp of the given kind.
static inline void photon_case_caustic(struct test_scene *t, enum light_kind kind) {
    test_scene_init(t);
    uint32_t grey = test_diffuse(t, 0.5f, 0.5f, 0.5f), white = 0;
    uint32_t glass = test_material(t, "dielectric", rgb_grey(0), rgb_grey(1));
    uint32_t mirror = test_material(t, "conductor", rgb_grey(0), rgb_grey(0.9f));
    t->material[mirror].front.base.eta = t->material[mirror].back.base.eta = rgb_grey(0.0f);
    t->material[mirror].front.base.k = t->material[mirror].back.base.k = rgb_grey(1.0f);
    test_rectangle(t, test_transform(v3(0, 0, 0), v3(3, 3, 1)), grey);
    test_quadric(t, SHAPE_SPHERE, test_transform(v3(0.5f, 0, 0.6f), v3(0.4f, 0.4f, 0.4f)), false,
                 glass);
    struct mat4 stand = mat4_rotate(v3(0, 1, 0), 70.0f);
    struct mat4 position = test_transform(v3(-1, 0, 0.5f), v3(0.3f, 0.3f, 0.3f));
    test_rectangle(t, mat4_mul(&position, &stand), mirror);
    photon_case_lamp(t, kind, white);
    test_scene_finish(t);
}

#endif
