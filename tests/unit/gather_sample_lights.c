// SPDX-License-Identifier: Apache-2.0
// Direct light of few lights is sampled without a choice among them, and agrees with many samples
// that choose.
#include "gather/gather.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "test_scene.h"

// A white floor with `lamps` point lights above it, of which a plate hides all but the first.
static void sample_lights_scene(struct test_scene *t, int lamps) {
    test_scene_init(t);
    const uint32_t white = test_diffuse(t, 1.0f, 1.0f, 1.0f);
    test_rectangle(t, test_transform(v3(0, 0, 0), v3(9, 9, 1)), white);
    test_rectangle(t, test_transform(v3(5, 0, 1), v3(4.5f, 1, 1)), white);
    for (int i = 0; i < lamps; i++) {
        const vec3 at = v3(3.0f * (float)i, 0.0f, 2.0f);
        test_light(t, (struct light){.kind = LIGHT_POINT, .position = at, .value = rgb_grey(4.0f)});
    }
    test_scene_finish(t);
}

static struct shading_point below(const struct test_scene *t) {
    struct ray ray = {.o = v3(0, 0, 0.5f), .d = v3(0, 0, -1), .tfar = INFINITY};
    struct interaction s;
    struct shading_point p;
    assert_true(scene_intersect(&t->scene, &ray, &s));
    scene_shading_point_make(&t->scene, &s, ray.d, &p);
    return p;
}

static double sample_lights_mean(const struct test_scene *t, int samples, int runs,
                                 double *deviation) {
    const satin_options options = satin_options_default;
    const struct gather g = {.scene = &t->scene, .options = &options};
    const struct gather_mis alone = {1, {{BRDF_SMOOTH, 0.0f}}};
    const struct shading_point p = below(t);
    double sum = 0.0, squares = 0.0;
    for (int i = 0; i < runs; i++) {
        struct sampler sampler = {(uint32_t)i, 7, 0};
        const struct gather_light_samples lights = {samples, (uint32_t)(i * samples)};
        float variance;
        double L = (double)gather_sample_lights(&g, &p, alone, lights, sampler, &variance).g;
        assert_true(variance >= 0.0f && (samples > 1 || variance == 0.0f));
        sum += L;
        squares += L * L;
    }
    *deviation = sqrt(fmax(squares / runs - sum / runs * (sum / runs), 0.0));
    return sum / runs;
}

// The first lamp brings 4 / 2^2, of which a white surface reflects 1 / pi.
static void few_lights_are_all_sampled(void **state) {
    (void)state;
    for (int lamps = 1; lamps <= 4; lamps++) {
        struct test_scene t;
        double deviation;
        sample_lights_scene(&t, lamps);
        assert_true(fabs(sample_lights_mean(&t, 1, 64, &deviation) * M_PI - 1.0) < 1e-4);
        assert_true(deviation < 1e-5);
        test_scene_free(&t);
    }
}

static void as_many_samples_as_lights_choose_among_them(void **state) {
    (void)state;
    enum { RUNS = 20000 };
    struct test_scene t;
    double deviation;
    sample_lights_scene(&t, 3);
    double mean = sample_lights_mean(&t, 3, RUNS, &deviation);
    assert_true(deviation > 0.01);
    assert_true(fabs(mean * M_PI - 1.0) < 5.0 * M_PI * deviation / sqrt(RUNS));
    test_scene_free(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(few_lights_are_all_sampled),
        cmocka_unit_test(as_many_samples_as_lights_choose_among_them),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
