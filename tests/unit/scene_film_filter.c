// SPDX-License-Identifier: Apache-2.0
// Offsets drawn from the film's filters: their distribution, their weights, and the window.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "scene/scene.h"

static float scene_film_filter_value(const struct scene_film *film, float x) {
    float s = 2 * film->stddev * film->stddev;
    if (film->filter == FILTER_TENT) return fmaxf(film->radius - fabsf(x), 0);
    if (film->filter == FILTER_GAUSSIAN)
        return fmaxf(expf(-x * x / s) - expf(-film->radius * film->radius / s), 0);
    return fabsf(x) <= film->radius ? 1 : 0;
}

// The fraction of stratified samples left of a point is the filter's integral up to there, also
// where the window cuts the filter.
static void filter_samples_are_distributed(void **state) {
    (void)state;
    const struct scene_film films[] = {
        {.filter = FILTER_BOX, .radius = 0.5f},
        {.filter = FILTER_TENT, .radius = 1.5f},
        {.filter = FILTER_GAUSSIAN, .radius = 2.0f, .stddev = 0.5f},
        {.filter = FILTER_GAUSSIAN, .radius = 12.0f, .stddev = 3.0f}};
    enum { COUNT = 2000, STEPS = 4000 };
    for (int f = 0; f < 4; f++)
        for (int c = 0; c < 3; c++) {
            const float centre = (float[]){0.5f, 50.5f, 99.5f}[c];
            float at = centre + 0.3f * films[f].radius;
            double total = 0, left = 0;
            for (int i = 0; i < STEPS; i++) {
                float x = 100.0f * ((float)i + 0.5f) / STEPS;
                total += scene_film_filter_value(&films[f], x - centre);
                if (x < at) left += scene_film_filter_value(&films[f], x - centre);
            }
            int below = 0;
            for (int i = 0; i < COUNT; i++) {
                float u = ((float)i + 0.5f) / COUNT;
                float x = centre + scene_film_filter_sample(&films[f], centre, 0, 100, u);
                assert_true(x >= 0 && x < 100);
                below += x < at;
            }
            // The tolerance is one step of the sum and one sample.
            double slack = 100.0 / STEPS / films[f].radius + 1.0 / COUNT;
            assert_true(fabs((double)below / COUNT - left / total) < slack);
        }
}

static void filter_samples_stay_inside(void **state) {
    (void)state;
    const struct scene_film film = {.filter = FILTER_BOX, .radius = 0.5f};
    const float ends[] = {0.0f, 0.5f, 0x1.fffffep-1f};
    for (int i = 0; i < 3; i++) {
        float x = 4095.5f + scene_film_filter_sample(&film, 4095.5f, 4095, 4096, ends[i]);
        assert_true(x >= 4095 && x < 4096);
    }
}

// The values are those of Mitsuba 3.9.1 at 0, .5, 1.1, 1.5, 1.9 and 2.5.
static void lobes_agree_with_mitsuba(void **state) {
    (void)state;
    static const float at[6] = {0, .5f, 1.1f, 1.5f, 1.9f, 2.5f};
    static const struct {
        struct scene_film film;
        float value[6];
    } known[] = {
        {{.filter = FILTER_CUBIC, .radius = 2, .b = 1 / 3.f, .c = 1 / 3.f},
         {.8889f, .5347f, .0135f, -.0347f, -.0029f, 0}},
        {{.filter = FILTER_CUBIC, .radius = 2, .c = .5f},
         {1, .5625f, -.0405f, -.0625f, -.0045f, 0}},
        {{.filter = FILTER_LANCZOS, .radius = 3}, {1, .6079f, -.0709f, -.1351f, -.0238f, .0243f}},
        {{.filter = FILTER_LANCZOS, .radius = 2}, {1, .5732f, -.0511f, -.0637f, -.0027f, 0}}};
    for (int f = 0; f < 4; f++) {
        struct scene_film_filter filter;
        scene_film_filter_make(&known[f].film, &filter);
        float step = 2.0f * known[f].film.radius / FILM_FILTER_STEPS;
        for (int i = 0; i < 6; i++) {
            if (at[i] >= known[f].film.radius) continue;
            int k = (int)((at[i] + known[f].film.radius) / step);
            k = k > 0 ? k : 1;
            float slope = (filter.sum[k + 1] - filter.sum[k - 1]) / (2.0f * step);
            assert_float_equal(slope, known[f].value[i], 4e-3f);
        }
    }
}

// Weighted samples are distributed as the filter is, also where the window cuts it: their sums of
// 1 and of a test function are the integrals.
static void lobes_are_weighted(void **state) {
    (void)state;
    const struct scene_film films[] = {{.filter = FILTER_CUBIC, .radius = 2, .c = .5f},
                                       {.filter = FILTER_LANCZOS, .radius = 3}};
    enum { COUNT = 20000 };
    for (int f = 0; f < 2; f++) {
        struct scene_film_filter filter;
        scene_film_filter_make(&films[f], &filter);
        for (int c = 0; c < 3; c++) {
            const float centre = (float[]){0.5f, 50.5f, 98.5f}[c];
            double ones = 0.0, mean = 0.0, total = 0.0, exact = 0.0;
            int negative = 0;
            for (int i = 0; i < COUNT; i++) {
                float u = ((float)i + 0.5f) / COUNT;
                struct scene_film_offset o = scene_film_filter_offset(&filter, centre, 0, 100, u);
                assert_true(centre + o.x >= 0 && centre + o.x < 100);
                ones += (double)o.weight / COUNT;
                mean += (double)(o.weight * cosf(o.x + 0.3f)) / COUNT;
                negative += o.weight < 0.0f;
            }
            for (int i = 0; i < FILM_FILTER_STEPS; i++) {
                float x = films[f].radius * (2.0f * ((float)i + 0.5f) / FILM_FILTER_STEPS - 1.0f);
                if (centre + x < 0 || centre + x >= 100) continue;
                double value = (double)(filter.sum[i + 1] - filter.sum[i]);
                total += value;
                exact += value * (double)cosf(x + 0.3f);
            }
            assert_true(negative > COUNT / 40);
            assert_true(fabs(ones - 1.0) < 4e-3);
            assert_true(fabs(mean - exact / total) < 4e-3);
        }
    }
}

// Weighted samples of a widened filter have the integrals of the filter, also where the window cuts
// it, and twice as many of them are in an outermost half percent.
static void wide_filters_are_weighted(void **state) {
    (void)state;
    const struct scene_film films[] = {{.filter = FILTER_GAUSSIAN, .radius = 2, .stddev = .5f},
                                       {.filter = FILTER_TENT, .radius = 1}};
    enum { COUNT = 40000, OUTERMOST = COUNT / 200 };
    for (int f = 0; f < 2; f++) {
        struct scene_film_filter even, wide;
        scene_film_filter_make(&films[f], &even);
        wide = even;
        scene_film_filter_widen(&wide);
        for (int c = 0; c < 2; c++) {
            const float centre = (float[]){50.5f, 0.5f}[c],
                        end = even.inverse[FILM_FILTER_STEPS] - even.inverse[0];
            double ones = 0.0, mean = 0.0, exact = 0.0, tail = 0.0;
            float last = 0.0f;
            int found = 0;
            for (int i = 0; i < COUNT; i++) {
                const float u = ((float)i + 0.5f) / COUNT;
                const float x = scene_film_filter_offset(&even, centre, 0, 100, u).x;
                if (i == COUNT - OUTERMOST) last = x;
                exact += (double)cosf(x + 0.3f) / COUNT;
            }
            for (int i = 0; i < COUNT; i++) {
                const float u = ((float)i + 0.5f) / COUNT;
                const struct scene_film_offset o =
                    scene_film_filter_offset(&wide, centre, 0, 100, u);
                assert_true(o.weight >= 0.5f && o.weight <= 1.5f && fabsf(o.x) <= end);
                ones += (double)o.weight / COUNT;
                mean += (double)(o.weight * cosf(o.x + 0.3f)) / COUNT;
                if (o.x < last) continue;
                tail += (double)o.weight / OUTERMOST;
                found++;
            }
            assert_true(fabs(ones - 1.0) < 1e-4);
            assert_true(fabs(mean - exact) < 1e-4);
            assert_true(fabs(tail - 1.0) < 0.02);
            assert_in_range(found, 19 * OUTERMOST / 10, 2 * OUTERMOST);
        }
    }
}

// A box has no tails.
static void boxes_are_not_widened(void **state) {
    (void)state;
    const struct scene_film film = {.filter = FILTER_BOX, .radius = .5f};
    struct scene_film_filter filter;
    scene_film_filter_make(&film, &filter);
    scene_film_filter_widen(&filter);
    const struct scene_film_offset o = scene_film_filter_offset(&filter, 50.5f, 0, 100, .1f);
    assert_float_equal(o.x, -.4f, 1e-3f);
    assert_float_equal(o.weight, 1.0f, 0.0f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(filter_samples_are_distributed),
        cmocka_unit_test(filter_samples_stay_inside),
        cmocka_unit_test(wide_filters_are_weighted),
        cmocka_unit_test(boxes_are_not_widened),
        cmocka_unit_test(lobes_agree_with_mitsuba),
        cmocka_unit_test(lobes_are_weighted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
