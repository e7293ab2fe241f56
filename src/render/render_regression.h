// SPDX-License-Identifier: Apache-2.0
// Private to render/: a linear regression of the light of pixels on the surfaces that they show.
#ifndef RENDER_REGRESSION_H
#define RENDER_REGRESSION_H

enum {
    REGRESSORS = 8,  // albedo, normal, depth, alpha
    REGRESSOR_DEPTH = 6,
    REGRESSION_LAYERS = 4,  // of light, those before SHADE_EMISSION
    REGRESSION_VALUES = 3 * REGRESSION_LAYERS,
    REGRESSION_MOST = 48,              // pixels
    REGRESSION_LEAST = REGRESSORS + 2  // those without which nothing is known
};

struct regression {
    // To be set: regressors x and values y of each pixel, and how much it counts.
    int count;
    float weight[REGRESSION_MOST], x[REGRESSION_MOST][REGRESSORS];
    float y[REGRESSION_MOST][REGRESSION_VALUES];
    // What follows from them.
    float sum, x_mean[REGRESSORS], y_mean[REGRESSION_VALUES];
    float least[REGRESSION_VALUES], most[REGRESSION_VALUES];
    float scale[REGRESSORS];                     // one over the deviation; 0: it does not vary
    float a[REGRESSORS][REGRESSORS];             // correlations
    float b[REGRESSORS][REGRESSION_VALUES];      // with the values
    float slope[REGRESSORS][REGRESSION_VALUES];  // of values by scaled regressors
    float reliance[REGRESSION_LAYERS];           // how far each layer's counts, from 0 to 1
    // The mean squared difference of each layer from what that predicts, summed over channels.
    float residual[REGRESSION_LAYERS];
};

// Fits REGRESSION_LEAST pixels or more, whose x and y it overwrites.
void render_regression_fit(struct regression *g);
// The change of the values where the regressors change by dx.
void render_regression_change(const struct regression *g, const float dx[REGRESSORS],
                              float change[REGRESSION_VALUES]);

#endif
