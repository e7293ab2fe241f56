// SPDX-License-Identifier: Apache-2.0
// The rough diffuse BRDF against the published formulas in double precision, by angles, and its
// albedo against sums over directions.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/rng.h"
#include "base/sampling.h"
#include "brdf/brdf.h"

static const float alphas[] = {0.0f, 0.05f, 0.2f, 0.7f, 3.0f, 1e6f};
enum { ALPHAS = sizeof alphas / sizeof *alphas };

static struct brdf grooves(float alpha, bool fast, struct arena *arena) {
    struct brdf b = {.model = brdf_find("roughdiffuse"),
                     .diffuse = {0.2f, 0.6f, 1.0f},
                     .alpha_u = alpha,
                     .fast = fast};
    assert_int_equal(brdf_prepare(&b, arena, NULL), SATIN_OK);
    return b;
}

static vec3 toward(double theta, double phi) {
    return v3((float)(sin(theta) * cos(phi)), (float)(sin(theta) * sin(phi)), (float)cos(theta));
}

// [Oren and Nayar 1994, (27) to (30)]: the radiance L1 + L2 under a unit irradiance of the surface.
static double oren_nayar(double rho, double alpha, double theta_r, double theta_i, double phi) {
    const double s2 = alpha * alpha / 2, c = cos(phi);
    const double a = fmax(theta_r, theta_i), b = fmin(theta_r, theta_i);
    const double c1 = 1 - 0.5 * s2 / (s2 + 0.33), c4 = 0.17 * s2 / (s2 + 0.13);
    const double c2 = 0.45 * s2 / (s2 + 0.09) * (c >= 0 ? sin(a) : sin(a) - pow(2 * b / M_PI, 3));
    const double c3 = 0.125 * s2 / (s2 + 0.09) * pow(4 * a * b / (M_PI * M_PI), 2);
    const double once = rho / M_PI * (c1 + c * c2 * tan(b) + (1 - fabs(c)) * c3 * tan((a + b) / 2));
    return once + rho * rho / M_PI * c4 * (1 - c * pow(2 * b / M_PI, 2));
}

// [Oren and Nayar 1994, 4.4], the qualitative model.
static double qualitative(double rho, double alpha, double theta_r, double theta_i, double phi) {
    const double s2 = alpha * alpha / 2;
    const double a = fmax(theta_r, theta_i), b = fmin(theta_r, theta_i);
    return rho / M_PI *
           (1 - 0.5 * s2 / (s2 + 0.33) +
            0.45 * s2 / (s2 + 0.09) * fmax(cos(phi), 0) * sin(a) * tan(b));
}

static void values_are_the_published_ones(void **state) {
    (void)state;
    struct arena arena = {0};
    for (int i = 0; i < 2 * ALPHAS; i++) {
        const bool fast = i >= ALPHAS;
        const struct brdf b = grooves(alphas[i % ALPHAS], fast, &arena);
        struct rng rng = rng_make(3, RNG_TEST, (uint64_t)i);
        for (int k = 0; k < 2000; k++) {
            const double r = 1.55 * (double)rng_float(&rng), t = 1.55 * (double)rng_float(&rng);
            const double at = 7.0 * (double)rng_float(&rng), phi = 7.0 * (double)rng_float(&rng);
            const rgb f = brdf_eval(&b, toward(r, at), toward(t, at + phi), BRDF_ALL);
            const double alpha = (double)alphas[i % ALPHAS];
            const float got[3] = {f.r, f.g, f.b};
            const double rho[3] = {(double)b.diffuse.r, (double)b.diffuse.g, (double)b.diffuse.b};
            for (int c = 0; c < 3; c++) {
                const double want = fast ? qualitative(rho[c], alpha, r, t, phi)
                                         : oren_nayar(rho[c], alpha, r, t, phi);
                if (fabs((double)got[c] - fmax(want, 0.0)) > 3e-5 * fmax(fabs(want), 0.1))
                    fail_msg("alpha %g: %g, want %g", alpha, (double)got[c], want);
            }
        }
    }
    arena_free(&arena);
}

static void smooth_ones_are_lambertian(void **state) {
    (void)state;
    struct arena arena = {0};
    const struct brdf b = grooves(0.0f, false, &arena), fast = grooves(0.0f, true, &arena);
    const vec3 wo = toward(1.2, 0.3), wi = toward(0.9, 2.0);
    assert_float_equal(brdf_eval(&b, wo, wi, BRDF_ALL).g, 0.6f / PI_F, 1e-7f);
    assert_float_equal(brdf_eval(&fast, wo, wi, BRDF_ALL).g, 0.6f / PI_F, 1e-7f);
    assert_float_equal(brdf_albedo(&b, wo, BRDF_ALL).g, 0.6f, 1e-6f);
    arena_free(&arena);
}

// The sum over a grid of angles.
static rgb summed_albedo(const struct brdf *b, vec3 wo) {
    enum { SIDE = 256 };
    rgb sum = rgb_grey(0.0f);
    for (int i = 0; i < SIDE; i++) {
        rgb row = rgb_grey(0.0f);
        for (int k = 0; k < SIDE; k++) {
            const vec3 wi = toward((i + 0.5) / SIDE * M_PI_2, (k + 0.5) / SIDE * 2.0 * M_PI);
            const float area = sinf(2.0f * acosf(wi.z)) * PI_F * PI_F / 2.0f;
            row = rgb_mad(row, brdf_eval(b, wo, wi, BRDF_ALL), area / SIDE);
        }
        sum = rgb_mad(sum, row, 1.0f / SIDE);
    }
    return sum;
}

// The sums are accurate to 5e-5, as those of twice the size show. Of dark surfaces of alpha 3,
// values below 0 are 0 in the sums alone, which is 2.6e-4 at most.
static void albedos_are_sums_over_directions(void **state) {
    (void)state;
    struct arena arena = {0};
    for (int i = 0; i < 2 * (ALPHAS - 1); i++) {
        const bool fast = i % 2 != 0;
        const struct brdf b = grooves(alphas[i / 2], fast, &arena);
        for (double theta = 0.0; theta < 1.56; theta += 0.05) {
            const vec3 wo = toward(theta, 0.4);
            const rgb got = brdf_albedo(&b, wo, BRDF_DIFFUSE), want = summed_albedo(&b, wo);
            if (fabsf(got.r - want.r) > (b.alpha_u < 1.0f ? 1e-4f : 4e-4f) ||
                fabsf(got.b - want.b) > 1e-4f)
                fail_msg("alpha %g, fast %d, %g: %g %g, want %g %g", (double)b.alpha_u, fast, theta,
                         (double)got.r, (double)got.b, (double)want.r, (double)want.b);
        }
    }
    arena_free(&arena);
}

// White surfaces reflect no more than what the file says.
static void white_surfaces_hardly_gain_light(void **state) {
    (void)state;
    struct arena arena = {0};
    for (float alpha = 0.0f; alpha < 2.0f; alpha += 0.02f) {
        struct brdf b = grooves(alpha, false, &arena);
        b.diffuse = rgb_grey(1.0f);
        double mean = 0.0;
        enum { NODES = 256 };
        for (int i = 0; i < NODES; i++) {
            const float z = sqrtf(((float)i + 0.5f) / NODES);
            const float a = brdf_albedo(&b, v3(sqrtf(1.0f - z * z), 0.0f, z), BRDF_ALL).g;
            assert_true(a < 1.051f);
            mean += (double)a / NODES;
        }
        assert_true(mean < 1.0004);
        if (alpha > 0.16f) assert_true(mean < 1.0);
    }
    arena_free(&arena);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values_are_the_published_ones),
        cmocka_unit_test(smooth_ones_are_lambertian),
        cmocka_unit_test(albedos_are_sums_over_directions),
        cmocka_unit_test(white_surfaces_hardly_gain_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
