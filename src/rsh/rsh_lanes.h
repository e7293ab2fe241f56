// SPDX-License-Identifier: Apache-2.0
// Sixteen lanes, in one AVX-512 register or two AVX2 registers, with the permutations that rotation
// needs. A lane's index is 0 .. 15; the low half is lanes 0 .. 7.
#ifndef RSH_LANES_H
#define RSH_LANES_H

#include <immintrin.h>
#include <stdint.h>

#define LANES_INLINE static inline __attribute__((always_inline))

LANES_INLINE __m256 eight_reverse(__m256 v) {
    return _mm256_permutevar8x32_ps(v, _mm256_setr_epi32(7, 6, 5, 4, 3, 2, 1, 0));
}

#if defined(__AVX512F__)

typedef __m512 lanes;

LANES_INLINE lanes lanes_load(const float *p) { return _mm512_loadu_ps(p); }
LANES_INLINE lanes lanes_splat(float x) { return _mm512_set1_ps(x); }
LANES_INLINE lanes lanes_zero(void) { return _mm512_setzero_ps(); }
LANES_INLINE lanes lanes_add(lanes a, lanes b) { return _mm512_add_ps(a, b); }
LANES_INLINE lanes lanes_mul(lanes a, lanes b) { return _mm512_mul_ps(a, b); }
// a b + c, and c - a b.
LANES_INLINE lanes lanes_mad(lanes a, lanes b, lanes c) { return _mm512_fmadd_ps(a, b, c); }
LANES_INLINE lanes lanes_nmad(lanes a, lanes b, lanes c) { return _mm512_fnmadd_ps(a, b, c); }

// The low half of a and the high half of b.
LANES_INLINE lanes lanes_halves(lanes a, lanes b) { return _mm512_mask_mov_ps(a, 0xff00, b); }
// a in the lanes of the constant mask, b elsewhere.
#define lanes_choose(mask, a, b) \
    _mm512_mask_mov_ps(_mm512_set1_ps(b), (__mmask16)(mask), _mm512_set1_ps(a))

// Does what lanes_choose does, for vectors.
#define lanes_choose_of(mask, a, b) _mm512_mask_mov_ps(b, (__mmask16)(mask), a)
// Exchanges lanes 2 i and 2 i + 1. The next one is a b + c in odd lanes and a b - c in even ones.
LANES_INLINE lanes lanes_swap_pairs(lanes v) { return _mm512_permute_ps(v, 0xb1); }
LANES_INLINE lanes lanes_mad_sub(lanes a, lanes b, lanes c) { return _mm512_fmaddsub_ps(a, b, c); }

// Halves as registers of eight lanes, and eight numbers copied to both halves.
LANES_INLINE lanes lanes_pair(__m256 low, __m256 high) {
    return _mm512_insertf32x8(_mm512_castps256_ps512(low), high, 1);
}
LANES_INLINE __m256 lanes_low(lanes v) { return _mm512_castps512_ps256(v); }
LANES_INLINE __m256 lanes_high(lanes v) { return _mm512_extractf32x8_ps(v, 1); }
LANES_INLINE lanes lanes_twice(const float *p) {
    return _mm512_broadcast_f32x8(_mm256_loadu_ps(p));
}

// Loads the first or the last `count` of eight numbers, with 0 elsewhere. The stores write the same
// lanes.
LANES_INLINE __m256 eight_first(const float *p, int count) {
    return _mm256_maskz_loadu_ps((__mmask8)_bzhi_u32(0xff, (unsigned)count), p);
}
LANES_INLINE __m256 eight_last(const float *p, int count) {
    return _mm256_maskz_loadu_ps((__mmask8)~_bzhi_u32(0xff, (unsigned)(8 - count)), p);
}
LANES_INLINE void eight_store_first(float *p, int count, __m256 v) {
    _mm256_mask_storeu_ps(p, (__mmask8)_bzhi_u32(0xff, (unsigned)count), v);
}
LANES_INLINE void eight_store_last(float *p, int count, __m256 v) {
    _mm256_mask_storeu_ps(p, (__mmask8)~_bzhi_u32(0xff, (unsigned)(8 - count)), v);
}

typedef __m512i indices;
LANES_INLINE indices indices_load(const int32_t *p) { return _mm512_loadu_si512(p); }
// Keeps the compiler from reading the indices from memory again.
LANES_INLINE indices indices_held(indices p) {
    __asm__("" : "+v"(p));
    return p;
}
LANES_INLINE indices indices_next(indices p) { return _mm512_add_epi32(p, _mm512_set1_epi32(1)); }

// Lane i gets lane index[i] of v: within its own half (indices are modulo 8), from the other half,
// or from any lane.
LANES_INLINE lanes lanes_within(lanes v, indices p) { return _mm512_permutexvar_ps(p, v); }
LANES_INLINE lanes lanes_across(lanes v, indices p) { return _mm512_permutexvar_ps(p, v); }
LANES_INLINE lanes lanes_any(lanes v, indices p) { return _mm512_permutexvar_ps(p, v); }
// For a permutation of exchanged halves: lane i gets lane index[i] + 8 or - 8. These indices count
// as for `within` before they are converted to those of the opposite half.
LANES_INLINE indices indices_opposite(indices p) {
    return _mm512_xor_si512(p, _mm512_set1_epi32(8));
}
LANES_INLINE lanes lanes_opposite(lanes v, indices p) { return _mm512_permutexvar_ps(p, v); }

// Lane i gets in[index[i]], or 0 if index[i] >= count; count <= 32, index < 32.
struct lanes_source {
    __m512 low, high;
};
LANES_INLINE struct lanes_source lanes_source_of(const float *in, int count) {
    unsigned mask = _bzhi_u32(~0u, (unsigned)count);
    return (struct lanes_source){_mm512_maskz_loadu_ps((__mmask16)mask, in),
                                 _mm512_maskz_loadu_ps((__mmask16)(mask >> 16), in + 16)};
}
LANES_INLINE lanes lanes_gather(struct lanes_source s, indices p) {
    return _mm512_permutex2var_ps(s.low, p, s.high);
}

// out[k] = lane index[k] of a, or lane index[k] - 16 of b, for k < count <= 32.
LANES_INLINE void lanes_scatter(lanes a, lanes b, const int32_t *index, int count, float *out) {
    unsigned mask = _bzhi_u32(~0u, (unsigned)count);
    _mm512_mask_storeu_ps(out, (__mmask16)mask,
                          _mm512_permutex2var_ps(a, _mm512_loadu_si512(index), b));
    _mm512_mask_storeu_ps(out + 16, (__mmask16)(mask >> 16),
                          _mm512_permutex2var_ps(a, _mm512_loadu_si512(index + 16), b));
}

#else

typedef struct lanes {
    __m256 lo, hi;
} lanes;

LANES_INLINE lanes lanes_load(const float *p) {
    return (lanes){_mm256_loadu_ps(p), _mm256_loadu_ps(p + 8)};
}
LANES_INLINE lanes lanes_splat(float x) { return (lanes){_mm256_set1_ps(x), _mm256_set1_ps(x)}; }
LANES_INLINE lanes lanes_zero(void) { return (lanes){_mm256_setzero_ps(), _mm256_setzero_ps()}; }
LANES_INLINE lanes lanes_add(lanes a, lanes b) {
    return (lanes){_mm256_add_ps(a.lo, b.lo), _mm256_add_ps(a.hi, b.hi)};
}
LANES_INLINE lanes lanes_mul(lanes a, lanes b) {
    return (lanes){_mm256_mul_ps(a.lo, b.lo), _mm256_mul_ps(a.hi, b.hi)};
}
LANES_INLINE lanes lanes_mad(lanes a, lanes b, lanes c) {
    return (lanes){_mm256_fmadd_ps(a.lo, b.lo, c.lo), _mm256_fmadd_ps(a.hi, b.hi, c.hi)};
}
LANES_INLINE lanes lanes_nmad(lanes a, lanes b, lanes c) {
    return (lanes){_mm256_fnmadd_ps(a.lo, b.lo, c.lo), _mm256_fnmadd_ps(a.hi, b.hi, c.hi)};
}

LANES_INLINE lanes lanes_halves(lanes a, lanes b) { return (lanes){a.lo, b.hi}; }
#define lanes_choose(mask, a, b)                                                 \
    ((lanes){_mm256_blend_ps(_mm256_set1_ps(b), _mm256_set1_ps(a), (mask)&0xff), \
             _mm256_blend_ps(_mm256_set1_ps(b), _mm256_set1_ps(a), (mask) >> 8)})

#define lanes_choose_of(mask, a, b)                        \
    ((lanes){_mm256_blend_ps((b).lo, (a).lo, (mask)&0xff), \
             _mm256_blend_ps((b).hi, (a).hi, (mask) >> 8)})
LANES_INLINE lanes lanes_swap_pairs(lanes v) {
    return (lanes){_mm256_permute_ps(v.lo, 0xb1), _mm256_permute_ps(v.hi, 0xb1)};
}
LANES_INLINE lanes lanes_mad_sub(lanes a, lanes b, lanes c) {
    return (lanes){_mm256_fmaddsub_ps(a.lo, b.lo, c.lo), _mm256_fmaddsub_ps(a.hi, b.hi, c.hi)};
}

LANES_INLINE __m256i eight_mask(int count, __m256i index) {
    return _mm256_cmpgt_epi32(_mm256_set1_epi32(count), index);
}
LANES_INLINE __m256i first_mask(int count) {
    return eight_mask(count, _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
}
LANES_INLINE __m256i last_mask(int count) {
    return eight_mask(count, _mm256_setr_epi32(7, 6, 5, 4, 3, 2, 1, 0));
}
LANES_INLINE __m256 eight_first(const float *p, int count) {
    return _mm256_maskload_ps(p, first_mask(count));
}
LANES_INLINE __m256 eight_last(const float *p, int count) {
    return _mm256_maskload_ps(p, last_mask(count));
}
// Masked stores are slow on some processors, so whole rows are stored without a mask.
LANES_INLINE void eight_store_first(float *p, int count, __m256 v) {
    if (count == 8)
        _mm256_storeu_ps(p, v);
    else
        _mm256_maskstore_ps(p, first_mask(count), v);
}
LANES_INLINE void eight_store_last(float *p, int count, __m256 v) {
    if (count == 8)
        _mm256_storeu_ps(p, v);
    else
        _mm256_maskstore_ps(p, last_mask(count), v);
}

LANES_INLINE lanes lanes_pair(__m256 low, __m256 high) { return (lanes){low, high}; }
LANES_INLINE __m256 lanes_low(lanes v) { return v.lo; }
LANES_INLINE __m256 lanes_high(lanes v) { return v.hi; }
LANES_INLINE lanes lanes_twice(const float *p) {
    return (lanes){_mm256_loadu_ps(p), _mm256_loadu_ps(p)};
}

typedef struct indices {
    __m256i lo, hi;
} indices;
LANES_INLINE __m256i eight_indices(const int32_t *p) {
    return _mm256_loadu_si256((const __m256i *)(const void *)p);
}
LANES_INLINE indices indices_load(const int32_t *p) {
    return (indices){eight_indices(p), eight_indices(p + 8)};
}
// AVX2 has too few registers to hold tables.
LANES_INLINE indices indices_held(indices p) { return p; }
LANES_INLINE indices indices_next(indices p) {
    const __m256i one = _mm256_set1_epi32(1);
    return (indices){_mm256_add_epi32(p.lo, one), _mm256_add_epi32(p.hi, one)};
}

// The instruction uses only the low three bits of an index.
LANES_INLINE lanes lanes_within(lanes v, indices p) {
    return (lanes){_mm256_permutevar8x32_ps(v.lo, p.lo), _mm256_permutevar8x32_ps(v.hi, p.hi)};
}
LANES_INLINE indices indices_opposite(indices p) { return p; }
LANES_INLINE lanes lanes_opposite(lanes v, indices p) {
    return lanes_within((lanes){v.hi, v.lo}, p);
}
LANES_INLINE lanes lanes_across(lanes v, indices p) { return lanes_opposite(v, p); }
LANES_INLINE __m256 either(lanes v, __m256i index) {
    __m256 high = _mm256_castsi256_ps(_mm256_slli_epi32(index, 28));
    return _mm256_blendv_ps(_mm256_permutevar8x32_ps(v.lo, index),
                            _mm256_permutevar8x32_ps(v.hi, index), high);
}
LANES_INLINE lanes lanes_any(lanes v, indices p) {
    return (lanes){either(v, p.lo), either(v, p.hi)};
}

struct lanes_source {
    const float *in;
    __m256i count;
};
LANES_INLINE struct lanes_source lanes_source_of(const float *in, int count) {
    return (struct lanes_source){in, _mm256_set1_epi32(count)};
}
LANES_INLINE __m256 gather8(struct lanes_source s, __m256i index) {
    __m256 mask = _mm256_castsi256_ps(_mm256_cmpgt_epi32(s.count, index));
    return _mm256_mask_i32gather_ps(_mm256_setzero_ps(), s.in, index, mask, 4);
}
LANES_INLINE lanes lanes_gather(struct lanes_source s, indices p) {
    return (lanes){gather8(s, p.lo), gather8(s, p.hi)};
}

LANES_INLINE void lanes_scatter(lanes a, lanes b, const int32_t *index, int count, float *out) {
    float from[32];
    _mm256_storeu_ps(from, a.lo);
    _mm256_storeu_ps(from + 8, a.hi);
    _mm256_storeu_ps(from + 16, b.lo);
    _mm256_storeu_ps(from + 24, b.hi);
    for (int k = 0; k < count; k++) out[k] = from[index[k]];
}

#endif
#endif
