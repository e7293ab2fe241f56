// SPDX-License-Identifier: Apache-2.0
// Path tracing where the answer is known: a plane under a white sky is as bright as its albedo,
// however the sky is divided between light and BRDF sampling.
#include "gather/gather.h"

#include <float.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "test_scene.h"

enum { PATHS = 20000 };

struct gather_path_mean {
    double value, variance;  // the variance of `value`
};

static struct gather_path_mean gather_path_mean_of(double sum, double squares) {
    double value = sum / PATHS;
    return (struct gather_path_mean){value, (squares / PATHS - value * value) / (PATHS - 1)};
}

static struct gather_path_mean by_paths(const struct gather *g, vec3 wo) {
    double sum = 0.0, squares = 0.0;
    for (uint32_t i = 0; i < PATHS; i++) {
        struct rng rng = rng_make(1, RNG_TEST, i);
        struct sampler sampler = {0, (uint32_t)(rng_float(&rng) * 0x1p32f), 0};
        struct ray ray = {.o = v3_mul(wo, 3.0f), .d = v3_neg(wo), .tfar = INFINITY};
        struct gather_eye_hit seen;
        double L = (double)gather_path_eye(g, ray, &sampler, &seen).g;
        sum += L;
        squares += L * L;
    }
    return gather_path_mean_of(sum, squares);
}

static struct gather_path_mean by_brdf(const struct brdf *b, vec3 wo) {
    double sum = 0.0, squares = 0.0;
    struct rng rng = rng_make(2, RNG_TEST, 0);
    for (int i = 0; i < PATHS; i++) {
        struct brdf_sample s;
        float u = rng_float(&rng), x = rng_float(&rng), y = rng_float(&rng);
        if (!brdf_sample_wi(b, wo, u, (vec2){x, y}, BRDF_ALL, BRDF_RADIANCE, &s)) continue;
        sum += (double)s.weight.g;
        squares += (double)(s.weight.g * s.weight.g);
    }
    return gather_path_mean_of(sum, squares);
}

static void planes_in_a_furnace_have_the_brightness_of_their_albedo(void **state) {
    (void)state;
    static const char *const model[] = {"diffuse", "plastic",        "roughplastic",   "phong",
                                        "ward",    "roughconductor", "thindielectric", "conductor"};
    for (size_t i = 0; i < sizeof model / sizeof *model; i++) {
        struct test_scene t;
        test_scene_init(&t);
        uint32_t m = test_material(&t, model[i], rgb_grey(0.4f), rgb_grey(0.5f));
        test_rectangle(&t, test_transform(v3(0, 0, 0), v3(1, 1, 1)), m);
        test_light(&t, (struct light){.kind = LIGHT_CONSTANT, .value = rgb_grey(1.0f)});
        test_scene_finish(&t);
        const satin_options options = satin_options_default;
        const struct gather g = {.scene = &t.scene, .options = &options};
        for (float z = 0.2f; z < 1.0f; z += 0.35f) {
            vec3 wo = v3(sqrtf(1.0f - z * z), 0.0f, z);
            struct gather_path_mean a = by_paths(&g, wo),
                                    b = by_brdf(&t.material[m].front.base, wo);
            double off = fabs(a.value - b.value), deviation = sqrt(a.variance + b.variance);
            // The bound gives one false alarm in 600 runs of the 24 cases.
            if (off > 4.0 * deviation + 1e-4)
                fail_msg("%s at cosine %g: %g by paths, %g by the BRDF +- %g", model[i], (double)z,
                         a.value, b.value, deviation);
        }
        test_scene_free(&t);
    }
}

// A diffuse plane beside a pane that shows the sky: the surface that the ray hits, and the part of
// the light that is emission, with and without longer paths.
static void the_first_surface_and_its_emission_are_reported(void **state) {
    (void)state;
    struct test_scene t;
    test_scene_init(&t);
    uint32_t grey = test_material(&t, "diffuse", rgb_grey(0.4f), rgb_grey(0.0f));
    uint32_t pane = test_material(&t, "thindielectric", rgb_grey(0.0f), rgb_grey(0.5f));
    test_rectangle(&t, test_transform(v3(0, 0, 0), v3(1, 1, 1)), grey);
    test_rectangle(&t, test_transform(v3(3, 0, 0), v3(1, 1, 1)), pane);
    test_light(&t, (struct light){.kind = LIGHT_CONSTANT, .value = rgb_grey(2.0f)});
    test_scene_finish(&t);
    satin_options options = satin_options_default;
    options.rr_depth = 9;
    const struct gather g = {.scene = &t.scene, .options = &options};
    for (int depth = 0; depth < 4; depth++) {
        options.max_depth = depth;
        struct sampler sampler = {0};
        struct gather_eye_hit seen;
        struct ray ray = {.o = v3(0.5f, 0.5f, 2.0f), .d = v3(0, 0, -1), .tfar = INFINITY};
        rgb L = gather_path_eye(&g, ray, &sampler, &seen);
        // Embree divides by a refined reciprocal, whose last bits depend on the processor.
        assert_true(seen.hit && fabsf(seen.point.interaction.t - 2.0f) < 4.0f * FLT_EPSILON);
        assert_true(seen.point.interaction.ng.z == 1.0f);
        assert_true(rgb_black(seen.emission) && (depth < 2) == rgb_black(L));
        ray.o.x = 3.5f;
        L = gather_path_eye(&g, ray, &sampler, &seen);
        assert_true(seen.hit && (seen.point.lobes & BRDF_DELTA));
        assert_true(L.g == seen.emission.g && (depth < 2) == rgb_black(L));
        ray.o.x = 9.0f;
        L = gather_path_eye(&g, ray, &sampler, &seen);
        assert_true(!seen.hit && L.g == (depth ? 2.0f : 0.0f) && seen.emission.g == L.g);
    }
    test_scene_free(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(planes_in_a_furnace_have_the_brightness_of_their_albedo),
        cmocka_unit_test(the_first_surface_and_its_emission_are_reported)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
