// SPDX-License-Identifier: Apache-2.0
// Gather rays do not read estimates whose photons lie on one side of their disc.
#include "base/sampling.h"
#include "photon/photon_map.h"
#include "photon_case.h"
#include "test_scene.h"

enum { PHOTONS = 60, SEEDS = 256 };
static const float DISC_RADIUS = 0.1f;

// The number of discs on a floor that are reliable, of SEEDS that have random photons, whose
// density falls along x as e^(-falloff x) over the radius, before x = `wall`.
static int count_reliable(const struct satin_scene *scene, float falloff, float wall) {
    int reliable = 0;
    for (uint64_t seed = 0; seed < SEEDS; seed++) {
        struct rng rng = rng_make(seed, 0, 0);
        float position[3 * PHOTONS], distance2[PHOTONS];
        int row[PHOTONS];
        struct photon photon[PHOTONS] = {0};
        struct photon_map map = {.photon = photon, .position = position, .count = PHOTONS};
        for (int i = 0; i < PHOTONS;) {
            const float x = 2.0f * rng_float(&rng) - 1.0f, y = 2.0f * rng_float(&rng) - 1.0f;
            if (x * x + y * y >= 1.0f || DISC_RADIUS * x >= wall) continue;
            if (rng_float(&rng) >= expf(-falloff * (x + 1.0f))) continue;
            position[3 * i] = DISC_RADIUS * x;
            position[3 * i + 1] = DISC_RADIUS * y;
            position[3 * i + 2] = 0.0f;
            distance2[i] = sqrf(DISC_RADIUS) * (x * x + y * y);
            photon[i].power = rgb_grey(1.0f);
            photon[i].n = photon_pack(v3(0, 0, 1));
            photon[i].path = (uint8_t)i;
            row[i] = i;
            i++;
        }
        struct photon_disc disc = {.map = &map,
                                   .p = v3(0, 0, 0),
                                   .n = v3(0, 0, 1),
                                   .r = DISC_RADIUS,
                                   .r2 = sqrf(DISC_RADIUS),
                                   .kernel = KERNEL_FLAT,
                                   .count = PHOTONS,
                                   .row = row,
                                   .distance2 = distance2};
        photon_disc_scale(&disc, scene);
        assert_true(disc.corrected == (wall < DISC_RADIUS));
        reliable += photon_disc_reliable(&disc);
    }
    return reliable;
}

static void one_sided_estimates_are_not_read(void **state) {
    (void)state;
    struct test_scene t;
    test_scene_init(&t);
    test_rectangle(&t, test_transform(v3(0, 0, 0), v3(1, 1, 1)),
                   test_diffuse(&t, 0.5f, 0.5f, 0.5f));
    test_scene_finish(&t);
    const int even = count_reliable(&t.scene, 0.0f, INFINITY),
              slow = count_reliable(&t.scene, 0.5f, INFINITY),
              fast = count_reliable(&t.scene, 2.5f, INFINITY);
    print_message("reliable: %d even, %d slow, %d fast of %d\n", even, slow, fast, SEEDS);
    assert_int_equal(even, SEEDS);
    assert_true(slow > SEEDS - SEEDS / 16);
    assert_true(fast < SEEDS / 16);
    test_scene_free(&t);
}

// Beside a wall, photons are on one side because the surface is.
static void estimates_beside_a_wall_are_read(void **state) {
    (void)state;
    struct test_scene t;
    test_scene_init(&t);
    const uint32_t grey = test_diffuse(&t, 0.5f, 0.5f, 0.5f);
    const struct mat4 across = mat4_rotate(v3(0, 1, 0), 90.0f),
                      at = test_transform(v3(0.01f, 0, 0), v3(1, 1, 1));
    test_rectangle(&t, test_transform(v3(0, 0, 0), v3(1, 1, 1)), grey);
    test_rectangle(&t, mat4_mul(&at, &across), grey);
    test_scene_finish(&t);
    const int even = count_reliable(&t.scene, 0.0f, 0.01f);
    print_message("reliable beside a wall: %d of %d\n", even, SEEDS);
    assert_int_equal(even, SEEDS);
    test_scene_free(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(one_sided_estimates_are_not_read),
                                       cmocka_unit_test(estimates_beside_a_wall_are_read)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
