// SPDX-License-Identifier: Apache-2.0
// The weights of records of different numbers of rays, and of dense ones.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "cache/cache.h"
#include "fill/fill_record.h"
#include "test_scene.h"

struct cache_find_fixture {
    struct test_scene scene;
    satin_options options;
    struct cache *cache;
};

static void add_record(struct cache_find_fixture *f, float x, float y, float R, float E, int rays) {
    const struct cache_head head = {.p = v3(x, y, 0),
                                    .R = R,
                                    .n = v3(0, 0, 1),
                                    .search_radius = 2.0f * R,
                                    .clear = 1.0f,
                                    .scale = 1.0f,
                                    .u = v3(1, 0, 0)};
    const struct cache_irradiance_record record = {
        .value = {.E = rgb_grey(E), .rays = (uint32_t)rays}, .radius_ratio = 1.0f};
    assert_true(cache_insert_irradiance(f->cache, &head, &record));
}

// A plate at z = 0.
static void cache_find_plate(struct cache_find_fixture *f, float noise) {
    *f = (struct cache_find_fixture){.options = satin_options_default};
    test_scene_init(&f->scene);
    test_rectangle(&f->scene, mat4_identity(), test_diffuse(&f->scene, 0.5f, 0.5f, 0.5f));
    test_scene_finish(&f->scene);
    f->options.irradiance_a = 0.5f;
    f->options.irradiance_rays = 480;
    f->options.irradiance_noise = noise;
    f->options.leak_test = false;
    f->cache = cache_new(&f->scene.scene, &f->options, 0);
    assert_non_null(f->cache);
}

// Two records at the same distance from its middle, of 48 and 500 rays: a tenth of the options'
// rays, and more than all.
static void cache_find_start(struct cache_find_fixture *f, float noise) {
    cache_find_plate(f, noise);
    add_record(f, -0.1f, 0.0f, 0.5f, 12.0f, 48);
    add_record(f, 0.1f, 0.0f, 0.5f, 1.0f, 500);
}

static void cache_find_stop(struct cache_find_fixture *f) {
    cache_free(f->cache);
    test_scene_free(&f->scene);
}

static float cache_find_mean(const struct cache_find_fixture *f) {
    const struct cache_lookup at = {
        .p = v3(0, 0, 0), .n = v3(0, 0, 1), .frame = frame_from_normal(v3(0, 0, 1))};
    rgb E;
    assert_int_equal(cache_irradiance(f->cache, &at, f->options.irradiance_a, &E).count, 2);
    return E.r;
}

// (12 / 10 + 1) / (1 / 10 + 1) = 2.
static void weights_are_by_numbers_of_rays(void **state) {
    (void)state;
    struct cache_find_fixture f;
    cache_find_start(&f, 0.0f);
    assert_float_equal(cache_rays_fraction(f.cache, CACHE_IRRADIANCE, 0), 0.1f, 1e-6f);
    assert_true(cache_rays_fraction(f.cache, CACHE_IRRADIANCE, 1) == 1.0f);
    assert_float_equal(cache_find_mean(&f), 2.0f, 1e-5f);
    cache_find_stop(&f);
}

// With a noise, noisy records have more rays than others, and all are equally good.
static void weights_are_equal_if_rays_follow_from_noise(void **state) {
    (void)state;
    struct cache_find_fixture f;
    cache_find_start(&f, 0.1f);
    assert_float_equal(cache_find_mean(&f), 6.5f, 1e-5f);
    cache_find_stop(&f);
}

// Only the second record is a good one, and it does not extend to the position beside the first.
static void records_of_few_rays_do_not_cover(void **state) {
    (void)state;
    struct cache_find_fixture f;
    cache_find_start(&f, 0.0f);
    const struct fill fill = {.cache = f.cache};
    const struct fill_site middle = {.p = v3(0, 0, 0), .frame = frame_from_normal(v3(0, 0, 1))};
    struct fill_site beside = middle;
    beside.p.x = -0.2f;
    struct fill_sites sites = {.a = 0.5f};
    assert_true(fill_is_covered(&fill, CACHE_IRRADIANCE, &sites, &middle));
    assert_true(fill_is_covered(&fill, CACHE_IRRADIANCE, &sites, &beside));
    sites.rays_least = 0.5f;
    assert_true(fill_is_covered(&fill, CACHE_IRRADIANCE, &sites, &middle));
    assert_false(fill_is_covered(&fill, CACHE_IRRADIANCE, &sites, &beside));
    cache_find_stop(&f);
}

// Two circles with the same number of records, each of an irradiance.
static void add_circles(struct cache_find_fixture *f, int count) {
    for (int i = 0; i < count; i++) {
        const float angle = 6.2831853f * (float)i / (float)count;
        add_record(f, 0.1f * cosf(angle), 0.1f * sinf(angle), 1.0f, 1.0f, 500);
        add_record(f, 0.4f * cosf(angle), 0.4f * sinf(angle), 1.0f, 5.0f, 500);
    }
}

static float read_circles(const struct cache_find_fixture *f, float x) {
    const struct cache_lookup at = {
        .p = v3(x, 0, 0), .n = v3(0, 0, 1), .frame = frame_from_normal(v3(0, 0, 1))};
    rgb E;
    assert_true(cache_irradiance(f->cache, &at, f->options.irradiance_a, &E).count > 0);
    return E.r;
}

// At a = .5 weights are .8 and .2. Of two records each all are read, of twelve only those close by.
static void dense_records_are_read_closely(void **state) {
    (void)state;
    struct cache_find_fixture f;
    cache_find_plate(&f, 0.0f);
    add_circles(&f, 2);
    assert_float_equal(read_circles(&f, 0.0f), (0.8f * 1.0f + 0.2f * 5.0f) / 1.0f, 1e-4f);
    cache_find_stop(&f);
    cache_find_plate(&f, 0.0f);
    add_circles(&f, 12);
    assert_float_equal(read_circles(&f, 0.0f), 1.0f, 1e-5f);
    cache_find_stop(&f);
}

// From where records are dense to where they are not, no step is larger than others.
static void close_records_leave_no_seam(void **state) {
    (void)state;
    enum { STEPS = 4000 };
    struct cache_find_fixture f;
    cache_find_plate(&f, 0.0f);
    add_circles(&f, 12);
    float before = read_circles(&f, 0.0f);
    for (int i = 1; i <= STEPS; i++) {
        const float E = read_circles(&f, 0.6f * (float)i / STEPS);
        assert_true(fabsf(E - before) < 0.02f);
        before = E;
    }
    assert_true(before > 4.0f);
    cache_find_stop(&f);
}

static int read_row(const struct cache_find_fixture *f, float x, rgb *E) {
    const struct cache_lookup at = {
        .p = v3(x, 0, 0), .n = v3(0, 0, 1), .frame = frame_from_normal(v3(0, 0, 1))};
    return cache_irradiance(f->cache, &at, f->options.irradiance_a, E).count;
}

// Two records whose discs of a = .5 do not meet: at 1.5 times a they do, if the store allows it.
// Where one of them has the weight of a half, it is read as before.
static void few_records_are_read_wider(void **state) {
    (void)state;
    struct cache_find_fixture f;
    cache_find_plate(&f, 0.0f);
    add_record(&f, -0.55f, 0.0f, 1.0f, 1.0f, 500);
    add_record(&f, 0.55f, 0.0f, 1.0f, 5.0f, 48);
    rgb E;
    assert_int_equal(read_row(&f, 0.0f, &E), 0);
    f.cache->store[CACHE_IRRADIANCE].widens = true;
    assert_int_equal(read_row(&f, 0.0f, &E), 2);
    assert_float_equal(E.r, (1.0f + 0.1f * 5.0f) / 1.1f, 1e-4f);
    assert_int_equal(read_row(&f, -0.31f, &E), 1);
    assert_int_equal(read_row(&f, 1.29f, &E), 1);
    assert_int_equal(read_row(&f, 1.31f, &E), 0);
    cache_find_stop(&f);
}

// Between them light passes from one to the other without a step.
static void few_records_leave_no_seam(void **state) {
    (void)state;
    enum { STEPS = 1000 };
    struct cache_find_fixture f;
    cache_find_plate(&f, 0.0f);
    add_record(&f, -0.55f, 0.0f, 1.0f, 1.0f, 500);
    add_record(&f, 0.55f, 0.0f, 1.0f, 5.0f, 500);
    f.cache->store[CACHE_IRRADIANCE].widens = true;
    rgb E;
    float before = 1.0f;
    for (int i = 0; i <= STEPS; i++) {
        assert_true(read_row(&f, 1.1f * (float)i / STEPS - 0.55f, &E) > 0);
        assert_true(E.r >= before - 1e-5f && E.r - before < 0.03f);
        before = E.r;
    }
    assert_float_equal(before, 5.0f, 1e-5f);
    cache_find_stop(&f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(weights_are_by_numbers_of_rays),
        cmocka_unit_test(weights_are_equal_if_rays_follow_from_noise),
        cmocka_unit_test(records_of_few_rays_do_not_cover),
        cmocka_unit_test(dense_records_are_read_closely),
        cmocka_unit_test(close_records_leave_no_seam),
        cmocka_unit_test(few_records_are_read_wider),
        cmocka_unit_test(few_records_leave_no_seam),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
