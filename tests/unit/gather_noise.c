// SPDX-License-Identifier: Apache-2.0
// The noise that the first passes report of their lookups: that of paths is the standard deviation
// of many paths, that of photons the spread of lookups in a closed furnace, and light that is known
// exactly has none.
#include <math.h>
#include <stdlib.h>

#include "gather/gather.h"
#include "photon_case.h"
#include "test_scene.h"

enum { RAYS = 8192 };

// The unit sphere, diffuse, around a point light that brings an irradiance of pi.
static void noise_sphere(struct test_scene *t, float albedo) {
    test_scene_init(t);
    test_quadric(t, SHAPE_SPHERE, mat4_identity(), true, test_diffuse(t, albedo, albedo, albedo));
    test_light(t, (struct light){.kind = LIGHT_POINT, .value = rgb_grey(PI_F)});
    test_scene_finish(t);
}

static struct gather_noise measure(const struct gather *g, int threads) {
    static struct ray ray[RAYS];
    struct parallel *pool = parallel_new(threads);
    struct gather_noise noise;
    for (uint32_t i = 0; i < RAYS; i++) {
        const vec2 u = sample_sobol2(i, 5);
        ray[i] = (struct ray){v3(0.1f, 0, 0), 0.0f, sample_uniform_sphere(u.x, u.y), INFINITY};
    }
    assert_int_equal(gather_noise_measure(g, ray, RAYS, pool, &noise), SATIN_OK);
    parallel_free(pool);
    return noise;
}

// The standard deviation of paths over their mean. In a sphere all rays have the same light, so
// those of a single ray have that of all.
static double path_deviation(const struct gather *g) {
    enum { PATHS = 40000 };
    double sum = 0.0, squares = 0.0;
    for (uint32_t i = 0; i < PATHS; i++) {
        struct sampler sampler = {0, (uint32_t)rng_mix(i + 1), 0};
        struct gather_first first;
        const struct ray ray = {v3(0.1f, 0, 0), 0.0f, v3(1, 0, 0), INFINITY};
        const double L = (double)rgb_luminance(gather_path(g, ray, &sampler, &first));
        sum += L / PATHS;
        squares += L * L / PATHS;
    }
    return sqrt(squares - sum * sum) / sum;
}

// The number of bounces that a path gathers is geometric, with at most a few tens of them, so the
// deviation by 8192 pairs is known to about 2 %. Tests at 8 %.
static void paths_have_their_deviation(void **state) {
    (void)state;
    struct test_scene t;
    noise_sphere(&t, 0.6f);
    satin_options o = satin_options_default;
    o.first_pass = SATIN_FIRST_PATH;
    o.max_depth = -1;
    o.rr_depth = 2;
    const struct gather g = gather_make(&t.scene, &o, NULL);
    const struct gather_noise one = measure(&g, 1), three = measure(&g, 3);
    const double deviation = path_deviation(&g);
    print_message("%.4f of %.4f\n", one.error, deviation);
    assert_true(fabs(one.error / deviation - 1.0) < 0.08);
    assert_true(one.error == one.sampled && one.stored == 0.0);
    assert_int_equal(one.lookups, RAYS);
    assert_true(one.cpu_s > 0.0);
    // Equal bits by any number of threads.
    assert_true(three.error == one.error && three.sampled == one.sampled);
    test_scene_free(&t);
}

// Direct light of a point is found without noise; light of further bounces is left out.
static void direct_light_alone_has_no_noise(void **state) {
    (void)state;
    struct test_scene t;
    noise_sphere(&t, 0.6f);
    satin_options o = satin_options_default;
    o.first_pass = SATIN_FIRST_NONE;
    o.max_depth = -1;
    const struct gather g = gather_make(&t.scene, &o, NULL);
    const struct gather_noise noise = measure(&g, 2);
    assert_int_equal(noise.lookups, RAYS);
    assert_true(noise.error < 1e-6 && noise.stored == 0.0);
    // Without light there is nothing to divide by.
    t.light[0].value = rgb_grey(0.0f);
    assert_int_equal(measure(&g, 2).lookups, 0);
    test_scene_free(&t);
}

// A closed furnace, where every lookup should be 1: what they differ by is the noise of photons.
static void photons_have_their_spread(void **state) {
    (void)state;
    static const int k[] = {25, 100};
    static struct gather_ray rays[RAYS];
    double stored[2];
    for (int i = 0; i < 2; i++) {
        struct test_scene t;
        test_furnace(&t, 0.5f);
        satin_options o = satin_options_default;
        o.first_pass = SATIN_FIRST_PRECOMPUTED;
        o.photons = 40000;
        o.caustic_photons = 0;
        o.photon_k = k[i];
        o.max_depth = -1;
        o.gather_direct = o.gather_near = false;
        struct parallel *pool = parallel_new(2);
        struct stats stats = {0};
        struct photon_maps *maps = NULL;
        assert_int_equal(photon_case_build(&t.scene, &o, pool, &stats, &maps), SATIN_OK);
        const struct gather g = gather_make(&t.scene, &o, maps);
        const struct gather_noise noise = measure(&g, 2);
        assert_true(noise.read == 1.0);
        for (uint32_t j = 0; j < RAYS; j++) {
            const vec2 u = sample_sobol2(j, 5);
            const struct ray ray = {v3(0.1f, 0, 0), 0.0f, sample_uniform_sphere(u.x, u.y),
                                    INFINITY};
            rays[j] = (struct gather_ray){.ray = ray, .item = j};
        }
        struct gather_scratch *scratch = gather_scratch_new(NULL, 0);
        gather_rays(&g, scratch, rays, RAYS, 3);
        double squares = 0.0;
        for (int j = 0; j < RAYS; j++)
            squares += pow((double)rgb_luminance(rays[j].L) - 1.0, 2.0) / RAYS;
        print_message("k %d: %.4f, spread %.4f\n", k[i], noise.stored, sqrt(squares));
        assert_true(fabs(noise.stored / sqrt(squares) - 1.0) < 0.15);
        assert_true(noise.sampled == 0.0 && noise.error == noise.stored);
        stored[i] = noise.stored;
        gather_scratch_free(scratch);
        photon_maps_free(maps);
        parallel_free(pool);
        test_scene_free(&t);
    }
    // As the root of the photons that count, 24 and 99.
    assert_true(fabs(stored[0] / stored[1] / sqrt(99.0 / 24.0) - 1.0) < 0.1);
}

// Rays that look nothing up are paths, whose mean is the same.
static void without_lookups_rays_are_paths(void **state) {
    (void)state;
    static struct gather_ray rays[RAYS];
    struct test_scene t;
    test_furnace(&t, 0.5f);
    satin_options o = satin_options_default;
    o.first_pass = SATIN_FIRST_PRECOMPUTED;
    o.photons = 4000;
    o.max_depth = -1;
    o.rr_depth = 5;
    struct parallel *pool = parallel_new(2);
    struct stats stats = {0};
    struct photon_maps *maps = NULL;
    assert_int_equal(photon_case_build(&t.scene, &o, pool, &stats, &maps), SATIN_OK);
    struct gather g = gather_make(&t.scene, &o, maps);
    assert_true(gather_looks_up(&g));
    gather_end_lookups(&g);
    assert_false(gather_looks_up(&g));
    const struct gather_noise noise = measure(&g, 2);
    assert_true(noise.read == 0.0 && noise.stored == 0.0 && noise.sampled > 0.1);
    for (uint32_t i = 0; i < RAYS; i++) {
        const vec2 u = sample_sobol2(i, 5);
        const struct ray ray = {v3(0.1f, 0, 0), 0.0f, sample_uniform_sphere(u.x, u.y), INFINITY};
        rays[i] = (struct gather_ray){.ray = ray, .item = i};
    }
    struct gather_scratch *scratch = gather_scratch_new(NULL, 0);
    gather_rays(&g, scratch, rays, RAYS, 3);
    double mean = 0.0;
    for (int i = 0; i < RAYS; i++) mean += (double)rgb_luminance(rays[i].L) / RAYS;
    // A wall reflects a radiance of 1 of its 2; the deviation of the mean is .5 %.
    print_message("mean %.4f, noise %.3f\n", mean, noise.sampled);
    assert_true(fabs(mean - 1.0) < 4.0 * noise.sampled / sqrt(RAYS));
    gather_scratch_free(scratch);
    photon_maps_free(maps);
    parallel_free(pool);
    test_scene_free(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(paths_have_their_deviation),
        cmocka_unit_test(direct_light_alone_has_no_noise),
        cmocka_unit_test(photons_have_their_spread),
        cmocka_unit_test(without_lookups_rays_are_paths),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
