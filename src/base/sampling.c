// SPDX-License-Identifier: Apache-2.0
// The sampling maps that are too long to be inline.
#include "base/sampling.h"

vec2 sample_disk(float u, float v) {
    float a = 2.0f * u - 1.0f, b = 2.0f * v - 1.0f;
    if (a == 0.0f && b == 0.0f) return (vec2){0.0f, 0.0f};
    float r, phi;
    if (fabsf(a) > fabsf(b)) {
        r = a;
        phi = (PI_F / 4.0f) * (b / a);
    } else {
        r = b;
        phi = PI_F / 2.0f - (PI_F / 4.0f) * (a / b);
    }
    return (vec2){r * cosf(phi), r * sinf(phi)};
}

vec2 sample_triangle(float u, float v) {
    float s = sqrtf(u);
    return (vec2){s * (1.0f - v), s * v};
}

double sample_cdf_build(const float *weight, size_t n, float *cdf) {
    double sum = 0.0;
    for (size_t i = 0; i < n; i++) sum += weight[i] > 0.0f ? (double)weight[i] : 0.0;
    double run = 0.0;
    cdf[0] = 0.0f;
    for (size_t i = 0; i < n; i++) {
        run += sum > 0.0 ? (weight[i] > 0.0f ? (double)weight[i] / sum : 0.0) : 1.0 / (double)n;
        cdf[i + 1] = (float)(run < 1.0 ? run : 1.0);
    }
    // The cdf is exactly 1 from the last item with a weight on, so that rounding leaves no interval
    // of u without an item.
    size_t last = n;
    while (last > 1 && sum > 0.0 && !(weight[last - 1] > 0.0f)) last--;
    for (size_t i = last; i <= n; i++) cdf[i] = 1.0f;
    return sum;
}

// The last of the items [lo, lo + count) whose cdf value is at most u, or lo.
static size_t find_item(const float *cdf, size_t lo, size_t count, float u) {
    // Without a conditional jump, because the outcome is random and half of the predictions would
    // be wrong.
    while (count > 1) {
        const size_t half = count / 2;
        lo += cdf[lo + half] <= u ? half : 0;
        count -= half;
    }
    return lo;
}

static float rest_within(const float *cdf, size_t i, float u) {
    const float width = cdf[i + 1] - cdf[i];
    const float rest = width > 0.0f ? (u - cdf[i]) / width : 0.5f;
    return clampf(rest, 0.0f, SAMPLE_BELOW_ONE);
}

size_t sample_cdf(const float *cdf, size_t n, float u, float *u_rest) {
    const size_t i = find_item(cdf, 0, n, u);
    if (u_rest) *u_rest = rest_within(cdf, i, u);
    return i;
}

void sample_cuts_build(const float *cdf, size_t n, size_t cuts, uint32_t *cut) {
    for (size_t i = 0; i <= cuts; i++)
        cut[i] = (uint32_t)find_item(cdf, 0, n, (float)i / (float)cuts);
}

size_t sample_cdf_cut(const float *cdf, const uint32_t *cut, size_t cuts, float u, float *u_rest) {
    const size_t at = (size_t)(u * (float)cuts), range = at < cuts ? at : cuts - 1;
    const size_t i = find_item(cdf, cut[range], cut[range + 1] - cut[range] + 1, u);
    *u_rest = rest_within(cdf, i, u);
    return i;
}

static uint32_t reverse_bits(uint32_t x) {
    x = __builtin_bswap32(x);
    x = ((x & 0x0f0f0f0fu) << 4) | ((x >> 4) & 0x0f0f0f0fu);
    x = ((x & 0x33333333u) << 2) | ((x >> 2) & 0x33333333u);
    return ((x & 0x55555555u) << 1) | ((x >> 1) & 0x55555555u);
}

// Owen scrambling of a bit-reversed value: each bit is flipped by a hash of the bits below it.
static uint32_t owen_reversed(uint32_t x, uint32_t seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

static uint32_t owen(uint32_t x, uint32_t seed) {
    return reverse_bits(owen_reversed(reverse_bits(x), seed));
}

static uint32_t hash32(uint32_t x) {
    x ^= x >> 16;
    x *= 0x21f0aaadu;
    x ^= x >> 15;
    x *= 0xd35a2d97u;
    return x ^ (x >> 15);
}

// The second Sobol' dimension, bits reversed: its generator matrix is Pascal's triangle modulo 2,
// so by Lucas' theorem bit k of the result is the sum of the index bits j whose binary digits
// contain those of k.
static uint32_t sobol_second_reversed(uint32_t i) {
    i ^= i >> 16;
    i ^= (i & 0xff00ff00u) >> 8;
    i ^= (i & 0xf0f0f0f0u) >> 4;
    i ^= (i & 0xccccccccu) >> 2;
    return i ^ ((i & 0xaaaaaaaau) >> 1);
}

static float unit_float(uint32_t x) { return (float)(x >> 8) * 0x1p-24f; }

vec2 sample_sobol2(uint32_t index, uint32_t seed) {
    uint32_t i = owen(index, hash32(seed ^ 0x9e3779b9u));
    uint32_t x = owen_reversed(i, hash32(seed ^ 0x7f4a7c15u));  // dimension 0 reversed is the index
    uint32_t y = owen_reversed(sobol_second_reversed(i), hash32(seed ^ 0x68e31da4u));
    return (vec2){unit_float(reverse_bits(x)), unit_float(reverse_bits(y))};
}

// Generator matrices of dimensions 2 and 3, column by column, bits reversed: from the polynomials
// x^2 + x + 1 and x^3 + x + 1 with the starting values 1, 3 and 1, 3, 1 of Joe and Kuo 2008.
static const uint32_t sobol_column[2][32] = {
    {0x00000001u, 0x00000003u, 0x00000006u, 0x00000009u, 0x00000017u, 0x0000003au, 0x00000071u,
     0x000000a3u, 0x00000116u, 0x00000339u, 0x00000677u, 0x000009aau, 0x00001601u, 0x00003903u,
     0x00007706u, 0x0000aa09u, 0x00010117u, 0x0003033au, 0x00060671u, 0x000909a3u, 0x00171616u,
     0x003a3939u, 0x00717777u, 0x00a3aaaau, 0x01170001u, 0x033a0003u, 0x06710006u, 0x09a30009u,
     0x16160017u, 0x3939003au, 0x77770071u, 0xaaaa00a3u},
    {0x00000001u, 0x00000003u, 0x00000004u, 0x0000000au, 0x0000001fu, 0x0000002eu, 0x00000045u,
     0x000000c9u, 0x0000011bu, 0x000002a4u, 0x0000079au, 0x00000b67u, 0x0000101eu, 0x0000302du,
     0x00004041u, 0x0000a0c3u, 0x0001f104u, 0x0002e28au, 0x000457dfu, 0x000c9baeu, 0x0011a105u,
     0x002a7289u, 0x0079e7dbu, 0x00b6dba4u, 0x0100011au, 0x030002a7u, 0x0400079eu, 0x0a000b6du,
     0x1f001001u, 0x2e003003u, 0x45004004u, 0xc900a00au}};

void sample_sobol4(uint32_t index, uint32_t seed, float u[4]) {
    uint32_t i = owen(index, hash32(seed ^ 0x9e3779b9u));
    uint32_t third = 0, fourth = 0;
    for (int b = 0; b < 32; b++) {
        uint32_t mask = -(i >> b & 1u);
        third ^= mask & sobol_column[0][b];
        fourth ^= mask & sobol_column[1][b];
    }
    uint32_t x[4] = {owen_reversed(i, hash32(seed ^ 0x7f4a7c15u)),
                     owen_reversed(sobol_second_reversed(i), hash32(seed ^ 0x68e31da4u)),
                     owen_reversed(third, hash32(seed ^ 0x3c6ef372u)),
                     owen_reversed(fourth, hash32(seed ^ 0x1b873593u))};
    for (int k = 0; k < 4; k++) u[k] = unit_float(reverse_bits(x[k]));
}

float sample_sobol1(uint32_t index, uint32_t seed) {
    uint32_t i = owen(index, hash32(seed ^ 0x9e3779b9u));
    return unit_float(reverse_bits(owen_reversed(i, hash32(seed ^ 0x7f4a7c15u))));
}
