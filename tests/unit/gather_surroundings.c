// SPDX-License-Identifier: Apache-2.0
// The measurements that a hemisphere makes of its surroundings: distances in a box, the sectors
// that a wall fills, and the Hessian of E against second differences, in a box lit by a point
// light, whose gathered radiance (first pass `none`) has no noise.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "gather/gather.h"
#include "test_scene.h"

struct gather_surroundings_fixture {
    struct test_scene scene;
    satin_options options;
    struct gather g;
    struct gather_layout *layout;
    struct gather_worker *worker;
};

static void gather_surroundings_start(struct gather_surroundings_fixture *f, int rays) {
    test_scene_finish(&f->scene);
    f->options = satin_options_default;
    f->options.first_pass = SATIN_FIRST_NONE;
    f->options.max_depth = -1;
    f->g = gather_make(&f->scene.scene, &f->options, NULL);
    f->layout = gather_layout_new(rays, SATIN_HSH, 0);
    f->worker = gather_workers_new(NULL, gather_layout_rays(f->layout));
    assert_true(f->layout && f->worker);
}

static void gather_surroundings_lamp(struct gather_surroundings_fixture *f, vec3 p) {
    test_light(&f->scene,
               (struct light){.kind = LIGHT_POINT, .position = p, .value = rgb_grey(1.0f)});
}

static void start_box(struct gather_surroundings_fixture *f, int rays) {
    test_scene_init(&f->scene);
    test_cube(&f->scene, mat4_identity(), true, test_diffuse(&f->scene, 0.5f, 0.6f, 0.7f));
    gather_surroundings_lamp(f, v3(0.5f, 0.6f, 0.1f));
    gather_surroundings_start(f, rays);
}

// A box with a lower one in it, lit from above: the floor of the box sees its sides and the rest.
static void start_two_boxes(struct gather_surroundings_fixture *f, int rays) {
    test_scene_init(&f->scene);
    test_cube(&f->scene, mat4_identity(), true, test_diffuse(&f->scene, 0.5f, 0.6f, 0.7f));
    test_cube(&f->scene, test_transform(v3(0.0f, -0.2f, 0.4f), v3(0.3f, 0.3f, 0.2f)), false,
              test_diffuse(&f->scene, 0.5f, 0.6f, 0.7f));
    gather_surroundings_lamp(f, v3(0.0f, 0.1f, 0.95f));
    gather_surroundings_start(f, rays);
}

// A ball lit from its centre, so equally bright everywhere; a black plate hides a part of it.
static void start_ball(struct gather_surroundings_fixture *f, int rays) {
    test_scene_init(&f->scene);
    test_quadric(&f->scene, SHAPE_SPHERE, mat4_scale(v3(2, 2, 2)), true,
                 test_diffuse(&f->scene, 0.5f, 0.6f, 0.7f));
    test_cube(&f->scene, test_transform(v3(0.5f, -0.3f, 0.1f), v3(0.3f, 0.01f, 0.2f)), false,
              test_diffuse(&f->scene, 0, 0, 0));
    gather_surroundings_lamp(f, v3(0, 0, 0));
    gather_surroundings_start(f, rays);
}

static void gather_surroundings_stop(struct gather_surroundings_fixture *f) {
    gather_workers_free(f->worker, 1);
    gather_layout_free(f->layout);
    test_scene_free(&f->scene);
}

static double gather_surroundings_irradiance(struct gather_surroundings_fixture *f, float x,
                                             float z, uint64_t stream,
                                             struct gather_surroundings *around) {
    vec3 n = v3(0, 1, 0);
    struct gather_site site = {
        v3(x, -1.0f, z), n, frame_from_tangent(n, v3(1, 0, 0)), stream, true, NULL, {0, 0, 0}};
    struct cache_irradiance_value value;
    gather_hemisphere_trace(&f->g, f->layout, &site, f->worker->scratch, f->worker->hemisphere);
    gather_hemisphere_irradiance(f->worker->hemisphere, f->g.options->irradiance_gradients, &value);
    if (around)
        gather_surroundings_make(f->worker->hemisphere, SATIN_GRADIENTS_STRATIFIED, true, around);
    return (double)rgb_luminance(value.E);
}

// The axis x is along u, and v = n x u = -z.
static void second_differences(struct gather_surroundings_fixture *f, float x, float z, float h,
                               uint64_t stream, double out[3]) {
    double E[3][3];
    for (int i = -1; i <= 1; i++)
        for (int j = -1; j <= 1; j++)
            E[i + 1][j + 1] =
                gather_surroundings_irradiance(f, x + (float)i * h, z - (float)j * h, stream, NULL);
    double h2 = (double)h * (double)h;
    out[0] = (E[2][1] - 2.0 * E[1][1] + E[0][1]) / h2;
    out[1] = (E[2][2] - E[2][0] - E[0][2] + E[0][0]) / (4.0 * h2);
    out[2] = (E[1][2] - 2.0 * E[1][1] + E[1][0]) / h2;
}

// Returns the root mean square of the error over that of the differences.
static double hessian_error(struct gather_surroundings_fixture *f, float x, float z, float h) {
    double error = 0.0, size = 0.0;
    for (uint64_t i = 0; i < 4; i++) {
        struct gather_surroundings around;
        double difference[3];
        gather_surroundings_irradiance(f, x, z, i, &around);
        second_differences(f, x, z, h, i, difference);
        for (int k = 0; k < 3; k++) {
            double d = (double)around.hessian[k] - difference[k];
            error += d * d;
            size += difference[k] * difference[k];
        }
    }
    return sqrt(error / size);
}

static void the_hessian_matches_second_differences(void **state) {
    (void)state;
    struct gather_surroundings_fixture f;
    start_box(&f, 60000);
    // The sum over strata is good to the first order in their size, 1 / 140; most of this is noise
    // of the differences.
    assert_true(hessian_error(&f, -0.3f, 0.2f, 0.2f) < 0.05);
    gather_surroundings_stop(&f);
}

static void the_hessian_sees_an_edge_that_hides(void **state) {
    (void)state;
    struct gather_surroundings_fixture f;
    start_ball(&f, 60000);
    assert_true(hessian_error(&f, 0.1f, 0.0f, 0.1f) < 0.1);
    gather_surroundings_stop(&f);
}

static void distances_are_those_of_the_box(void **state) {
    (void)state;
    struct gather_surroundings_fixture f;
    struct gather_surroundings around;
    start_box(&f, 2000);
    gather_surroundings_irradiance(&f, 0.9f, 0.0f, 1, &around);
    assert_true(around.least > 0.1f && around.least < 0.11f);
    assert_true(around.least_upright >= around.least && around.least_upright < 0.12f);
    assert_true(around.harmonic > around.least && around.harmonic < 2.0f);
    // The wall at u = .1 stands .1 / cos(phi) away, the one behind at 1.9.
    assert_true(around.sector[0] > 0.099f && around.sector[0] < 0.12f);
    assert_true(around.sector[CACHE_SECTORS / 2] > 1.8f);
    assert_true(around.deviation >= 0.0f && around.deviation < 0.05f);
    gather_surroundings_stop(&f);
}

// Over many hemispheres: the deviation of the luminance of gradients over the one that they report.
static double gradient_noise_error(struct gather_surroundings_fixture *f, satin_gradients kind,
                                   float x, float z) {
    enum { STREAMS = 512 };
    double sum[2] = {0}, squares = 0.0, reported = 0.0;
    for (uint64_t i = 0; i < STREAMS; i++) {
        struct gather_surroundings around;
        struct cache_irradiance_value value;
        const double E = gather_surroundings_irradiance(f, x, z, i, &around);
        gather_hemisphere_irradiance(f->worker->hemisphere, kind, &value);
        gather_surroundings_make(f->worker->hemisphere, kind, false, &around);
        double along[2] = {0};
        for (int c = 0; c < 3; c++) {
            const float weight = (float[]){0.2126f, 0.7152f, 0.0722f}[c];
            along[0] += (double)(weight * value.grad_t[c].x);
            along[1] += (double)(weight * value.grad_t[c].z);
        }
        for (int k = 0; k < 2; k++) {
            sum[k] += along[k];
            squares += along[k] * along[k];
        }
        reported += pow(E * (double)around.gradient_deviation, 2.0);
    }
    const double mean2 = (sum[0] * sum[0] + sum[1] * sum[1]) / STREAMS;
    return sqrt(0.5 * (squares - mean2) / reported);
}

// The deviation is .36 to .92 of what 250 rays report, and .42 to .82 of what 1000 do, as a change
// of light from stratum to stratum counts as noise. Gradients by solid angle ignore what strata do
// for noise.
static void the_noise_of_gradients_is_known(void **state) {
    (void)state;
    struct gather_surroundings_fixture f;
    for (int rays = 250; rays <= 1000; rays *= 4) {
        start_two_boxes(&f, rays);
        for (int k = 0; k < 6; k++) {
            const double error =
                gradient_noise_error(&f, SATIN_GRADIENTS_STRATIFIED, 0.1f, -0.4f + 0.2f * (float)k);
            assert_true(error > 0.3 && error < 1.1);
        }
        const double solid = gradient_noise_error(&f, SATIN_GRADIENTS_SOLID_ANGLE, 0.1f, 0.2f);
        assert_true(solid > 0.3 && solid < 1.1);
        gather_surroundings_stop(&f);
        start_ball(&f, rays);
        const double hidden = gradient_noise_error(&f, SATIN_GRADIENTS_STRATIFIED, 0.1f, 0.1f);
        print_message("two boxes, by solid angle: %.3f; ball: %.3f\n", solid, hidden);
        assert_true(hidden > 0.5 && hidden < 1.1);
        gather_surroundings_stop(&f);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_hessian_matches_second_differences),
        cmocka_unit_test(the_hessian_sees_an_edge_that_hides),
        cmocka_unit_test(distances_are_those_of_the_box),
        cmocka_unit_test(the_noise_of_gradients_is_known),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
