// SPDX-License-Identifier: Apache-2.0
// Smoothed estimates: noise is removed where light is uniform or grows linearly; borders of light,
// and walls between bright and dark, stay.
#include <math.h>
#include <stdlib.h>

#include "photon/photon_map.h"
#include "photon_case.h"
#include "test_scene.h"

enum { PHOTONS = 60000, K = 60 };

// Irradiance on the floor z = 0 within [-1, 1]^2, of mean 1 at most.
typedef float (*light_fn)(float x, float y);
static float even(float x, float y) {
    (void)x, (void)y;
    return 0.5f;
}
static float slope(float x, float y) {
    (void)y;
    return 0.5f + 0.4f * x;
}
static float step(float x, float y) {
    (void)y;
    return x < 0.0f ? 0.9f : 0.1f;
}

// Errors relative to the true values, over the entries for which `at` is true.
struct photon_caustic_smooth_errors {
    double mean, rms, most;
    int count;
};
typedef bool (*at_fn)(float x, float y);
static bool inside(float x, float y) { return fabsf(x) < 0.8f && fabsf(y) < 0.8f; }
static bool off_border(float x, float y) { return inside(x, y) && fabsf(x) > 0.15f; }
static bool at_border(float x, float y) { return inside(x, y) && fabsf(x) < 0.02f; }

static void photon_caustic_smooth_scene_of(struct test_scene *t, bool wall) {
    test_scene_init(t);
    const uint32_t grey = test_diffuse(t, 0.5f, 0.5f, 0.5f);
    test_rectangle(t, test_transform(v3(0, 0, 0), v3(1, 1, 1)), grey);
    if (wall) test_cube(t, test_transform(v3(0, 0, .5f), v3(.002f, 1, .5f)), false, grey);
    test_scene_finish(t);
}

static void precompute(struct test_scene *t, const struct photon_hit *hit, size_t count,
                       bool smooth, struct photon_map *map, struct photon_irradiance *out) {
    const struct log quiet = {0};
    struct parallel *pool = parallel_new(2);
    assert_non_null(pool);
    assert_int_equal(photon_map_build(&t->scene, hit, count, pool, quiet, map), SATIN_OK);
    const struct photon_precompute what = {map,  &t->scene, 1,    K,    KERNEL_PARABOLA,
                                           true, smooth,    true, false};
    assert_int_equal(photon_irradiance_build(&what, pool, quiet, out), SATIN_OK);
    parallel_free(pool);
}

static void photon_caustic_smooth_build(struct test_scene *t, light_fn light, bool smooth,
                                        struct photon_map *map, struct photon_irradiance *out) {
    struct photon_hit *hit = calloc(PHOTONS, sizeof *hit);
    struct rng rng = rng_make(1, RNG_TEST, 0);
    size_t count = 0;
    for (int i = 0; i < PHOTONS; i++) {
        const float x = 2.0f * rng_float(&rng) - 1.0f, y = 2.0f * rng_float(&rng) - 1.0f;
        if (rng_float(&rng) >= light(x, y)) continue;
        const uint32_t up = photon_pack(v3(0, 0, 1));
        hit[count++] = (struct photon_hit){
            v3(x, y, 0), rgb_grey(4.0f / PHOTONS), up, up, 0, false, false, 0, 0, 0};
    }
    precompute(t, hit, count, smooth, map, out);
    free(hit);
}

static struct photon_caustic_smooth_errors photon_caustic_smooth_errors_of(
    const struct photon_irradiance *r, light_fn light, at_fn at) {
    struct photon_caustic_smooth_errors e = {0};
    for (size_t i = 0; i < r->count; i++) {
        const vec3 p = photon_entry_position(&r->position, i);
        if (!at(p.x, p.y)) continue;
        const double d = (double)r->E[i].g / (double)light(p.x, p.y) - 1.0;
        e.mean += d;
        e.rms += d * d;
        e.most = fmax(e.most, fabs(d));
        e.count++;
    }
    assert_true(e.count > 100);
    e.mean /= e.count;
    e.rms = sqrt(e.rms / e.count);
    return e;
}

static struct photon_caustic_smooth_errors photon_caustic_smooth_run(light_fn light, bool wall,
                                                                     bool smooth, at_fn at) {
    struct test_scene t;
    struct photon_map map;
    struct photon_irradiance r;
    photon_caustic_smooth_scene_of(&t, wall);
    photon_caustic_smooth_build(&t, light, smooth, &map, &r);
    const struct photon_caustic_smooth_errors e = photon_caustic_smooth_errors_of(&r, light, at);
    photon_irradiance_free(&r);
    photon_map_free(&map);
    test_scene_free(&t);
    return e;
}

static void noise_is_removed(void **state) {
    (void)state;
    const light_fn light[] = {even, slope};
    for (int i = 0; i < 2; i++) {
        const struct photon_caustic_smooth_errors before =
            photon_caustic_smooth_run(light[i], false, false, inside);
        const struct photon_caustic_smooth_errors after =
            photon_caustic_smooth_run(light[i], false, true, inside);
        print_message("rms %.4f, %.4f, mean %+.4f, most %.3f, %.3f\n", before.rms, after.rms,
                      after.mean, before.most, after.most);
        assert_true(before.rms > 0.12 && after.rms < 0.27 * before.rms);
        assert_true(fabs(after.mean) < 0.01);
    }
}

static void borders_of_caustics_stay(void **state) {
    (void)state;
    for (int wall = 0; wall < 2; wall++) {
        const struct photon_caustic_smooth_errors before =
            photon_caustic_smooth_run(step, wall, false, at_border);
        const struct photon_caustic_smooth_errors after =
            photon_caustic_smooth_run(step, wall, true, at_border);
        const struct photon_caustic_smooth_errors aside =
            photon_caustic_smooth_run(step, wall, true, off_border);
        print_message("border %.3f, %.3f; aside %.4f, mean %+.4f\n", before.rms, after.rms,
                      aside.rms, aside.mean);
        assert_true(after.rms < 1.1 * before.rms);
        assert_true(aside.rms < 0.08 && fabs(aside.mean) < 0.02);
    }
}

// Estimates at photons that mostly lie in a few points have no radius; those of fewer photons than
// an estimate takes have no finite one. Lookups distinguish the sides of the surface nevertheless.
static void normals_count_without_a_radius(void **state) {
    (void)state;
    enum { POINTS = 20, SPREAD = PHOTONS / 4 };
    const uint32_t up = photon_pack(v3(0, 0, 1));
    for (int few = 0; few < 2; few++) {
        struct test_scene t;
        struct photon_map map;
        struct photon_irradiance r;
        struct photon_hit *hit = calloc(PHOTONS, sizeof *hit);
        struct rng rng = rng_make(3, RNG_TEST, 0);
        for (int i = 0; i < PHOTONS; i++) {
            const float x = 2.0f * rng_float(&rng) - 1.0f, y = 2.0f * rng_float(&rng) - 1.0f;
            const vec3 p = i < SPREAD ? v3(x, y, 0) : v3(0.04f * (float)(i % POINTS), 0.9f, 0);
            hit[i] =
                (struct photon_hit){p, rgb_grey(4.0f / SPREAD), up, up, 0, false, false, 0, 0, 0};
        }
        photon_caustic_smooth_scene_of(&t, false);
        precompute(&t, hit, few ? K / 2 : PHOTONS, !few, &map, &r);
        assert_true(r.position.scale > 0.0f && isfinite(r.position.scale));
        for (size_t i = 0; i < r.count; i++) assert_true(rgb_finite(r.E[i]));
        // With few photons they do not extend far.
        const vec3 p = few ? photon_entry_position(&r.position, 0) : v3(-0.5f, -0.5f, 0);
        const int entry = photon_irradiance_entry(&r, p, v3(0, 0, 1));
        assert_true(entry >= 0);
        assert_int_equal(photon_irradiance_entry(&r, p, v3(0, 0, -1)), -1);
        if (!few) assert_true(fabsf(photon_irradiance_value(&r, entry, p).g - 1.0f) < 0.5f);
        photon_irradiance_free(&r);
        photon_map_free(&map);
        free(hit);
        test_scene_free(&t);
    }
}

// Deviation of the uniform light that a surface reflects which is not only diffuse, over its mean.
static double glossy_noise(const struct photon_maps *maps, const struct satin_scene *scene,
                           const struct brdf *brdf, double *mean) {
    enum { POINTS = 2000 };
    struct rng rng = rng_make(2, RNG_TEST, 0);
    const vec3 up = v3(0, 0, 1), wo = v3_unit(v3(.3f, .2f, 1));
    const struct frame frame = frame_from_normal(up);
    double sum = 0.0, square = 0.0;
    for (int i = 0; i < POINTS; i++) {
        const float x = 1.6f * rng_float(&rng) - .8f, y = 1.6f * rng_float(&rng) - .8f;
        const struct shading_point at = photon_case_point(v3(x, y, 0), &frame, brdf, wo);
        const struct photon_caustic_limits limits = {BRDF_DIFFUSE | BRDF_GLOSSY, INFINITY, -1};
        const rgb L = photon_caustic(maps, scene, &at, &limits, PHOTON_ALONE);
        sum += (double)L.g;
        square += (double)L.g * (double)L.g;
    }
    *mean = sum / POINTS;
    return sqrt(square / POINTS - *mean * *mean) / *mean;
}

static void glossy_surfaces_are_as_smooth(void **state) {
    (void)state;
    struct test_scene t;
    photon_caustic_smooth_scene_of(&t, false);
    struct photon_maps maps = {.caustic_k = K, .area = true, .smooth = true};
    photon_caustic_smooth_build(&t, even, true, &maps.caustic, &maps.caustic_irradiance);
    const uint32_t phong = test_material(&t, "phong", rgb_grey(.5f), rgb_grey(.3f));
    const struct brdf *brdf = &t.material[phong].front.base;
    double mean[2], noise[2];
    for (int smooth = 0; smooth < 2; smooth++) {
        maps.smooth = smooth;
        noise[smooth] = glossy_noise(&maps, &t.scene, brdf, &mean[smooth]);
    }
    print_message("%.4f, %.4f of %.4f, %.4f\n", noise[0], noise[1], mean[0], mean[1]);
    assert_true(noise[1] < 0.4 * noise[0] && fabs(mean[1] / mean[0] - 1.0) < 0.01);
    photon_irradiance_free(&maps.caustic_irradiance);
    photon_map_free(&maps.caustic);
    test_scene_free(&t);
}

// Light whose square overflows: values stay finite and do not change.
static void extreme_values_stay(void **state) {
    (void)state;
    struct test_scene t;
    struct photon_map map;
    struct photon_irradiance r;
    photon_caustic_smooth_scene_of(&t, false);
    photon_caustic_smooth_build(&t, even, false, &map, &r);
    for (size_t i = 0; i < map.count; i++) map.photon[i].power = rgb_grey(1e30f);
    for (size_t i = 0; i < r.count; i++) r.E[i] = rgb_grey(1e34f);
    struct parallel *pool = parallel_new(1);
    const struct photon_precompute what = {&map, &t.scene, 1,    K,    KERNEL_PARABOLA,
                                           true, true,     true, false};
    assert_int_equal(photon_caustic_smooth(&what, pool, &r), SATIN_OK);
    for (size_t i = 0; i < r.count; i++) assert_true(r.E[i].r == 1e34f);
    parallel_free(pool);
    photon_irradiance_free(&r);
    photon_map_free(&map);
    test_scene_free(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(noise_is_removed),
        cmocka_unit_test(borders_of_caustics_stay),
        cmocka_unit_test(normals_count_without_a_radius),
        cmocka_unit_test(glossy_surfaces_are_as_smooth),
        cmocka_unit_test(extreme_values_stay),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
