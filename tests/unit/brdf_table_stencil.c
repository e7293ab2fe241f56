// SPDX-License-Identifier: Apache-2.0
// Interpolation of nodes of a table: cubic polynomials are exact, on both sides of an axis and
// beside what is not known.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "brdf/brdf_table.h"

enum { ORDER = 3, SIDE = 33, VALUES = ORDER * ORDER, NODES = SIDE * SIDE };

struct stencil_table {
    float c[NODES * VALUES], norm[NODES], error[NODES], sign[4 * VALUES];
    uint8_t order[NODES];
    struct brdf_table table;
    struct table_nodes nodes;
};

// A polynomial of degree 3 along each axis, with the symmetry of the coefficient of band l: even or
// odd in x and y.
static double polynomial(int l, int m, double x, double y) {
    const double even_x = 1.0 + l - 0.5 * x * x, odd_x = x * (0.3 + x * x);
    const double even_y = 0.7 + m * y * y, odd_y = y * (1.1 - y * y);
    const bool odd_in_x = m >= 0 ? m % 2 : m % 2 == 0;
    return (odd_in_x ? odd_x : even_x) * (m < 0 ? odd_y : even_y);
}

static void fill_coefficients(struct stencil_table *s, size_t node, float *c) {
    const struct table_position at = brdf_table_position(&s->table, node);
    for (int l = 0; l < ORDER; l++)
        for (int m = -l; m <= l; m++)
            *c++ = (float)polynomial(l, m, at.i / (double)SIDE, at.j / (double)SIDE);
}

// A quadrant whose nodes at multiples of 2 `step` are known.
static void stencil_table_make(struct stencil_table *s, int step) {
    memset(s, 0, sizeof *s);
    s->table = (struct brdf_table){.max_order = ORDER,
                                   .channels = 1,
                                   .side = SIDE,
                                   .nodes = NODES,
                                   .stride = VALUES,
                                   .values = VALUES,
                                   .c = s->c,
                                   .order = s->order};
    s->nodes = (struct table_nodes){&s->table, step, s->norm, s->error, {NULL}};
    for (int k = 0; k < 4; k++) s->nodes.sign[k] = s->sign + k * VALUES;
    brdf_table_signs(&s->nodes);
    for (size_t node = 0; node < NODES; node++) {
        const struct table_position at = brdf_table_position(&s->table, node);
        if (at.i % (2 * step) || at.j % (2 * step)) continue;
        fill_coefficients(s, node, s->c + node * VALUES);
        s->norm[node] = 2.0f;
        s->order[node] = ORDER;
    }
}

static struct table_stencil stencil_at(const struct stencil_table *s, int i, int j) {
    return brdf_table_stencil(&s->nodes, (struct table_position){i, j});
}

// The weights sum to 1, and no node has one twice unless it is mirrored; the sums of products of
// weights and of four polynomials are those at the node, but for rounding.
static void assert_exact(struct stencil_table *s, int i, int j) {
    float c[VALUES], want[VALUES];
    const struct table_stencil from = stencil_at(s, i, j);
    assert_true(from.complete && !from.refused);
    assert_true(fabsf(brdf_table_interpolate(&s->nodes, &from, c) - 2.0f) < 1e-5f);
    fill_coefficients(s, (size_t)j * SIDE + (size_t)i, want);
    for (int k = 0; k < VALUES; k++) assert_true(fabsf(c[k] - want[k]) < 2e-6f);
}

static void polynomials_are_exact(void **state) {
    (void)state;
    struct stencil_table s;
    for (int step = 1; step <= 2; step++) {
        stencil_table_make(&s, step);
        const int position[] = {0, step, 2 * step, 3 * step, 9 * step, 10 * step};
        for (int a = 0; a < 6; a++)
            for (int b = 0; b < 6; b++)
                if (position[a] / step % 2 || position[b] / step % 2)
                    assert_exact(&s, position[a], position[b]);
    }
}

static void other_sides_serve_where_nodes_are_missing(void **state) {
    (void)state;
    struct stencil_table s;
    stencil_table_make(&s, 1);
    assert_int_equal(stencil_at(&s, 31, 0).count, 4);
    assert_exact(&s, 31, 0);  // beside the boundary of the disk
    assert_exact(&s, 9, 25);
    for (int j = 0; j < SIDE; j++) {
        s.norm[j * SIDE + 12] = 0.0f;
        s.order[j * SIDE + 12] = 0;
    }
    assert_exact(&s, 9, 4);                        // nodes at 4 to 10 instead of 6 to 12
    assert_exact(&s, 15, 5);                       // 14 to 20
    assert_false(stencil_at(&s, 11, 4).complete);  // between 10 and 12
    assert_false(stencil_at(&s, 11, 4).refused);
    assert_true(stencil_at(&s, 12, 5).refused);
}

static void errors_of_the_next_coarser_grid_are_expected(void **state) {
    (void)state;
    struct stencil_table s;
    stencil_table_make(&s, 1);
    for (int node = 0; node < NODES; node++) s.error[node] = INFINITY;
    for (int j = 0; j < SIDE; j += 2)
        for (int i = 0; i < SIDE; i += 2)
            if (i % 4 || j % 4) s.error[j * SIDE + i] = i == 6 && j == 4 ? 0.8f : 0.08f;
    struct table_stencil from = stencil_at(&s, 15, 4);
    assert_true(fabsf(brdf_table_expected_error(&s.nodes, &from) - 0.01f) < 1e-6f);
    from = stencil_at(&s, 7, 5);
    assert_true(fabsf(brdf_table_expected_error(&s.nodes, &from) - 0.1f) < 1e-6f);
    s.norm[4 * SIDE + 6] = s.norm[4 * SIDE + 8] = 0.0f;
    from = stencil_at(&s, 7, 4);
    assert_true(isinf(brdf_table_expected_error(&s.nodes, &from)));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(polynomials_are_exact),
        cmocka_unit_test(other_sides_serve_where_nodes_are_missing),
        cmocka_unit_test(errors_of_the_next_coarser_grid_are_expected),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
