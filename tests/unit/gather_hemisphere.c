// SPDX-License-Identifier: Apache-2.0
// Hemispheres of gather rays: known irradiance and radiance in a furnace, where gradients are zero
// within noise; gradients against central differences of the same sample set in a box lit by a
// point light, whose gathered radiance (first pass `none`) has no noise.
#include "gather/gather.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "rsh/rsh.h"
#include "test_scene.h"

enum { ORDER = 6, N2 = ORDER * ORDER, STREAMS = 24 };

struct gather_hemisphere_fixture {
    struct test_scene scene;
    satin_options options;
    struct gather g;
};

static void gather_hemisphere_start(struct gather_hemisphere_fixture *f) {
    f->options = satin_options_default;
    f->options.first_pass = SATIN_FIRST_NONE;
    f->options.max_depth = -1;
    f->g = gather_make(&f->scene.scene, &f->options, NULL);
}

static struct gather_site gather_hemisphere_floor_site(float x, float z, uint64_t stream) {
    vec3 n = v3(0, 1, 0);
    return (struct gather_site){v3(x, -1.0f, z), n, frame_from_normal(n), stream, true, NULL,
                                {0, 0, 0}};
}

// A closed box whose walls reflect half and emit half: gathered radiance is 1 / 4 everywhere.
static void furnace_box(struct gather_hemisphere_fixture *f) {
    test_scene_init(&f->scene);
    uint32_t wall = test_diffuse(&f->scene, 0.5f, 0.5f, 0.5f);
    uint32_t box = test_cube(&f->scene, mat4_identity(), true, wall);
    test_area_light(&f->scene, box, rgb_grey(0.5f));
    test_scene_finish(&f->scene);
    gather_hemisphere_start(f);
}

static void a_furnace_has_no_gradients(void **state) {
    (void)state;
    struct gather_hemisphere_fixture f;
    furnace_box(&f);
    struct gather_layout *layout = gather_layout_new(1000, SATIN_HSH, 0);
    struct gather_worker *worker = gather_workers_new(NULL, gather_layout_rays(layout));
    double E = 0.0, sum[4] = {0}, square[4] = {0};
    for (uint64_t i = 0; i < STREAMS; i++) {
        struct gather_site site = gather_hemisphere_floor_site(0.3f, 0.2f, i);
        struct cache_irradiance_value value;
        gather_hemisphere_trace(&f.g, layout, &site, worker->scratch, worker->hemisphere);
        gather_hemisphere_irradiance(worker->hemisphere, f.g.options->irradiance_gradients, &value);
        E += (double)value.E.g / STREAMS;
        const float c[4] = {value.grad_t[1].x, value.grad_t[1].z, value.grad_r[1].x,
                            value.grad_r[1].z};
        for (int k = 0; k < 4; k++) {
            sum[k] += (double)c[k];
            square[k] += (double)c[k] * (double)c[k];
        }
    }
    assert_true(fabs(E / (0.25 * 3.14159265358979) - 1.0) < 0.005);
    for (int k = 0; k < 4; k++) {
        double mean = sum[k] / STREAMS, variance = square[k] / STREAMS - mean * mean;
        // The bound is five standard errors, a chance of 1e-6 for each of four numbers. The seeds
        // are fixed.
        assert_true(fabs(mean) < 5.0 * sqrt(variance / (STREAMS - 1)));
    }
    gather_workers_free(worker, 1);
    gather_layout_free(layout);
    test_scene_free(&f.scene);
}

static void point_lit_box(struct gather_hemisphere_fixture *f) {
    test_scene_init(&f->scene);
    test_cube(&f->scene, mat4_identity(), true, test_diffuse(&f->scene, 0.5f, 0.6f, 0.7f));
    test_light(&f->scene,
               (struct light){
                   .kind = LIGHT_POINT, .position = v3(0.5f, 0.4f, 0.1f), .value = rgb_grey(1.0f)});
    test_scene_finish(&f->scene);
    gather_hemisphere_start(f);
}

static struct cache_irradiance_value irradiance_at(struct gather_hemisphere_fixture *f,
                                                   struct gather_layout *layout,
                                                   const struct gather_worker *worker,
                                                   struct gather_site site) {
    struct cache_irradiance_value value;
    gather_hemisphere_trace(&f->g, layout, &site, worker->scratch, worker->hemisphere);
    gather_hemisphere_irradiance(worker->hemisphere, f->g.options->irradiance_gradients, &value);
    return value;
}

static void radiance_at(const struct gather_hemisphere_fixture *f,
                        const struct gather_layout *layout, const struct gather_worker *worker,
                        const struct gather_site *site, struct gather_radiance *out) {
    gather_hemisphere_trace(&f->g, layout, site, worker->scratch, worker->hemisphere);
    gather_hemisphere_radiance(worker->hemisphere, f->g.options->radiance_gradients, out);
}

// Mean and deviation over streams of the irradiance by 400 rays below polished walls.
static double polished_irradiance(struct gather_hemisphere_fixture *f, double *deviation) {
    enum { MANY = 256 };
    struct gather_layout *layout = gather_layout_new(400, SATIN_HSH, 0);
    struct gather_worker *worker = gather_workers_new(NULL, gather_layout_rays(layout));
    double sum = 0.0, square = 0.0;
    for (uint64_t i = 0; i < MANY; i++) {
        const double E =
            (double)irradiance_at(f, layout, worker, gather_hemisphere_floor_site(0.3f, 0.2f, i))
                .E.g;
        sum += E;
        square += E * E;
    }
    gather_workers_free(worker, 1);
    gather_layout_free(layout);
    *deviation = sqrt(square / MANY - sum * sum / MANY / MANY);
    return sum / MANY;
}

// The image of a point light in polished walls is narrower than the rays' strata: one record in
// many meets it and is far too bright, unless rays treat lobes as at least as wide as the solid
// angle of their stratum.
static void polished_walls_are_visible_through_beams(void **state) {
    (void)state;
    struct gather_hemisphere_fixture f;
    test_scene_init(&f.scene);
    const uint32_t polished = test_material(&f.scene, "phong", rgb_grey(0.0f), rgb_grey(0.5f));
    struct material *m = &f.scene.scene.material[polished];
    m->front.base.exponent = m->back.base.exponent = 20000.0f;
    test_cube(&f.scene, mat4_identity(), true, polished);
    test_light(&f.scene,
               (struct light){
                   .kind = LIGHT_POINT, .position = v3(0.5f, 0.4f, 0.1f), .value = rgb_grey(1.0f)});
    test_scene_finish(&f.scene);
    gather_hemisphere_start(&f);
    double beams, rays;
    f.options.texture_filter = false;
    const double by_rays = polished_irradiance(&f, &rays);
    f.options.texture_filter = true;
    const double by_beams = polished_irradiance(&f, &beams);
    print_message("by rays %.4f, deviation %.4f; by beams %.4f, deviation %.4f\n", by_rays, rays,
                  by_beams, beams);
    assert_true(beams < 0.25 * rays);
    // The bound is five standard errors, and the light that wider lobes reflect elsewhere.
    assert_true(fabs(by_beams - by_rays) < 5.0 * rays / sqrt(256.0) + 0.02 * by_rays);
    test_scene_free(&f.scene);
}

static void irradiance_gradients_match_differences(void **state) {
    (void)state;
    struct gather_hemisphere_fixture f;
    point_lit_box(&f);
    struct gather_layout *layout = gather_layout_new(12000, SATIN_HSH, 0);
    struct gather_worker *worker = gather_workers_new(NULL, gather_layout_rays(layout));
    const float h = 0.02f, x = -0.3f, z = 0.2f;
    double error = 0.0, size = 0.0;
    for (uint64_t i = 0; i < 4; i++) {
        struct cache_irradiance_value here =
            irradiance_at(&f, layout, worker, gather_hemisphere_floor_site(x, z, i));
        for (int axis = 0; axis < 2; axis++) {
            float dx = axis ? 0.0f : h, dz = axis ? h : 0.0f;
            float up =
                irradiance_at(&f, layout, worker, gather_hemisphere_floor_site(x + dx, z + dz, i))
                    .E.g;
            float down =
                irradiance_at(&f, layout, worker, gather_hemisphere_floor_site(x - dx, z - dz, i))
                    .E.g;
            double difference = (double)(up - down) / (2.0 * (double)h);
            double given = (double)(axis ? here.grad_t[1].z : here.grad_t[1].x);
            error += (given - difference) * (given - difference);
            size += difference * difference;
        }
    }
    // Errata: Ward and Heckbert's weights are good to about 1 % at 4000 rays, 0.6 % at this count;
    // the central difference adds its own curvature term of the order h^2.
    assert_true(size > 0.0 && sqrt(error / size) < 0.03);

    gather_workers_free(worker, 1);
    gather_layout_free(layout);
    test_scene_free(&f.scene);
}

static void rotation_gradient_matches_a_tilt(void **state) {
    (void)state;
    struct gather_hemisphere_fixture f;
    point_lit_box(&f);
    struct gather_layout *layout = gather_layout_new(12000, SATIN_HSH, 0);
    struct gather_worker *worker = gather_workers_new(NULL, gather_layout_rays(layout));
    // Beside a wall irradiance depends much on the normal, which is tilted by 2 degrees both ways.
    const float tilt = 0.035f;
    double given = 0.0, difference = 0.0;
    for (uint64_t i = 0; i < STREAMS; i++) {
        struct gather_site site = gather_hemisphere_floor_site(0.8f, 0.1f, i);
        given += (double)v3_dot(v3_cross(v3(0, 1, 0), v3(1, 0, 0)),
                                irradiance_at(&f, layout, worker, site).grad_r[1]);
        for (int side = -1; side <= 1; side += 2) {
            struct gather_site tilted = site;
            tilted.frame =
                frame_from_tangent(v3_unit(v3((float)side * tilt, 1.0f, 0.0f)), site.frame.u);
            difference +=
                (double)irradiance_at(&f, layout, worker, tilted).E.g * side / (2.0 * (double)tilt);
        }
    }
    // E is to 0.05 % in each of 24 pairs of 12000 rays, so its slope to .002 of .036 in their
    // mean; with the wrong sign the deviation would be 2.
    assert_true(fabs(difference) > 0.02 * STREAMS);
    assert_true(fabs(given / difference - 1.0) < 0.15);
    gather_workers_free(worker, 1);
    gather_layout_free(layout);
    test_scene_free(&f.scene);
}

static void radiance_gradients_match_differences(void **state) {
    (void)state;
    struct gather_hemisphere_fixture f;
    point_lit_box(&f);
    struct gather_layout *layout = gather_layout_new(16000, SATIN_HSH, ORDER);
    struct gather_worker *worker = gather_workers_new(NULL, gather_layout_rays(layout));
    const float h = 0.02f, x = -0.3f, z = 0.2f;
    float a[3 * N2], dx[3 * N2], dy[3 * N2], up[3 * N2], down[3 * N2];
    double error = 0.0, size = 0.0;
    struct gather_site site = gather_hemisphere_floor_site(x, z, 5);
    struct gather_radiance here = {.lambda = a, .dx = dx, .dy = dy};
    radiance_at(&f, layout, worker, &site, &here);
    for (int axis = 0; axis < 2; axis++) {
        vec3 along = v3_mul(axis ? site.frame.v : site.frame.u, h);
        struct gather_site s = site;
        s.p = v3_add(site.p, along);
        radiance_at(&f, layout, worker, &s, &(struct gather_radiance){.lambda = up});
        s.p = v3_sub(site.p, along);
        radiance_at(&f, layout, worker, &s, &(struct gather_radiance){.lambda = down});
        for (int k = 0; k < 3 * N2; k++) {
            double difference = (double)(up[k] - down[k]) / (2.0 * (double)h);
            double given = (double)(axis ? dy[k] : dx[k]);
            error += (given - difference) * (given - difference);
            size += difference * difference;
        }
    }
    // Errata: 2 % for all coefficients at 1024 rays, 1 % at 4096, with weights at the walls; plus
    // h^2.
    assert_true(size > 0.0 && sqrt(error / size) < 0.04);
    gather_workers_free(worker, 1);
    gather_layout_free(layout);
    test_scene_free(&f.scene);
}

static void constant_radiance_has_one_coefficient(void **state) {
    (void)state;
    struct gather_hemisphere_fixture f;
    furnace_box(&f);
    struct gather_layout *layout = gather_layout_new(20000, SATIN_HSH, ORDER);
    struct gather_worker *worker = gather_workers_new(NULL, gather_layout_rays(layout));
    float a[3 * N2];
    struct gather_site site = gather_hemisphere_floor_site(0.1f, -0.4f, 3);
    radiance_at(&f, layout, worker, &site, &(struct gather_radiance){.lambda = a});
    // 1 / 4 times the integral of H_0 = 1 / sqrt(2 pi) over the hemisphere. One light sample of six
    // faces spreads by less than its mean, so a coefficient's standard error is below 0.7 %; five
    // of them for one, twice the expected sum for the 35 others.
    double exact = 0.25 * sqrt(2.0 * 3.14159265358979), rest = 0.0;
    assert_true(fabs((double)a[0] / exact - 1.0) < 0.035);
    for (int k = 1; k < N2; k++) rest += (double)a[k] * (double)a[k];
    assert_true(sqrt(rest) < 0.08 * exact);
    gather_workers_free(worker, 1);
    gather_layout_free(layout);
    test_scene_free(&f.scene);
}

// The results of a hemisphere stay when the worker gathers the next one.
static void hemispheres_own_what_they_found(void **state) {
    (void)state;
    struct gather_hemisphere_fixture f;
    furnace_box(&f);
    struct gather_layout *layout = gather_layout_new(100, SATIN_HSH, 0);
    struct gather_worker *worker = gather_workers_new(NULL, gather_layout_rays(layout));
    struct gather_hemisphere *other = gather_hemisphere_new(gather_layout_rays(layout));
    const struct gather_site here = gather_hemisphere_floor_site(0.3f, 0.2f, 0),
                             there = gather_hemisphere_floor_site(-0.7f, 0.1f, 1);
    struct cache_irradiance_value before, after;
    gather_hemisphere_trace(&f.g, layout, &here, worker->scratch, worker->hemisphere);
    gather_hemisphere_irradiance(worker->hemisphere, f.g.options->irradiance_gradients, &before);
    gather_hemisphere_trace(&f.g, layout, &there, worker->scratch, other);
    gather_hemisphere_irradiance(worker->hemisphere, f.g.options->irradiance_gradients, &after);
    assert_memory_equal(&before, &after, sizeof before);
    gather_hemisphere_irradiance(other, f.g.options->irradiance_gradients, &after);
    assert_memory_not_equal(&before, &after, sizeof before);
    gather_hemisphere_free(other);
    gather_workers_free(worker, 1);
    gather_layout_free(layout);
    test_scene_free(&f.scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_furnace_has_no_gradients),
        cmocka_unit_test(polished_walls_are_visible_through_beams),
        cmocka_unit_test(irradiance_gradients_match_differences),
        cmocka_unit_test(rotation_gradient_matches_a_tilt),
        cmocka_unit_test(radiance_gradients_match_differences),
        cmocka_unit_test(constant_radiance_has_one_coefficient),
        cmocka_unit_test(hemispheres_own_what_they_found),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
