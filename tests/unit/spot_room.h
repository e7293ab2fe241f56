// SPDX-License-Identifier: Apache-2.0
// A cube whose light all comes from a small spot of light on its ceiling: for tests of gather rays
// to photon clusters.
#ifndef SPOT_ROOM_H
#define SPOT_ROOM_H

#include <math.h>

#include "gather/gather_cluster_rays.h"
#include "photon_case.h"
#include "test_scene.h"

static const vec3 LAMP = {0.2f, 0.0f, 0.1f};
static const float ALBEDO = 0.5f;

struct spot_room {
    struct test_scene scene;
    satin_options options;
    struct parallel *pool;
    struct photon_maps *maps;
    struct gather g;
    struct gather_layout *layout;
    struct gather_worker *worker;
};

// Sets the `half_angle` of the beam, and makes a hemisphere of `rays` for harmonics of `order`, or
// for irradiance if it is 0. max_depth, the first pass and the number of photons of the global map
// are those of `options`.
static inline void spot_room_make(struct spot_room *f, float half_angle, satin_options options,
                                  int rays, int order) {
    test_scene_init(&f->scene);
    test_cube(&f->scene, mat4_identity(), true, test_diffuse(&f->scene, ALBEDO, ALBEDO, ALBEDO));
    struct light spot = {.kind = LIGHT_SPOT,
                         .position = LAMP,
                         .direction = v3(0, 1, 0),
                         .to_world = mat4_translate(LAMP),
                         .value = rgb_grey(1.0f)};
    spot.cos_cutoff = cosf(half_angle);
    spot.cos_beam = cosf(0.999f * half_angle);
    test_light(&f->scene, spot);
    test_scene_finish(&f->scene);
    f->options = options;
    f->options.caustic_photons = 0;
    f->pool = parallel_new(2);
    assert_non_null(f->pool);
    struct stats stats = {0};
    assert_int_equal(photon_case_build(&f->scene.scene, &f->options, f->pool, &stats, &f->maps),
                     SATIN_OK);
    f->g = gather_make(&f->scene.scene, &f->options, f->maps);
    f->layout = gather_layout_new(rays, SATIN_HSH, order);
    f->worker = gather_workers_new(NULL, gather_layout_rays(f->layout));
    assert_true(f->layout && f->worker);
}

static inline void spot_room_free(struct spot_room *f) {
    gather_workers_free(f->worker, 1);
    gather_layout_free(f->layout);
    photon_maps_free(f->maps);
    parallel_free(f->pool);
    test_scene_free(&f->scene);
}

static inline struct cache_irradiance_value spot_room_irradiance(const struct spot_room *f,
                                                                 const struct gather_site *site) {
    struct cache_irradiance_value value;
    gather_hemisphere_trace(&f->g, f->layout, site, f->worker->scratch, f->worker->hemisphere);
    gather_hemisphere_irradiance(f->worker->hemisphere, f->g.options->irradiance_gradients, &value);
    return value;
}

#endif
