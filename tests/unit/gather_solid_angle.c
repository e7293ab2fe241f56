// SPDX-License-Identifier: Apache-2.0
// Solid-angle-based gradients of random hits: by differentiation, by differences, and by moving
// the centre while the areas that were hit stay, in double. The three must agree, coefficient by
// coefficient, wherever the hits are.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gather/gather_gradients.h"
#include "rsh/rsh.h"

enum { RAYS = 400, ORDER = 10, N2 = ORDER * ORDER };

struct gather_solid_angle_fixture {
    struct gather_layout *layout;
    struct frame frame;
    struct gather_hemisphere *hemisphere;
    size_t count;
};

// Hits at distances over three decades, with normals up to 75 degrees from the ray; every seventh
// ray misses, every eleventh meets a mirror.
static void gather_solid_angle_start(struct gather_solid_angle_fixture *f, satin_basis basis,
                                     int order) {
    f->layout = gather_layout_new(RAYS, basis, order);
    f->count = gather_layout_rays(f->layout);
    f->frame = frame_from_normal(v3_unit(v3(0.3f, -0.5f, 0.7f)));
    f->hemisphere = gather_hemisphere_new(f->count);
    gather_hemisphere_begin(f->hemisphere, f->layout, &f->frame);
    struct rng rng = rng_make(1, RNG_GATHER, 0);
    struct gather_hemisphere *h = f->hemisphere;
    for (size_t i = 0; i < f->count; i++) {
        float u = rng_float(&rng), v = rng_float(&rng);
        vec3 w = order ? sample_uniform_hemisphere(u, v) : sample_cosine_hemisphere(u, v);
        h->x[i] = w.x, h->y[i] = w.y, h->z[i] = w.z;
        vec3 tilt = v3_mul(sample_uniform_sphere(rng_float(&rng), rng_float(&rng)), 0.95f);
        struct gather_first hit = {powf(10.0f, 3.0f * rng_float(&rng) - 2.0f),
                                   frame_to_world(&f->frame, v3_unit(v3_sub(tilt, w)))};
        if (i % 11 == 0) hit.ng = GATHER_NOTHING.ng;
        h->ray[i].first = i % 7 ? hit : GATHER_NOTHING;
        h->L[i] = rgb_make(rng_float(&rng), rng_float(&rng), rng_float(&rng));
        const rgb value = rgb_scale(h->L[i], 2.0f * PI_F / (float)f->count);
        h->r[i] = value.r, h->g[i] = value.g, h->b[i] = value.b;
    }
}

static void gather_solid_angle_finish(struct gather_solid_angle_fixture *f) {
    gather_hemisphere_free(f->hemisphere);
    gather_layout_free(f->layout);
}

// Direction and solid angle, over the previous one, of the area that ray i hit, when the centre has
// moved by `step` along an axis. False if it is not known.
static bool moved(const struct gather_solid_angle_fixture *f, size_t i, int axis, double step,
                  double w[3], double *omega) {
    const struct gather_hemisphere *h = f->hemisphere;
    const struct gather_first *hit = &h->ray[i].first;
    const vec3 nl = frame_to_local(&f->frame, hit->ng);
    const double old[3] = {(double)h->x[i], (double)h->y[i], (double)h->z[i]};
    const double n[3] = {(double)nl.x, (double)nl.y, (double)nl.z};
    double r = (double)hit->r, length2 = 0.0, c = 0.0, c_old = 0.0;
    if (!isfinite(r) || v3_len2(nl) < 0.5f) return false;
    for (int k = 0; k < 3; k++) {
        w[k] = r * old[k] - (k == axis ? step : 0.0);
        length2 += w[k] * w[k];
        c += n[k] * w[k];
        c_old += n[k] * r * old[k];
    }
    *omega = c / c_old * pow(r * r / length2, 1.5);
    for (int k = 0; k < 3; k++) w[k] /= sqrt(length2);
    return true;
}

// Checks that a vector of derivatives has an error of at most `limit` times its length.
static void gather_solid_angle_compare(const float *given, const double *wanted, int count,
                                       double limit) {
    double error = 0.0, size = 0.0;
    for (int k = 0; k < count; k++) {
        error += ((double)given[k] - wanted[k]) * ((double)given[k] - wanted[k]);
        size += wanted[k] * wanted[k];
    }
    assert_true(size > 0.0);
    if (sqrt(error / size) > limit) fail_msg("relative error %g", sqrt(error / size));
}

// A step of a ten-thousandth of r is exact to 1e-6 with derivatives in double; the harmonics are
// floats, so their differences are good to 1e-3 only and the step must be larger: .003, whose
// third-order term is that squared times 10 squared.
static void wanted_radiance(const struct gather_solid_angle_fixture *f, int axis, double *out) {
    const rsh_basis basis = brdf_rsh_basis(f->layout->basis);
    for (int k = 0; k < 3 * N2; k++) out[k] = 0.0;
    for (size_t i = 0; i < f->count; i++)
        for (int side = -1; side <= 1; side += 2) {
            double w[3], omega, h = 0.003 * (double)f->hemisphere->ray[i].first.r;
            float H[N2];
            if (!moved(f, i, axis, side * h, w, &omega)) continue;
            rsh_eval(basis, ORDER, (float[]){(float)w[0], (float)w[1], (float)w[2]}, H);
            const double L[3] = {(double)f->hemisphere->r[i], (double)f->hemisphere->g[i],
                                 (double)f->hemisphere->b[i]};
            for (int k = 0; k < 3 * N2; k++)
                out[k] += side * omega * L[k / N2] * (double)H[k % N2] / (2.0 * h);
        }
}

static void test_gather_solid_angle_radiance(satin_basis basis) {
    struct gather_solid_angle_fixture f;
    gather_solid_angle_start(&f, basis, ORDER);
    static double wanted[2][3 * N2];
    static float dx[3 * N2], dy[3 * N2];
    for (int axis = 0; axis < 2; axis++) wanted_radiance(&f, axis, wanted[axis]);
    for (int differences = 0; differences < 2; differences++) {
        memset(dx, 0, sizeof dx);
        memset(dy, 0, sizeof dy);
        gather_solid_angle_radiance(f.hemisphere, differences, 0, dx, dy);
        gather_solid_angle_compare(dx, wanted[0], 3 * N2, 2e-3);
        gather_solid_angle_compare(dy, wanted[1], 3 * N2, 2e-3);
    }
    gather_solid_angle_finish(&f);
}

static void radiance_in_hemispherical_harmonics_has_its_gradients(void **state) {
    (void)state;
    test_gather_solid_angle_radiance(SATIN_HSH);
}

static void radiance_in_spherical_harmonics_has_its_gradients(void **state) {
    (void)state;
    test_gather_solid_angle_radiance(SATIN_SH);
}

static void irradiance_of_a_patch_has_its_gradients(void **state) {
    (void)state;
    struct gather_solid_angle_fixture f;
    gather_solid_angle_start(&f, SATIN_HSH, 0);
    double wanted[6] = {0};
    for (size_t i = 0; i < f.count; i++)
        for (int k = 0; k < 4; k++) {
            const int side = k & 1 ? 1 : -1, axis = k >> 1;
            double w[3], omega, h = 1e-4 * (double)f.hemisphere->ray[i].first.r;
            if (!moved(&f, i, axis, side * h, w, &omega)) continue;
            const rgb L = f.hemisphere->L[i];
            const double change = side * omega * w[2] / (double)f.hemisphere->z[i] / (2.0 * h) *
                                  (double)PI_F / (double)f.count;
            wanted[axis] += (double)L.r * change;
            wanted[2 + axis] += (double)L.g * change;
            wanted[4 + axis] += (double)L.b * change;
        }
    for (int differences = 0; differences < 2; differences++) {
        vec3 grad[3] = {{0}};
        gather_solid_angle_irradiance(f.hemisphere, differences, 0, grad);
        const float given[6] = {grad[0].x, grad[0].y, grad[1].x, grad[1].y, grad[2].x, grad[2].y};
        gather_solid_angle_compare(given, wanted, 6, 2e-4);
        for (int c = 0; c < 3; c++) assert_true(grad[c].z == 0.0f);
    }
    gather_solid_angle_finish(&f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(radiance_in_hemispherical_harmonics_has_its_gradients),
        cmocka_unit_test(radiance_in_spherical_harmonics_has_its_gradients),
        cmocka_unit_test(irradiance_of_a_patch_has_its_gradients),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
