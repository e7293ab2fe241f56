// SPDX-License-Identifier: Apache-2.0
// Radii of density estimates are narrowed where light is curved, to those of the least error, and
// stay where it is even.
#include <math.h>
#include <stdlib.h>

#include "photon/photon_map.h"
#include "test_scene.h"

enum { COUNT = 10000 };

// The least squared radius over that of k photons, by the formulas for light E (1 - |p|^2): there
// are COUNT photons in a disc of radius 1, so R^2 = k / (2 COUNT), and the Laplacian is -4 E. Of
// its square, four times the variance of the Laplacian is left out, which is 192 / k E^2 / R^4.
static double exact_ratio2(int k) {
    const double disc2 = k / (2.0 * COUNT), curved = 4.0 * disc2,
                 bias2 = (curved * curved - 4.0 * 192.0 / k) / 144.0 * 9.0 / 4.0;
    return cbrt(1.0 / (2.0 * bias2 * k));
}

// Photons on a floor: of even light in a square, or of light E (1 - |p|^2) in a disc.
static struct photon_map floor_map(const struct test_scene *t, bool even, struct parallel *pool) {
    struct photon_hit *hit = calloc(COUNT, sizeof *hit);
    const uint32_t up = photon_pack(v3(0, 0, 1));
    struct rng rng = rng_make(1, RNG_TEST, 0);
    for (int i = 0; i < COUNT; i++) {
        const float u = rng_float(&rng), v = rng_float(&rng);
        const float r = sqrtf(1.0f - sqrtf(u)), phi = 2.0f * PI_F * v;
        const vec3 p = even ? v3(2.0f * u - 1.0f, 2.0f * v - 1.0f, 0.0f)
                            : v3(r * cosf(phi), r * sinf(phi), 0.0f);
        hit[i] = (struct photon_hit){p, rgb_grey(1.0f), up, up, 0, false, false, 0, 0, 0};
    }
    struct photon_map map;
    assert_int_equal(photon_map_build(&t->scene, hit, COUNT, pool, (struct log){0}, &map),
                     SATIN_OK);
    free(hit);
    return map;
}

// The mean of new over old squared radii of the photons near the middle, and how many are narrower.
static double mean_ratio2(bool even, int k, double *narrower) {
    struct test_scene t;
    test_scene_init(&t);
    test_rectangle(&t, mat4_identity(), test_diffuse(&t, 0.5f, 0.5f, 0.5f));
    test_scene_finish(&t);
    struct parallel *pool = parallel_new(2);
    struct photon_map map = floor_map(&t, even, pool);
    map.radius_max = 1.0f;
    assert_int_equal(photon_map_find_radii(&map, k, pool), SATIN_OK);
    float *before = malloc(map.count * sizeof *before);
    for (size_t i = 0; i < map.count; i++) before[i] = map.radius2[i];
    assert_int_equal(photon_map_narrow_radii(&map, k, pool), SATIN_OK);
    double sum = 0.0;
    int count = 0, fewer = 0;
    for (size_t i = 0; i < map.count; i++) {
        assert_true(map.radius2[i] > 0.0f && map.radius2[i] <= before[i]);
        if (v3_len(photon_position(&map, i)) > (even ? 0.7f : 0.1f)) continue;
        sum += (double)(map.radius2[i] / before[i]);
        fewer += map.radius2[i] < before[i];
        count++;
    }
    *narrower = (double)fewer / count;
    free(before);
    photon_map_free(&map);
    parallel_free(pool);
    test_scene_free(&t);
    return sum / count;
}

static void curved_light_has_the_best_radius(void **state) {
    (void)state;
    const int k[] = {3300, 3700};
    for (int i = 0; i < 2; i++) {
        double narrower;
        const double ratio2 = mean_ratio2(false, k[i], &narrower), exact = exact_ratio2(k[i]);
        print_message("k = %d: squared radius %.3f of %.3f\n", k[i], ratio2, exact);
        assert_true(fabs(ratio2 / exact - 1.0) < 0.2);
    }
}

// Two standard deviations are exceeded by one in twenty.
static void even_light_keeps_its_radius(void **state) {
    (void)state;
    double narrower;
    const double ratio2 = mean_ratio2(true, 60, &narrower);
    print_message("squared radius %.3f, %.3f narrower\n", ratio2, narrower);
    assert_true(narrower < 0.1 && ratio2 > 0.9);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(curved_light_has_the_best_radius),
        cmocka_unit_test(even_light_keeps_its_radius),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
