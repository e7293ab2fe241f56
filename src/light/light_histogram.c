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

vec3 light_histogram_sample(const struct light_histogram *histogram, float u, float v) {
    const int bin =
        (int)sample_cdf_cut(histogram->cdf, histogram->cut, LIGHT_HISTOGRAM_CUTS, u, &u);
    return light_histogram_direction(bin, u, v);
}

static int clamp_bin(float x) {
    const int i = (int)(x * LIGHT_HISTOGRAM_SIDE);
    return i < 0 ? 0 : i < LIGHT_HISTOGRAM_SIDE ? i : LIGHT_HISTOGRAM_SIDE - 1;
}

float light_histogram_pdf(const struct light_histogram *histogram, vec3 w) {
    const int bin =
        clamp_bin(0.5f - 0.5f * w.z) * LIGHT_HISTOGRAM_SIDE + clamp_bin(azimuth_fraction(w.y, w.x));
    return (histogram->cdf[bin + 1] - histogram->cdf[bin]) * (LIGHT_HISTOGRAM_BINS * 0.25f / PI_F);
}
