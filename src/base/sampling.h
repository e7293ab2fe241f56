// SPDX-License-Identifier: Apache-2.0
// Maps from the unit square to directions and points, with their densities, and low-discrepancy
// points. `u` and `v` are in [0, 1). Hemispheres are about +z.
#ifndef BASE_SAMPLING_H
#define BASE_SAMPLING_H

#include <stddef.h>
#include <stdint.h>

#include "base/vec.h"

// The largest number below 1, for results that would round to 1.
#define SAMPLE_BELOW_ONE 0x1.fffffep-1f

// A number in stratum j of n >= 1 strata of [0, 1): (j + u) / n for u in [0, 1), but never 1, to
// which the last stratum would round once in some ten thousand samples.
static inline float sample_stratum(int j, float u, int n) {
    return minf(((float)j + u) / (float)n, SAMPLE_BELOW_ONE);
}

// For u in [p, 1), where p < 1 is the probability of the other choice: u rescaled to [0, 1), and
// never 1, to which the quotient would round once in some ten million samples.
static inline float sample_rest(float u, float p) {
    return minf((u - p) / (1.0f - p), SAMPLE_BELOW_ONE);
}

// Density cos(theta) / pi.
static inline vec3 sample_cosine_hemisphere(float u, float v) {
    float r = sqrtf(u), phi = 2.0f * PI_F * v;
    return v3(r * cosf(phi), r * sinf(phi), safe_sqrtf(1.0f - u));
}

// Density 1 / (2 pi).
static inline vec3 sample_uniform_hemisphere(float u, float v) {
    float s = safe_sqrtf(1.0f - u * u), phi = 2.0f * PI_F * v;
    return v3(s * cosf(phi), s * sinf(phi), u);
}

// Density 1 / (4 pi).
static inline vec3 sample_uniform_sphere(float u, float v) {
    float z = 1.0f - 2.0f * u, s = safe_sqrtf(1.0f - z * z), phi = 2.0f * PI_F * v;
    return v3(s * cosf(phi), s * sinf(phi), z);
}

// In the cone about z whose half angle has this versine, 1 - cosine. The sine is accurate for the
// narrowest cones too, as no cosine near 1 is squared. Density 1 / (2 pi versine).
static inline vec3 sample_uniform_cone(float u, float v, float versine) {
    const float away = u * versine, sine = safe_sqrtf(away * (2.0f - away)), phi = 2.0f * PI_F * v;
    return v3(sine * cosf(phi), sine * sinf(phi), 1.0f - away);
}

// Uniform in the unit disk by the concentric map (Shirley and Chiu 1997); density 1 / pi.
vec2 sample_disk(float u, float v);

// Barycentric coordinates (b1, b2), uniform over a triangle.
vec2 sample_triangle(float u, float v);

// A discrete distribution over n >= 1 items: cdf[n + 1] ascends from 0 to 1. Fills `cdf` from
// weights (negative ones and NaN count as 0; if all are zero, the distribution is uniform) and
// returns the sum of the weights.
double sample_cdf_build(const float *weight, size_t n, float *cdf);
// The index i with cdf[i] <= u < cdf[i + 1], whose probability is never 0. *u_rest (may be NULL) is
// set to u rescaled to [0, 1) within the item.
size_t sample_cdf(const float *cdf, size_t n, float u, float *u_rest);
// For long distributions: cut[i] is the item that is drawn at i / cuts, which shortens the search.
// `cut` has cuts + 1 entries; cuts is a power of two. sample_cdf_cut returns what sample_cdf
// returns.
void sample_cuts_build(const float *cdf, size_t n, size_t cuts, uint32_t *cut);
size_t sample_cdf_cut(const float *cdf, const uint32_t *cut, size_t cuts, float u, float *u_rest);

// MIS weight of a technique with density a against one with density b: the power heuristic
// [Veach 1997, 9.2.4]. Infinite a gives 1; both 0 gives 0.
static inline float mis_power(float a, float b) {
    if (!(a > 0.0f)) return 0.0f;
    float q = b / a;
    return 1.0f / (1.0f + q * q);
}

// Point `index` of Sobol' dimensions 0 and 1, Owen-scrambled by hashing (Laine and Karras 2011 with
// Burley's 2020 constants), its order shuffled, all by `seed`. Any aligned run of 2^k points is a
// (0, k, 2)-net; different seeds give independent sequences. Both coordinates are in [0, 1).
vec2 sample_sobol2(uint32_t index, uint32_t seed);
// As sample_sobol2 in dimensions 0 to 3, for paths, which is a little slower. Aligned runs are nets
// of quality t = 3.
void sample_sobol4(uint32_t index, uint32_t seed, float u[4]);
// Does what sample_sobol2 does, in one dimension.
float sample_sobol1(uint32_t index, uint32_t seed);

// A stream of such points for one sample of one pixel or record. Each call uses a new pair of
// dimensions, padded from 2-D sequences, so every pair is stratified over the samples of the pixel.
struct sampler {
    uint32_t index;      // number of the sample
    uint32_t seed;       // of the pixel
    uint32_t dimension;  // counts calls
};

static inline uint32_t sampler_seed(struct sampler *s) {
    return s->seed ^ (0x9e3779b9u * ++s->dimension);
}
static inline vec2 sampler_2d(struct sampler *s) {
    return sample_sobol2(s->index, sampler_seed(s));
}
static inline float sampler_1d(struct sampler *s) {
    return sample_sobol1(s->index, sampler_seed(s));
}

#endif
