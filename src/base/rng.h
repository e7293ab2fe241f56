// SPDX-License-Identifier: Apache-2.0
// Random numbers from a counter: (seed, stream, item, dimension) -> number. The state is a value on
// the stack, so the numbers of an item depend on its index alone, on any thread.
#ifndef BASE_RNG_H
#define BASE_RNG_H

#include <stdint.h>

// Each use of random numbers has its own stream, so that no two of them use the same numbers.
// Images depend on the values; 9 is free.
enum rng_stream {
    RNG_PHOTON = 1,
    RNG_GATHER,
    RNG_GATHER_HIT,
    RNG_PIXEL,
    RNG_HAIR,
    RNG_FEATURE,
    RNG_PATH = 7,
    RNG_SITE,
    RNG_TEST = 10,
    RNG_CAUSTIC,
    RNG_EMISSION,
    RNG_SEEN,
    RNG_BOUNCE,
    RNG_ALLOCATION,
    RNG_CELL,
    RNG_VISIBILITY,
    RNG_SMOOTH,
    RNG_RIM,
    RNG_BOX,
    RNG_RECORD_TEST,
    RNG_DIVIDE,
    RNG_LOOKUP,
    RNG_REFINE,
    RNG_OPENING
};

struct rng {
    uint64_t key;
    uint64_t counter;
};

// 2^64 over the golden ratio, as an odd number: its multiples are distributed equally over all 64
// bits (Steele et al. 2014; Knuth 1973, 6.4).
#define RNG_GOLDEN 0x9e3779b97f4a7c15ull

// The finaliser of splitmix64 (Steele et al. 2014): a bijection that mixes every bit into every
// other.
static inline uint64_t rng_mix(uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
}

static inline struct rng rng_make(uint64_t seed, enum rng_stream stream, uint64_t item) {
    uint64_t k = rng_mix(seed + RNG_GOLDEN * (uint64_t)stream);
    return (struct rng){rng_mix(k ^ rng_mix(item + 0x632be59bd9b4e019ull)), 0};
}

static inline uint32_t rng_u32(struct rng *r) {
    return (uint32_t)(rng_mix(r->key + RNG_GOLDEN * ++r->counter) >> 32);
}

// Uniform in [0, 1), 24 bits.
static inline float rng_float(struct rng *r) { return (float)(rng_u32(r) >> 8) * 0x1p-24f; }

// Uniform in [0, 1), 53 bits.
static inline double rng_double(struct rng *r) {
    return (double)(rng_mix(r->key + RNG_GOLDEN * ++r->counter) >> 11) * 0x1p-53;
}

#endif
