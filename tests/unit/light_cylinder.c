// SPDX-License-Identifier: Apache-2.0
// Long lights, tubes and strips: samples follow the density that is reported, and have little
// noise.
#include "test_light.h"

// Strips and tubes near their middle, beside them and beyond their end.
static void densities_of_long_lights_are_right(void **state) {
    (void)state;
    struct test_scene t;
    struct mat4 skew = test_transform(v3(0, 0, 0), v3(0.2f, 1.5f, 1.0f));
    skew.m[0][1] = 0.1f;
    const struct mat4 shape_of[] = {test_transform(v3(0, 0, 0), v3(1.5f, 0.2f, 1.0f)), skew,
                                    test_transform(v3(0, 0, -1.5f), v3(0.2f, 0.2f, 3.0f))};
    static const char *const name[] = {"strip", "skewed strip", "tube"};
    for (int kind = 0; kind < 3; kind++) {
        test_scene_init(&t);
        const uint32_t grey = test_diffuse(&t, 0.5f, 0.5f, 0.5f);
        const uint32_t shape = kind < 2
                                   ? test_rectangle(&t, shape_of[kind], grey)
                                   : test_quadric(&t, SHAPE_CYLINDER, shape_of[kind], false, grey);
        test_area_light(&t, shape, rgb_grey(1.0f));
        test_scene_finish(&t);
        // Along the axis of each, then across it.
        const vec3 along = v3_unit(mat4_vector(&shape_of[kind], kind == 0   ? v3(1, 0, 0)
                                                                : kind == 1 ? v3(0, 1, 0)
                                                                            : v3(0, 0, 1)));
        const vec3 across = kind < 2 ? v3(0, 0, 1) : v3(0.6f, 0.8f, 0);
        static const float at[][2] = {{0.4f, 0.5f}, {-1.2f, 0.9f}, {2.0f, 0.6f}, {1.0f, 4.0f}};
        for (int i = 0; i < 4; i++)
            test_light_density(&t, 0, v3_mad(v3_mul(along, at[i][0]), at[i][1], across),
                               name[kind]);
        test_scene_free(&t);
    }
}

// The light of a tube near a ceiling, and of a strip, by few samples: its deviation is that of the
// light that they see, not of the distances along the tube.
static void long_lights_have_little_noise(void **state) {
    (void)state;
    for (int kind = 0; kind < 2; kind++) {
        struct test_scene t;
        test_scene_init(&t);
        const uint32_t grey = test_diffuse(&t, 0.5f, 0.5f, 0.5f);
        const struct mat4 tube = test_transform(v3(0, 0, -1.5f), v3(0.004f, 0.004f, 3.0f));
        const struct mat4 strip = test_transform(v3(0, 0, 0), v3(0.002f, 1.5f, 1.0f));
        test_area_light(&t,
                        kind ? test_rectangle(&t, strip, grey)
                             : test_quadric(&t, SHAPE_CYLINDER, tube, false, grey),
                        rgb_grey(1.0f));
        test_scene_finish(&t);
        const vec3 p = kind ? v3(0.02f, 1.3f, 0.1f) : v3(0.1f, 0.02f, 1.3f);
        const vec3 n = kind ? v3(0, 0, -1) : v3(-1, 0, 0);
        const float deviation = test_light_deviation(&t, p, n);
        if (!(deviation < 1.0f))
            printf("%s: deviation %g\n", kind ? "strip" : "tube", (double)deviation);
        assert_true(deviation < 1.0f);  // by area, that of the tube is 5.4
        test_scene_free(&t);
    }
}

// Samples of thick tubes near a point, of thin ones far from it, and of one that is not quite round
// are on the surface that rays find, not within it.
static void tubes_are_not_in_their_own_shadow(void **state) {
    (void)state;
    static const struct {
        vec3 scale, centre;
    } tube[] = {{{100.0f, 100.0f, 200.0f}, {0, 102, 0}},
                {{10.0f, 10.0f, 20.0f}, {0, 10.2f, 0}},
                {{1e-6f, 1e-6f, 1.0f}, {0.3f, 2, 0.2f}},
                {{0.5f, 0.50004f, 2.0f}, {0, 1, 0}}};
    for (size_t k = 0; k < sizeof tube / sizeof *tube; k++) {
        struct test_scene t;
        test_scene_init(&t);
        const struct mat4 scale = mat4_scale(tube[k].scale), lay = mat4_rotate(v3(0, 1, 0), 90.0f);
        const struct mat4 move =
            mat4_translate(v3_sub(tube[k].centre, v3(0.5f * tube[k].scale.z, 0, 0)));
        struct mat4 to_world = mat4_mul(&lay, &scale);
        to_world = mat4_mul(&move, &to_world);
        const uint32_t shape =
            test_quadric(&t, SHAPE_CYLINDER, to_world, false, test_diffuse(&t, 0.5f, 0.5f, 0.5f));
        test_area_light(&t, shape, rgb_grey(1.0f));
        test_scene_finish(&t);
        const vec3 p = v3(0.3f, 0.0f, 0.2f), up = v3(0, 1, 0);
        struct rng rng = rng_make(4, RNG_TEST, (uint64_t)k);
        enum { N = 10000 };
        int hidden = 0;
        for (int i = 0; i < N; i++) {
            struct light_sample s;
            const float u = rng_float(&rng), v = rng_float(&rng);
            if (!light_sample_wi(&t.scene, 0, p, u, v, &s)) continue;
            const struct ray ray = scene_spawn_to(&t.scene, p, up, s.p, s.n);
            hidden += scene_occluded(&t.scene, &ray);
        }
        if (hidden > N / 1000) printf("tube %zu: %d of %d hidden\n", k, hidden, N);
        assert_true(hidden <= N / 1000);
        test_scene_free(&t);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(densities_of_long_lights_are_right),
                                       cmocka_unit_test(long_lights_have_little_noise),
                                       cmocka_unit_test(tubes_are_not_in_their_own_shadow)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
