// SPDX-License-Identifier: Apache-2.0
// Directions by bins of equal solid angle: where an environment is seen.
#include "base/sampling.h"
#include "light/light_kinds.h"

vec3 light_window_direction(int bin, float u, float v) {
    return sample_uniform_sphere(sample_stratum(bin / LIGHT_WINDOW_SIDE, u, LIGHT_WINDOW_SIDE),
                                 sample_stratum(bin % LIGHT_WINDOW_SIDE, v, LIGHT_WINDOW_SIDE));
}

vec3 light_window_sample(const struct light_window *window, float u, float v) {
    const int bin = (int)sample_cdf(window->cdf, LIGHT_WINDOW_BINS, u, &u);
    return light_window_direction(bin, u, v);
}

static int within(float x) {
    const int i = (int)(x * LIGHT_WINDOW_SIDE);
    return i < 0 ? 0 : i < LIGHT_WINDOW_SIDE ? i : LIGHT_WINDOW_SIDE - 1;
}

float light_window_pdf(const struct light_window *window, vec3 w) {
    float azimuth = atan2f(w.y, w.x) * (0.5f / PI_F);
    if (azimuth < 0.0f) azimuth += 1.0f;
    const int bin = within(0.5f - 0.5f * w.z) * LIGHT_WINDOW_SIDE + within(azimuth);
    return (window->cdf[bin + 1] - window->cdf[bin]) * (LIGHT_WINDOW_BINS * 0.25f / PI_F);
}
