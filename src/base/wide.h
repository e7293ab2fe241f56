// SPDX-License-Identifier: Apache-2.0
// Loops over arrays that are compiled twice, once for processors with AVX2, which is chosen when
// the program starts. Either way the bits are the same, as no operations are contracted or
// reordered (meson.build).
#ifndef BASE_WIDE_H
#define BASE_WIDE_H

#if defined(__x86_64__) && defined(__gnu_linux__)
#define WIDE __attribute__((target_clones("default", "avx2")))
#else
#define WIDE
#endif

// What such a function calls has to be a part of it.
#define WIDE_INLINE static inline __attribute__((always_inline))

#endif
