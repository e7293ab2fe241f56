// SPDX-License-Identifier: Apache-2.0
// Time of a thread, medians, and the peak rate of fused multiply-adds, with which results are
// compared.
#ifndef BENCH_TIMING_H
#define BENCH_TIMING_H

#include <stdlib.h>
#include <time.h>

static inline double now_ns(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static inline int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Sorts v.
static inline double median_time(double *v, size_t count) {
    qsort(v, count, sizeof *v, ascending);
    return v[count / 2];
}

#if defined(__x86_64__)
#include <immintrin.h>
// `steps` times 16 vectors of 16, or 12 of 8, multiply-adds that do not wait for each other; the
// sum goes to result[0 .. 15], so that the compiler keeps it.
__attribute__((target("avx512f"))) static inline void peak_avx512(int steps, float *result) {
    __m512 a[16], m = _mm512_set1_ps(0.999f), s = _mm512_setzero_ps();
    for (int j = 0; j < 16; j++) a[j] = _mm512_set1_ps((float)j);
    for (int i = 0; i < steps; i++)
#pragma GCC unroll 16
        for (int j = 0; j < 16; j++) a[j] = _mm512_fmadd_ps(a[j], m, m);
    for (int j = 0; j < 16; j++) s = _mm512_add_ps(s, a[j]);
    _mm512_storeu_ps(result, s);
}
__attribute__((target("avx2,fma"))) static inline void peak_avx2(int steps, float *result) {
    __m256 a[12], m = _mm256_set1_ps(0.999f), s = _mm256_setzero_ps();
    for (int j = 0; j < 12; j++) a[j] = _mm256_set1_ps((float)j);
    for (int i = 0; i < steps; i++)
#pragma GCC unroll 12
        for (int j = 0; j < 12; j++) a[j] = _mm256_fmadd_ps(a[j], m, m);
    for (int j = 0; j < 12; j++) s = _mm256_add_ps(s, a[j]);
    _mm256_storeu_ps(result, s);
}
#endif

#endif
