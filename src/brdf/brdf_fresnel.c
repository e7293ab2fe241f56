// SPDX-License-Identifier: Apache-2.0
// The Fresnel terms that are too long to be inline, see brdf_fresnel.h.
#include "brdf/brdf_fresnel.h"

// With eta + i k and s = sin^2: the boundary has the reflectance of one of real index a + i b
// normal to it, where (a + i b)^2 = (eta + i k)^2 - s. The arrays have four lanes to fill a vector;
// lane 3 is unused.
rgb brdf_fresnel_conductor(float cos_i, rgb eta, rgb k) {
    const float n[4] = {eta.r, eta.g, eta.b, 1.0f}, kk[4] = {k.r, k.g, k.b, 0.0f};
    const float c2 = cos_i * cos_i, s2 = 1.0f - c2, s4 = s2 * s2;
    float r[4];
    for (int i = 0; i < 4; i++) {
        float real = n[i] * n[i] - kk[i] * kk[i] - s2, nk = 2.0f * n[i] * kk[i];
        float norm = sqrtf(real * real + nk * nk);  // a^2 + b^2
        float a = sqrtf(maxf(0.5f * (norm + real), 0.0f));
        float t1 = norm + c2, t2 = 2.0f * cos_i * a;
        float t3 = norm * c2 + s4, t4 = t2 * s2;
        // (s + p) / 2 with s = (t1 - t2) / (t1 + t2) and p = s (t3 - t4) / (t3 + t4).
        r[i] = (t1 - t2) * t3 / ((t1 + t2) * (t3 + t4));
    }
    return rgb_make(r[0], r[1], r[2]);
}

float brdf_fresnel_diffuse_mean(float eta) {
    float x = 1.0f / eta;
    if (eta < 1.0f) return 0.0636f * x + 0.6681f + eta * (0.7099f - 1.4399f * eta);
    return 0.919317f +
           x * (-3.4793f + x * (6.75335f + x * (-7.80989f + x * (4.98554f - 1.36881f * x))));
}
