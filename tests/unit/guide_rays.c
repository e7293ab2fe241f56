// SPDX-License-Identifier: Apache-2.0
// Rays to photon clusters: which cones get some, how many, and with what density.
#include "guide/guide.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/sampling.h"

static const float GUIDE_RAYS_HALF_ANGLE = 0.05f;

// Cones around different axes, that send `E` each and are full of light.
static struct guide_rays cones(int count, float E) {
    struct guide_rays rays = {.count = count};
    for (int i = 0; i < count; i++)
        rays.cone[i] = (struct guide_cone){.axis = v3(sinf((float)i), 0, cosf((float)i)),
                                           .versine = 1.0f - cosf(GUIDE_RAYS_HALF_ANGLE),
                                           .E = E,
                                           .chance = 1e-3f,
                                           .filled = 1.0f};
    return rays;
}

static void faint_cones_get_no_rays(void **state) {
    (void)state;
    struct guide_rays rays = cones(3, 1.0f);
    rays.cone[1].E = 1e-6f;
    const vec3 last = rays.cone[2].axis;
    guide_rays_allocate(&rays, 1.0f, 1000);
    assert_int_equal(rays.count, 2);
    assert_true(v3_dist2(rays.cone[1].axis, last) == 0.0f);
    const double solid_angle = 2.0 * M_PI * (double)rays.cone[0].versine;
    for (int i = 0; i < rays.count; i++) {
        assert_true(rays.rays[i] > 0 && (rays.rays[i] & (rays.rays[i] - 1)) == 0);
        assert_true(fabs((double)rays.density[i] * solid_angle / rays.rays[i] - 1.0) < 1e-5);
    }
    struct guide_rays none = cones(1, 0.0f);
    guide_rays_allocate(&none, 1.0f, 1000);
    assert_int_equal(none.count, 0);
}

static void at_most_half_of_the_stratified_rays_are_added(void **state) {
    (void)state;
    for (size_t stratified = 8; stratified <= 4096; stratified *= 2) {
        struct guide_rays rays = cones(GUIDE_CONES, 1.0f);
        guide_rays_allocate(&rays, 0.0f, stratified);
        size_t all = 0;
        for (int i = 0; i < rays.count; i++) all += (size_t)rays.rays[i];
        assert_true(all <= stratified / 2);
    }
}

static void directions_are_in_their_cone(void **state) {
    (void)state;
    enum { SAMPLES = 1 << 12 };
    const struct guide_rays rays = cones(1, 1.0f);
    double above = 0.0;
    for (uint32_t i = 0; i < SAMPLES; i++) {
        // The direction is a little off the border, where the last digit decides.
        vec2 u = sample_sobol2(i, 1);
        u.x *= 0.999f;
        const vec3 w = guide_cone_sample(&rays.cone[0], u);
        assert_true(guide_cone_holds(&rays.cone[0], w));
        above += (1.0 - (double)v3_dot(w, rays.cone[0].axis)) / SAMPLES;
    }
    // The mean of 1 - cosine over a cone is half of the largest value; floats near 1 have steps of
    // 6e-8.
    assert_true(fabs(above / (0.5 * 0.999 * (double)rays.cone[0].versine) - 1.0) < 1e-2);
    assert_false(guide_cone_holds(&rays.cone[0], v3(1, 0, 0)));
}

static void densities_of_all_cones_add_up(void **state) {
    (void)state;
    struct guide_rays rays = cones(2, 1.0f);
    rays.density[0] = 2.0f;
    rays.density[1] = 5.0f;
    rays.first[1] = 3;
    assert_true(guide_rays_weight(&rays, -1, rays.cone[0].axis, 2.0f) == 0.5f);
    assert_true(guide_rays_weight(&rays, 2, rays.cone[0].axis, 2.0f) == 0.5f);
    assert_true(guide_rays_weight(&rays, 3, rays.cone[0].axis, 1.0f) == 0.125f);
    assert_true(guide_rays_weight(&rays, -1, v3(0, 1, 0), 1.0f) == 1.0f);
}

// Whether stratified rays and those to three cones, one of which is half below the horizon, make up
// the solid angle of the hemisphere and that of a cone when each counts by its weight.
static void weighted_rays_cover_the_hemisphere(void **state) {
    (void)state;
    enum { STRATIFIED = 1 << 14, CONES = 3 };
    const vec3 n = v3(0, 0, 1);
    const struct frame frame = frame_from_normal(n);
    const float density = STRATIFIED / (2.0f * PI_F);
    struct guide_rays rays = cones(CONES, 1.0f);
    rays.cone[1].axis = v3_unit(
        v3(0.5f * GUIDE_RAYS_HALF_ANGLE, GUIDE_RAYS_HALF_ANGLE, 1.0f));  // it overlaps the first
    rays.cone[2].axis = v3(1, 0, 0);
    guide_rays_allocate(&rays, 0.0f, STRATIFIED);
    assert_int_equal(rays.count, CONES);
    // Weights depend on the rays that were drawn from each cone, so all rays are drawn before.
    static vec3 ray[STRATIFIED + STRATIFIED / 2];
    struct guide_draw draw = {.stream = 3, .n = n};
    float own;
    for (int i = 0; guide_rays_draw(&rays, &draw, &ray[i], &own); i++) {
        assert_int_equal(draw.drawn, i + 1);
        assert_true(v3_dot(ray[i], n) > 0.0f && own == rays.density[draw.cone]);
    }
    assert_int_equal(rays.first[0], 0);
    assert_int_equal(rays.first[1], rays.rays[0]);
    assert_true(draw.drawn - rays.first[2] < rays.rays[2]);  // half are below the horizon
    double all = 0.0, cone = 0.0;
    for (int i = -STRATIFIED; i < draw.drawn; i++) {
        const vec2 u = sample_sobol2((uint32_t)(i + STRATIFIED), 7);
        const vec3 w = i < 0 ? frame_to_world(&frame, sample_uniform_hemisphere(u.x, u.y)) : ray[i];
        const double weight = (double)guide_rays_weight(&rays, i, w, density);
        all += weight / (double)density;
        if (guide_cone_holds(&rays.cone[0], w)) cone += weight / (double)density;
    }
    // One of the cone's 256 rays more or less is .4 %, and one of the hemisphere a thousandth of
    // that.
    assert_true(fabs(all / (2.0 * M_PI) - 1.0) < 5e-4);
    assert_true(fabs(cone / (2.0 * M_PI * (double)rays.cone[0].versine) - 1.0) < 5e-3);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(faint_cones_get_no_rays),
        cmocka_unit_test(at_most_half_of_the_stratified_rays_are_added),
        cmocka_unit_test(directions_are_in_their_cone),
        cmocka_unit_test(densities_of_all_cones_add_up),
        cmocka_unit_test(weighted_rays_cover_the_hemisphere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
