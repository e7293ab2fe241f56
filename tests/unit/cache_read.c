// SPDX-License-Identifier: Apache-2.0
// What an interpolation returns beside its value: the number of records that it read, their
// weights, their own accuracies and gather rays by weight; and where records stand.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "cache/cache.h"

enum { RECORDS = 2 };

struct cache_read_fixture {
    satin_options options;
    struct cache cache;
    struct cache_irradiance_record record[RECORDS];
};

// Two records on a plane: a whole one of 100 rays, and one of half its accuracy and 300 rays.
static void cache_read_start(struct cache_read_fixture *f) {
    static const float x[RECORDS] = {0.0f, 0.3f}, scale[RECORDS] = {1.0f, 0.5f};
    f->options = satin_options_default;
    f->options.irradiance_a = 0.4f;
    f->options.irradiance_rays = 100;
    f->options.leak_test = false;
    f->cache =
        (struct cache){.options = &f->options, .store[CACHE_IRRADIANCE].irradiance = f->record};
    struct cache_options of[CACHE_KINDS];
    cache_options_of(&f->options, of);
    f->cache.store[CACHE_IRRADIANCE].options = of[CACHE_IRRADIANCE];
    cache_tree_init(&f->cache.store[CACHE_IRRADIANCE].tree, v3(-1, -1, -1), v3(1, 1, 1));
    for (int i = 0; i < RECORDS; i++) {
        f->record[i] = (struct cache_irradiance_record){
            .value = {.E = rgb_grey((float)i), .rays = i ? 300 : 100}, .radius_ratio = 1.0f};
        struct cache_head head = {.p = v3(x[i], 0, 0),
                                  .R = 1.0f,
                                  .n = v3(0, 0, 1),
                                  .search_radius = 1.0f,
                                  .scale = scale[i]};
        assert_true(cache_tree_insert(&f->cache.store[CACHE_IRRADIANCE].tree, &head));
    }
}

static struct cache_lookup cache_read_lookup(float x) {
    return (struct cache_lookup){
        .p = v3(x, 0, 0), .n = v3(0, 0, 1), .frame = frame_from_normal(v3(0, 0, 1))};
}

static bool cache_read_near(float x, float wanted) { return fabsf(x - wanted) < 1e-5f; }

static void the_records_of_a_value_are_reported(void **state) {
    (void)state;
    struct cache_read_fixture f;
    cache_read_start(&f);
    // At accuracy .8 the weights are 1 - .2 / .8 and 1 - .1 / .4, both 3/4.
    struct cache_lookup at = cache_read_lookup(0.2f);
    rgb E;
    struct cache_used used = cache_irradiance(&f.cache, &at, 0.8f, &E);
    assert_int_equal(used.count, 2);
    assert_true(cache_read_near(used.weight, 1.5f) && cache_read_near(E.r, 0.5f));
    assert_true(cache_read_near(used.a / used.weight, 0.5f * (0.4f + 0.2f)));
    assert_true(cache_read_near(used.rays / used.weight, 200.0f));
    // Beyond the second record, only the first one is read.
    at = cache_read_lookup(-0.4f);
    used = cache_irradiance(&f.cache, &at, 0.8f, &E);
    assert_int_equal(used.count, 1);
    assert_true(cache_read_near(used.weight, 0.5f) && cache_read_near(used.a, 0.2f) &&
                cache_read_near(used.rays, 50.0f));
    cache_tree_free(&f.cache.store[CACHE_IRRADIANCE].tree);
}

// Two records on the parabola E = 1 + x + x^2, with its slopes.
static void errors_of_second_order_cancel(void **state) {
    (void)state;
    struct cache_read_fixture f;
    cache_read_start(&f);
    for (int i = 0; i < RECORDS; i++) {
        const float x = f.cache.store[CACHE_IRRADIANCE].tree.head[i].p.x;
        f.cache.store[CACHE_IRRADIANCE].tree.head[i].scale = 1.0f;
        f.record[i].value.E = rgb_grey(1.0f + x + x * x);
        for (int c = 0; c < 3; c++) f.record[i].value.grad_t[c] = v3(1.0f + 2.0f * x, 0, 0);
    }
    rgb E;
    struct cache_lookup at = cache_read_lookup(0.15f);
    assert_int_equal(cache_irradiance(&f.cache, &at, 0.4f, &E).count, 2);
    assert_true(cache_read_near(E.r, 1.0f + 0.15f + 0.15f * 0.15f));
    // Elsewhere the error is the square of the mean shift: weights 3/4 and 1/2, offsets .1 and -.2.
    at = cache_read_lookup(0.1f);
    assert_int_equal(cache_irradiance(&f.cache, &at, 0.4f, &E).count, 2);
    const float shift = (0.75f * 0.1f - 0.5f * 0.2f) / (0.75f + 0.5f);
    assert_true(cache_read_near(E.r, 1.0f + 0.1f + 0.01f - shift * shift));
    cache_tree_free(&f.cache.store[CACHE_IRRADIANCE].tree);
}

// Records that are larger than they should be are read if they agree better than gathering would.
static void oversized_records_that_disagree_are_not_read(void **state) {
    (void)state;
    struct cache_read_fixture f;
    cache_read_start(&f);
    satin_options options = *f.cache.options;
    f.cache.options = &options;
    for (int i = 0; i < RECORDS; i++) {
        f.record[i].value.E = rgb_grey(i ? 1.2f : 1.0f);
        f.record[i].radius_ratio = 0.1f;
    }
    struct cache_lookup at = cache_read_lookup(0.2f);  // where both have the same weight
    rgb E;
    options.gather_radius_ratio = 0.05f;
    assert_int_equal(cache_irradiance(&f.cache, &at, 0.8f, &E).count, 2);
    options.gather_radius_ratio = 0.3f;
    assert_int_equal(cache_irradiance(&f.cache, &at, 0.8f, &E).count, 0);
    // They deviate from their mean by .1 / 1.1.
    at.gather_deviation = 0.09f;
    assert_int_equal(cache_irradiance(&f.cache, &at, 0.8f, &E).count, 0);
    at.gather_deviation = 0.092f;
    assert_int_equal(cache_irradiance(&f.cache, &at, 0.8f, &E).count, 2);
    assert_true(cache_read_near(E.r, 1.1f));
    // What a single record hides is not known.
    at.p.x = -0.4f;
    assert_int_equal(cache_irradiance(&f.cache, &at, 0.8f, &E).count, 0);
    cache_tree_free(&f.cache.store[CACHE_IRRADIANCE].tree);
}

// The light of a bright gap of less than a pixel ends where other records have more weight than its
// own oversized one, which is read beside them if it is dark or if they are as bright.
static void light_of_an_oversized_record_is_not_thrown_far(void **state) {
    (void)state;
    struct cache_read_fixture f;
    cache_read_start(&f);
    f.record[1].radius_ratio = 0.1f;
    struct cache_lookup at = cache_read_lookup(0.1f);  // weights 1 - .1 / .8 and 1 - .2 / .4
    rgb E;
    f.record[0].value.E = rgb_grey(1.0f);
    for (int i = 0; i < 3; i++) {
        static const float light[3] = {0.0f, 1.0f, 60.0f};
        f.record[1].value.E = rgb_grey(light[i]);
        assert_int_equal(cache_irradiance(&f.cache, &at, 0.8f, &E).count, i < 2 ? 2 : 0);
    }
    cache_tree_free(&f.cache.store[CACHE_IRRADIANCE].tree);
}

static void no_record_is_found_far_away(void **state) {
    (void)state;
    struct cache_read_fixture f;
    cache_read_start(&f);
    const struct cache_lookup at = cache_read_lookup(-0.9f);
    rgb E = rgb_grey(7.0f);
    assert_int_equal(cache_irradiance(&f.cache, &at, 0.8f, &E).count, 0);
    assert_true(E.r == 7.0f);
    cache_tree_free(&f.cache.store[CACHE_IRRADIANCE].tree);
}

static void positions_of_records_are_found(void **state) {
    (void)state;
    struct cache_read_fixture f;
    cache_read_start(&f);
    const vec3 up = v3(0, 0, 1);
    assert_true(cache_has_record_near(&f.cache, v3(0.31f, 0, 0), up, 0.02f));
    assert_false(cache_has_record_near(&f.cache, v3(0.31f, 0, 0), v3_neg(up), 0.02f));
    assert_false(cache_has_record_near(&f.cache, v3(0.35f, 0, 0), up, 0.02f));
    cache_tree_free(&f.cache.store[CACHE_IRRADIANCE].tree);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_records_of_a_value_are_reported),
        cmocka_unit_test(errors_of_second_order_cancel),
        cmocka_unit_test(oversized_records_that_disagree_are_not_read),
        cmocka_unit_test(light_of_an_oversized_record_is_not_thrown_far),
        cmocka_unit_test(no_record_is_found_far_away),
        cmocka_unit_test(positions_of_records_are_found),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
