// SPDX-License-Identifier: Apache-2.0
// Rotation matrices band by band from the 3 x 3 matrix [Ivanic and Ruedenberg 1996, with the
// corrections of 1998], and the derivatives of the rotation about y by the same recurrence with the
// product rule [K05 C; errata 4 for its missing cases]. Kept as an independent form and for
// derivatives of any order; rsh_rotate needs no matrices.
#include <math.h>
#include <string.h>

#include "rsh/rsh_kernel.h"

// Matrices of band l begin at block(l), rows and columns m = -l .. l.
static int block(int l) { return l * (2 * l - 1) * (2 * l + 1) / 3; }

int rsh_blocks_size(int order) { return rsh_order_ok(order) ? block(order) : 0; }

// Derivatives 0 .. highest of one entry: the k-th is `step` numbers after the one before.
struct recurrence {
    int highest;
    ptrdiff_t step;
    const float *first;  // band 1: entry (0, 0)
    const float *last;   // band l - 1: entry (0, 0)
    int l;
};

// The k-th derivative of R^1_ij R^(l-1)_ab.
static float product(const struct recurrence *a, int k, int i, int j, int m1, int m2) {
    const float *f = a->first + 3 * i + j, *g = a->last + m1 * (2 * a->l - 1) + m2;
    float sum = 0.0f, choose = 1.0f;
    for (int p = 0; p <= k; p++) {
        sum += choose * f[p * a->step] * g[(k - p) * a->step];
        choose = choose * (float)(k - p) / (float)(p + 1);
    }
    return sum;
}

// dP of [K05 C], all three cases.
static float part(const struct recurrence *a, int k, int i, int m1, int m2) {
    int l = a->l;
    if (m2 == l) return product(a, k, i, 1, m1, l - 1) - product(a, k, i, -1, m1, 1 - l);
    if (m2 == -l) return product(a, k, i, 1, m1, 1 - l) + product(a, k, i, -1, m1, l - 1);
    return product(a, k, i, 0, m1, m2);
}

static float part_v(const struct recurrence *a, int k, int m1, int m2) {
    if (m1 > 1) return part(a, k, 1, m1 - 1, m2) - part(a, k, -1, 1 - m1, m2);
    if (m1 == 1) return sqrtf(2.0f) * part(a, k, 1, 0, m2);
    if (m1 == 0) return part(a, k, 1, 1, m2) + part(a, k, -1, -1, m2);
    if (m1 == -1) return sqrtf(2.0f) * part(a, k, -1, 0, m2);
    return part(a, k, 1, m1 + 1, m2) + part(a, k, -1, -m1 - 1, m2);
}

static float part_w(const struct recurrence *a, int k, int m1, int m2) {
    if (m1 > 0) return part(a, k, 1, m1 + 1, m2) + part(a, k, -1, -m1 - 1, m2);
    return part(a, k, 1, m1 - 1, m2) - part(a, k, -1, 1 - m1, m2);
}

// The coefficients u, v and w are a factor of the row, rsh_ivanic_row, times one of the column. A
// term with factor 0 is left out: its indices leave the block.
static float entry(const struct recurrence *a, int k, int m1, int m2) {
    int row = a->l * (a->l + 1) + m1, column = a->l * (a->l + 1) + m2;
    const float *f = rsh_ivanic_row[row];
    float sum = f[1] * part_v(a, k, m1, m2);
    if (f[0] != 0.0f) sum += f[0] * part(a, k, 0, m1, m2);
    if (f[2] != 0.0f) sum += f[2] * part_w(a, k, m1, m2);
    return rsh_ivanic_column[column] * sum;
}

// Fills bands 2 .. order - 1 of derivatives 0 .. highest, `step` numbers each; bands 0 and 1 stand.
static void build(int order, int highest, float *blocks) {
    struct recurrence a = {
        .highest = highest, .step = block(order), .first = blocks + block(1) + 4};
    for (a.l = 2; a.l < order; a.l++) {
        int l = a.l, size = 2 * l + 1;
        a.last = blocks + block(l - 1) + (l - 1) * (2 * l - 1) + l - 1;
        for (int k = 0; k <= highest; k++) {
            float *middle = blocks + k * a.step + block(l) + l * size + l;
            for (int m1 = -l; m1 <= l; m1++)
                for (int m2 = -l; m2 <= l; m2++) middle[m1 * size + m2] = entry(&a, k, m1, m2);
        }
    }
}

bool rsh_rotation_blocks(int order, const float r[9], float *blocks) {
    if (!rsh_order_ok(order) || !rsh_all_finite(r, 9)) return false;
    blocks[0] = 1.0f;
    // Band 1 is (y, z, x).
    static const int axis[3] = {1, 2, 0};
    for (int i = 0; i < 9 && order > 1; i++) blocks[1 + i] = r[3 * axis[i / 3] + axis[i % 3]];
    build(order, 0, blocks);
    return true;
}

bool rsh_rotation_y_derivatives(int order, float beta, int highest, float *blocks) {
    if (!rsh_order_ok(order) || !isfinite(beta) || highest < 0) return false;
    const float c = cosf(beta), s = sinf(beta), turn[4] = {c, -s, -c, s};
    for (int k = 0; k <= highest; k++) {
        // R_y: y stays, z' = z cos - x sin, x' = z sin + x cos.
        float cosine = turn[k % 4], minus_sine = turn[(k + 1) % 4], still = k == 0;
        const float first[10] = {still, still, 0, 0, 0, cosine, minus_sine, 0, -minus_sine, cosine};
        int size = block(order);
        memcpy(blocks + k * size, first, (size_t)(size < 10 ? size : 10) * sizeof *first);
    }
    build(order, highest, blocks);
    return true;
}

bool rsh_apply_blocks(int order, int channels, const float *blocks, const float *in, float *out) {
    if (!rsh_order_ok(order)) return false;
    for (int c = 0; c < channels; c++) {
        const float *row = blocks;
        for (int l = 0; l < order; l++) {
            int size = 2 * l + 1;
            float v[2 * RSH_MAX_ORDER - 1];
            memcpy(v, in, (size_t)size * sizeof *v);
            for (int i = 0; i < size; i++, row += size) {
                float sum = 0.0f;
                for (int j = 0; j < size; j++) sum += row[j] * v[j];
                out[i] = sum;
            }
            in += size;
            out += size;
        }
    }
    return true;
}

bool rsh_rotate_ivanic(int order, int channels, const float r[9], const float *in, float *out) {
    float blocks[RSH_MAX_BLOCKS];
    return rsh_rotation_blocks(order, r, blocks) &&
           rsh_apply_blocks(order, channels, blocks, in, out);
}
