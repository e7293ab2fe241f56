// SPDX-License-Identifier: Apache-2.0
// Photons of a surface that lies behind another one do not count on it; those of a surface with a
// step, or of a curved one, do.
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

// A floor and photons.
struct layered {
    struct test_scene t;
    struct photon_hit hit[3 * PART];
    struct photon_map map;
    uint32_t grey;
};

static void begin_layered(struct layered *l) {
    test_scene_init(&l->t);
    l->grey = test_diffuse(&l->t, 0.5f, 0.5f, 0.5f);
    test_rectangle(&l->t, test_transform(v3(0, 0, 0), v3(1, 1, 1)), l->grey);
}

static void end_layered(struct layered *l) {
    photon_map_free(&l->map);
    test_scene_free(&l->t);
}

// The photons that count at p, with those at the border of the disc or beyond not counted.
struct counted {
    int over, beside, under;
};

static struct counted counted_at(const struct test_scene *t, const struct photon_map *map, vec3 p,
                                 enum photon_correction correction) {
    int row[PHOTON_K_MAX];
    float distance2[PHOTON_K_MAX];
    struct photon_disc disc;
    const struct photon_query query = {map,          &t->scene,   p,         v3(0, 0, 1),
                                       3 * PART + 1, KERNEL_FLAT, correction};
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
    struct layered l;
    begin_layered(&l);
    test_rectangle(&l.t, test_transform(v3(1, 0, RISE), v3(1, 1, 1)), l.grey);
    test_scene_finish(&l.t);
    for (uint32_t i = 0; i < PART; i++) {
        const vec2 u = sample_sobol2(i, 0);
        const float x = 0.01f + 0.19f * u.x, y = 0.2f * u.y - 0.1f;
        l.hit[3 * i] = hit_at(v3(x, y, RISE), v3(0, 0, 1));
        l.hit[3 * i + 1] = hit_at(v3(-x, y, 0), v3(0, 0, 1));
        l.hit[3 * i + 2] = hit_at(v3(x, y, 0), v3(0, 0, 1));
    }
    build_map(&l.t, l.hit, 3 * PART, &l.map);
    const struct counted over = counted_at(&l.t, &l.map, v3(0.05f, 0, RISE), AREA_WHOLE),
                         beside = counted_at(&l.t, &l.map, v3(-0.05f, 0, 0), AREA_WHOLE),
                         under = counted_at(&l.t, &l.map, v3(0.05f, 0, 0), AREA_WHOLE);
    assert_true(over.over == PART && over.beside == PART && over.under == 0);
    assert_true(beside.over == PART && beside.beside == PART && beside.under == PART);
    assert_true(under.over == 0 && under.beside == PART && under.under == PART);
    end_layered(&l);
}

// A pipe whose bottom is a step above a floor: the floor beneath it has photons where the pipe is
// above the plane of its bottom.
static void floor_under_a_pipe_does_not_count(void **state) {
    (void)state;
    struct layered l;
    const float radius = 0.3f;
    begin_layered(&l);
    const struct mat4 along = mat4_rotate(v3(0, 1, 0), 90.0f),
                      high = test_transform(v3(-0.5f, 0, radius + RISE), v3(1, 1, 1)),
                      thin = test_transform(v3(0, 0, 0), v3(radius, radius, 1));
    const struct mat4 lying = mat4_mul(&high, &along);
    test_quadric(&l.t, SHAPE_CYLINDER, mat4_mul(&lying, &thin), true, l.grey);
    test_scene_finish(&l.t);
    for (uint32_t i = 0; i < 3 * PART; i++) {
        const vec2 u = sample_sobol2(i, 0);
        l.hit[i] = hit_at(v3(0.3f * u.x - 0.15f, 0.3f * u.y - 0.15f, 0), v3(0, 0, 1));
    }
    build_map(&l.t, l.hit, 3 * PART, &l.map);
    const struct counted on = counted_at(&l.t, &l.map, v3(0, 0, 0), AREA_MEASURED),
                         over = counted_at(&l.t, &l.map, v3(0, 0, RISE), AREA_MEASURED);
    assert_int_equal(on.beside + on.under, 3 * PART);
    assert_int_equal(over.beside + over.under, 0);
    end_layered(&l);
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
        const struct counted counted = counted_at(&t, &map, v3(0, 0, 0), AREA_WHOLE);
        assert_int_equal(counted.over + counted.beside + counted.under, 3 * PART);
        photon_map_free(&map);
        test_scene_free(&t);
    }
}

// In the corner of a floor and a wall, which a thin wall divides: no photon beyond it counts.
static void photons_behind_a_wall_do_not_count(void **state) {
    (void)state;
    struct layered l;
    begin_layered(&l);
    const struct mat4 across = mat4_rotate(v3(0, 1, 0), 90.0f),
                      along = mat4_rotate(v3(1, 0, 0), 90.0f),
                      front = test_transform(v3(0, 0, 1), v3(1, 1, 1));
    test_rectangle(&l.t, mat4_mul(&front, &across), l.grey);
    test_rectangle(&l.t, mat4_mul(&front, &along), l.grey);
    test_scene_finish(&l.t);
    for (uint32_t i = 0; i < 3 * PART; i++) {
        const vec2 u = sample_sobol2(i, 0);
        l.hit[i] = hit_at(v3(0.4f * u.x - 0.2f, -0.2f * u.y, 0), v3(0, 0, 1));
    }
    build_map(&l.t, l.hit, 3 * PART, &l.map);
    int near = 0, behind = 0;
    for (uint32_t i = 0; i < PART; i++) {
        const vec2 u = sample_sobol2(i, 1);
        int row[PHOTON_K_MAX];
        float distance2[PHOTON_K_MAX];
        struct photon_disc disc;
        const struct photon_query query = {&l.map,       &l.t.scene, v3(0.1f * u.x, -0.1f * u.y, 0),
                                           v3(0, 0, 1),  PART,       KERNEL_FLAT,
                                           AREA_MEASURED};
        photon_disc_find(&query, row, distance2, &disc);
        for (int k = 0; k < disc.count; k++)
            if (photon_disc_weight(&disc, k) > 0.0f)
                *(photon_position(&l.map, (size_t)disc.row[k]).x > 0.0f ? &near : &behind) += 1;
    }
    print_message("%d before the wall, %d behind it\n", near, behind);
    assert_true(near > 10 * PART && behind == 0);
    end_layered(&l);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(layers_are_not_steps),
                                       cmocka_unit_test(floor_under_a_pipe_does_not_count),
                                       cmocka_unit_test(photons_of_a_ball_count),
                                       cmocka_unit_test(photons_behind_a_wall_do_not_count)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
