// SPDX-License-Identifier: Apache-2.0
// Photons go to the lights by what is visible of their light: a lamp in a closed room, in a bright
// sky.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "photon/photon_map.h"
#include "test_scene.h"

// A camera amid a cube of half-width 1, with a small lamp at its ceiling, beneath a sky that brings
// some hundred times its power. The lamp is light 0.
static void guide_allocation_room(struct test_scene *t, bool closed) {
    test_scene_init(t);
    const uint32_t grey = test_diffuse(t, 0.5f, 0.5f, 0.5f);
    if (closed) {
        test_cube(t, mat4_identity(), true, grey);
    } else {
        test_rectangle(t, test_transform(v3(0, 0, -1), v3(1, 1, 1)), grey);
    }
    // It is upside down, so that it shines down.
    struct mat4 down = test_transform(v3(0, 0, 0.9f), v3(0.2f, -0.2f, -1.0f));
    test_area_light(t, test_rectangle(t, down, grey), rgb_grey(10.0f));
    test_light(t, (struct light){.kind = LIGHT_CONSTANT, .value = rgb_grey(10.0f)});
    test_scene_finish(t);
    t->scene.camera = (struct camera){
        .to_world = mat4_scale(v3(1, 1, -1)), .tan_x = 1.0f, .tan_y = 1.0f, .far_clip = INFINITY};
    t->scene.film =
        (struct scene_film){.width = 64, .height = 64, .crop_width = 64, .crop_height = 64};
}

static void lamps_in_closed_rooms_get_half(void **state) {
    (void)state;
    struct test_scene t;
    struct guide_allocation allocation;
    guide_allocation_room(&t, true);
    const float by_power = t.scene.light_cdf[1];
    assert_true(by_power < 0.01f);
    guide_allocation_make(&t.scene, 1, GUIDE_SEEN_PATHS_MAX, NULL, &allocation);
    assert_false(allocation.by_power);
    assert_true(fabsf(allocation.fraction[0] - 0.5f - 0.5f * by_power) < 1e-6f);
    assert_true(fabsf(allocation.fraction[0] + allocation.fraction[1] - 1.0f) < 1e-6f);
    test_scene_free(&t);
}

static void skies_over_open_floors_get_most(void **state) {
    (void)state;
    struct test_scene t;
    struct guide_allocation allocation;
    guide_allocation_room(&t, false);
    guide_allocation_make(&t.scene, 1, GUIDE_SEEN_PATHS_MAX, NULL, &allocation);
    // Walks leave the floor upwards and hit only the back of the lamp, or the sky.
    assert_true(allocation.by_power || allocation.fraction[1] > 0.5f);
    test_scene_free(&t);
}

// What is seen and the allocation are the same to the bit for any number of threads.
static void threads_do_not_change_the_allocation(void **state) {
    (void)state;
    struct test_scene t;
    guide_allocation_room(&t, true);
    struct guide_allocation one, many;
    struct guide_seen seen_one, seen_many;
    memset(&seen_one, 0, sizeof seen_one);
    memset(&seen_many, 0, sizeof seen_many);
    struct parallel *pool = parallel_new(3);
    assert_non_null(pool);
    guide_allocation_make(&t.scene, 1, GUIDE_SEEN_PATHS_MAX, NULL, &one);
    guide_allocation_make(&t.scene, 1, GUIDE_SEEN_PATHS_MAX, pool, &many);
    guide_seen_make(&t.scene, 1, GUIDE_SEEN_PATHS_MAX, NULL, &seen_one);
    guide_seen_make(&t.scene, 1, GUIDE_SEEN_PATHS_MAX, pool, &seen_many);
    parallel_free(pool);
    assert_false(one.by_power);
    assert_memory_equal(one.fraction, many.fraction, t.scene.light_count * sizeof *one.fraction);
    assert_true(seen_one.count > 0);
    assert_int_equal(seen_one.count, seen_many.count);
    assert_true(seen_one.ray_length == seen_many.ray_length);
    assert_memory_equal(seen_one.box, seen_many.box, sizeof seen_one.box);
    test_scene_free(&t);
}

// With another allocation the same amount of light arrives.
static void allocation_keeps_the_power(void **state) {
    (void)state;
    struct test_scene t;
    guide_allocation_room(&t, true);
    struct guide_allocation allocation;
    guide_allocation_make(&t.scene, 1, GUIDE_SEEN_PATHS_MAX, NULL, &allocation);
    struct parallel *pool = parallel_new(1);
    assert_non_null(pool);
    const struct photon_tracing tracing = {.scene = &t.scene,
                                           .seed = 1,
                                           .consumer = {{1 << 20, 1 << PHOTON_DIRECT, NULL},
                                                        {1 << 20, 1 << PHOTON_DIRECT, &allocation}},
                                           .bounces = 0};
    struct photon_trace trace[PHOTON_CONSUMERS];
    assert_int_equal(photon_trace_run(&tracing, pool, (struct log){0}, trace), SATIN_OK);
    double sum[PHOTON_CONSUMERS] = {0.0};
    for (int i = 0; i < PHOTON_CONSUMERS; i++) {
        for (size_t k = 0; k < trace[i].count; k++) sum[i] += (double)trace[i].hit[k].power.g;
        photon_trace_free(&trace[i]);
    }
    parallel_free(pool);
    test_scene_free(&t);
    assert_true(sum[0] > 0.0 && fabs(sum[1] / sum[0] - 1.0) < 2e-3);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lamps_in_closed_rooms_get_half),
        cmocka_unit_test(skies_over_open_floors_get_most),
        cmocka_unit_test(threads_do_not_change_the_allocation),
        cmocka_unit_test(allocation_keeps_the_power),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
