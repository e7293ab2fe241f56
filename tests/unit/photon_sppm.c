// SPDX-License-Identifier: Apache-2.0
// Progressive photon mapping in a closed furnace, whose solution is known at every depth, inside
// the walls and at edges; and that the noise of the mean over passes falls.
#include "test_scene.h"

#include <math.h>
#include <stdio.h>

#include "base/sampling.h"
#include "photon/photon.h"
#include "render/render_budget.h"

#define ALBEDO 0.5f

// A distance from the eye beside which all discs are narrow.
#define FAR 100.0f

enum { PASSES = 16, POINTS = 96 };

static satin_options sppm_options(int max_depth) {
    satin_options o = satin_options_default;
    o.integrator = SATIN_SPPM;
    o.photons = 20000;
    o.max_depth = max_depth;
    return o;
}

static struct photon_sppm *sppm_begin(const struct test_scene *t, const satin_options *o,
                                      struct parallel *pool, struct stats *stats) {
    const struct photon_request request = {
        .scene = &t->scene, .options = o, .paths = render_budget_paths(o, 0.0)};
    struct photon_sppm *sppm;
    assert_int_equal(photon_sppm_new(&request, pool, (struct log){0}, stats, &sppm), SATIN_OK);
    return sppm;
}

// A point of a wall of the box, seen along its normal: inside, or at an edge.
static struct shading_point furnace_point(const struct test_scene *t, int i, bool edge) {
    const int wall = i % 6;
    const vec2 u = sample_sobol2((uint32_t)i, 1);
    const float x = edge ? 1.0f - 0.05f * u.x : 1.8f * u.x - 0.9f, y = 1.8f * u.y - 0.9f,
                h = wall & 1 ? 1.0f : -1.0f;
    vec3 p[3] = {v3(h, x, -y), v3(-x, h, y), v3(x, -y, h)};
    vec3 d[3] = {v3(h, 0, 0), v3(0, h, 0), v3(0, 0, h)};
    struct ray ray = {v3_mad(p[wall / 2], -0.5f, d[wall / 2]), 0.0f, d[wall / 2], INFINITY};
    struct interaction s;
    struct shading_point point;
    assert_true(scene_intersect(&t->scene, &ray, &s));
    scene_shading_point_make(&t->scene, &s, ray.d, &point);
    return point;
}

// Means over the points of the walls and over all passes: of green, and of the squares of the
// differences of the points' means from `exact`.
struct sppm_result {
    double mean, error2;
    int indirect;  // points and passes whose indirect light is from photons
};

static struct sppm_result furnace_reflection(int max_depth, bool edge, float length, int passes,
                                             double exact) {
    struct test_scene t;
    test_furnace(&t, ALBEDO);
    const satin_options o = sppm_options(max_depth);
    struct parallel *pool = parallel_new(2);
    struct stats stats = {0};
    struct photon_sppm *sppm = sppm_begin(&t, &o, pool, &stats);
    double sum[POINTS] = {0};
    struct sppm_result result = {0};
    for (int i = 0; i < passes; i++) {
        assert_int_equal(photon_sppm_next(sppm, pool, (struct log){0}, &stats), SATIN_OK);
        for (int k = 0; k < POINTS; k++) {
            const struct shading_point point = furnace_point(&t, k, edge);
            bool indirect;
            sum[k] += (double)photon_sppm_radiance(sppm, &point, 1, length, &indirect).g / passes;
            result.indirect += indirect;
        }
    }
    for (int k = 0; k < POINTS; k++) {
        result.mean += sum[k] / POINTS;
        result.error2 += (sum[k] - exact) * (sum[k] - exact) / POINTS;
    }
    assert_int_equal((int)stats_get(&stats, "photons.emitted"), (passes + 1) * (int)o.photons);
    if (max_depth < 0)
        assert_true(fabs(stats_get(&stats, "photons.power_emitted") / (24.0 * M_PI) - 1.0) < 1e-4);
    photon_sppm_free(sppm);
    parallel_free(pool);
    test_scene_free(&t);
    return result;
}

// Walls emit 1, so the irradiance is pi times the sum of the powers of the albedo; the first is
// direct light. A path of d segments from the eye has d - 2 bounces after the one that is seen.
static double exact_radiance(int max_depth) {
    double sum = 0.0, power = (double)ALBEDO * (double)ALBEDO;
    for (int depth = 3; max_depth < 0 ? power > 1e-9 : depth <= max_depth; depth++) {
        sum += power;
        power *= (double)ALBEDO;
    }
    return sum;
}

// 16 passes of 50 n^(-1/3) photons at 96 points have a standard deviation of .6 %; at edges the
// outline of a disc is approximate.
static void the_furnace_is_reflected(void **state) {
    (void)state;
    const int depths[] = {-1, 3, 5};
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 3; k++) {
            const double exact = exact_radiance(depths[k]);
            const struct sppm_result result =
                furnace_reflection(depths[k], i == 1, FAR, PASSES, exact);
            const double mean = result.mean;
            assert_int_equal(result.indirect, PASSES * POINTS);
            printf("%s, max-depth %d: %.4f of %.4f\n", i == 1 ? "edges" : "inside", depths[k], mean,
                   exact);
            assert_true(fabs(mean / exact - 1.0) < (i == 1 ? 0.045 : 0.02));
        }
    assert_true(furnace_reflection(2, false, FAR, 1, 0.0).mean == 0.0);
}

// Near the eye, discs are too wide for indirect light, and there are no caustics.
static void sparse_photons_are_not_read(void **state) {
    (void)state;
    const struct sppm_result near = furnace_reflection(-1, false, 0.1f, 1, 0.0);
    assert_true(near.mean == 0.0 && near.indirect == 0);
}

// The variance of the mean of n passes falls as n^(-2/3): by 4 from 2 to 16 passes.
static void noise_falls_with_the_passes(void **state) {
    (void)state;
    const double exact = exact_radiance(-1);
    const double few = furnace_reflection(-1, false, FAR, 2, exact).error2;
    assert_true(few > 2.0 * furnace_reflection(-1, false, FAR, PASSES, exact).error2);
}

// A slab across the floor of the furnace, as high as a fifth of the first discs: its edges are
// within the layer of these, and without that of discs a third as wide. It has no face below, which
// would send light out.
#define SLAB_HEIGHT 0.03f

static void furnace_with_slab(struct test_scene *t) {
    test_scene_init(t);
    const uint32_t grey = test_diffuse(t, ALBEDO, ALBEDO, ALBEDO);
    const struct mat4 top = test_transform(v3(0, 0, SLAB_HEIGHT - 1), v3(.5f, 1, 1)),
                      size = mat4_scale(v3(0.5f * SLAB_HEIGHT, 1, 1)),
                      place = mat4_translate(v3(0.5f, 0, 0.5f * SLAB_HEIGHT - 1)),
                      upright = mat4_rotate(v3(0, 1, 0), 90), half = mat4_rotate(v3(0, 0, 1), 180);
    struct mat4 side = mat4_mul(&upright, &size);
    side = mat4_mul(&place, &side);
    test_area_light(t, test_cube(t, mat4_identity(), true, grey), rgb_grey(1));
    test_area_light(t, test_rectangle(t, top, grey), rgb_grey(1));
    test_area_light(t, test_rectangle(t, side, grey), rgb_grey(1));
    test_area_light(t, test_rectangle(t, mat4_mul(&half, &side), grey), rgb_grey(1));
    test_scene_finish(t);
}

// A point within .03 of the edge of the slab: on the floor, on its side, or on its top.
static struct shading_point slab_point(const struct test_scene *t, int i, int where) {
    const vec2 u = sample_sobol2((uint32_t)i, 2);
    const float x = where == 0 ? 0.5f + 0.03f * u.x : 0.5f - 0.03f * u.x, y = 1.6f * u.y - 0.8f;
    struct ray ray = {v3(x, y, 0), 0.0f, v3(0, 0, -1), INFINITY};
    if (where == 1)
        ray = (struct ray){v3(0.9f, y, -1.0f + SLAB_HEIGHT * (0.1f + 0.8f * u.x)), 0.0f,
                           v3(-1, 0, 0), INFINITY};
    struct interaction s;
    struct shading_point point;
    assert_true(scene_intersect(&t->scene, &ray, &s));
    scene_shading_point_make(&t->scene, &s, ray.d, &point);
    return point;
}

// After 1,000 passes discs are a third as wide as in the first one. Those of the points overlap: in
// the mean of 16 passes the side was .13 off. Without the edges that only the smaller discs have,
// the top was .86 of its light and the side .90, which is a strip among discs of the top and floor.
static void light_is_right_at_low_steps(void **state) {
    (void)state;
    enum { LATE_PASSES = 128 };
    struct test_scene t;
    furnace_with_slab(&t);
    const satin_options o = sppm_options(-1);
    struct parallel *pool = parallel_new(2);
    struct stats stats = {0};
    struct photon_sppm *sppm = sppm_begin(&t, &o, pool, &stats);
    photon_sppm_skip(sppm, 1000);
    double mean[3] = {0};
    for (int i = 0; i < LATE_PASSES; i++) {
        assert_int_equal(photon_sppm_next(sppm, pool, (struct log){0}, &stats), SATIN_OK);
        for (int k = 0; k < 3 * POINTS; k++) {
            const struct shading_point point = slab_point(&t, k, k % 3);
            bool indirect;
            mean[k % 3] += (double)photon_sppm_radiance(sppm, &point, 1, FAR, &indirect).g;
        }
    }
    for (int where = 0; where < 3; where++) {
        mean[where] /= LATE_PASSES * POINTS * exact_radiance(-1);
        printf("%s: %.3f\n", where == 0 ? "floor" : where == 1 ? "side" : "top", mean[where]);
    }
    for (int where = 0; where < 3; where++) assert_true(fabs(mean[where] - 1.0) < 0.04);
    photon_sppm_free(sppm);
    parallel_free(pool);
    test_scene_free(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_furnace_is_reflected),
        cmocka_unit_test(light_is_right_at_low_steps),
        cmocka_unit_test(sparse_photons_are_not_read),
        cmocka_unit_test(noise_falls_with_the_passes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
