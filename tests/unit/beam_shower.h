// SPDX-License-Identifier: Apache-2.0
// Photons on a floor for tests, of which a part arrives as a beam.
#ifndef BEAM_SHOWER_H
#define BEAM_SHOWER_H

#include <stdlib.h>

#include "base/sampling.h"
#include "photon/photon_map.h"
#include "test_scene.h"

enum { BEAM_SHOWER_PHOTONS = 20000 };
static const float BEAM_SHOWER_HALF_ANGLE = 0.03f;  // of the beam's cone

// Photons on the floor z = 0 within [-.5, .5]^2. A `fraction` of them is from a cone around an
// axis, the others are from everywhere.
struct beam_shower {
    vec3 axis;
    float fraction;
    bool indirect;
};

// Sets the global map of *maps.
static void beam_shower_build(const struct beam_shower *shower, struct photon_maps *maps) {
    struct test_scene t;
    test_scene_init(&t);
    test_rectangle(&t, mat4_identity(), test_diffuse(&t, 0.5f, 0.5f, 0.5f));
    test_scene_finish(&t);
    struct photon_hit *hit = calloc(BEAM_SHOWER_PHOTONS, sizeof *hit);
    const struct frame up = frame_from_normal(v3(0, 0, 1)), cone = frame_from_normal(shower->axis);
    const float versine = 1.0f - cosf(BEAM_SHOWER_HALF_ANGLE);
    struct rng rng = rng_make(1, RNG_TEST, 0);
    for (size_t i = 0; i < BEAM_SHOWER_PHOTONS; i++) {
        const float u = rng_float(&rng), v = rng_float(&rng), x = rng_float(&rng) - 0.5f,
                    y = rng_float(&rng) - 0.5f;
        const vec3 wi = rng_float(&rng) < shower->fraction
                            ? frame_to_world(&cone, sample_uniform_cone(u, v, versine))
                            : frame_to_world(&up, sample_cosine_hemisphere(u, v));
        hit[i] = (struct photon_hit){.p = v3(x, y, 0),
                                     .power = rgb_grey(1.0f / BEAM_SHOWER_PHOTONS),
                                     .wi = photon_pack(wi),
                                     .n = photon_pack(v3(0, 0, 1)),
                                     .indirect = shower->indirect};
    }
    struct parallel *pool = parallel_new(2);
    assert_int_equal(
        photon_map_build(&t.scene, hit, BEAM_SHOWER_PHOTONS, pool, (struct log){0}, &maps->global),
        SATIN_OK);
    parallel_free(pool);
    free(hit);
    test_scene_free(&t);
}

#endif
