// SPDX-License-Identifier: Apache-2.0
// Strong caustic photons are divided among weaker ones around them, which have their power and stay
// on their side of walls; equal photons stay as they are.
#include <math.h>
#include <stdlib.h>

#include "photon/photon_map.h"
#include "test_scene.h"

enum { WEAK = 5000, K = 60 };
static const float LARGEST = 0.1f, WIDEST = 0.4f;

// A floor of 2 x 2 with a wall at x = .1, as high as the floor is wide.
static void divide_scene(struct test_scene *t) {
    test_scene_init(t);
    const uint32_t white = test_diffuse(t, 0.5f, 0.5f, 0.5f);
    test_rectangle(t, mat4_identity(), white);
    const struct mat4 to = mat4_translate(v3(0.1f, 0.0f, 0.5f)),
                      rotate = mat4_rotate(v3(0, 1, 0), 90.0f);
    const struct mat4 upright = mat4_mul(&to, &rotate);
    test_rectangle(t, upright, white);
    test_scene_finish(t);
}

// Weak photons all over the floor, and one of `strong` times their power beside the wall.
static struct photon_map divide_map(const struct test_scene *t, float strong,
                                    struct parallel *pool) {
    static struct photon_hit hit[WEAK + 1];
    const uint32_t up = photon_pack(v3(0, 0, 1));
    struct rng rng = rng_make(1, RNG_TEST, 0);
    for (int i = 0; i <= WEAK; i++) {
        const vec3 p = v3(2.0f * rng_float(&rng) - 1.0f, 2.0f * rng_float(&rng) - 1.0f, 0.0f);
        hit[i] = (struct photon_hit){p, rgb_grey(1.0f / WEAK), up, up, 0, false, false, 0, 0, 0};
    }
    hit[WEAK].p = v3(0, 0, 0);
    hit[WEAK].power = rgb_grey(strong / WEAK);
    struct photon_map map;
    assert_int_equal(photon_map_build(&t->scene, hit, WEAK + 1, pool, (struct log){0}, &map),
                     SATIN_OK);
    map.radius_max = LARGEST;
    return map;
}

static double power_of(const struct photon_map *map) {
    double sum = 0.0;
    for (size_t i = 0; i < map->count; i++) sum += (double)map->photon[i].power.g;
    return sum;
}

// The light of the copies in an estimate is that of one photon, so its variance is the square of
// their sum. How many of them there are is known roughly.
static void copies_vary_together(void **state) {
    (void)state;
    struct test_scene t;
    divide_scene(&t);
    struct parallel *pool = parallel_new(2);
    struct photon_map map = divide_map(&t, 500.0f, pool);
    const struct photon_divide by = {1, K, 1.0f, WIDEST};
    assert_int_equal(photon_map_divide(&by, &t.scene, pool, (struct log){0}, &map), SATIN_OK);
    const struct photon_query query = {&map, &t.scene,    v3(-0.02f, 0, 0), v3(0, 0, 1),
                                       K,    KERNEL_FLAT, AREA_WHOLE};
    int row[K], copies = 0;
    float distance2[K];
    struct photon_disc disc;
    photon_index_nearest(map.index, &query.p.x, 1, K, LARGEST * LARGEST, row, distance2);
    photon_disc_make(&query, row, distance2, &disc);
    double sum = 0.0;
    for (int i = 0; i < K; i++) {
        const double power = row[i] < 0 ? 0.0 : (double)map.photon[row[i]].power.g;
        if (!(distance2[i] < disc.r2) || fabs(power * WEAK - 1.0) < 1e-3) continue;
        sum += power * (double)disc.scale;
        copies++;
    }
    const double together = (double)photon_disc_variance(&disc) / (3.0 * sum * sum);
    print_message("%d copies, variance %.2f\n", copies, together);
    assert_true(copies > 5 && together > 0.5 && together < 2.0);
    photon_map_free(&map);
    parallel_free(pool);
    test_scene_free(&t);
}

static void a_strong_photon_is_divided(void **state) {
    (void)state;
    struct test_scene t;
    divide_scene(&t);
    struct parallel *pool = parallel_new(2);
    struct photon_map map = divide_map(&t, 500.0f, pool);
    const double power = power_of(&map);
    // The kernel of a weak photon has a peak of .013 at the largest radius.
    const struct photon_divide by = {1, K, 1.0f, WIDEST};
    assert_int_equal(photon_map_divide(&by, &t.scene, pool, (struct log){0}, &map), SATIN_OK);
    assert_true(map.count > WEAK + 16);
    assert_true(map.radius_max == LARGEST);
    assert_true(fabs(power_of(&map) / power - 1.0) < 1e-4);
    double most = 0.0, far = 0.0, divided = 0.0;
    for (size_t i = 0; i < map.count; i++) {
        const vec3 p = photon_position(&map, i);
        const double own = (double)map.photon[i].power.g;
        most = fmax(most, own);
        if (fabs(own * WEAK - 1.0) < 1e-3) continue;  // a weak one
        divided += own;
        far = fmax(far, (double)v3_len(p));
        assert_true(fabsf(p.z) < 1e-5f && p.x < 0.1f);
    }
    assert_true(fabs(divided * WEAK - 500.0) < 1.0);
    assert_true(most * WEAK < 30.0);
    assert_true(far > 0.5 * (double)WIDEST && far <= (double)WIDEST);
    photon_map_free(&map);
    parallel_free(pool);
    test_scene_free(&t);
}

// Where estimates have small discs, a photon is a bright spot that would not be visible if it were
// spread over the largest disc.
static void a_spot_among_many_photons_is_divided(void **state) {
    (void)state;
    struct test_scene t;
    divide_scene(&t);
    struct parallel *pool = parallel_new(2);
    for (int strong = 5; strong <= 20; strong *= 4) {
        struct photon_map map = divide_map(&t, (float)strong, pool);
        map.radius_max = 0.3f;
        const double power = power_of(&map);
        const struct photon_divide by = {1, K, 2.0f, WIDEST};
        assert_int_equal(photon_map_divide(&by, &t.scene, pool, (struct log){0}, &map), SATIN_OK);
        assert_true(strong > 5 ? map.count > WEAK + 16 : map.count == WEAK + 1);
        assert_true(fabs(power_of(&map) / power - 1.0) < 1e-4);
        for (size_t i = 0; i < map.count; i++) assert_true(map.photon[i].power.g * WEAK < 5.5f);
        photon_map_free(&map);
    }
    parallel_free(pool);
    test_scene_free(&t);
}

// Neither are photons among which one is not visible, nor any if the mean irradiance is not known.
static void equal_photons_stay(void **state) {
    (void)state;
    struct test_scene t;
    divide_scene(&t);
    struct parallel *pool = parallel_new(2);
    const struct {
        float strong, irradiance;
    } cases[] = {{1.0f, 1.0f}, {500.0f, 0.0f}, {500.0f, 1e4f}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct photon_map map = divide_map(&t, cases[i].strong, pool);
        const struct photon_divide by = {1, K, cases[i].irradiance, WIDEST};
        assert_int_equal(photon_map_divide(&by, &t.scene, pool, (struct log){0}, &map), SATIN_OK);
        assert_int_equal(map.count, WEAK + 1);
        photon_map_free(&map);
    }
    parallel_free(pool);
    test_scene_free(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_strong_photon_is_divided),
        cmocka_unit_test(copies_vary_together),
        cmocka_unit_test(a_spot_among_many_photons_is_divided),
        cmocka_unit_test(equal_photons_stay),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
