// SPDX-License-Identifier: Apache-2.0
// The noise of density estimates as the photons report it: with photons that are on one path, and
// in a closed furnace, whose irradiance is constant, for any number of photons of an estimate.
#include "photon_case.h"
#include "test_scene.h"

#include <math.h>

#include "photon/photon_map.h"

// ---- A disc by hand -----------------------------------------------------------------------------

enum { PHOTONS = 48, TOGETHER = 4, TRIALS = 4000 };

// The mean of the noise of discs of 48 equal photons, of which each `together` are of one path.
static double mean_noise(int together) {
    static float position[3 * PHOTONS], distance2[PHOTONS];
    static int row[PHOTONS];
    struct photon photon[PHOTONS];
    const uint32_t up = photon_pack(v3(0, 0, 1));
    const struct photon_map map = {.photon = photon, .position = position, .count = PHOTONS};
    const struct photon_disc disc = {.map = &map,
                                     .n = v3(0, 0, 1),
                                     .count = PHOTONS,
                                     .row = row,
                                     .distance2 = distance2,
                                     .r = 1.0f,
                                     .r2 = 1.0f,
                                     .scale = 1.0f};
    struct rng rng = rng_make(7, RNG_TEST, (uint64_t)together);
    double sum = 0.0;
    for (int trial = 0; trial < TRIALS; trial++) {
        unsigned path = 0;
        for (int i = 0; i < PHOTONS; i++) {
            if (i % together == 0) path = rng_u32(&rng) % 64;
            row[i] = i;
            photon[i] = (struct photon){
                .power = rgb_grey(2.0f), .n = up, .wi = up, .tilt = photon_pack_tilt(1.0f)};
            photon[i].path = path & 63;
        }
        sum += photon_disc_noise2(&disc) / TRIALS;
    }
    return sum;
}

// The variance of a sum of n equal and independent terms is 1 / n of its square: n are the paths.
// The standard deviation of one trial is about 2^.5 / 64, whatever n, so that of the mean is
// .00035: five of them.
static void photons_of_a_path_count_together(void **state) {
    (void)state;
    assert_true(fabs(mean_noise(1) - 1.0 / PHOTONS) < 5.0 * 0.00035);
    assert_true(fabs(mean_noise(TOGETHER) - (double)TOGETHER / PHOTONS) < 5.0 * 0.00035);
}

// A photon alone has a variance as large as its square, and there is none without photons.
static void single_photons_are_all_noise(void **state) {
    (void)state;
    float position[3] = {0}, distance2 = 0.0f;
    int row = 0;
    const uint32_t up = photon_pack(v3(0, 0, 1));
    struct photon photon = {
        .power = rgb_grey(2.0f), .n = up, .wi = up, .tilt = photon_pack_tilt(1.0f)};
    const struct photon_map map = {.photon = &photon, .position = position, .count = 1};
    struct photon_disc disc = {.map = &map,
                               .n = v3(0, 0, 1),
                               .count = 1,
                               .row = &row,
                               .distance2 = &distance2,
                               .r = 1.0f,
                               .r2 = 1.0f,
                               .scale = 1.0f};
    assert_true(fabs(photon_disc_noise2(&disc) - 1.0) < 1e-6);
    disc.count = 0;
    assert_true(photon_disc_noise2(&disc) < 0.0);
}

// ---- A furnace ----------------------------------------------------------------------------------

// The noise that the photons of a box report, which emits 1 and reflects half, and the spread of
// the irradiance of its entries far from edges, where it is constant.
struct furnace_noise {
    double reported, spread;
};

static struct furnace_noise photon_noise_furnace(satin_options o, int threads) {
    struct test_scene t;
    test_furnace(&t, 0.5f);
    struct parallel *pool = parallel_new(threads);
    struct stats stats = {0};
    struct photon_maps *maps = NULL;
    o.caustic_photons = 0;
    o.gather_direct = false;
    o.max_depth = -1;
    assert_int_equal(photon_case_build(&t.scene, &o, pool, &stats, &maps), SATIN_OK);
    const struct photon_irradiance *r = &maps->irradiance;
    double sum = 0.0, squares = 0.0, count = 0.0;
    for (size_t i = 0; i < r->count; i++) {
        const vec3 p = photon_entry_position(&r->position, i);
        const float most = 1.0f - r->radius[i];
        if ((fabsf(p.x) > most) + (fabsf(p.y) > most) + (fabsf(p.z) > most) != 1) continue;
        sum += (double)r->E[i].g;
        squares += (double)(r->E[i].g * r->E[i].g);
        count += 1.0;
    }
    assert_true(count > 2000.0);
    const struct furnace_noise found = {sqrt((double)photon_noise2(maps)),
                                        sqrt(squares * count / (sum * sum) - 1.0)};
    photon_maps_free(maps);
    parallel_free(pool);
    test_scene_free(&t);
    return found;
}

// The noise falls as the root of the k - 1 photons that count, and is the spread of the entries.
// The mean over 1024 discs is known to 3 %, because hashes coincide, and photons of one path add 1
// to 2 %. The spread of the 800 separate discs of 100 photons is known to 3 % too; it is
// (k - 3)^-1/2, because a disc is as wide as its photons make it. Tests at 10 %.
static void it_falls_with_the_photons_of_an_estimate(void **state) {
    (void)state;
    static const int k[] = {26, 50, 101};
    for (int i = 0; i < 3; i++) {
        satin_options o = satin_options_default;
        o.photons = 40000;
        o.photon_k = k[i];
        const struct furnace_noise n = photon_noise_furnace(o, 2);
        print_message("k %d: %.4f, spread %.4f, (k - 1)^-1/2 %.4f\n", k[i], n.reported, n.spread,
                      1.0 / sqrt(k[i] - 1.0));
        assert_true(fabs(n.reported * sqrt(k[i] - 1.0) - 1.0) < 0.1);
        assert_true(fabs(n.spread / n.reported - 1.0) < 0.1);
    }
}

// Batches of first pass `reverse` lower it as the root of their number.
static void it_falls_with_the_batches(void **state) {
    (void)state;
    satin_options o = satin_options_default;
    o.first_pass = SATIN_FIRST_REVERSE;
    o.photons = o.photon_batch = 20000;
    const double one = photon_noise_furnace(o, 2).reported;
    o.photons = 8 * o.photon_batch;
    const double eight = photon_noise_furnace(o, 2).reported;
    assert_true(fabs(eight * sqrt(8.0) / one - 1.0) < 1e-5);
    // For any number of threads.
    assert_true(photon_noise_furnace(o, 1).reported == eight);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(photons_of_a_path_count_together),
        cmocka_unit_test(single_photons_are_all_noise),
        cmocka_unit_test(it_falls_with_the_photons_of_an_estimate),
        cmocka_unit_test(it_falls_with_the_batches),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
