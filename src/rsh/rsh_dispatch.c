// SPDX-License-Identifier: Apache-2.0
// Chooses the instruction set. The only state is one pointer to constant data. Every thread
// computes the same value for it, so a race is harmless.
#include <stdatomic.h>

#include "rsh/rsh_kernel.h"

#if defined(__x86_64__)

const struct rsh_kernels *const *rsh_kernels_usable(void) {
    static const struct rsh_kernels *const all[] = {&rsh_kernels_avx512, &rsh_kernels_avx2,
                                                    &rsh_kernels_sse2, &rsh_kernels_plain, NULL};
    bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    bool avx512 = avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                  __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
                  __builtin_cpu_supports("bmi2");
    return avx512 ? all : avx2 ? all + 1 : all + 2;
}

#else

const struct rsh_kernels *const *rsh_kernels_usable(void) {
    static const struct rsh_kernels *const all[] = {&rsh_kernels_native, &rsh_kernels_plain, NULL};
    return all;
}

#endif

static _Atomic(const struct rsh_kernels *) best;

void rsh_kernels_choose(const struct rsh_kernels *kernels) {
    atomic_store_explicit(&best, kernels, memory_order_relaxed);
}

const struct rsh_kernels *rsh_kernels_best(void) {
    const struct rsh_kernels *k = atomic_load_explicit(&best, memory_order_relaxed);
    if (!k) {
        k = rsh_kernels_usable()[0];
        atomic_store_explicit(&best, k, memory_order_relaxed);
    }
    return k;
}
