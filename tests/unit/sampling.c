// SPDX-License-Identifier: Apache-2.0
// Sampling maps: round trips, net property of the Sobol' points, discrete distributions.
#include "base/sampling.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/rng.h"

// The inverse of sample_disk, after the formulas of Shirley and Chiu (1997).
static vec2 disk_inverse(vec2 p) {
    float r = sqrtf(p.x * p.x + p.y * p.y);
    if (r == 0.0f) return (vec2){0.5f, 0.5f};
    float a, b;
    if (fabsf(p.x) > fabsf(p.y)) {
        a = copysignf(r, p.x);
        b = a * atan2f(copysignf(1.0f, p.x) * p.y, fabsf(p.x)) * (4.0f / PI_F);
    } else {
        b = copysignf(r, p.y);
        a = b * atan2f(copysignf(1.0f, p.y) * p.x, fabsf(p.y)) * (4.0f / PI_F);
    }
    return (vec2){0.5f * (a + 1.0f), 0.5f * (b + 1.0f)};
}

static void the_disk_map_is_inverted(void **state) {
    (void)state;
    struct rng rng = rng_make(1, RNG_TEST, 0);
    for (int i = 0; i < 10000; i++) {
        float u = rng_float(&rng), v = rng_float(&rng);
        vec2 q = disk_inverse(sample_disk(u, v));
        assert_true(fabsf(q.x - u) < 2e-6f && fabsf(q.y - v) < 2e-6f);
    }
}

// The largest number of the last stratum is below 1, where a simple quotient rounds to it.
static void strata_end_below_one(void **state) {
    (void)state;
    const float last = 0x1.fffffep-1f;
    int rounded = 0;
    for (int n = 1; n <= 5000; n++) {
        const float u = sample_stratum(n - 1, last, n);
        assert_true(u >= (float)(n - 1) / (float)n && u < 1.0f);
        rounded += ((float)(n - 1) + last) / (float)n >= 1.0f;
        const vec3 w = sample_uniform_hemisphere(1.0f - u, 0.5f);
        assert_true(w.z > 0.0f && sample_cosine_hemisphere(u, 0.5f).z > 0.0f);
    }
    assert_true(rounded > 100);
    assert_true(sample_stratum(0, 0.0f, 7) == 0.0f && sample_stratum(3, 0.25f, 4) == 0.8125f);
}

// So is what is left of a number after a choice, which selects a lobe that may not exist.
static void rests_end_below_one(void **state) {
    (void)state;
    const float last = 0x1.fffffep-1f;
    int rounded = 0;
    for (int i = 0; i < 5000; i++) {
        const float p = (float)i / 5000.0f, u = sample_rest(last, p);
        assert_true(u > 0.99f && u < 1.0f && sample_rest(p, p) == 0.0f);
        rounded += (last - p) / (1.0f - p) >= 1.0f;
    }
    assert_true(rounded > 100);
    assert_true(sample_rest(0.25f, 0.0f) == 0.25f && sample_rest(0.75f, 0.5f) == 0.5f);
}

// The border of a cone is at the sine of its half angle, even where the cosine rounds to 1.
static void narrow_cones_keep_their_width(void **state) {
    (void)state;
    for (double angle = 1.0; angle > 1e-6; angle *= 0.5) {
        const double half = sin(0.5 * angle), versine = 2.0 * half * half;
        const vec3 w = sample_uniform_cone(1.0f, 0.0f, (float)versine);
        assert_true(fabs((double)w.x / sin(angle) - 1.0) < 1e-6 && w.y == 0.0f);
        assert_true(fabs((double)w.z - cos(angle)) < 1e-7);
    }
    assert_true(1.0f - (float)(2.0 * sin(1e-5) * sin(1e-5)) == 1.0f);
}

// Every elementary interval of area 2^-8 holds exactly one of any aligned run of 256 points.
static void sobol_is_a_net(void **state) {
    (void)state;
    for (uint32_t seed = 0; seed < 20; seed++)
        for (int shape = 0; shape <= 8; shape++) {
            int hits[256] = {0};
            for (uint32_t i = 0; i < 256; i++) {
                vec2 p = sample_sobol2(512 + i, seed);
                assert_true(p.x >= 0 && p.x < 1 && p.y >= 0 && p.y < 1);
                int column = (int)(p.x * (float)(1 << shape)),
                    row = (int)(p.y * (float)(256 >> shape));
                hits[row * (1 << shape) + column]++;
            }
            for (int c = 0; c < 256; c++) assert_int_equal(hits[c], 1);
        }
}

// With t = 3 every elementary interval of volume 2^(3 - 8) holds exactly 8 of an aligned run of 256
// points in four dimensions, and each pair of the first three is at least as even.
static void sobol4_is_a_net(void **state) {
    (void)state;
    for (uint32_t seed = 0; seed < 10; seed++)
        for (int split = 0; split < 4 * 4 * 4; split++) {
            int bits[4] = {split & 3, split >> 2 & 3, split >> 4 & 3, 0};
            bits[3] = 5 - bits[0] - bits[1] - bits[2];
            if (bits[3] < 0) continue;
            int hits[32] = {0};
            for (uint32_t i = 0; i < 256; i++) {
                float u[4];
                int cell = 0;
                sample_sobol4(1024 + i, seed, u);
                for (int k = 0; k < 4; k++) {
                    assert_true(u[k] >= 0 && u[k] < 1);
                    cell = cell << bits[k] | (int)(u[k] * (float)(1 << bits[k]));
                }
                hits[cell]++;
            }
            for (int c = 0; c < 32; c++) assert_int_equal(hits[c], 8);
        }
}

static void cdf_never_draws_zero(void **state) {
    (void)state;
    const float weight[6] = {0, 1, 0, 3, 0, 0};
    float cdf[7];
    assert_true(fabs(sample_cdf_build(weight, 6, cdf) - 4.0) < 1e-12);
    int count[6] = {0};
    for (int i = 0; i < 4096; i++) {
        float rest;
        count[sample_cdf(cdf, 6, (float)i / 4096.0f, &rest)]++;
        assert_true(rest >= 0 && rest < 1);
    }
    assert_int_equal(count[1], 1024);
    assert_int_equal(count[3], 3072);
}

// Also where cut points lie within one item, and for 1 itself, which rounding may give.
static void cuts_change_no_sample(void **state) {
    (void)state;
    enum { ITEMS = 1000, CUTS_MOST = 256, SAMPLES = 1 << 16 };
    float weight[ITEMS], cdf[ITEMS + 1];
    for (int i = 0; i < ITEMS; i++)
        weight[i] = i % 7 < 3 ? 0.0f : i == 600 ? 900.0f : (float)(i % 5);
    sample_cdf_build(weight, ITEMS, cdf);
    for (size_t cuts = 1; cuts <= CUTS_MOST; cuts *= 4) {
        uint32_t cut[CUTS_MOST + 1];
        sample_cuts_build(cdf, ITEMS, cuts, cut);
        for (int i = 0; i <= SAMPLES; i++) {
            const float u = (float)i / SAMPLES;
            float rest, rest_cut;
            assert_int_equal(sample_cdf_cut(cdf, cut, cuts, u, &rest_cut),
                             sample_cdf(cdf, ITEMS, u, &rest));
            assert_true(rest == rest_cut);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_disk_map_is_inverted), cmocka_unit_test(strata_end_below_one),
        cmocka_unit_test(rests_end_below_one),      cmocka_unit_test(narrow_cones_keep_their_width),
        cmocka_unit_test(sobol_is_a_net),           cmocka_unit_test(sobol4_is_a_net),
        cmocka_unit_test(cdf_never_draws_zero),     cmocka_unit_test(cuts_change_no_sample),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
