// SPDX-License-Identifier: Apache-2.0
// Vectors of the native width for the kernels. The build defines RSH_WIDTH, the number of lanes,
// and RSH_NAME, the suffix of all names of an instruction set.
#ifndef RSH_VECTOR_H
#define RSH_VECTOR_H

#include <stdint.h>
#include <string.h>

#include "rsh/rsh_inline.h"

#ifndef RSH_WIDTH
#define RSH_WIDTH 4
#define RSH_NAME native
#endif

#define TEXT2(a) #a
#define TEXT(a) TEXT2(a)

enum { W = RSH_WIDTH };

#if RSH_WIDTH == 1
typedef float vf;
#else
typedef float vf __attribute__((vector_size(4 * RSH_WIDTH)));
#endif

INLINE vf load(const float *p) {
    vf v;
    memcpy(&v, p, sizeof v);
    return v;
}

INLINE void store(float *p, vf v) { memcpy(p, &v, sizeof v); }

INLINE vf splat(float x) { return x - (vf){0}; }

#if RSH_WIDTH > 1
typedef int32_t vi __attribute__((vector_size(4 * RSH_WIDTH)));

INLINE vf magnitude(vf v) { return (vf)((vi)v & INT32_MAX); }

// v >= 0 with the sign of s.
INLINE vf with_sign(vf v, vf s) { return (vf)((vi)v | ((vi)s & INT32_MIN)); }
#endif

// v, with its magnitude raised to `least` if it is smaller.
INLINE vf lanes_at_least(vf v, float least) {
#if RSH_WIDTH == 1
    return v > least || v < -least ? v : least;
#else
    const vf floor = splat(least);
    const vi small = ((vi)v & INT32_MAX) < (vi)floor;
    return (vf)(((vi)v & ~small) | ((vi)floor & small));
#endif
}

// Keeps v in a register, although the compiler would read it from memory at every use.
#if defined(__x86_64__)
#define RSH_KEEP(v) __asm__("" : "+v"(v))
#else
#define RSH_KEEP(v) (void)(v)
#endif

// Adds halves lane by lane: the order of the sum depends on the width alone.
INLINE float sum_lanes(vf v) {
#if RSH_WIDTH == 16
    typedef float eight __attribute__((vector_size(32)));
    eight v8 = __builtin_shufflevector(v, v, 0, 1, 2, 3, 4, 5, 6, 7) +
               __builtin_shufflevector(v, v, 8, 9, 10, 11, 12, 13, 14, 15);
#elif RSH_WIDTH == 8
    vf v8 = v;
#endif
#if RSH_WIDTH >= 8
    typedef float four __attribute__((vector_size(16)));
    four v4 =
        __builtin_shufflevector(v8, v8, 0, 1, 2, 3) + __builtin_shufflevector(v8, v8, 4, 5, 6, 7);
#elif RSH_WIDTH == 4
    vf v4 = v;
#endif
#if RSH_WIDTH == 1
    return v;
#else
    return (v4[0] + v4[2]) + (v4[1] + v4[3]);
#endif
}

#if RSH_WIDTH > 1
typedef float quartet __attribute__((vector_size(16)));

INLINE quartet load_quartet(const float *p) {
    quartet v;
    memcpy(&v, p, sizeof v);
    return v;
}

// Lane i is the sum of the lanes of v[i], i < 4, in the order of sum_lanes.
INLINE quartet sum_four(const vf *v) {
    quartet t[4];
    for (int i = 0; i < 4; i++) {
        const float *p = (const float *)(v + i);
        t[i] = load_quartet(p);
        for (int k = 4; k < W; k += 4) t[i] += load_quartet(p + k);
    }
    const quartet a = __builtin_shufflevector(t[0], t[1], 0, 1, 4, 5) +
                      __builtin_shufflevector(t[0], t[1], 2, 3, 6, 7);
    const quartet b = __builtin_shufflevector(t[2], t[3], 0, 1, 4, 5) +
                      __builtin_shufflevector(t[2], t[3], 2, 3, 6, 7);
    return __builtin_shufflevector(a, b, 0, 2, 4, 6) + __builtin_shufflevector(a, b, 1, 3, 5, 7);
}
#endif

#endif
