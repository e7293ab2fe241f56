// SPDX-License-Identifier: Apache-2.0
// Photons through openings: with more of them where a room is lit through a slit, the same light
// arrives, from the sky and from the ground outside.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/sampling.h"
#include "guide/guide_visibility.h"
#include "light/light_kinds.h"
#include "photon/photon_map.h"
#include "test_scene.h"

// A room with a slit (test_slit_room) on a ground of +-20, under a sky or a low sun that shines
// into the slit.
static void room_on_ground(struct test_scene *t, enum light_kind kind) {
    test_scene_init(t);
    test_slit_room(t, true);
    test_rectangle(t, test_transform(v3(0, 0, -2), v3(20, 20, 1)),
                   test_diffuse(t, 0.6f, 0.6f, 0.6f));
    if (kind == LIGHT_CONSTANT)
        test_light(t, (struct light){.kind = LIGHT_CONSTANT, .value = rgb_grey(1.0f)});
    if (kind == LIGHT_DIRECTIONAL)
        test_light(t, (struct light){.kind = LIGHT_DIRECTIONAL,
                                     .direction = v3_unit(v3(-1, 0.1f, -0.4f)),
                                     .value = rgb_grey(3.0f)});
    test_scene_finish(t);
    test_look_down(t);
}

// The room, and what is learnt in it.
struct open_room {
    struct test_scene t;
    struct guide_visibility *visibility;
    const struct light_aim *aim;
};

static void begin_open_room(struct open_room *room, enum light_kind kind) {
    room_on_ground(&room->t, kind);
    const struct guide_visibility_samples samples = {
        .paths = 4096, .box_rays = 8, .bin_rays = 3, .open_bins = 1024, .light_rays = 32};
    struct parallel *pool = parallel_new(2);
    assert_int_equal(guide_visibility_build(&room->t.scene, 0, samples, pool, &room->visibility),
                     SATIN_OK);
    parallel_free(pool);
    room->aim = guide_visibility_aim(room->visibility);
    assert_non_null(room->aim);
}

static void end_open_room(struct open_room *room) {
    guide_visibility_free(room->visibility);
    test_scene_free(&room->t);
}

static struct photon_trace trace_aimed(const struct test_scene *t, const struct light_aim *aim,
                                       uint64_t seed, uint64_t paths, int threads) {
    struct parallel *pool = parallel_new(threads);
    const unsigned all = 1 << PHOTON_DIRECT | 1 << PHOTON_CAUSTIC | 1 << PHOTON_INDIRECT;
    const struct photon_tracing tracing = {.scene = &t->scene,
                                           .seed = seed,
                                           .consumer = {{.paths = paths, .classes = all}},
                                           .bounces = -1,
                                           .aim = aim};
    struct photon_trace out[PHOTON_CONSUMERS];
    assert_int_equal(photon_trace_run(&tracing, pool, (struct log){0}, out), SATIN_OK);
    parallel_free(pool);
    return out[0];
}

// What arrives in the room, and how many photons bring it: directly, and after other bounces.
struct arrived {
    double flux[2];
    size_t count;
};

static struct arrived arrive_in_room(const struct photon_trace *photons) {
    struct arrived sum = {{0.0}, 0};
    for (size_t i = 0; i < photons->count; i++) {
        const struct photon_hit *hit = &photons->hit[i];
        const vec3 p = v3_mad(hit->p, 0.01f, photon_unpack(hit->n));
        if (v3_max_abs(p) > 1.0f) continue;
        sum.flux[hit->indirect] += (double)hit->power.g;
        sum.count++;
    }
    return sum;
}

// The mean flux of passes with different seeds, and the variance of this mean.
static void repeat(const struct test_scene *t, const struct light_aim *aim, uint64_t paths,
                   double mean[2], double variance[2], size_t *count) {
    enum { PASSES = 24 };
    double sum[2] = {0.0}, squares[2] = {0.0};
    *count = 0;
    for (uint64_t seed = 0; seed < PASSES; seed++) {
        struct photon_trace photons = trace_aimed(t, aim, seed, paths, 2);
        const struct arrived in = arrive_in_room(&photons);
        for (int k = 0; k < 2; k++) {
            sum[k] += in.flux[k];
            squares[k] += in.flux[k] * in.flux[k];
        }
        *count += in.count;
        photon_trace_free(&photons);
    }
    for (int k = 0; k < 2; k++) {
        mean[k] = sum[k] / PASSES;
        variance[k] = (squares[k] / PASSES - mean[k] * mean[k]) / (PASSES - 1);
    }
}

static void as_much_light_arrives_with_less_noise(void **state) {
    static const enum light_kind KINDS[] = {LIGHT_CONSTANT, LIGHT_DIRECTIONAL};
    (void)state;
    for (int kind = 0; kind < 2; kind++) {
        struct open_room room;
        begin_open_room(&room, KINDS[kind]);
        double plain[2], aimed[2], plain2[2], aimed2[2];
        size_t few, many;
        repeat(&room.t, NULL, 200000, plain, plain2, &few);
        repeat(&room.t, room.aim, 20000, aimed, aimed2, &many);
        printf("photons %zu, %zu of a tenth of the paths\n", few, many);
        for (int k = 0; k < 2; k++) {
            printf("%s: %.4f +- %.4f, aimed %.4f +- %.4f\n", k ? "indirect" : "direct", plain[k],
                   sqrt(plain2[k]), aimed[k], sqrt(aimed2[k]));
            assert_true(plain[k] > 0.0 &&
                        fabs(plain[k] - aimed[k]) < 4.0 * sqrt(plain2[k] + aimed2[k]));
            // With as many paths, the variance would be a tenth.
            assert_true(aimed2[k] < 2.0 * plain2[k]);
        }
        assert_true((double)many > 3.0 * (double)few);
        end_open_room(&room);
    }
}

static void more_of_them_are_in_the_room(void **state) {
    static const enum light_kind KINDS[] = {LIGHT_CONSTANT, LIGHT_DIRECTIONAL};
    (void)state;
    for (int kind = 0; kind < 2; kind++) {
        struct open_room room;
        begin_open_room(&room, KINDS[kind]);
        double fraction[2];
        for (int aimed = 0; aimed < 2; aimed++) {
            const struct light_aim *aim = aimed ? room.aim : NULL;
            struct photon_trace photons = trace_aimed(&room.t, aim, 1, 200000, 2);
            fraction[aimed] = (double)arrive_in_room(&photons).count / (double)photons.count;
            photon_trace_free(&photons);
        }
        printf("fraction in the room %.5f, aimed %.3f\n", fraction[0], fraction[1]);
        assert_true(fraction[1] > 20.0 * fraction[0]);
        end_open_room(&room);
    }
}

// The power of all photons is that of the light, and all of it is accounted for.
static void the_power_is_that_of_the_sky(void **state) {
    (void)state;
    struct open_room room;
    begin_open_room(&room, LIGHT_CONSTANT);
    struct photon_trace photons = trace_aimed(&room.t, room.aim, 1, 200000, 2);
    const struct photon_power power = photons.power[0];
    assert_true(fabs(power.emitted / (double)room.t.scene.light[0].power - 1.0) < 0.01);
    assert_true(fabs(power.absorbed + power.escaped + power.ended - power.emitted) <
                1e-4 * power.emitted);
    photon_trace_free(&photons);
    end_open_room(&room);
}

static void threads_do_not_change_openings(void **state) {
    (void)state;
    struct open_room room;
    begin_open_room(&room, LIGHT_CONSTANT);
    struct photon_trace one = trace_aimed(&room.t, room.aim, 1, 20000, 1),
                        three = trace_aimed(&room.t, room.aim, 1, 20000, 3);
    assert_int_equal(one.count, three.count);
    assert_memory_equal(one.hit, three.hit, one.count * sizeof *one.hit);
    photon_trace_free(&one);
    photon_trace_free(&three);
    end_open_room(&room);
}

// A room whose wall of .1 has a hole of this width, on a ground. It is under a sky or, behind a
// screen that hides the hole, lit by the sun.
static void room_with_hole(struct test_scene *t, float width, bool screen) {
    const float top = 0.2f + width, half = 0.5f * width, side = 0.5f * (1.1f - half);
    test_scene_init(t);
    test_slit_room(t, true);
    const uint32_t grey = test_diffuse(t, 0.6f, 0.6f, 0.6f);
    for (int k = -1; k <= 1; k += 2)
        test_cube(
            t, test_transform(v3(1.05f, (float)k * (half + side), 0.35f), v3(0.05f, side, 0.15f)),
            false, grey);
    test_cube(
        t, test_transform(v3(1.05f, 0, 0.5f * (top + 0.5f)), v3(0.05f, half, 0.5f * (0.5f - top))),
        false, grey);
    test_rectangle(t, test_transform(v3(0, 0, -2), v3(20, 20, 1)), grey);
    if (screen) {
        test_cube(t, test_transform(v3(0.85f, 0, 0.2f), v3(0.03f, 0.6f, 0.6f)), false, grey);
        test_light(t, (struct light){.kind = LIGHT_DIRECTIONAL,
                                     .direction = v3_unit(v3(-1, 0.1f, -0.1f)),
                                     .value = rgb_grey(3.0f)});
    } else {
        test_light(t, (struct light){.kind = LIGHT_CONSTANT, .value = rgb_grey(1.0f)});
    }
    test_scene_finish(t);
    test_look_down(t);
}

// Many photons through openings start at the hole, with every seed; one ray through each bin from
// so many points finds it by chance. Paths that have left the room by it do not make the box
// larger.
static void find_holes(const struct test_scene *t, float width) {
    enum { SEEDS = 8, DRAWN = 256 };
    for (uint64_t seed = 0; seed < SEEDS; seed++) {
        const struct guide_visibility_samples samples = {
            .paths = 4096, .box_rays = 8, .bin_rays = 1, .open_bins = 1024, .light_rays = 32};
        struct guide_visibility *visibility;
        struct parallel *pool = parallel_new(2);
        assert_int_equal(guide_visibility_build(&t->scene, seed, samples, pool, &visibility),
                         SATIN_OK);
        const struct light_aim *aim = guide_visibility_aim(visibility);
        assert_non_null(aim);
        int near = 0;
        for (uint32_t i = 0; i < DRAWN; i++) {
            const vec2 u = sample_sobol2(i, 0);
            const vec3 p =
                light_openings_point(aim->openings, v3_unit(v3(-1, 0.1f, -0.1f)), u.x, u.y);
            near += p.x > 0.9f && fabsf(p.y) < 0.1f && fabsf(p.z - 0.2f) < 0.15f;
        }
        printf("hole of %g: %d of %d, box up to %.3f\n", (double)width, near, DRAWN,
               (double)visibility->box.hi.x);
        assert_true(near > DRAWN / 8 && visibility->box.hi.x < 1.2f);
        guide_visibility_free(visibility);
        parallel_free(pool);
    }
}

static void small_holes_are_found(void **state) {
    (void)state;
    for (int wide = 0; wide < 2; wide++) {
        const float width = wide ? 0.1f : 0.04f;
        struct test_scene t;
        room_with_hole(&t, width, false);
        find_holes(&t, width);
        test_scene_free(&t);
    }
}

// Neither the eye nor any point on its paths sees the hole.
static void holes_behind_a_screen_are_found(void **state) {
    (void)state;
    struct test_scene t;
    room_with_hole(&t, 0.1f, true);
    find_holes(&t, 0.1f);
    test_scene_free(&t);
}

// The box is around the room although its window shows a wall that is larger in all directions.
static void a_wall_outside_is_left_out(void **state) {
    (void)state;
    struct test_scene t;
    test_scene_init(&t);
    test_slit_room(&t, true);
    test_cube(&t, test_transform(v3(6, 0, 0), v3(1, 60, 40)), false,
              test_diffuse(&t, 0.6f, 0.6f, 0.6f));
    test_light(&t, (struct light){.kind = LIGHT_CONSTANT, .value = rgb_grey(1.0f)});
    test_scene_finish(&t);
    test_look_down(&t);
    t.scene.camera.to_world = mat4_rotate(v3(0, 1, 0), 90.0f);  // to the window
    const struct guide_visibility_samples samples = {
        .paths = 4096, .box_rays = 8, .bin_rays = 1, .open_bins = 1024, .light_rays = 32};
    struct guide_visibility *visibility;
    struct parallel *pool = parallel_new(2);
    assert_int_equal(guide_visibility_build(&t.scene, 0, samples, pool, &visibility), SATIN_OK);
    const struct light_box *box = &visibility->box;
    printf("box from %g %g %g to %g %g %g\n", (double)box->lo.x, (double)box->lo.y,
           (double)box->lo.z, (double)box->hi.x, (double)box->hi.y, (double)box->hi.z);
    assert_true(v3_max_abs(box->lo) < 1.2f && v3_max_abs(box->hi) < 1.2f);
    guide_visibility_free(visibility);
    parallel_free(pool);
    test_scene_free(&t);
}

// Openings get photons only if they are smaller than the scene. Around a small box in it, boxes
// grow up to half of the scene's area.
static void openings_are_small(void **state) {
    (void)state;
    struct test_scene t;
    room_on_ground(&t, LIGHT_CONSTANT);
    const struct light_box room = light_box_make(v3(-1, -1, -1), v3(1, 1, 1)),
                           large = light_box_make(v3(-30, -30, -2), v3(30, 30, 10));
    static float none[LIGHT_HISTOGRAM_BINS], all[LIGHT_HISTOGRAM_BINS];
    struct light_openings openings;
    struct light_aim aim;
    for (int i = 0; i < LIGHT_HISTOGRAM_BINS; i++) all[i] = 0.5f;
    guide_openings_make(&t.scene, &room, none, &openings, &aim);
    assert_null(aim.openings);
    guide_openings_make(&t.scene, &large, all, &openings, &aim);
    assert_null(aim.openings);
    guide_openings_make(&t.scene, &room, all, &openings, &aim);
    assert_ptr_equal(aim.openings, &openings);
    assert_true(fabsf(openings.area - 24.0f) < 1e-3f);
    assert_true(aim.count > 3 && aim.covers == 1);
    for (int i = 1; i < aim.count; i++) {
        assert_true(light_box_area(&aim.box[i]) < 0.5f * light_box_area(&aim.box[0]));
        assert_true(i == 1 || light_box_area(&aim.box[i]) > light_box_area(&aim.box[i - 1]));
    }
    test_scene_free(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(as_much_light_arrives_with_less_noise),
        cmocka_unit_test(more_of_them_are_in_the_room),
        cmocka_unit_test(the_power_is_that_of_the_sky),
        cmocka_unit_test(threads_do_not_change_openings),
        cmocka_unit_test(small_holes_are_found),
        cmocka_unit_test(holes_behind_a_screen_are_found),
        cmocka_unit_test(a_wall_outside_is_left_out),
        cmocka_unit_test(openings_are_small),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
