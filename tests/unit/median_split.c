// SPDX-License-Identifier: Apache-2.0
// Median splits: halves are equal in number, separate along the longest axis, and hold the same
// points for any last digit of points in one plane.
#include "base/median_split.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "base/sampling.h"

enum { MOST = 1001 };

static void median_split_put(struct split_point *point, size_t i, vec3 p) {
    point[i] = (struct split_point){.p = p, .item = (uint32_t)i};
}

// The points are in a box that is longest along y, from 1 to a thousand of them.
static void halves_of_a_split_are_apart(void **state) {
    (void)state;
    static struct split_point point[MOST];
    for (size_t count = 1; count <= MOST; count += 1 + count / 3) {
        for (size_t i = 0; i < count; i++) {
            const vec2 u = sample_sobol2((uint32_t)i, 1), v = sample_sobol2((uint32_t)i, 2);
            median_split_put(point, i, v3(u.x, 3.0f * u.y, 2.0f * v.x));
        }
        const struct split_plane border = median_split(point, count);
        assert_true(count < 16 || border.n.y == 1.0f);
        uint64_t items = 0;
        for (size_t i = 0; i < count; i++) {
            const float at = v3_dot(border.n, point[i].p);
            assert_true(i < count / 2 ? at <= border.at : at >= border.at);
            assert_true(i != count / 2 || at == border.at);
            items += point[i].item;
        }
        assert_int_equal(items, (uint64_t)count * (count - 1) / 2);
    }
}

// Three quarters of the points lie in a plane across the longest axis, with and without rounding;
// the same ones are below.
static void walls_are_cut_into_pieces(void **state) {
    (void)state;
    enum { COUNT = 1000 };
    static struct split_point point[COUNT];
    static bool below[2][COUNT];
    for (int rounded = 0; rounded < 2; rounded++) {
        for (size_t i = 0; i < COUNT; i++) {
            const vec2 u = sample_sobol2((uint32_t)i, 1);
            const float noise = rounded ? 1e-7f * sample_sobol1((uint32_t)i, 2) : 0.0f;
            const float x = i % 4 == 0 ? 2.0f * (float)i / COUNT : 0.3f + noise;
            median_split_put(point, i, v3(x, u.x, 0.5f * u.y));
        }
        median_split(point, COUNT);
        for (size_t i = 0; i < COUNT / 2; i++) below[rounded][point[i].item] = true;
    }
    int changed = 0;
    for (size_t i = 0; i < COUNT; i++) changed += below[0][i] != below[1][i];
    assert_true(changed <= 2);
}

static void points_at_one_position_are_harmless(void **state) {
    (void)state;
    struct split_point point[9];
    for (size_t i = 0; i < 9; i++) median_split_put(point, i, v3(1.0f, 2.0f, 3.0f));
    assert_true(median_split(point, 9).at == v3_dot(median_split(point, 9).n, point->p));
}

// Random points, and points of which many have the same key.
static void threads_do_not_change_a_split(void **state) {
    (void)state;
    static const size_t counts[] = {1, 2, 9000, 40000, 131072, 250001};
    struct parallel *pool = parallel_new(3);
    for (size_t k = 0; k < 2 * sizeof counts / sizeof *counts; k++) {
        const size_t count = counts[k / 2];
        struct split_point *one = calloc(count, sizeof *one), *all = calloc(count, sizeof *all);
        uint32_t *scratch = calloc(2 * count, sizeof *scratch);
        for (size_t i = 0; i < count; i++) {
            const float x = sample_sobol1((uint32_t)i, 1);
            const vec2 u = sample_sobol2((uint32_t)i, 2);
            median_split_put(one, i, v3(k & 1 ? 3.0f * floorf(8.0f * x) : 3.0f * x, u.x, u.y));
            if (k & 1) one[i].p.y = one[i].p.z = 0.0f;
            all[i] = one[i];
        }
        median_split(one, count);
        assert_true(median_split_parallel(all, count, scratch, pool));
        assert_memory_equal(one, all, count * sizeof *one);
        free(scratch);
        free(all);
        free(one);
    }
    parallel_free(pool);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_do_not_change_a_split),
        cmocka_unit_test(halves_of_a_split_are_apart),
        cmocka_unit_test(walls_are_cut_into_pieces),
        cmocka_unit_test(points_at_one_position_are_harmless),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
