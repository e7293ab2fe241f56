// SPDX-License-Identifier: Apache-2.0
// The variance of what records reflect at a point, by the noise that each of them has.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "cache/cache.h"
#include "test_scene.h"

struct cache_noise_fixture {
    struct test_scene scene;
    satin_options options;
    struct cache *cache;
    struct cache_tables tables;
    struct cache_reader reader;
};

// A diffuse plate at z = 0 that reflects half, and an empty cache for harmonics of `order`.
static void cache_noise_start(struct cache_noise_fixture *f, int order) {
    *f = (struct cache_noise_fixture){.options = satin_options_default};
    test_scene_init(&f->scene);
    test_rectangle(&f->scene, mat4_identity(), test_diffuse(&f->scene, 0.5f, 0.5f, 0.5f));
    test_scene_finish(&f->scene);
    f->options.irradiance_a = f->options.radiance_a = 0.5f;
    f->options.leak_test = false;
    f->options.radiance_diffuse = order > 0;
    f->cache = cache_new(&f->scene.scene, &f->options, order);
    assert_non_null(f->cache);
    f->reader = cache_reader_make(f->cache, &f->tables, &f->options);
}

static void cache_noise_stop(struct cache_noise_fixture *f) {
    cache_free(f->cache);
    test_scene_free(&f->scene);
}

static struct cache_head cache_noise_head(float x) {
    return (struct cache_head){.p = v3(x, 0, 0),
                               .R = 0.5f,
                               .n = v3(0, 0, 1),
                               .search_radius = 1.0f,
                               .scale = 1.0f,
                               .u = v3(1, 0, 0)};
}

// The variance at the point of the plate at x, from above.
static float cache_noise_at(const struct cache_noise_fixture *f, float x) {
    const struct ray ray = {v3(x, 0, 1), 0.0f, v3(0, 0, -1), INFINITY};
    struct interaction s;
    struct shading_point p;
    assert_true(scene_intersect(&f->scene.scene, &ray, &s));
    scene_shading_point_make(&f->scene.scene, &s, ray.d, &p);
    return cache_reflected_variance(&f->reader, &p);
}

// Two records of E = 2, whose standard deviations are .3 and .4 of that. In the middle their
// weights are equal, so that of the mean is (.3^2 + .4^2)^1/2 / 2 = 1/4.
static void records_are_averaged_with_their_noise(void **state) {
    (void)state;
    struct cache_noise_fixture f;
    cache_noise_start(&f, 0);
    assert_true(cache_noise_at(&f, 0.0f) == 0.0f);
    const float x[2] = {-0.1f, 0.1f}, deviation[2] = {0.3f, 0.4f};
    for (int i = 0; i < 2; i++) {
        const struct cache_head head = cache_noise_head(x[i]);
        const struct cache_irradiance_record record = {.value = {.E = rgb_grey(2.0f), .rays = 9},
                                                       .deviation = deviation[i],
                                                       .radius_ratio = 1.0f};
        assert_true(cache_insert_irradiance(f.cache, &head, &record));
    }
    const float L = 0.5f * 2.0f / PI_F;
    assert_float_equal(cache_noise_at(&f, 0.0f), sqrf(0.25f * L), 1e-5f);
    assert_true(cache_noise_at(&f, 0.9f) == 0.0f);
    cache_noise_stop(&f);
}

// A radiance record whose first coefficient has noise, which the plate reflects as light.
static void harmonics_have_the_noise_of_their_coefficients(void **state) {
    (void)state;
    struct cache_noise_fixture f;
    cache_noise_start(&f, 2);
    const struct cache_head head = cache_noise_head(0.0f);
    const struct cache_radiance_record record = {.frame = frame_from_normal(v3(0, 0, 1)),
                                                 .value = cache_value_new(f.cache),
                                                 .radius_ratio = 1.0f,
                                                 .rays = 9};
    assert_non_null(record.value);
    for (int i = 0; i < 4 * CACHE_LANES; i++) record.value[i] = 0.0f;
    for (int i = 0; i < 3; i++) record.value[i] = 1.0f;
    record.value[3] = 0.2f;
    assert_true(cache_insert_radiance(f.cache, &head, &record));
    const float noise = 0.5f / PI_F * f.cache->cosine[0] * 0.2f;
    assert_true(noise > 0.01f);
    assert_float_equal(cache_noise_at(&f, 0.0f), sqrf(noise), 1e-6f);
    cache_noise_stop(&f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(records_are_averaged_with_their_noise),
        cmocka_unit_test(harmonics_have_the_noise_of_their_coefficients),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
