// SPDX-License-Identifier: Apache-2.0
// The regression by which light follows surfaces at edges (render_edges.c).
#include "render/render_regression.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "base/vec.h"
#include "base/wide.h"

// The constants are measured in docs/experiments/edges.md.

// Added to the variance of each regressor, relative to it.
static const float RIDGE = 0.1f;
// A regressor that deviates by less than this does not vary; of depth, relative to it.
static const float VARIES_LEAST = 1e-3f;
// A regression counts as far as it explains more than this many times what noise would.
static const float EXPLAINED_LEAST = 4.0f;

// Rows of regressors and of values as vectors, as compilers do not make them of such short loops.
typedef float eight __attribute__((vector_size(32), aligned(4), may_alias));
typedef float four __attribute__((vector_size(16), aligned(4), may_alias));
typedef int32_t eight_bits __attribute__((vector_size(32)));
typedef int32_t four_bits __attribute__((vector_size(16)));
_Static_assert(REGRESSORS == 8 && REGRESSION_VALUES == 12, "rows are eight, and eight and four");

WIDE_INLINE eight *as_eight(float *row) { return (eight *)row; }
WIDE_INLINE four *as_four(float *row) { return (four *)row; }

// Lets the values of a row limit those of `least` and `most`.
WIDE_INLINE void add_to_range(struct regression *g, float *row) {
    const eight y = *as_eight(row), low = *as_eight(g->least), high = *as_eight(g->most);
    const eight_bits below = y<low, above = y> high;
    *as_eight(g->least) = (eight)((below & (eight_bits)y) | (~below & (eight_bits)low));
    *as_eight(g->most) = (eight)((above & (eight_bits)y) | (~above & (eight_bits)high));
    const four z = *as_four(row + 8), less = *as_four(&g->least[8]), more = *as_four(&g->most[8]);
    const four_bits z_below = z<less, z_above = z> more;
    *as_four(&g->least[8]) = (four)((z_below & (four_bits)z) | (~z_below & (four_bits)less));
    *as_four(&g->most[8]) = (four)((z_above & (four_bits)z) | (~z_above & (four_bits)more));
}

WIDE_INLINE void take_means(struct regression *g) {
    eight x = {0.0f}, first = {0.0f};
    four last = {0.0f};
    g->sum = 0.0f;
    memcpy(g->least, g->y[0], sizeof g->least);
    memcpy(g->most, g->y[0], sizeof g->most);
    for (int i = 0; i < g->count; i++) {
        const float w = g->weight[i];
        g->sum += w;
        x += w * *as_eight(g->x[i]);
        first += w * *as_eight(g->y[i]);
        last += w * *as_four(&g->y[i][8]);
        add_to_range(g, g->y[i]);
    }
    *as_eight(g->x_mean) = x / g->sum;
    *as_eight(g->y_mean) = first / g->sum;
    *as_four(&g->y_mean[8]) = last / g->sum;
}

// Subtracts the means, and scales the regressors.
WIDE_INLINE void normalize(struct regression *g) {
    eight squares = {0.0f};
    for (int i = 0; i < g->count; i++) {
        *as_eight(g->y[i]) -= *as_eight(g->y_mean);
        *as_four(&g->y[i][8]) -= *as_four(&g->y_mean[8]);
        *as_eight(g->x[i]) -= *as_eight(g->x_mean);
        squares += g->weight[i] * *as_eight(g->x[i]) * *as_eight(g->x[i]);
    }
    for (int k = 0; k < REGRESSORS; k++) {
        const float least = VARIES_LEAST * (k == REGRESSOR_DEPTH ? g->x_mean[k] : 1.0f),
                    deviation = sqrtf(squares[k] / g->sum);
        g->scale[k] = deviation > least ? 1.0f / deviation : 0.0f;
    }
    for (int i = 0; i < g->count; i++) *as_eight(g->x[i]) *= *as_eight(g->scale);
}

// The sums of one regressor at a time, which fit in registers.
WIDE_INLINE void correlate(struct regression *g) {
    float part[REGRESSION_MOST];
    for (int i = 0; i < g->count; i++) part[i] = g->weight[i] / g->sum;
    for (int k = 0; k < REGRESSORS; k++) {
        eight a = {0.0f}, first = {0.0f};
        four last = {0.0f};
        for (int i = 0; i < g->count; i++) {
            const float wx = part[i] * g->x[i][k];
            a += wx * *as_eight(g->x[i]);
            first += wx * *as_eight(g->y[i]);
            last += wx * *as_four(&g->y[i][8]);
        }
        *as_eight(g->a[k]) = a;
        *as_eight(g->b[k]) = first;
        *as_four(&g->b[k][8]) = last;
    }
}

// Subtracts a row of values times a factor from another one.
WIDE_INLINE void subtract_row(float *to, const float *from, float factor) {
    *as_eight(to) -= factor * *(const eight *)from;
    *as_four(to + 8) -= factor * *(const four *)(from + 8);
}

WIDE_INLINE void divide_row(float *row, float by) {
    *as_eight(row) /= by;
    *as_four(row + 8) /= by;
}

// Solves (A + RIDGE) slope = B by the Cholesky decomposition.
WIDE_INLINE void solve(struct regression *g) {
    float c[REGRESSORS][REGRESSORS];
    for (int k = 0; k < REGRESSORS; k++)
        for (int l = 0; l <= k; l++) {
            float left = g->a[k][l] + (k == l ? RIDGE : 0.0f);
            for (int m = 0; m < l; m++) left -= c[k][m] * c[l][m];
            c[k][l] = k == l ? sqrtf(left) : left / c[l][l];
        }
    memcpy(g->slope, g->b, sizeof g->slope);
    for (int k = 0; k < REGRESSORS; k++) {
        for (int m = 0; m < k; m++) subtract_row(g->slope[k], g->slope[m], c[k][m]);
        divide_row(g->slope[k], c[k][k]);
    }
    for (int k = REGRESSORS - 1; k >= 0; k--) {
        for (int m = k + 1; m < REGRESSORS; m++) subtract_row(g->slope[k], g->slope[m], c[m][k]);
        divide_row(g->slope[k], c[k][k]);
    }
}

WIDE_INLINE float sum_channels(const float *value, int layer) {
    return value[3 * layer] + value[3 * layer + 1] + value[3 * layer + 2];
}

// The mean square of y - reliance * p, of values y and predictions p, by the means of y^2, of y p
// and of p^2.
WIDE_INLINE float squared_rest(float y2, float yp, float p2, float reliance) {
    return maxf(y2 + reliance * (reliance * p2 - 2.0f * yp), 0.0f);
}

// Sets how far the regression of each layer counts, from 0 to 1: by its variance that the
// regressors explain, over what they would explain if it were noise; and what that leaves.
WIDE_INLINE void find_reliance(struct regression *g) {
    float squares = 0.0f, explained[REGRESSION_VALUES] = {0.0f}, all[REGRESSION_VALUES],
          common[REGRESSION_VALUES] = {0.0f};  // with what is predicted
    eight first = {0.0f};
    four last = {0.0f};
    for (int i = 0; i < g->count; i++) {
        const float part = g->weight[i] / g->sum;
        squares += sqrf(g->weight[i]);
        first += part * (*as_eight(g->y[i]) * *as_eight(g->y[i]));
        last += part * (*as_four(&g->y[i][8]) * *as_four(&g->y[i][8]));
    }
    *as_eight(all) = first;
    *as_four(&all[8]) = last;
    for (int k = 0; k < REGRESSORS; k++) {
        float predicted[REGRESSION_VALUES] = {0.0f};
        for (int l = 0; l < REGRESSORS; l++) subtract_row(predicted, g->slope[l], -g->a[k][l]);
        for (int c = 0; c < REGRESSION_VALUES; c++) {
            explained[c] += g->slope[k][c] * predicted[c];
            common[c] += g->slope[k][c] * g->b[k][c];
        }
    }
    // The number of pixels that would be as many if all had equal weights.
    const float n = maxf(sqrf(g->sum) / squares, REGRESSORS + 2.0f);
    for (int k = 0; k < REGRESSION_LAYERS; k++) {
        const float whole = sum_channels(explained, k),
                    left = squared_rest(sum_channels(all, k), sum_channels(common, k), whole, 1.0f),
                    noise = left * REGRESSORS / (n - REGRESSORS - 1.0f),
                    reliance =
                        whole > 0.0f ? maxf(1.0f - EXPLAINED_LEAST * noise / whole, 0.0f) : 0.0f;
        g->reliance[k] = reliance;
        g->residual[k] =
            squared_rest(sum_channels(all, k), sum_channels(common, k), whole, reliance);
    }
}

WIDE void render_regression_fit(struct regression *g) {
    take_means(g);
    normalize(g);
    correlate(g);
    solve(g);
    find_reliance(g);
}

void render_regression_change(const struct regression *g, const float dx[REGRESSORS],
                              float change[REGRESSION_VALUES]) {
    memset(change, 0, REGRESSION_VALUES * sizeof *change);
    for (int k = 0; k < REGRESSORS; k++)
        for (int c = 0; c < REGRESSION_VALUES; c++)
            change[c] += dx[k] * g->scale[k] * g->slope[k][c];
    for (int c = 0; c < REGRESSION_VALUES; c++) change[c] *= g->reliance[c / 3];
}
