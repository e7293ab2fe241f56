// SPDX-License-Identifier: Apache-2.0
// Light at an edge that the surfaces around do not explain goes as far as its noise does.
#include "render/render_edges.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

enum { GRID = 3, MIDDLE = 4 };

// A grid of pixels that are noisy by their two halves, and a regression by which direct light is 1
// in each of them, and at most 3, and differs from that by .5 in the mean.
struct noisy_edge {
    struct render_image image;
    struct image_pixel pixel[GRID * GRID];
    struct image_noisy noisy[GRID * GRID];
    struct regression g;
};

static void set_halves(struct noisy_edge *e, int at, uint32_t samples, float even, float odd) {
    const float half = 0.5f * (float)samples;
    e->pixel[at].samples = samples;
    e->pixel[at].weight = (float)samples;
    e->pixel[at].layer[SHADE_DIRECT] = rgb_make(half * (even + odd), 0.0f, 0.0f);
    e->noisy[at].odd[SHADE_DIRECT] = rgb_make(half * odd, 0.0f, 0.0f);
    e->noisy[at].weight = half;
}

static struct noisy_edge *noisy_edge_new(void) {
    struct noisy_edge *e = calloc(1, sizeof *e);
    assert_non_null(e);
    e->image.width = e->image.height = GRID;
    e->image.pixel = e->pixel;
    e->image.noisy_light = e->noisy;
    for (int i = 0; i < GRID * GRID; i++) set_halves(e, i, 2, 0.5f, 1.5f);
    e->g.y_mean[0] = 1.0f;
    e->g.most[0] = 3.0f;
    e->g.residual[SHADE_DIRECT] = sqrf(0.5f);
    return e;
}

// The light that remains of `light` in the middle.
static float quietened(const struct noisy_edge *e, float light) {
    const float dx[REGRESSORS] = {0.0f}, value[REGRESSION_VALUES] = {light};
    struct pixel_change change = {0};
    render_edges_quieten(&e->image, MIDDLE, &e->g, dx, value, &change);
    assert_true(change.light[SHADE_DIRECT].g == 0.0f);
    assert_true(rgb_black(change.light[SHADE_CAUSTIC]));
    return light + change.light[SHADE_DIRECT].r;
}

static void noise_goes_to_the_light_around(void **state) {
    (void)state;
    struct noisy_edge *e = noisy_edge_new();
    set_halves(e, MIDDLE, 2, 0.0f, 20.0f);
    assert_float_equal(quietened(e, 10.0f), 1.5f, 1e-5f);
    assert_float_equal(quietened(e, 0.0f), 0.5f, 1e-5f);
    free(e);
}

static void light_that_varies_as_around_stays(void **state) {
    (void)state;
    struct noisy_edge *e = noisy_edge_new();
    set_halves(e, MIDDLE, 2, 0.0f, 2.8f);
    assert_true(quietened(e, 1.4f) == 1.4f);
    free(e);
}

static void light_of_both_halves_stays(void **state) {
    (void)state;
    struct noisy_edge *e = noisy_edge_new();
    set_halves(e, MIDDLE, 2, 10.0f, 10.0f);
    assert_true(quietened(e, 10.0f) == 10.0f);
    free(e);
}

// The standard deviation of a mean of a hundred samples, in halves of 9 and 11, is 1.
static void light_goes_as_far_as_its_noise(void **state) {
    (void)state;
    struct noisy_edge *e = noisy_edge_new();
    set_halves(e, MIDDLE, 100, 9.0f, 11.0f);
    assert_float_equal(quietened(e, 10.0f), 9.0f, 1e-5f);
    free(e);
}

// The halves of the pixels around differ by 1, so one of their samples has a deviation of .71.
static void one_sample_is_as_noisy_as_those_around(void **state) {
    (void)state;
    struct noisy_edge *e = noisy_edge_new();
    set_halves(e, MIDDLE, 1, 20.0f, 0.0f);
    e->noisy[MIDDLE].weight = 0.0f;
    assert_float_equal(quietened(e, 10.0f), 10.0f - sqrtf(0.5f), 1e-5f);
    for (int i = 0; i < GRID * GRID; i++) e->noisy[i].weight = 0.0f;  // not known
    assert_float_equal(quietened(e, 10.0f), 1.5f, 1e-5f);
    free(e);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(noise_goes_to_the_light_around),
        cmocka_unit_test(light_that_varies_as_around_stays),
        cmocka_unit_test(light_of_both_halves_stays),
        cmocka_unit_test(light_goes_as_far_as_its_noise),
        cmocka_unit_test(one_sample_is_as_noisy_as_those_around),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
