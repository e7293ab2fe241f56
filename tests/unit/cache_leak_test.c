// SPDX-License-Identifier: Apache-2.0
// The leak test: a record beside a thin wall serves points on its own side and beyond the wall's
// end, none behind the wall.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "fill/fill_record.h"
#include "test_scene.h"

struct cache_leak_fixture {
    struct test_scene scene;
    satin_options options;
    struct gather g;
    struct cache cache;
    struct cache_head head;
};

// A floor in the xy plane; a wall at x = 0, from y = -10 to 0.5. The record lies at x = .2.
static void cache_leak_start(struct cache_leak_fixture *f, float least) {
    test_scene_init(&f->scene);
    uint32_t grey = test_diffuse(&f->scene, 0.5f, 0.5f, 0.5f);
    test_rectangle(&f->scene, mat4_scale(v3(10, 10, 1)), grey);
    test_cube(&f->scene, test_transform(v3(0, -4.75f, 1), v3(0.001f, 5.25f, 1)), false, grey);
    test_light(&f->scene, (struct light){.kind = LIGHT_POINT, .value = rgb_grey(1.0f)});
    test_scene_finish(&f->scene);
    f->options = satin_options_default;
    f->options.first_pass = SATIN_FIRST_NONE;
    f->options.max_depth = -1;
    f->g = gather_make(&f->scene.scene, &f->options, NULL);
    f->cache = (struct cache){.scene = &f->scene.scene, .options = &f->options};

    const vec3 up = v3(0, 0, 1);
    struct gather_site site = {
        v3(0.2f, 0, 0), up, frame_from_tangent(up, v3(1, 0, 0)), 7, true, NULL, {0, 0, 0}};
    struct gather_layout *layout = gather_layout_new(600, SATIN_HSH, 0);
    struct gather_worker *worker = gather_workers_new(NULL, gather_layout_rays(layout));
    struct cache_irradiance_value value;
    struct gather_surroundings around;
    gather_hemisphere_trace(&f->g, layout, &site, worker->scratch, worker->hemisphere);
    gather_hemisphere_irradiance(worker->hemisphere, f->g.options->irradiance_gradients, &value);
    gather_surroundings_make(worker->hemisphere, SATIN_GRADIENTS_STRATIFIED, false, &around);
    f->head = (struct cache_head){
        .p = site.p, .R = 2.0f, .n = up, .u = site.frame.u, .search_radius = 2.0f, .scale = 1.0f};
    f->head.clear = fill_find_sectors(&around, f->head.search_radius, least, f->head.sector);
    gather_workers_free(worker, 1);
    gather_layout_free(layout);
}

static void a_wall_hides_what_is_behind(void **state) {
    (void)state;
    struct cache_leak_fixture f;
    cache_leak_start(&f, 0.0f);
    // Hits are near towards the wall, but not away from it.
    assert_true(f.head.sector[CACHE_SECTORS / 2] < UINT8_MAX);
    assert_int_equal(f.head.sector[0], UINT8_MAX);
    assert_true(cache_leaks(&f.cache, &f.head, v3(-0.3f, 0, 0)));
    assert_true(cache_leaks(&f.cache, &f.head, v3(-0.01f, -0.3f, 0)));
    assert_false(cache_leaks(&f.cache, &f.head, v3(0.01f, 0, 0)));
    assert_false(cache_leaks(&f.cache, &f.head, v3(0.9f, -0.4f, 0)));
    assert_false(cache_leaks(&f.cache, &f.head, v3(-0.2f, 1.6f, 0)));  // around its end
    f.options.leak_test = false;
    assert_false(cache_leaks(&f.cache, &f.head, v3(-0.3f, 0, 0)));
    test_scene_free(&f.scene);
}

// What is close to a surface that is near a record on one side is not served by it, but for points
// within the least influence radius.
static void records_serve_points_up_to_near_surfaces(void **state) {
    (void)state;
    struct cache_leak_fixture f;
    cache_leak_start(&f, 0.0f);
    assert_true(cache_serves(&f.head, v3(0.06f, 0, 0)));
    assert_false(cache_serves(&f.head, v3(0.01f, 0, 0)));
    assert_false(cache_serves(&f.head, v3(0.01f, -0.1f, 0)));
    assert_true(cache_serves(&f.head, v3(1.9f, 0, 0)));
    test_scene_free(&f.scene);
    cache_leak_start(&f, 0.3f);
    assert_true(cache_serves(&f.head, v3(0.01f, 0, 0)));
    assert_false(cache_serves(&f.head, v3(-0.2f, 0, 0)));
    test_scene_free(&f.scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_wall_hides_what_is_behind),
                                       cmocka_unit_test(records_serve_points_up_to_near_surfaces)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
