// SPDX-License-Identifier: Apache-2.0
// Full convergence on a plane with an edge of irradiance across it: records on either side give way
// to each other, new ones fill the gaps, every point keeps a record, and no two records visibly
// disagree anywhere but within the least radius; the same for any number of threads.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "base/parallel.h"
#include "cache/cache_records.h"
#include "test_scene.h"

enum { SIDE = 48 };  // points along a side of the plane

static const float PIXEL = 0.01f;

struct fixture {
    struct test_scene scene;
    satin_options options;
    struct gather g;
    struct parallel *pool;
    struct cache *cache;
    struct cache_site site[SIDE * SIDE];
};

// A floor that is divided by a thin wall, lit on one side; records see nothing of the wall, as the
// leak test is off.
static void start(struct fixture *f, int threads) {
    test_scene_init(&f->scene);
    uint32_t grey = test_diffuse(&f->scene, 0.8f, 0.8f, 0.8f);
    test_rectangle(&f->scene, mat4_scale(v3(3, 3, 1)), grey);
    test_cube(&f->scene, test_transform(v3(0, 0, 1.3f), v3(3, 3, 0.01f)), false, grey);
    test_cube(&f->scene, test_transform(v3(0, 0, 0.2f), v3(0.001f, 3, 0.2f)), false, grey);
    test_light(&f->scene,
               (struct light){
                   .kind = LIGHT_POINT, .position = v3(-0.4f, 0, 1.0f), .value = rgb_grey(1.0f)});
    test_scene_finish(&f->scene);
    f->options = satin_options_default;
    f->options.first_pass = SATIN_FIRST_NONE;
    f->options.max_depth = -1;
    f->options.irradiance_rays = 2000;
    f->options.irradiance_a = 1.0f;
    f->options.leak_test = false;
    f->options.irradiance_min_pixels = 1.0f;
    f->g = gather_make(&f->scene.scene, &f->options, NULL);
    f->pool = parallel_new(threads);
    f->cache = cache_new(&f->g, 0, f->pool);
    assert_non_null(f->cache);
    const vec3 up = v3(0, 0, 1);
    for (int i = 0; i < SIDE * SIDE; i++) {
        int j = i * 1103 % (SIDE * SIDE);  // scattered
        vec3 p = v3(((float)(j % SIDE) + 0.5f) / SIDE - 0.5f,
                    ((float)(j / SIDE) + 0.5f) / SIDE - 0.5f, 0.0f);
        f->site[i] = (struct cache_site){.p = p,
                                         .ng = up,
                                         .frame = frame_from_normal(up),
                                         .pixel = PIXEL,
                                         .stream = (uint64_t)j,
                                         .wants = CACHE_IRRADIANCE};
    }
}

static void stop(struct fixture *f) {
    cache_free(f->cache);
    parallel_free(f->pool);
    test_scene_free(&f->scene);
}

static void surface(void *user, const struct cache_site *site, struct cache_place *at,
                    struct cache_surface *out) {
    (void)user;
    *at = (struct cache_place){site->p, site->frame.n, site->frame, 0.0f};
    out->diffuse = rgb_grey(0.8f / PI_F);
    out->lobe.order = 0;
}

static float direct(void *user, const struct cache_site *site) {
    (void)site;
    return *(const float *)user;
}

// Fills, then converges beside direct light of that luminance; returns how many records were added.
static size_t run(struct fixture *f, float light) {
    struct cache_fill fill = {.site = f->site,
                              .count = 12,  // coarse to fine
                              .a_irradiance = f->options.irradiance_a,
                              .a_radiance = 0.3f,
                              .widest = 2.0f,
                              .spacing = 1.5f};
    assert_int_equal(cache_fill(f->cache, &fill), SATIN_OK);
    fill.count = SIDE * SIDE;
    assert_int_equal(cache_fill(f->cache, &fill), SATIN_OK);
    size_t before = cache_count(f->cache, CACHE_IRRADIANCE);
    struct cache_converge with = {.site = f->site,
                                  .count = SIDE * SIDE,
                                  .fill = fill,
                                  .widen = {1.5f, 1.0f},
                                  .surface = surface,
                                  .direct = direct,
                                  .user = &light};
    assert_int_equal(cache_converge(f->cache, &with), SATIN_OK);
    return cache_count(f->cache, CACHE_IRRADIANCE) - before;
}

static void records_are_added_where_they_disagree(void **state) {
    (void)state;
    struct fixture f;
    start(&f, 1);
    size_t added = run(&f, 0.0f);
    assert_true(added > 0);
    assert_true(f.cache->converged.passes >= 2 && f.cache->converged.passes <= 11);
    bool smaller = false;
    for (size_t i = 0; i < f.cache->irradiance_tree.head_count; i++)
        smaller = smaller || f.cache->irradiance_tree.head[i].scale < 1.0f;
    assert_true(smaller);
    struct cache_near near[CACHE_NEAR_MAX];
    for (int i = 0; i < SIDE * SIDE; i++)
        assert_true(cache_find(f.cache, &f.cache->irradiance_tree, f.site[i].p, f.site[i].frame.n,
                               f.options.irradiance_a, near) > 0);
    stop(&f);
}

// Beside strong direct light the same differences are not seen [K05 6.4].
static void direct_light_hides_differences(void **state) {
    (void)state;
    struct fixture f;
    start(&f, 1);
    assert_int_equal(run(&f, 1000.0f), 0);
    assert_int_equal(f.cache->converged.shrunk, 0);
    stop(&f);
}

static void threads_make_no_difference(void **state) {
    (void)state;
    struct fixture a, b;
    start(&a, 1);
    start(&b, 3);
    run(&a, 0.0f);
    run(&b, 0.0f);
    const struct cache_tree *s = &a.cache->irradiance_tree, *t = &b.cache->irradiance_tree;
    assert_int_equal(s->head_count, t->head_count);
    assert_memory_equal(s->head, t->head, s->head_count * sizeof *s->head);
    stop(&a);
    stop(&b);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(records_are_added_where_they_disagree),
        cmocka_unit_test(direct_light_hides_differences),
        cmocka_unit_test(threads_make_no_difference),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
