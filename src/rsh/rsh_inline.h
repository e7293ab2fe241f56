// SPDX-License-Identifier: Apache-2.0
// Private to rsh/: macros of the files that are compiled once per instruction set.
#ifndef RSH_INLINE_H
#define RSH_INLINE_H

// Joins two names after their macros are expanded.
#define GLUE2(a, b) a##b
#define GLUE(a, b) GLUE2(a, b)

// Kernels are fast only if the compiler knows the constant arguments in their loops.
#define INLINE static inline __attribute__((always_inline))

#endif
