// SPDX-License-Identifier: Apache-2.0
// The own discs of photons, and the photons whose discs cover a point, against searches of all
// photons one by one.
#include "photon/photon_cover.h"

#include <math.h>
#include <stdlib.h>

#include "photon/photon_own_area.h"
#include "photon_case.h"
#include "test_scene.h"

enum { COUNT = 4000, POINTS = 500 };
#define WIDEST 0.1f  // largest radius of a disc

// Photons on a floor: most are uniform, others around a focus, in a cluster far from all others, at
// one position, or on a line.
static vec3 photon_cover_position(struct rng *rng, int i) {
    const float u = rng_float(rng), v = rng_float(rng);
    const float r = 0.3f * u * u * u, phi = 2.0f * PI_F * v;
    switch (i % 8) {
        case 0:
        case 1:
            return v3(r * cosf(phi), r * sinf(phi), 0.0f);
        case 2:
            return v3(0.9f + 1e-3f * u, 0.9f + 1e-3f * v, 0.0f);
        case 3:
            return i % 64 == 3 ? v3(-0.25f, 0.125f, 0.0f) : v3(-0.5f, u - 0.5f, 0.0f);
        default:
            return v3(u - 0.5f, v - 0.5f, 0.0f);
    }
}

struct cover_case {
    struct test_scene scene;
    struct parallel *pool;
    struct photon_map map;
};

// A floor and a wall on it, and a map of COUNT photons with their radii.
static void photon_cover_setup(struct cover_case *c, int k) {
    test_scene_init(&c->scene);
    const uint32_t grey = test_diffuse(&c->scene, 0.5f, 0.5f, 0.5f);
    const struct mat4 stand = mat4_rotate(v3(0, 1, 0), 90.0f),
                      move = test_transform(v3(0.2f, 0, 0), v3(1, 1, 1));
    test_rectangle(&c->scene, test_transform(v3(0, 0, 0), v3(2, 2, 1)), grey);
    test_rectangle(&c->scene, mat4_mul(&move, &stand), grey);
    test_scene_finish(&c->scene);
    c->pool = parallel_new(2);
    assert_non_null(c->pool);
    struct photon_hit *hit = calloc(COUNT, sizeof *hit);
    struct rng rng = rng_make(1, RNG_TEST, 0);
    const uint32_t up = photon_pack(v3(0, 0, 1));
    for (int i = 0; i < COUNT; i++) {
        const float power = 0.5f + rng_float(&rng);
        const vec3 p = photon_cover_position(&rng, i);
        const uint8_t bounces = (uint8_t)(rng_float(&rng) * 5.0f);
        const int8_t tilt = photon_pack_tilt(0.2f + 2.0f * rng_float(&rng));
        hit[i] = (struct photon_hit){p, rgb_grey(power), up, up, bounces, false, false, 0, tilt, 0};
    }
    assert_int_equal(
        photon_map_build(&c->scene.scene, hit, COUNT, c->pool, (struct log){0}, &c->map), SATIN_OK);
    c->map.radius_max = WIDEST;
    c->map.stride = 1;
    assert_int_equal(photon_map_find_radii(&c->map, k, c->pool), SATIN_OK);
    free(hit);
}

static void photon_cover_teardown(struct cover_case *c) {
    photon_map_free(&c->map);
    parallel_free(c->pool);
    test_scene_free(&c->scene);
}

// The squared radius of photon i's disc, by the distances of all photons.
static float radius2_of_all(const struct photon_map *map, size_t i, int k) {
    static float distance2[COUNT];
    for (size_t j = 0; j < COUNT; j++)
        distance2[j] = v3_dist2(photon_position(map, i), photon_position(map, j));
    qsort(distance2, COUNT, sizeof *distance2, array_compare_floats);
    return fminf(distance2[k - 1], map->radius_max * map->radius_max);
}

static void radii_are_those_of_the_nearest(void **state) {
    (void)state;
    const int k[] = {2, 7, 60};
    for (int l = 0; l < 3; l++) {
        struct cover_case c;
        int limited = 0, zero = 0;
        photon_cover_setup(&c, k[l]);
        for (size_t i = 0; i < COUNT; i++) {
            assert_float_equal(c.map.radius2[i], radius2_of_all(&c.map, i, k[l]), 0.0f);
            limited += c.map.radius2[i] == WIDEST * WIDEST;
            zero += c.map.radius2[i] == 0.0f;
        }
        print_message("k = %d: %d discs of the largest radius, %d of radius 0\n", k[l], limited,
                      zero);
        photon_cover_teardown(&c);
    }
}

// The irradiance at p by all photons, one by one, and the largest number of bounces.
static rgb irradiance_of_all(const struct photon_map *map, vec3 p, vec3 n, int *bounces) {
    rgb E = rgb_grey(0.0f);
    *bounces = 0;
    for (size_t i = 0; i < COUNT; i++) {
        const vec3 at = photon_position(map, i);
        const float d2 = v3_dist2(at, p);
        if (!(d2 < map->radius2[i])) continue;
        const float weight = photon_own_weight(map, i, n, p, d2, KERNEL_PARABOLA);
        E = rgb_mad(E, map->photon[i].power, weight * photon_unpack_tilt(map->photon[i].tilt));
        if (weight > 0.0f && map->photon[i].bounces > *bounces) *bounces = map->photon[i].bounces;
    }
    return E;
}

static void assert_close(rgb a, rgb b) { assert_true(fabsf(a.r - b.r) <= 1e-5f * b.r); }

static void estimates_have_all_that_cover_them(void **state) {
    (void)state;
    struct cover_case c;
    photon_cover_setup(&c, 60);
    const vec3 n = photon_unpack(photon_pack(v3(0, 0, 1)));
    static float clear[COUNT];
    static rgb E[COUNT];
    static uint8_t bounces[COUNT];
    c.map.whole_disc = calloc(COUNT, 1);
    assert_int_equal(
        photon_own_areas_find(&c.map, &c.scene.scene, KERNEL_PARABOLA, true, c.pool, clear),
        SATIN_OK);
    assert_int_equal(photon_cover_build(&c.map, c.pool), SATIN_OK);
    int most;
    photon_cover_estimate(&c.map, 0, COUNT, KERNEL_PARABOLA, E, bounces);
    for (size_t i = 0; i < COUNT; i++) {
        assert_close(E[i], irradiance_of_all(&c.map, photon_position(&c.map, i), n, &most));
        assert_int_equal(bounces[i], most);
    }
    struct rng rng = rng_make(1, RNG_TEST, 1);
    for (int i = 0; i < POINTS; i++) {
        const vec3 p = v3_add(photon_cover_position(&rng, i), v3(0.01f, 0.01f, 0.0f));
        struct photon_cover_walk walk;
        rgb sum = rgb_grey(0.0f);
        photon_cover_begin(&walk, &c.map, p, n, KERNEL_PARABOLA);
        while (photon_cover_next(&walk)) sum = rgb_add(sum, photon_disc_irradiance(&walk.disc));
        assert_close(sum, irradiance_of_all(&c.map, p, n, &most));
    }
    photon_cover_teardown(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(radii_are_those_of_the_nearest),
        cmocka_unit_test(estimates_have_all_that_cover_them),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
