// SPDX-License-Identifier: Apache-2.0
// Product sampling of an environment: the density is that of all bins together, samples go above
// the horizon of the point that they light, and their number follows the cosine.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/sampling.h"
#include "light/light_kinds.h"

enum { SIDE = LIGHT_HISTOGRAM_SIDE };

struct light_product_bins {
    struct light_blocks blocks;
    struct light_histogram histogram;
    struct light_product product;
};

// Makes the product of a box of half-width `half` around the origin for these weights.
static void light_product_of(float half, const float weight[LIGHT_HISTOGRAM_BINS],
                             struct light_receiver at, struct light_product_bins *out) {
    const struct light_box box = light_box_make(v3(-half, -half, -half), v3(half, half, half));
    bool bin[LIGHT_HISTOGRAM_BINS];
    for (int i = 0; i < LIGHT_HISTOGRAM_BINS; i++) bin[i] = weight[i] > 0.0f;
    light_blocks_build(&box, bin, &out->blocks);
    light_histogram_build(weight, 0.9f, &out->blocks, &out->histogram);
    light_product_make(&out->histogram, &at, &out->product);
}

// The number of 4,096 samples that are above the horizon.
static int light_product_above(const struct light_product *product, vec3 n) {
    int above = 0;
    for (uint32_t i = 0; i < 4096; i++) {
        const vec2 u = sample_sobol2(i, 1);
        float pdf_w;
        const vec3 w = light_product_sample(product, u.x, u.y, &pdf_w);
        assert_true(fabsf(light_product_pdf(product, w) / pdf_w - 1.0f) < 1e-3f);
        above += v3_dot(n, w) > 0.0f;
    }
    return above;
}

// In rooms whose sides are 1e-9 to 1e9, and from points beyond the box.
static void probabilities_sum_to_one(void **state) {
    (void)state;
    float weight[LIGHT_HISTOGRAM_BINS];
    for (int i = 0; i < LIGHT_HISTOGRAM_BINS; i++) weight[i] = i % 7 ? 0.0f : (float)(i % 5);
    for (int k = 0; k < 12; k++) {
        const float half = powf(10.0f, (float)(6 * (k % 4) - 9));
        const vec3 p = v3_mul(v3(0.3f, -0.9f, k < 6 ? 0.5f : 3.0f), half);
        const struct light_receiver at = {p, v3_unit(v3(1, 2, 3)), k % 3 == 0};
        static struct light_product_bins bins;
        light_product_of(half, weight, at, &bins);
        double sum = 0.0;
        for (int bin = 0; bin < LIGHT_HISTOGRAM_BINS; bin++) {
            float density;
            const vec3 w = light_box_direction(&bins.blocks.box, p, bin, 0.5f, 0.5f, &density);
            sum += (double)(light_product_pdf(&bins.product, w) / density);
        }
        assert_true(fabs(sum - 1.0) < 1e-4);
    }
}

// On the floor of a room that is open on all sides, half of the bins are below the horizon, and a
// lit block at it has a few of the samples. Without a normal, or where light comes from both sides,
// a half are.
static void samples_go_above_the_horizon(void **state) {
    (void)state;
    float weight[LIGHT_HISTOGRAM_BINS];
    for (int i = 0; i < LIGHT_HISTOGRAM_BINS; i++) weight[i] = 1.0f;
    const vec3 p = v3(0, 0, 0), up = v3(0, 0, 1);
    const struct light_receiver at[] = {{p, up, false}, {p, v3(0, 0, 0), false}, {p, up, true}};
    int above[3];
    for (int k = 0; k < 3; k++) {
        static struct light_product_bins bins;
        light_product_of(1.0f, weight, at[k], &bins);
        above[k] = light_product_above(&bins.product, up);
    }
    print_message("above: %d, %d, %d of 4096\n", above[0], above[1], above[2]);
    assert_true(above[0] > 4096 * 0.9);
    assert_true(abs(above[1] - 2048) < 40 && abs(above[2] - 2048) < 40);
}

// A point close to the wall of a window, but not to the window, draws directions that pass it, or a
// fraction of them would be lost in a corner of a room. Before the window it is moved from the
// wall.
static void a_window_is_met_from_beside_it(void **state) {
    (void)state;
    float weight[LIGHT_HISTOGRAM_BINS] = {0.0f};
    // The middle bins of the face at x = 1, up to 1/8 from its middle.
    for (int i = 0; i < 16; i++)
        weight[(SIDE + SIDE / 2 - 2 + i / 4) * SIDE + SIDE / 2 - 2 + i % 4] = 1.0f;
    static struct light_product_bins bins;
    const vec3 p = v3(0.98f, 0.1f, -0.8f), n = v3(0, 0, 1);
    light_product_of(1.0f, weight, (struct light_receiver){p, n, false}, &bins);
    assert_int_equal(light_product_above(&bins.product, n), 4096);
    for (uint32_t i = 0; i < 4096; i++) {
        const vec2 u = sample_sobol2(i, 1);
        float pdf_w;
        const vec3 w = light_product_sample(&bins.product, u.x, u.y, &pdf_w);
        const vec3 q = v3_mad(p, (1.0f - p.x) / w.x, w);
        assert_true(fabsf(q.y) < 0.1251f && fabsf(q.z) < 0.1251f);
    }
    const struct light_receiver before = {v3(0.98f, 0.1f, 0.0f), v3(-1, 0, 0), true};
    light_product_of(1.0f, weight, before, &bins);
    assert_float_equal(bins.product.p.x, 1.0f - 2.0f / SIDE, 1e-6f);
}

// Two windows, one above the point and one at 60 degrees from its normal and as far, get samples in
// proportion to their cosines.
static void samples_follow_the_cosine(void **state) {
    (void)state;
    float weight[LIGHT_HISTOGRAM_BINS] = {0.0f};
    // The middle bins of the faces at x = 1 and z = 1.
    for (int i = 0; i < 16; i++) {
        const int bin = (SIDE / 2 - 2 + i / 4) * SIDE + SIDE / 2 - 2 + i % 4;
        weight[SIDE * SIDE + bin] = weight[5 * SIDE * SIDE + bin] = 1.0f;
    }
    const vec3 n = v3(sinf(PI_F / 6.0f), 0.0f, cosf(PI_F / 6.0f));
    static struct light_product_bins bins;
    light_product_of(1.0f, weight, (struct light_receiver){v3(0, 0, 0), n, false}, &bins);
    int aside = 0, above = 0;
    for (uint32_t i = 0; i < 4096; i++) {
        const vec2 u = sample_sobol2(i, 1);
        float pdf_w;
        const vec3 w = light_product_sample(&bins.product, u.x, u.y, &pdf_w);
        if (w.x > w.z)
            aside++;
        else
            above++;
    }
    const double ratio = (double)aside / above;
    print_message("%d, %d\n", aside, above);
    // tan 30 degrees, and a little more by the radius of the blocks
    assert_true(ratio > 0.577 && ratio < 0.7);
}

// A wall whose windows are all behind it: the samples of bins would be lost.
static void a_point_that_faces_no_bin_has_no_samples_by_bins(void **state) {
    (void)state;
    float weight[LIGHT_HISTOGRAM_BINS] = {0.0f};
    for (int i = 0; i < SIDE * SIDE; i++) weight[i] = 1.0f;  // x = -1
    static struct light_product_bins bins;
    const struct light_receiver away = {v3(0, 0, 0), v3(1, 0, 0), false},
                                towards = {v3(0, 0, 0), v3(-1, 0, 0), false};
    light_product_of(1.0f, weight, away, &bins);
    assert_true(bins.product.fraction == 0.0f);
    light_product_of(1.0f, weight, towards, &bins);
    assert_true(bins.product.fraction == 0.9f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(probabilities_sum_to_one),
        cmocka_unit_test(samples_go_above_the_horizon),
        cmocka_unit_test(a_window_is_met_from_beside_it),
        cmocka_unit_test(samples_follow_the_cosine),
        cmocka_unit_test(a_point_that_faces_no_bin_has_no_samples_by_bins),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
