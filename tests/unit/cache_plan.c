// SPDX-License-Identifier: Apache-2.0
// Records at shading points: which kinds a surface reads, by its BRDF and the options, and the
// light that records add to what a gather ray finds.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "cache/cache.h"
#include "test_scene.h"

struct cache_plan_fixture {
    struct test_scene scene;
    satin_options options;
    struct cache *cache;
    struct cache_tables tables;
    struct cache_reader reader;
};

// A plate of a material at z = 0, with one irradiance record of E = 2 in its middle.
static void cache_plan_start(struct cache_plan_fixture *f, const char *model) {
    *f = (struct cache_plan_fixture){.options = satin_options_default};
    test_scene_init(&f->scene);
    test_rectangle(&f->scene, mat4_identity(),
                   test_material(&f->scene, model, rgb_grey(0.5f), rgb_grey(0.25f)));
    test_scene_finish(&f->scene);
    f->options.irradiance_a = 0.5f;
    f->options.leak_test = false;
    f->cache = cache_new(&f->scene.scene, &f->options, 0);
    assert_non_null(f->cache);
    f->reader = cache_reader_make(f->cache, &f->tables, &f->options);
    const struct cache_head head = {.p = v3(0, 0, 0),
                                    .R = 0.5f,
                                    .n = v3(0, 0, 1),
                                    .search_radius = 1.0f,
                                    .scale = 1.0f,
                                    .u = v3(1, 0, 0)};
    const struct cache_irradiance_record record = {.value = {.E = rgb_grey(2.0f), .rays = 9},
                                                   .radius_ratio = 1.0f};
    assert_true(cache_insert_irradiance(f->cache, &head, &record));
    assert_int_equal(cache_rays(f->cache), 9);
}

static void cache_plan_stop(struct cache_plan_fixture *f) {
    cache_free(f->cache);
    cache_tables_free(&f->tables);
    test_scene_free(&f->scene);
}

// The point of the plate at x, from above.
static struct shading_point cache_plan_point(const struct cache_plan_fixture *f, float x) {
    const struct ray ray = {v3(x, 0, 1), 0.0f, v3(0, 0, -1), INFINITY};
    struct interaction s;
    struct shading_point p;
    assert_true(scene_intersect(&f->scene.scene, &ray, &s));
    scene_shading_point_make(&f->scene.scene, &s, ray.d, &p);
    return p;
}

static void records_add_the_light_of_their_lobes(void **state) {
    (void)state;
    struct cache_plan_fixture f;
    cache_plan_start(&f, "diffuse");
    struct shading_point p = cache_plan_point(&f, 0.1f);
    rgb L = rgb_grey(1.0f);
    assert_int_equal(cache_add_reflected(&f.reader, &p, &L), BRDF_DIFFUSE);
    assert_float_equal(L.g, 1.0f + 0.5f * 2.0f / PI_F, 1e-5f);
    // No record is near.
    p = cache_plan_point(&f, 0.9f);
    L = rgb_grey(1.0f);
    assert_int_equal(cache_add_reflected(&f.reader, &p, &L), 0);
    assert_true(L.g == 1.0f);
    cache_plan_stop(&f);
}

static void lobes_decide_which_records_are_read(void **state) {
    (void)state;
    static const struct {
        const char *model;
        unsigned kinds, sampled;
    } cases[] = {{"diffuse", 1 << CACHE_IRRADIANCE, 0},
                 {"phong", 1 << CACHE_IRRADIANCE, BRDF_GLOSSY},  // there is no table of its lobe
                 {"conductor", 0, 0}};
    for (int i = 0; i < 3; i++) {
        struct cache_plan_fixture f;
        struct cache_plan plan;
        cache_plan_start(&f, cases[i].model);
        const struct shading_point p = cache_plan_point(&f, 0.1f);
        cache_plan_make(&f.reader, &p, &plan);
        assert_int_equal(plan.sampled, cases[i].sampled);
        assert_int_equal(cache_plan_kinds(&f.reader, &p), cases[i].kinds);
        f.options.irradiance_cache = false;
        f.reader = cache_reader_make(f.cache, &f.tables, &f.options);
        assert_int_equal(cache_plan_kinds(&f.reader, &p), 0);
        cache_plan_stop(&f);
    }
}

// With a table of its harmonics, a glossy lobe is lit by radiance records, with the diffuse one.
static void glossy_lobes_with_a_table_read_radiance(void **state) {
    (void)state;
    struct cache_plan_fixture f;
    struct cache_plan plan;
    cache_plan_start(&f, "phong");
    struct parallel *pool = parallel_new(1);
    f.scene.scene.side_count = 1;  // both sides of the plate are of index 0
    assert_int_equal(
        cache_tables_build(&f.scene.scene, &f.options, pool, (struct log){0}, &f.tables), SATIN_OK);
    const struct shading_point p = cache_plan_point(&f, 0.1f);
    int channels = 0;
    assert_non_null(cache_table(&f.tables, p.side, &channels));
    assert_int_equal(channels, 1);
    cache_plan_make(&f.reader, &p, &plan);
    assert_int_equal(plan.cached, BRDF_DIFFUSE | BRDF_GLOSSY);
    assert_int_equal(plan.sampled, 0);
    assert_int_equal(cache_plan_kinds(&f.reader, &p), 1 << CACHE_RADIANCE);
    parallel_free(pool);
    cache_plan_stop(&f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(records_add_the_light_of_their_lobes),
        cmocka_unit_test(lobes_decide_which_records_are_read),
        cmocka_unit_test(glossy_lobes_with_a_table_read_radiance),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
