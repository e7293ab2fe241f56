// SPDX-License-Identifier: Apache-2.0
// Visible-environment histograms: directions in bins of equal solid angle, drawn where a cell of
// the scene has found the environment visible.
#include "base/sampling.h"
#include "light/light_kinds.h"

vec3 light_histogram_direction(int bin, float u, float v) {
    return sample_uniform_sphere(
        sample_stratum(bin / LIGHT_HISTOGRAM_SIDE, u, LIGHT_HISTOGRAM_SIDE),
        sample_stratum(bin % LIGHT_HISTOGRAM_SIDE, v, LIGHT_HISTOGRAM_SIDE));
}

void light_bins_build(const float weight[LIGHT_HISTOGRAM_BINS], struct light_bins *out) {
    float sum[LIGHT_HISTOGRAM_SIDE];
    for (size_t row = 0; row < LIGHT_HISTOGRAM_SIDE; row++)
        sum[row] = (float)sample_cdf_build(weight + row * LIGHT_HISTOGRAM_SIDE,
                                           LIGHT_HISTOGRAM_SIDE, out->column[row]);
    sample_cdf_build(sum, LIGHT_HISTOGRAM_SIDE, out->row);
}

vec3 light_histogram_sample(const struct light_histogram *histogram, float u, float v) {
    const struct light_bins *bins = histogram->bins;
    const int row = (int)sample_cdf(bins->row, LIGHT_HISTOGRAM_SIDE, u, &u);
    const int column = (int)sample_cdf(bins->column[row], LIGHT_HISTOGRAM_SIDE, v, &v);
    return light_histogram_direction(row * LIGHT_HISTOGRAM_SIDE + column, u, v);
}

static int clamp_bin(float x) {
    const int i = (int)(x * LIGHT_HISTOGRAM_SIDE);
    return i < 0 ? 0 : i < LIGHT_HISTOGRAM_SIDE ? i : LIGHT_HISTOGRAM_SIDE - 1;
}

float light_histogram_pdf(const struct light_histogram *histogram, vec3 w) {
    const int row = clamp_bin(0.5f - 0.5f * w.z), column = clamp_bin(azimuth_fraction(w.y, w.x));
    const float *rows = histogram->bins->row, *columns = histogram->bins->column[row];
    return (rows[row + 1] - rows[row]) * (columns[column + 1] - columns[column]) *
           (LIGHT_HISTOGRAM_BINS * 0.25f / PI_F);
}
