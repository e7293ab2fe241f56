// SPDX-License-Identifier: Apache-2.0
// The Fresnel terms that are too long to be inline, see brdf_fresnel.h.
#include "brdf/brdf_fresnel.h"

#include <stdint.h>

// The three channels side by side; the fourth is unused.
typedef float channels __attribute__((vector_size(16)));
typedef int32_t channel_bits __attribute__((vector_size(16)));

// The square root, 0 of what is negative.
static channels root(channels x) {
    const channels y = (channels)((channel_bits)x & (x > 0.0f));
    return (channels){sqrtf(y[0]), sqrtf(y[1]), sqrtf(y[2]), sqrtf(y[3])};
}

// With eta + i k and s = sin^2: the boundary has the reflectance of one of real index a + i b
// normal to it, where (a + i b)^2 = (eta + i k)^2 - s.
rgb brdf_fresnel_conductor(float cos_i, rgb eta, rgb k) {
    const channels n = {eta.r, eta.g, eta.b, 1.0f}, kk = {k.r, k.g, k.b, 0.0f};
    const float c2 = cos_i * cos_i, s2 = 1.0f - c2, s4 = s2 * s2;
    const channels real = n * n - kk * kk - s2, nk = 2.0f * n * kk;
    const channels norm = root(real * real + nk * nk);  // a^2 + b^2
    const channels a = root(0.5f * (norm + real));
    const channels t1 = norm + c2, t2 = 2.0f * cos_i * a;
    const channels t3 = norm * c2 + s4, t4 = t2 * s2;
    // (s + p) / 2 with s = (t1 - t2) / (t1 + t2) and p = s (t3 - t4) / (t3 + t4).
    const channels r = (t1 - t2) * t3 / ((t1 + t2) * (t3 + t4));
    return rgb_make(r[0], r[1], r[2]);
}

float brdf_fresnel_diffuse_mean(float eta) {
    float x = 1.0f / eta;
    if (eta < 1.0f) return 0.0636f * x + 0.6681f + eta * (0.7099f - 1.4399f * eta);
    return 0.919317f +
           x * (-3.4793f + x * (6.75335f + x * (-7.80989f + x * (4.98554f - 1.36881f * x))));
}
