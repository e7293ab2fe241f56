// SPDX-License-Identifier: Apache-2.0
// The regression by which light follows surfaces at edges (render_edges.c).
#include "render/render_regression.h"

#include <math.h>
#include <string.h>

#include "base/vec.h"

// The constants are measured in docs/experiments/edges.md.

// Added to the variance of each regressor, relative to it.
static const float RIDGE = 0.1f;
// A regressor that deviates by less than this does not vary; of depth, relative to it.
static const float VARIES_LEAST = 1e-3f;
// A regression counts as far as it explains more than this many times what noise would.
static const float EXPLAINED_LEAST = 4.0f;

static void take_means(struct regression *g) {
    g->sum = 0.0f;
    memset(g->x_mean, 0, sizeof g->x_mean);
    memset(g->y_mean, 0, sizeof g->y_mean);
    memcpy(g->least, g->y[0], sizeof g->least);
    memcpy(g->most, g->y[0], sizeof g->most);
    for (int i = 0; i < g->count; i++) {
        const float *x = g->x[i], *y = g->y[i], w = g->weight[i];
        g->sum += w;
        for (int k = 0; k < REGRESSORS; k++) g->x_mean[k] += w * x[k];
        for (int c = 0; c < REGRESSION_VALUES; c++) {
            g->y_mean[c] += w * y[c];
            g->least[c] = minf(y[c], g->least[c]);
            g->most[c] = maxf(y[c], g->most[c]);
        }
    }
    for (int k = 0; k < REGRESSORS; k++) g->x_mean[k] /= g->sum;
    for (int c = 0; c < REGRESSION_VALUES; c++) g->y_mean[c] /= g->sum;
}

// Subtracts the means, and scales the regressors.
static void normalize(struct regression *g) {
    float squares[REGRESSORS] = {0.0f};
    for (int i = 0; i < g->count; i++) {
        for (int c = 0; c < REGRESSION_VALUES; c++) g->y[i][c] -= g->y_mean[c];
        for (int k = 0; k < REGRESSORS; k++) {
            g->x[i][k] -= g->x_mean[k];
            squares[k] += g->weight[i] * g->x[i][k] * g->x[i][k];
        }
    }
    for (int k = 0; k < REGRESSORS; k++) {
        const float least = VARIES_LEAST * (k == REGRESSOR_DEPTH ? g->x_mean[k] : 1.0f),
                    deviation = sqrtf(squares[k] / g->sum);
        g->scale[k] = deviation > least ? 1.0f / deviation : 0.0f;
    }
    for (int i = 0; i < g->count; i++)
        for (int k = 0; k < REGRESSORS; k++) g->x[i][k] *= g->scale[k];
}

static void correlate(struct regression *g) {
    memset(g->a, 0, sizeof g->a);
    memset(g->b, 0, sizeof g->b);
    for (int i = 0; i < g->count; i++)
        for (int k = 0; k < REGRESSORS; k++) {
            const float wx = g->weight[i] / g->sum * g->x[i][k];
            for (int l = 0; l < REGRESSORS; l++) g->a[k][l] += wx * g->x[i][l];
            for (int c = 0; c < REGRESSION_VALUES; c++) g->b[k][c] += wx * g->y[i][c];
        }
}

// Solves (A + RIDGE) slope = B by the Cholesky decomposition.
static void solve(struct regression *g) {
    float c[REGRESSORS][REGRESSORS];
    for (int k = 0; k < REGRESSORS; k++)
        for (int l = 0; l <= k; l++) {
            float left = g->a[k][l] + (k == l ? RIDGE : 0.0f);
            for (int m = 0; m < l; m++) left -= c[k][m] * c[l][m];
            c[k][l] = k == l ? sqrtf(left) : left / c[l][l];
        }
    memcpy(g->slope, g->b, sizeof g->slope);
    for (int k = 0; k < REGRESSORS; k++) {
        for (int m = 0; m < k; m++)
            for (int v = 0; v < REGRESSION_VALUES; v++) g->slope[k][v] -= c[k][m] * g->slope[m][v];
        for (int v = 0; v < REGRESSION_VALUES; v++) g->slope[k][v] /= c[k][k];
    }
    for (int k = REGRESSORS - 1; k >= 0; k--) {
        for (int m = k + 1; m < REGRESSORS; m++)
            for (int v = 0; v < REGRESSION_VALUES; v++) g->slope[k][v] -= c[m][k] * g->slope[m][v];
        for (int v = 0; v < REGRESSION_VALUES; v++) g->slope[k][v] /= c[k][k];
    }
}

// Sets how far the regression of each layer counts, from 0 to 1: by its variance that the
// regressors explain, over what they would explain if it were noise.
static void find_reliance(struct regression *g) {
    float squares = 0.0f, explained[REGRESSION_VALUES] = {0.0f}, left[REGRESSION_VALUES] = {0.0f};
    for (int i = 0; i < g->count; i++) {
        squares += sqrf(g->weight[i]);
        for (int c = 0; c < REGRESSION_VALUES; c++)
            left[c] += g->weight[i] / g->sum * sqrf(g->y[i][c]);
    }
    for (int k = 0; k < REGRESSORS; k++) {
        float predicted[REGRESSION_VALUES] = {0.0f};
        for (int l = 0; l < REGRESSORS; l++)
            for (int c = 0; c < REGRESSION_VALUES; c++) predicted[c] += g->a[k][l] * g->slope[l][c];
        for (int c = 0; c < REGRESSION_VALUES; c++) {
            explained[c] += g->slope[k][c] * predicted[c];
            left[c] += g->slope[k][c] * (predicted[c] - 2.0f * g->b[k][c]);
        }
    }
    // The number of pixels that would be as many if all had equal weights.
    const float n = maxf(sqrf(g->sum) / squares, REGRESSORS + 2.0f);
    for (int k = 0; k < REGRESSION_LAYERS; k++) {
        const float whole = explained[3 * k] + explained[3 * k + 1] + explained[3 * k + 2],
                    noise = maxf(left[3 * k] + left[3 * k + 1] + left[3 * k + 2], 0.0f) *
                            REGRESSORS / (n - REGRESSORS - 1.0f);
        g->reliance[k] = whole > 0.0f ? maxf(1.0f - EXPLAINED_LEAST * noise / whole, 0.0f) : 0.0f;
    }
}

void render_regression_fit(struct regression *g) {
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
