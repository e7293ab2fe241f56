// SPDX-License-Identifier: Apache-2.0
// Rotation matrices band by band from the 3 x 3 matrix [Ivanic and Ruedenberg 1996, with the
// corrections of 1998], and the derivatives of the rotation about y by the same recurrence with the
// product rule [K05 C; errata 4 for its missing cases]. Kept as an independent form, and for
// derivatives of any order; rsh_rotate needs no matrices.
#include <math.h>
#include <string.h>

#include "rsh/rsh_kernel.h"

// The index at which the matrix of band l begins; its rows and columns are m = -l .. l.
static int block(int l) { return l * (2 * l - 1) * (2 * l + 1) / 3; }

int rsh_blocks_size(int order) { return rsh_order_ok(order) ? block(order) : 0; }

// One term of a row: factor times row i of R^1 times row m of band l - 1.
struct term {
    float factor;
    int i, m;
};

// The terms of row m of band l: the functions U, V and W of the papers with their coefficients. A
// term whose factor is 0 is left out, as its row may be outside the block.
static int terms_of(int l, int m, struct term *t) {
    const float *f = rsh_ivanic_row[l * (l + 1) + m], v = f[1], w = f[2];
    int count = 0;
    if (f[0] != 0.0f) t[count++] = (struct term){f[0], 0, m};
    if (m == 1 || m == -1) {
        t[count++] = (struct term){sqrtf(2.0f) * v, m, 0};
    } else if (m > 0) {
        t[count++] = (struct term){v, 1, m - 1};
        t[count++] = (struct term){-v, -1, 1 - m};
    } else {
        t[count++] = (struct term){v, 1, m + 1};
        t[count++] = (struct term){v, -1, -m - 1};
    }
    if (w == 0.0f) return count;
    int sign = m > 0 ? 1 : -1;
    t[count++] = (struct term){w, 1, m + sign};
    t[count++] = (struct term){sign > 0 ? w : -w, -1, -m - sign};
    return count;
}

// Adds factor times P of the papers to all columns of `row`. `first` is row i of R^1 and `last` the
// row of R^(l-1), each at its column 0.
static void add_term(int l, float factor, const float *first, const float *last, float *row) {
    float centre = factor * first[0], right = factor * first[1], left = factor * first[-1];
    for (int m = 1 - l; m < l; m++) row[m] += centre * last[m];
    row[l] += right * last[l - 1] - left * last[1 - l];
    row[-l] += right * last[1 - l] + left * last[l - 1];
}

// Fills bands 2 .. order - 1 of derivatives 0 .. highest; bands 0 and 1 are given. The k-th
// derivative of a product is the sum over p of k! / p! (k - p)! times the p-th derivative of one
// factor and the (k - p)-th of the other [K05 C, dT].
static void build_blocks(int order, int highest, float *blocks) {
    const ptrdiff_t step = block(order);
    for (int l = 2; l < order; l++) {
        const float *first = blocks + block(1) + 4, *scale = rsh_ivanic_column + l * (l + 1);
        const float *last = blocks + block(l - 1) + 2 * l * (l - 1);
        for (int m = -l; m <= l; m++) {
            struct term terms[5];
            int count = terms_of(l, m, terms);
            float *row = blocks + block(l) + (l + m) * (2 * l + 1) + l;
            for (int k = 0; k <= highest; k++, row += step) {
                memset(row - l, 0, (size_t)(2 * l + 1) * sizeof *row);
                for (int i = 0; i < count; i++) {
                    float factor = terms[i].factor;
                    for (int p = 0; p <= k; p++) {
                        add_term(l, factor, first + p * step + 3 * terms[i].i,
                                 last + (k - p) * step + terms[i].m * (2 * l - 1), row);
                        factor *= (float)(k - p) / (float)(p + 1);
                    }
                }
                for (int j = -l; j <= l; j++) row[j] *= scale[j];
            }
        }
    }
}

bool rsh_rotation_blocks(int order, const float r[9], float *blocks) {
    if (!rsh_order_ok(order) || !rsh_in_range(r, 9)) return false;
    blocks[0] = 1.0f;
    // Band 1 is (y, z, x). Entries are clamped to [-1, 1]: larger ones are from no rotation and
    // would overflow in high bands.
    static const int axis[3] = {1, 2, 0};
    for (int i = 0; i < 9 && order > 1; i++)
        blocks[1 + i] = fminf(fmaxf(r[3 * axis[i / 3] + axis[i % 3]], -1.0f), 1.0f);
    build_blocks(order, 0, blocks);
    return true;
}

bool rsh_rotation_y_derivatives(int order, float beta, int highest, float *blocks) {
    if (!rsh_order_ok(order) || !rsh_in_range(&beta, 1) || highest < 0) return false;
    const float c = cosf(beta), s = sinf(beta), quadrant[4] = {c, -s, -c, s};
    for (int k = 0; k <= highest; k++) {
        // R_y: y stays, z' = z cos - x sin, x' = z sin + x cos.
        float cosine = quadrant[k % 4], minus_sine = quadrant[(k + 1) % 4], still = k == 0;
        const float first[10] = {still, still, 0, 0, 0, cosine, minus_sine, 0, -minus_sine, cosine};
        int size = block(order);
        memcpy(blocks + k * size, first, (size_t)(size < 10 ? size : 10) * sizeof *first);
    }
    build_blocks(order, highest, blocks);
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
