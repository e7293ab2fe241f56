// SPDX-License-Identifier: Apache-2.0
// Light of a surface that lies behind another one is not counted on it, nor read there; that of a
// surface with a step, or of a curved one, is.
#include <math.h>
#include <stdlib.h>

#include "base/sampling.h"
#include "photon/photon_map.h"
#include "photon_case.h"
#include "test_scene.h"

enum { PART = 256 };  // photons of each part of the surfaces
static const float RISE = 0.05f;

static struct photon_hit hit_at(vec3 p, vec3 n) {
    const uint32_t up = photon_pack(n);
    return (struct photon_hit){p, rgb_grey(1.0f), up, up, 0, false, false, 0, 0, 0};
}

static void build_map(const struct test_scene *t, const struct photon_hit *hit, size_t count,
                      struct photon_map *map) {
    struct parallel *pool = parallel_new(2);
    assert_non_null(pool);
    *map = (struct photon_map){0};
    assert_int_equal(photon_map_build(&t->scene, hit, count, pool, (struct log){0}, map), SATIN_OK);
    map->radius_max = 0.3f;
    parallel_free(pool);
}

// The photons that count at p, with those at the border of the disc or beyond not counted.
struct counted {
    int over, beside, under;
};

static struct counted counted_at(const struct test_scene *t, const struct photon_map *map, vec3 p) {
    int row[PHOTON_K_MAX];
    float distance2[PHOTON_K_MAX];
    struct photon_disc disc;
    const struct photon_query query = {map,          &t->scene,   p,         v3(0, 0, 1),
                                       3 * PART + 1, KERNEL_FLAT, AREA_WHOLE};
    struct counted counted = {0};
    photon_disc_find(&query, row, distance2, &disc);
    for (int i = 0; i < disc.count; i++) {
        const vec3 q = photon_position(map, (size_t)row[i]);
        assert_true(photon_disc_weight(&disc, i) > 0.0f);
        *(q.z > 0.0f ? &counted.over : q.x < 0.0f ? &counted.beside : &counted.under) += 1;
    }
    return counted;
}

// A floor, of which a part is under another one that is a step higher. All of the photons are
// within .2 of the edge, and within the disc.
static void layers_are_not_steps(void **state) {
    (void)state;
    struct test_scene t;
    struct photon_hit hit[3 * PART];
    struct photon_map map;
    test_scene_init(&t);
    const uint32_t grey = test_diffuse(&t, 0.5f, 0.5f, 0.5f);
    test_rectangle(&t, test_transform(v3(0, 0, 0), v3(1, 1, 1)), grey);
    test_rectangle(&t, test_transform(v3(1, 0, RISE), v3(1, 1, 1)), grey);
    test_scene_finish(&t);
    for (uint32_t i = 0; i < PART; i++) {
        const vec2 u = sample_sobol2(i, 0);
        const float x = 0.01f + 0.19f * u.x, y = 0.2f * u.y - 0.1f;
        hit[3 * i] = hit_at(v3(x, y, RISE), v3(0, 0, 1));
        hit[3 * i + 1] = hit_at(v3(-x, y, 0), v3(0, 0, 1));
        hit[3 * i + 2] = hit_at(v3(x, y, 0), v3(0, 0, 1));
    }
    build_map(&t, hit, 3 * PART, &map);
    const struct counted over = counted_at(&t, &map, v3(0.05f, 0, RISE)),
                         beside = counted_at(&t, &map, v3(-0.05f, 0, 0)),
                         under = counted_at(&t, &map, v3(0.05f, 0, 0));
    assert_true(over.over == PART && over.beside == PART && over.under == 0);
    assert_true(beside.over == PART && beside.beside == PART && beside.under == PART);
    assert_true(under.over == 0 && under.beside == PART && under.under == PART);
    photon_map_free(&map);
    test_scene_free(&t);
}

// On a ball, of radius 1, all photons of the disc count, within and without.
static void photons_of_a_ball_count(void **state) {
    (void)state;
    for (int side = -1; side <= 1; side += 2) {
        struct test_scene t;
        struct photon_hit hit[3 * PART];
        struct photon_map map;
        test_scene_init(&t);
        test_quadric(&t, SHAPE_SPHERE, test_transform(v3(0, 0, -(float)side), v3(1, 1, 1)), false,
                     test_diffuse(&t, 0.5f, 0.5f, 0.5f));
        test_scene_finish(&t);
        for (uint32_t i = 0; i < 3 * PART; i++) {
            const vec2 u = sample_sobol2(i, 0);
            const vec3 on = v3_unit(v3(0.3f * u.x - 0.15f, 0.3f * u.y - 0.15f, (float)side));
            hit[i] = hit_at(v3(on.x, on.y, on.z - (float)side), v3_mul(on, (float)side));
        }
        build_map(&t, hit, 3 * PART, &map);
        const struct counted counted = counted_at(&t, &map, v3(0, 0, 0));
        assert_int_equal(counted.over + counted.beside + counted.under, 3 * PART);
        photon_map_free(&map);
        test_scene_free(&t);
    }
}

// In the corner of a floor and a wall, which a thin wall divides: no photon beyond it counts.
static void photons_behind_a_wall_do_not_count(void **state) {
    (void)state;
    struct test_scene t;
    struct photon_hit hit[3 * PART];
    struct photon_map map;
    test_scene_init(&t);
    const uint32_t grey = test_diffuse(&t, 0.5f, 0.5f, 0.5f);
    const struct mat4 across = mat4_rotate(v3(0, 1, 0), 90.0f),
                      along = mat4_rotate(v3(1, 0, 0), 90.0f),
                      front = test_transform(v3(0, 0, 1), v3(1, 1, 1));
    test_rectangle(&t, test_transform(v3(0, 0, 0), v3(1, 1, 1)), grey);
    test_rectangle(&t, mat4_mul(&front, &across), grey);
    test_rectangle(&t, mat4_mul(&front, &along), grey);
    test_scene_finish(&t);
    for (uint32_t i = 0; i < 3 * PART; i++) {
        const vec2 u = sample_sobol2(i, 0);
        hit[i] = hit_at(v3(0.4f * u.x - 0.2f, -0.2f * u.y, 0), v3(0, 0, 1));
    }
    build_map(&t, hit, 3 * PART, &map);
    int near = 0, behind = 0;
    for (uint32_t i = 0; i < PART; i++) {
        const vec2 u = sample_sobol2(i, 1);
        int row[PHOTON_K_MAX];
        float distance2[PHOTON_K_MAX];
        struct photon_disc disc;
        const struct photon_query query = {&map,         &t.scene, v3(0.1f * u.x, -0.1f * u.y, 0),
                                           v3(0, 0, 1),  PART,     KERNEL_FLAT,
                                           AREA_MEASURED};
        photon_disc_find(&query, row, distance2, &disc);
        for (int k = 0; k < disc.count; k++)
            if (photon_disc_weight(&disc, k) > 0.0f)
                *(photon_position(&map, (size_t)disc.row[k]).x > 0.0f ? &near : &behind) += 1;
    }
    print_message("%d before the wall, %d behind it\n", near, behind);
    assert_true(near > 10 * PART && behind == 0);
    photon_map_free(&map);
    test_scene_free(&t);
}

// A floor a little over a ground, with a lamp between them, whose entries are farther from each
// other than ten times that.
static void floor_over_light_is_dark(void **state) {
    (void)state;
    enum { POINTS = 256 };
    struct test_scene t;
    struct photon_maps *maps = NULL;
    satin_options o = satin_options_default;
    o.photons = 2000;
    o.caustic_photons = 0;
    o.photon_k = 50;
    o.gather_direct = false;
    test_scene_init(&t);
    const uint32_t grey = test_diffuse(&t, 0.5f, 0.5f, 0.5f);
    const struct mat4 down = mat4_rotate(v3(1, 0, 0), 180.0f),
                      lamp = test_transform(v3(0, 0, 0.019f), v3(0.7f, 0.7f, 1));
    test_rectangle(&t, test_transform(v3(0, 0, 0), v3(2, 2, 1)), grey);
    test_rectangle(&t, test_transform(v3(0, 0, 0.02f), v3(1, 1, 1)), grey);
    test_area_light(&t, test_rectangle(&t, mat4_mul(&lamp, &down), grey), rgb_grey(1.0f));
    test_scene_finish(&t);
    struct stats stats = {0};
    struct parallel *pool = parallel_new(2);
    assert_int_equal(photon_case_build(&t.scene, &o, pool, &stats, &maps), SATIN_OK);
    double over = 0.0, under = 0.0;
    for (uint32_t i = 0; i < POINTS; i++) {
        const vec2 u = sample_sobol2(i, 0);
        const vec3 p = v3(1.4f * u.x - 0.7f, 1.4f * u.y - 0.7f, 0.02f), up = v3(0, 0, 1);
        float radius;
        over += (double)photon_irradiance_at(maps, &t.scene, p, up, &radius, NULL).g;
        under += (double)photon_irradiance_at(maps, &t.scene, v3(p.x, p.y, 0), up, &radius, NULL).g;
    }
    print_message("%g over it, %g under it\n", over / POINTS, under / POINTS);
    assert_true(under > 1.0 * POINTS && over < 1e-3 * under);
    parallel_free(pool);
    photon_maps_free(maps);
    test_scene_free(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(layers_are_not_steps),
                                       cmocka_unit_test(photons_of_a_ball_count),
                                       cmocka_unit_test(photons_behind_a_wall_do_not_count),
                                       cmocka_unit_test(floor_over_light_is_dark)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
