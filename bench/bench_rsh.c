// SPDX-License-Identifier: Apache-2.0
// Times the harmonics on one thread, every instruction set this machine has, next to the peak rate
// of fused multiply-adds measured in the same run. The cases alternate; a figure is the median of
// the rounds in nanoseconds per unit named in its row. "least ns" is what the multiply-adds, at the
// measured peak, or the stores, at 32 bytes per cycle, take alone, whichever is more. A round of a
// case takes a tenth of a millisecond or more, since reading the clock takes half a microsecond.
//
// usage: bench_rsh [ROUNDS]        (default 15)
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "bench_timing.h"
#include "rsh/rsh.h"
#include "rsh/rsh_kernel.h"

// Evaluated at once: 64 directions times 100 functions stay in the first cache.
enum { BATCH = 64, RECORDS = 512 };
enum { COUNT = 2048, CALLS = 200, MAX_CASES = 512, MAX_ROUNDS = 101, N_MAX = RSH_MAX_COEFFICIENTS };
enum { ROUND_NS = 100000 };

// Whole lines of the cache: a vector of 64 bytes across two of them takes twice the time.
static _Alignas(64) float directions[3][COUNT], values[3][COUNT], matrix[COUNT * N_MAX];
// The margin keeps the two from falling on the same lines of the cache.
static _Alignas(64) float records[2][3 * N_MAX * 16 + 64];
static float matrices[9][16];
static float coefficients[9 * N_MAX], result[9 * N_MAX + 24], frames[CALLS + 1][9];

struct timed {
    char name[64];
    const struct rsh_kernels *kernels;
    void (*run)(const struct timed *c);
    double units, flops;  // per run; flops of the sum that is asked for, 0 if it is not reported
    double steps, bytes;  // per unit: multiply-adds or products as done here, bytes stored
    int order, channels, method, repeats;
    float limit;
    double ns[MAX_ROUNDS];
};

static void run_eval(const struct timed *c) {
    for (int i = 0; i < COUNT; i += BATCH)
        c->kernels->eval_many((rsh_basis)c->method, c->order, BATCH, directions[0] + i,
                              directions[1] + i, directions[2] + i, matrix);
}

static void run_project(const struct timed *c) {
    const float *const v[3] = {values[0], values[1], values[2]};
    c->kernels->project(RSH_HEMISPHERE, c->order, COUNT,
                        (const float *const[3]){directions[0], directions[1], directions[2]}, v,
                        result);
}

static void run_accumulate(const struct timed *c) {
    const float *const v[3] = {values[0], values[1], values[2]};
    c->kernels->accumulate(COUNT, (size_t)(c->order * c->order), matrix, v, result);
}

static void run_rotation(const struct timed *c) {
    struct rsh_rotation t = {
        (enum rsh_method)c->method, 0.2f, 0.8f, 0.6f, 0.9800666f, 0.1986693f, 0.28f, -0.96f};
    for (int i = 0; i < CALLS; i++)
        c->kernels->rotate(&t, c->order, c->channels, coefficients, result);
}

// Records in structures of arrays, the same vector of them again and again.
static void run_records(const struct timed *c) {
    struct rsh_rotations t = {.method = (enum rsh_method)c->method};
    size_t width = (size_t)c->kernels->width;
    for (size_t i = 0; i < width; i++) {
        t.beta[i] = 0.2f;
        t.cos_alpha[i] = 0.8f, t.sin_alpha[i] = 0.6f;
        t.cos_beta[i] = 0.9800666f, t.sin_beta[i] = 0.1986693f;
        t.cos_gamma[i] = 0.28f, t.sin_gamma[i] = -0.96f;
    }
    for (size_t i = 0; i < RECORDS; i += width)
        c->kernels->rotate_many(&t, c->order, c->channels, width, records[0], records[1]);
}

static void run_rotate_many(const struct timed *c) {
    const float *r[9];
    for (int e = 0; e < 9; e++) r[e] = matrices[e];
    for (int i = 0; i < RECORDS; i += 16)
        rsh_rotate_many(c->order, c->channels, 16, r, records[0], records[1]);
}

static void run_dot(const struct timed *c) {
    int n = c->order * c->order;
    for (int i = 0; i < CALLS; i++) c->kernels->dot3(n, 0, coefficients, coefficients + n, result);
}

static void run_extend(const struct timed *c) {
    const int bands[2] = {rsh_sphere_order(c->order), c->order};
    for (int i = 0; i < CALLS; i++)
        c->kernels->convert(&rsh_extension[c->order - 1], false, bands, coefficients, result);
}

static void run_align(const struct timed *c) {
    for (int i = 0; i < CALLS; i++) {
        const rsh_alignment alignment = {(rsh_basis)c->method, frames[i], frames[i + 1], c->limit};
        rsh_align_transposed(&alignment, c->order, c->channels, coefficients, result);
    }
}

// The operations of hemispherical alignment by matrices of reprojection: two rotations about z, and
// for m >= 0 and m < 0 the matrices of one tabulated angle, or of two to interpolate between.
static void run_tabulated(const struct timed *c) {
    enum { ANGLES = 32, EVEN = 55, ODD = 45, SIZE = EVEN * EVEN + ODD * ODD };
    static float table[(ANGLES + 1) * SIZE];
    const struct rsh_rotation z = {.method = RSH_METHOD_Z, .cos_gamma = 0.6f, .sin_gamma = 0.8f};
    const float *v = coefficients;
    uint32_t state = 1;
    for (int i = 0; i < CALLS; i++) {
        state = state * 1664525u + 1013904223u;
        const float *const even[3] = {v, c->channels > 1 ? v + 100 : NULL, v + 200};
        const float *const odd[3] = {v + EVEN, c->channels > 1 ? v + 100 + EVEN : NULL, v + 255};
        const float *at = table + (state >> 16) % ANGLES * SIZE;
        c->kernels->rotate(&z, c->order, c->channels, v, result);
        for (int k = 0; k < c->method; k++, at += SIZE) {
            c->kernels->accumulate(EVEN, EVEN, at, even, result);
            c->kernels->accumulate(ODD, ODD, at + EVEN * EVEN, odd, result + 3 * EVEN);
        }
        c->kernels->rotate(&z, c->order, c->channels, result, result);
    }
}

static void run_eval_one(const struct timed *c) {
    for (int i = 0; i < CALLS; i++)
        rsh_eval(RSH_HEMISPHERE, c->order,
                 (float[3]){directions[0][i], directions[1][i], directions[2][i]}, result);
}

#if defined(__x86_64__)
static void run_peak(const struct timed *c) {
    c->order == 16 ? peak_avx512(COUNT, result) : peak_avx2(COUNT, result);
}
#endif

// Products per direction, added to or not: of the functions, and of Re, Im (x + i y)^m.
static double azimuth_steps(int n) {
    double steps = 0.0;
    for (int m = 2; m < n; m++) steps += m % 2 ? 4.0 : 3.0;
    return steps;
}

// One per root of the Legendre function in z^2, one per function, z at m = 0 too, and the point.
static double eval_steps(int basis, int n) {
    double steps = azimuth_steps(n) + 2.0 * (n - 2) + (basis == RSH_SPHERE ? 10.0 : 20.0);
    for (int m = 0; m < n; m++)
        for (int k = 0; k < n - m; k++) steps += k / 2 + (m ? 2 : k % 2);
    return steps;
}

// The steps of three colours, per sample and per record.
static double project_steps(int n) { return 3.0 * (n * n - n) + 4.0 * (n - 1) + azimuth_steps(n); }

static double batch_steps(int n) { return 33.0 * n * (n - 1) / 2.0 + 12.0 * n; }

static double exact_steps(int n) { return n * (2.0 * n * n + 18.0 * n - 14.0); }

static struct timed *add_case(struct timed *c, const struct rsh_kernels *k,
                              void (*run)(const struct timed *), const char *what, int order) {
    *c = (struct timed){.kernels = k, .run = run, .units = 1.0, .order = order, .channels = 1};
    snprintf(c->name, sizeof c->name, "%-8s %-26s", k ? k->name : "best", what);
    return c;
}

// The functions of a table of kernels, at one order.
static struct timed *add_kernels(struct timed *c, const struct rsh_kernels *k, int n) {
    for (int basis = RSH_SPHERE; basis <= RSH_HEMISPHERE; basis++) {
        add_case(c, k, run_eval,
                 basis == RSH_SPHERE ? "evaluate many" : "evaluate many, hemisphere", n);
        c->units = COUNT;
        c->method = basis;
        c->steps = n <= 10 ? eval_steps(basis, n) : 0.0;
        c++->bytes = 4.0 * n * n;
    }
    add_case(c, k, run_project, "project rgb", n)->units = COUNT;
    c->steps = n <= 10 ? project_steps(n) : 0.0;
    c++->flops = 6.0 * n * n * COUNT;
    add_case(c, k, run_accumulate, "accumulate rgb", n)->units = COUNT;
    c++->flops = 6.0 * n * n * COUNT;
    add_case(c, k, run_dot, "dot rgb", n)->units = CALLS;
    c++->flops = 6.0 * n * n * CALLS;
    add_case(c, k, run_extend, "extend", n)->units = CALLS;
    c++;
    for (int m = RSH_METHOD_TAYLOR_1_5; m <= RSH_METHOD_EXACT; m++) {
        static const char *const what[] = {"batch 1.5th", "batch 2nd", "batch exact"};
        add_case(c, k, run_records, what[m - RSH_METHOD_TAYLOR_1_5], n);
        c->units = RECORDS;
        c->method = m;
        c->steps = m == RSH_METHOD_EXACT        ? exact_steps(n)
                   : m == RSH_METHOD_TAYLOR_1_5 ? batch_steps(n)
                                                : 0.0;
        c->bytes = 12.0 * n * n;
        c++->channels = 3;
    }
    for (int rgb = 0; rgb < 2; rgb++)
        for (int m = RSH_METHOD_TAYLOR_1_5; m <= RSH_METHOD_EXACT; m++) {
            static const char *const what[] = {"rotate 1.5th", "rotate 2nd", "rotate exact"};
            add_case(c, k, run_rotation, what[m - RSH_METHOD_TAYLOR_1_5], n);
            c->units = CALLS;
            c->method = m;
            c++->channels = rgb ? 3 : 1;
        }
    return c;
}

// The library's calls, and those with which they are compared.
static struct timed *add_calls(struct timed *c) {
    for (int angles = 1; angles <= 2; angles++)
        for (int channels = 1; channels <= 3; channels += 2) {
            add_case(c, rsh_kernels_best(), run_tabulated,
                     angles == 1 ? "tabulated, one angle" : "tabulated, two angles", 10);
            c->units = CALLS;
            c->method = angles;
            c++->channels = channels;
        }
    // A record of three colours, and one with its two derivative vectors.
    for (int channels = 3; channels <= 9; channels += 6) {
        add_case(c, NULL, run_align, "align a record", 10)->units = CALLS;
        c->method = RSH_SPHERE;
        c++->channels = channels;
    }
    for (int n = 4; n <= 12; n += 2) {
        add_case(c, NULL, run_eval_one, "evaluate one", n)->units = CALLS;
        c++;
        add_case(c, NULL, run_rotate_many, "rotate many", n)->units = RECORDS;
        c++->channels = 3;
        for (int rgb = 0; rgb < 2; rgb++)
            for (int form = 0; form < 4; form++) {
                static const char *const what[] = {"align sphere true", "align sphere fast",
                                                   "align hemisphere true",
                                                   "align hemisphere fast"};
                add_case(c, NULL, run_align, what[form], n)->units = CALLS;
                c->limit = form % 2 ? 4.0f : 0.0f;
                c->method = form / 2 ? RSH_HEMISPHERE : RSH_SPHERE;
                c++->channels = rgb ? 3 : 1;
            }
    }
    return c;
}

static int add_cases(struct timed *cases) {
    struct timed *c = cases;
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512f")) {
        add_case(c, NULL, run_peak, "peak fma, 512 bit", 16)->units = COUNT * 16.0;
        c++->flops = 2.0 * 16 * 16 * COUNT;
    }
    if (__builtin_cpu_supports("avx2")) {
        add_case(c, NULL, run_peak, "peak fma, 256 bit", 8)->units = COUNT * 12.0;
        c++->flops = 2.0 * 8 * 12 * COUNT;
    }
#endif
    for (const struct rsh_kernels *const *k = rsh_kernels_usable(); *k; k++)
        for (int n = 4; n <= 12; n += 2) c = add_kernels(c, *k, n);
    return (int)(add_calls(c) - cases);
}

static void fill_randomly(void) {
    for (int i = 0; i < COUNT; i++) {
        float z = ((float)i + 0.5f) / COUNT, phi = 2.4f * (float)i, s = sqrtf(1.0f - z * z);
        directions[0][i] = s * cosf(phi);
        directions[1][i] = s * sinf(phi);
        directions[2][i] = z;
        for (int c = 0; c < 3; c++) values[c][i] = 1.0f + sinf((float)(i * (c + 1)));
    }
    for (int i = 0; i < 9 * N_MAX; i++) coefficients[i] = sinf((float)i);
    for (int i = 0; i < 3 * N_MAX * 16; i++) records[0][i] = sinf((float)i);
    for (int i = 0; i <= CALLS; i++) {
        float a = 0.1f * (float)i, b = 0.3f * sinf((float)i), ca = cosf(a), sa = sinf(a),
              cb = cosf(b), sb = sinf(b);
        const float f[9] = {ca * cb, sa * cb, -sb, -sa, ca, 0.0f, ca * sb, sa * sb, cb};
        for (int k = 0; k < 9; k++) frames[i][k] = matrices[k][i % 16] = f[k];
    }
}

// ns per unit.
static double time_case(const struct timed *c) {
    double start = now_ns();
    for (int i = 0; i < c->repeats; i++) c->run(c);
    return (now_ns() - start) / (c->units * c->repeats);
}

int main(int argc, char **argv) {
    static struct timed cases[MAX_CASES];
    int rounds = argc > 1 ? atoi(argv[1]) : 15, count = add_cases(cases);
    rounds = rounds < 1 ? 1 : rounds > MAX_ROUNDS ? MAX_ROUNDS : rounds;
    double peak = 1.0;
    fill_randomly();
    for (int i = 0; i < count; i++) {
        cases[i].repeats = 2;  // the first, with cold tables, has less influence
        cases[i].repeats = 1 + (int)(ROUND_NS / (time_case(&cases[i]) * cases[i].units));
    }
    for (int r = 0; r < rounds; r++)
        for (int i = 0; i < count; i++) cases[i].ns[r] = time_case(&cases[i]);
    printf("kernels  what                       order channels        ns  GFLOP/s  least ns\n");
    for (int i = 0; i < count; i++) {
        struct timed *c = &cases[i];
        double ns = median_time(c->ns, (size_t)rounds);
        printf("%s %5d %8d %9.2f", c->name, c->order, c->channels, ns);
        // The first case is the peak.
        if (i == 0) peak = c->flops / (ns * c->units);
        if (c->flops > 0.0)
            printf(" %8.1f", c->flops / (ns * c->units));
        else if (c->steps > 0.0)
            printf("         ");
        // A vector of 32 bytes stored and two multiplied and added per cycle: 32 bytes, 32 flops.
        if (c->steps > 0.0) printf(" %9.2f", fmax(2.0 * c->steps, c->bytes) / peak);
        printf("\n");
    }
    return 0;
}
