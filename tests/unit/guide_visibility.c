// SPDX-License-Identifier: Apache-2.0
// Visibility of the lights: in a room with a hole in its wall, most directions that are drawn to
// the sky go through the hole, and the light they bring has the right mean; a lamp behind a wall is
// rarely chosen.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/sampling.h"
#include "guide/guide.h"
#include "test_scene.h"

// A camera looks down at the floor of a room with a slit (test_slit_room); beneath a sky, or with
// lamps above the floor and above the ceiling.
static void guide_visibility_room(struct test_scene *t, bool walls, int lamps) {
    test_scene_init(t);
    test_slit_room(t, walls);
    if (!lamps) test_light(t, (struct light){.kind = LIGHT_CONSTANT, .value = rgb_grey(1.0f)});
    for (int i = 0; i < lamps; i++)
        test_light(t, (struct light){.kind = LIGHT_POINT,
                                     .position = v3(0, 0, i ? 1.2f : 0.9f),
                                     .value = rgb_grey(1.0f)});
    test_scene_finish(t);
    test_look_down(t);
}

struct guide_visibility_tally {
    double E, visible;  // irradiance; fraction of the samples that arrive at the sky
};

// Counts samples at p on the floor, with normal z.
static struct guide_visibility_tally guide_visibility_sample(const struct test_scene *t,
                                                             const struct light_product *product,
                                                             vec3 p) {
    enum { SAMPLES = 1 << 16 };
    struct guide_visibility_tally tally = {0};
    for (uint32_t i = 0; i < SAMPLES; i++) {
        const vec2 u = sample_sobol2(i, 3);
        struct light_sample s;
        const struct light_visibility visibility = {product, NULL};
        assert_true(light_sample_visible(&t->scene, 0, visibility, p, u.x, u.y, &s));
        struct ray ray = scene_spawn(&t->scene, p, v3(0, 0, 1), s.wi);
        if (!(s.wi.z > 0.0f) || scene_occluded(&t->scene, &ray)) continue;
        tally.visible += 1.0 / SAMPLES;
        tally.E += (double)(s.wi.z / s.pdf_w) / SAMPLES;
    }
    return tally;
}

// The product at p on the floor. NULL if there is none.
static const struct light_product *guide_visibility_product(const struct guide_visibility *all,
                                                            vec3 p, struct light_product *out) {
    const struct light_receiver at = {p, v3(0, 0, 1), false};
    return guide_visibility_at(all, &at, out).product;
}

// Learns the visibility on that many threads.
static struct guide_visibility *guide_visibility_look(struct test_scene *t, int threads,
                                                      int bin_rays) {
    enum { SEED = 0 };
    const struct guide_visibility_samples samples = {
        .paths = 4096, .box_rays = 8, .bin_rays = bin_rays, .open_bins = 1024, .light_rays = 32};
    struct parallel *pool = parallel_new(threads);
    struct guide_visibility *visibility = NULL;
    assert_int_equal(guide_visibility_build(&t->scene, SEED, samples, pool, &visibility), SATIN_OK);
    parallel_free(pool);
    return visibility;
}

enum { BIN_RAYS = 3 };  // as of the default options

static struct guide_visibility *begin(struct test_scene *t, bool walls, int lamps, int threads) {
    guide_visibility_room(t, walls, lamps);
    return guide_visibility_look(t, threads, BIN_RAYS);
}

static void end(struct test_scene *t, struct guide_visibility *visibility) {
    guide_visibility_free(visibility);
    test_scene_free(t);
}

static void samples_go_through_the_hole(void **state) {
    (void)state;
    struct test_scene t;
    struct guide_visibility *all = begin(&t, true, 0, 2);
    for (int i = 0; i < 9; i++) {
        const vec3 p = v3(0.3f * (float)(i % 3 - 1), 0.3f * (float)(i / 3 - 1), -1.0f);
        struct light_product product;
        assert_non_null(guide_visibility_product(all, p, &product));
        const struct guide_visibility_tally blind = guide_visibility_sample(&t, NULL, p),
                                            guided = guide_visibility_sample(&t, &product, p);
        assert_true(guided.visible > 30.0 * blind.visible && guided.visible > 0.6);
        assert_true(fabs(guided.E - blind.E) < 0.05 * blind.E);
    }
    end(&t, all);
}

// The hole is in the wall at x = 1 to 1.1. Its bins are the same from all of the room if the face
// is there.
static void the_box_ends_at_the_hole(void **state) {
    (void)state;
    struct test_scene t;
    struct guide_visibility *all = begin(&t, true, 0, 2);
    struct light_product product;
    const struct light_box *box =
        &guide_visibility_product(all, v3(0, 0, -1), &product)->histogram->blocks->box;
    print_message("face at %.3f\n", (double)box->hi.x);
    assert_true(box->hi.x > 0.95f && box->hi.x < 1.15f);
    end(&t, all);
}

// Some fifty rays through the slit do not show where the faces should be: they stay at the walls.
static void few_rays_do_not_move_the_box(void **state) {
    (void)state;
    struct test_scene t;
    guide_visibility_room(&t, true, 0);
    const struct guide_visibility_samples samples = {
        .paths = 512, .box_rays = 1, .bin_rays = 1, .open_bins = 1024, .light_rays = 1};
    struct parallel *pool = parallel_new(2);
    for (uint64_t seed = 0; seed < 8; seed++) {
        struct guide_visibility *all = NULL;
        assert_int_equal(guide_visibility_build(&t.scene, seed, samples, pool, &all), SATIN_OK);
        struct light_product product;
        assert_non_null(guide_visibility_product(all, v3(0, 0, -1), &product));
        const struct light_box *box = &product.histogram->blocks->box;
        const vec3 lo = box->lo, hi = box->hi;
        assert_true(fminf(hi.x, fminf(hi.y, hi.z)) > 0.95f && v3_max_abs(hi) < 1.15f);
        assert_true(fmaxf(lo.x, fmaxf(lo.y, lo.z)) < -0.95f && v3_max_abs(lo) < 1.15f);
        guide_visibility_free(all);
    }
    parallel_free(pool);
    test_scene_free(&t);
}

// The fraction of E at p that comes from directions which samples draw rarely: less often than if
// they went by radiance.
static double guide_visibility_rare(const struct test_scene *t, const struct guide_visibility *all,
                                    vec3 p) {
    enum { SAMPLES = 1 << 14 };
    struct light_product product;
    assert_non_null(guide_visibility_product(all, p, &product));
    double rare = 0.0, E = 0.0;
    for (uint32_t i = 0; i < SAMPLES; i++) {
        const vec2 u = sample_sobol2(i, 5);
        const vec3 w = sample_cosine_hemisphere(u.x, u.y);
        struct ray ray = scene_spawn(&t->scene, p, v3(0, 0, 1), w);
        if (scene_occluded(&t->scene, &ray)) continue;
        E += 1.0;
        if (light_environment_pdf(&t->scene, &product, w) <
            light_environment_pdf(&t->scene, NULL, w))
            rare += 1.0;
    }
    return rare / E;
}

// One ray per bin misses what is visible from a part of a cell; the cells around have found it.
// Without them .10 of E would be rare, with them nothing is.
static void rays_of_other_cells_find_what_those_of_one_miss(void **state) {
    (void)state;
    struct test_scene t;
    double rare = 0.0;
    guide_visibility_room(&t, true, 0);
    struct guide_visibility *all = guide_visibility_look(&t, 2, 1);
    for (int i = 0; i < 16; i++) {
        const vec3 p = v3(0.3f * (float)(i % 4) - 0.45f, 0.3f * (float)(i / 4) - 0.45f, -1.0f);
        rare += guide_visibility_rare(&t, all, p) / 16.0;
    }
    assert_true(rare < 0.02);
    end(&t, all);
}

static void samples_of_an_open_floor_go_to_the_sky(void **state) {
    (void)state;
    struct test_scene t;
    struct guide_visibility *all = begin(&t, false, 0, 1);
    const vec3 p = v3(0, 0, -1);
    struct light_product product;
    assert_non_null(guide_visibility_product(all, p, &product));
    const struct guide_visibility_tally blind = guide_visibility_sample(&t, NULL, p),
                                        guided = guide_visibility_sample(&t, &product, p);
    assert_true(fabs(blind.visible - 0.5) < 0.01 && guided.visible > 0.85);
    assert_true(fabs(guided.E - M_PI) < 0.02);
    end(&t, all);
}

// A court: a floor at y = -1 with walls of half its width, or with none, below a sky with a sun of
// four texels.
static void guide_visibility_court(struct test_scene *t, bool walls) {
    enum { WIDTH = 512, HEIGHT = 256 };
    static float texel[WIDTH * HEIGHT * 3];
    static struct image sky;
    for (size_t i = 0; i < WIDTH * HEIGHT * 3; i++) {
        const size_t row = i / 3 / WIDTH, column = i / 3 % WIDTH;
        texel[i] = row / 2 == 32 && column / 2 == 40 ? 3e4f : 0.3f;
    }
    sky = scene_image_make(WIDTH, HEIGHT, 3, texel);
    struct light light = {.kind = LIGHT_ENVMAP, .value = rgb_grey(1.0f), .image = &sky};
    light.to_world = light.to_local = mat4_identity();
    test_scene_init(t);
    const uint32_t grey = test_diffuse(t, 0.5f, 0.5f, 0.5f);
    test_cube(t, test_transform(v3(0, -1.05f, 0), v3(1.1f, 0.05f, 1.1f)), false, grey);
    for (int side = -1; walls && side <= 1; side += 2) {
        const float at = 1.05f * (float)side;
        test_cube(t, test_transform(v3(at, -0.5f, 0), v3(0.05f, 0.5f, 1.1f)), false, grey);
        test_cube(t, test_transform(v3(0, -0.5f, at), v3(1.1f, 0.5f, 0.05f)), false, grey);
    }
    test_light(t, light);
    test_scene_finish(t);
    test_look_down(t);
}

// The variance of the irradiance by one sample at p on the floor of the court, over the squared
// mean.
static double guide_visibility_variance(const struct test_scene *t,
                                        const struct guide_visibility *all, vec3 p) {
    enum { SAMPLES = 1 << 14 };
    const vec3 n = v3(0, 1, 0);
    const struct light_receiver at = {p, n, false};
    struct light_product product;
    const struct light_visibility visibility = guide_visibility_at(all, &at, &product);
    double sum = 0.0, squares = 0.0;
    for (uint32_t i = 0; i < SAMPLES; i++) {
        const vec2 u = sample_sobol2(i, 3);
        struct light_sample s;
        if (!light_sample_visible(&t->scene, 0, visibility, p, u.x, u.y, &s)) continue;
        struct ray ray = scene_spawn(&t->scene, p, n, s.wi);
        if (!(s.wi.y > 0.0f) || scene_occluded(&t->scene, &ray)) continue;
        const double E = (double)(s.wi.y * rgb_luminance(s.L) / s.pdf_w);
        sum += E;
        squares += E * E;
    }
    return squares * SAMPLES / (sum * sum) - 1.0;
}

// Rays through bins hardly ever meet such a sun, so samples by them are no better than by radiance
// where it is visible, but where it is hidden they are. On the floor both occur.
static void a_sun_smaller_than_a_bin_is_left_to_radiance(void **state) {
    (void)state;
    enum { POINTS = 64 };
    struct test_scene t;
    guide_visibility_court(&t, true);
    struct guide_visibility *all = guide_visibility_look(&t, 2, BIN_RAYS);
    double blind[2] = {0.0}, guided[2] = {0.0};
    for (int i = 0; i < POINTS; i++) {
        const vec3 p = v3(0.25f * (float)(i % 8) - 0.875f, -1.0f, 0.25f * (float)(i / 8) - 0.875f);
        const double by_radiance = guide_visibility_variance(&t, NULL, p);
        const int hidden = by_radiance > 2.0;
        blind[hidden] += by_radiance / POINTS;
        guided[hidden] += guide_visibility_variance(&t, all, p) / POINTS;
    }
    print_message("in the sun %.3f of %.3f, in its shadow %.3f of %.3f\n", guided[0], blind[0],
                  guided[1], blind[1]);
    assert_true(guided[0] < 1.2 * blind[0] && guided[1] < 0.1 * blind[1]);
    end(&t, all);
}

// Without walls bins gain nothing beside samples by radiance, and photons are not aimed.
static void bins_are_not_used_in_the_open(void **state) {
    (void)state;
    for (int walls = 0; walls < 2; walls++) {
        struct test_scene t;
        guide_visibility_court(&t, walls);
        struct guide_visibility *all = guide_visibility_look(&t, 2, BIN_RAYS);
        struct light_product product;
        const struct light_receiver at = {v3(0, -1, 0), v3(0, 1, 0), false};
        assert_true(!guide_visibility_at(all, &at, &product).product == !walls);
        assert_true(!guide_visibility_aim(all) == !walls);
        end(&t, all);
    }
}

static void without_a_sky_there_is_no_histogram(void **state) {
    (void)state;
    struct test_scene t;
    struct guide_visibility *all = begin(&t, true, 1, 1);
    assert_null(all);
    struct light_product unused;
    assert_null(guide_visibility_product(all, v3(0, 0, 0), &unused));
    test_scene_free(&t);
}

// Two equal lamps, one above the floor, the other above the ceiling.
static void lamps_behind_walls_are_hardly_chosen(void **state) {
    (void)state;
    struct test_scene t;
    struct guide_visibility *all = begin(&t, true, 2, 2);
    const vec3 p = v3(0.1f, 0.2f, -1);
    const struct light_receiver at = {p, v3(0, 0, 1), false};
    struct light_product unused;
    const struct light_visibility visibility = guide_visibility_at(all, &at, &unused);
    assert_null(visibility.product);
    assert_true(light_choose_probability(&t.scene, p, LIGHT_ALL_VISIBLE, 1) > 0.35f);
    const float behind = light_choose_probability(&t.scene, p, visibility, 1);
    assert_true(behind > 0.01f && behind < 0.2f);
    assert_true(fabsf(behind + light_choose_probability(&t.scene, p, visibility, 0) - 1.0f) <
                1e-5f);
    end(&t, all);
}

static void threads_do_not_change_visibility(void **state) {
    (void)state;
    struct test_scene t;
    guide_visibility_room(&t, true, 0);
    struct guide_visibility *one = guide_visibility_look(&t, 1, BIN_RAYS),
                            *three = guide_visibility_look(&t, 3, BIN_RAYS);
    for (int i = 0; i < 64; i++) {
        const vec3 p = v3(0.06f * (float)(i % 8) - 0.2f, 0.06f * (float)(i / 8) - 0.2f, -1.0f);
        struct light_product of_one, of_three;
        const struct light_histogram *a = guide_visibility_product(one, p, &of_one)->histogram,
                                     *b = guide_visibility_product(three, p, &of_three)->histogram;
        assert_true(a->fraction == b->fraction);
        assert_memory_equal(a->weight, b->weight, sizeof a->weight);
        assert_memory_equal(a->bin, b->bin, sizeof a->bin);
        assert_memory_equal(&a->blocks->box, &b->blocks->box, sizeof a->blocks->box);
    }
    guide_visibility_free(one);
    guide_visibility_free(three);
    test_scene_free(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_go_through_the_hole),
        cmocka_unit_test(the_box_ends_at_the_hole),
        cmocka_unit_test(few_rays_do_not_move_the_box),
        cmocka_unit_test(rays_of_other_cells_find_what_those_of_one_miss),
        cmocka_unit_test(samples_of_an_open_floor_go_to_the_sky),
        cmocka_unit_test(a_sun_smaller_than_a_bin_is_left_to_radiance),
        cmocka_unit_test(bins_are_not_used_in_the_open),
        cmocka_unit_test(without_a_sky_there_is_no_histogram),
        cmocka_unit_test(lamps_behind_walls_are_hardly_chosen),
        cmocka_unit_test(threads_do_not_change_visibility),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
