// SPDX-License-Identifier: Apache-2.0
// Figure 5.7 of [K05]: times of the forms of rotation for n = 4 .. 12, single records and batches,
// next to the peak rate of fused multiply-adds of the same run. The cases alternate; a figure is
// the median of the rounds, a ratio the median of the rounds' ratios. plot_rotation.py draws it.
//
// usage: fig_5_7 [ROUNDS]        (default 31); times are of one thread, in ns per record
//        fig_5_7_fma [ROUNDS]    the scalar forms with fused multiply-adds, without heading
//
// Scalar against scalar is one number at a time on both sides: the series and Pinchon and Hoggan's
// form by the batch kernel of width one, zxzxz and Ivanic in plain C. Zxzxz is there twice: with
// the rotations about x by a quarter circle by their entries alone, as the library has it and [K05
// 5.3.3] counts, and by whole matrices, zeros included. Vectors against vectors use the best
// instruction set of this machine; zxzxz with vectors is Pinchon and Hoggan's form, whose products
// are the same in number and position.
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bench_timing.h"
#include "rsh/rsh.h"
#include "rsh/rsh_kernel.h"
#include "rsh/rsh_multiples.h"
#include "rsh/rsh_rotate_lanes.h"
#include "rsh/rsh_tables.h"

enum { FIRST = 4, LAST = 12, RECORDS = 64, VECTOR = 16, MAX_ROUNDS = 101 };
enum { N_MAX = RSH_MAX_COEFFICIENTS, CHANNELS = 3 };

// Whole lines of the cache: a vector of 64 bytes across two of them takes twice the time.
static _Alignas(64) float in[CHANNELS * N_MAX * VECTOR + 64], out[CHANNELS * N_MAX * VECTOR + 64];
static float rotation[RECORDS][9], entries[9][RECORDS];
static const float *columns[9];

// The forms from FAST on are the library's own, for any options of the compiler.
enum form {
    FAST_SCALAR,
    EXACT_SCALAR,
    ZXZXZ,
    ZXZXZ_WHOLE,
    IVANIC,
    FAST,
    EXACT,
    FAST_BATCH,
    EXACT_BATCH,
    FORMS
};
static const char *const form_names[FORMS] = {
    "fast-scalar", "pinchon-hoggan-scalar", "zxzxz",      "zxzxz-whole",         "ivanic",
    "fast",        "pinchon-hoggan",        "fast-batch", "pinchon-hoggan-batch"};

#ifdef FUSED
enum { TIMED = FAST };
static const char suffix[] = "-fma";
static bool can_run(void) { return __builtin_cpu_supports("fma"); }
#else
enum { TIMED = FORMS };
static const char suffix[] = "";
static bool can_run(void) { return true; }
#endif

static void rotate_scalar(enum rsh_method method, int order, int channels, const float *r) {
    struct rsh_rotation t = rsh_rotation_of_matrix(r);
    t.method = method;
    t.beta = rsh_rotation_angle(&t);
    rsh_rotate_lanes_scalar(&t, order, channels, in, out);
}

// The rotation about x by a quarter circle and its transpose, band after band, zeros included.
enum { WHOLE = RSH_MAX_ORDER * (4 * N_MAX - 1) / 3 };
static float quarter[2][WHOLE];

static void fill_quarter(void) {
    for (int l = 0, entry = 0, band = 0; l < RSH_MAX_ORDER; band += (2 * l + 1) * (2 * l + 1), l++)
        for (int row = 0; row <= 2 * l; row++)
            for (; entry < rsh_quarter_end[l * l + row]; entry++) {
                const int at = band + row * (2 * l + 1) + rsh_quarter_column[entry];
                quarter[0][at] = rsh_quarter[entry];
                quarter[1][at] = rsh_quarter_back[entry];
            }
}

// Four rows at a time, so that sums do not wait for each other.
static void rotate_quarter(int order, const float *m, const float *v, float *to) {
    for (int l = 0, size = 1; l < order; l++, v += size, to += size, size += 2) {
        int row = 0;
        for (; row + 4 <= size; row += 4, m += 4 * size) {
            float a = 0.0f, b = 0.0f, c = 0.0f, d = 0.0f;
            for (int k = 0; k < size; k++) {
                a += m[k] * v[k];
                b += m[k + size] * v[k];
                c += m[k + 2 * size] * v[k];
                d += m[k + 3 * size] * v[k];
            }
            to[row] = a, to[row + 1] = b, to[row + 2] = c, to[row + 3] = d;
        }
        for (; row < size; row++, m += size) {
            float a = 0.0f;
            for (int k = 0; k < size; k++) a += m[k] * v[k];
            to[row] = a;
        }
    }
}

static void zxzxz_whole(int order, int channels, const float *r) {
    const struct rsh_rotation t = rsh_rotation_of_matrix(r);
    const struct rsh_multiples alpha = rsh_multiples_of(t.cos_alpha, t.sin_alpha, order),
                               beta = rsh_multiples_of(t.cos_beta, t.sin_beta, order),
                               gamma = rsh_multiples_of(t.cos_gamma, t.sin_gamma, order);
    const int n = order * order;
    for (int c = 0; c < channels; c++) {
        float v[N_MAX], u[N_MAX];
        memcpy(v, in + c * n, (size_t)n * sizeof *v);
        rsh_rotate_multiples(order, &gamma, v);
        rotate_quarter(order, quarter[0], v, u);
        rsh_rotate_multiples(order, &beta, u);
        rotate_quarter(order, quarter[1], u, v);
        rsh_rotate_multiples(order, &alpha, v);
        memcpy(out + c * n, v, (size_t)n * sizeof *v);
    }
}

static void run_batch_form(enum form form, int order, int channels, int first) {
    const float *r[9];
    for (int e = 0; e < 9; e++) r[e] = columns[e] + first;
    if (form == FAST_BATCH)
        rsh_rotate_taylor_many(RSH_TAYLOR_1_5, order, channels, VECTOR, r, in, out);
    else
        rsh_rotate_many(order, channels, VECTOR, r, in, out);
}

static void run_one(enum form form, int order, int channels, const float *r) {
    switch (form) {
        case FAST_SCALAR:
            rotate_scalar(RSH_METHOD_TAYLOR_1_5, order, channels, r);
            break;
        case EXACT_SCALAR:
            rotate_scalar(RSH_METHOD_EXACT, order, channels, r);
            break;
        case ZXZXZ:
            rsh_rotate_zxzxz(order, channels, r, in, out);
            break;
        case ZXZXZ_WHOLE:
            zxzxz_whole(order, channels, r);
            break;
        case IVANIC:
            rsh_rotate_ivanic(order, channels, r, in, out);
            break;
        case FAST:
            rsh_rotate_taylor(RSH_TAYLOR_1_5, order, channels, r, in, out);
            break;
        default:
            rsh_rotate(order, channels, r, in, out);
    }
}

// ns per record.
static double time_form(enum form form, int order, int channels) {
    // Rounds of slow forms are shorter, so that all take about as long; reading the clock takes
    // half a microsecond.
    int repeats = form >= FAST_BATCH ? 64 : form == IVANIC ? 2 : 16;
    double start = now_ns();
    for (int k = 0; k < repeats; k++) {
        if (form >= FAST_BATCH)
            for (int i = 0; i < RECORDS; i += VECTOR) run_batch_form(form, order, channels, i);
        else
            for (int i = 0; i < RECORDS; i++) run_one(form, order, channels, rotation[i]);
    }
    return (now_ns() - start) / (repeats * RECORDS);
}

static double time_peak(void) {
    enum { STEPS = 32768 };
    double flops = 0.0, start = now_ns();
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512f")) {
        peak_avx512(STEPS, out);
        flops = 2.0 * 16 * 16 * STEPS;
    } else if (__builtin_cpu_supports("avx2")) {
        peak_avx2(STEPS, out);
        flops = 2.0 * 8 * 12 * STEPS;
    }
#endif
    return flops / (now_ns() - start);
}

// Products per channel as [K05 5.3.3] counts them; an added product counts as two operations.
static double products(enum form form, int n) {
    if (form == FAST || form == FAST_SCALAR || form == FAST_BATCH) return 9.0 * n * n - 4.0 * n;
    if (form == IVANIC) return n * (4.0 * n * n - 1) / 3;
    if (form == ZXZXZ_WHOLE) return n * (8.0 * n * n + 18.0 * n - 20) / 3;
    return n * (2.0 * n * n + 18.0 * n - 14) / 3;
}

static void fill_rotations(void) {
    for (size_t i = 0; i < sizeof in / sizeof *in; i++) in[i] = sinf((float)i);
    for (int i = 0; i < RECORDS; i++) {
        float a = 0.4f * (float)i, b = 0.05f + 0.001f * (float)i, g = 1.7f * (float)i;
        float ca = cosf(a), sa = sinf(a), cb = cosf(b), sb = sinf(b), cg = cosf(g), sg = sinf(g);
        const float r[9] = {ca * cb * cg - sa * sg,
                            -ca * cb * sg - sa * cg,
                            ca * sb,
                            sa * cb * cg + ca * sg,
                            -sa * cb * sg + ca * cg,
                            sa * sb,
                            -sb * cg,
                            sb * sg,
                            cb};
        memcpy(rotation[i], r, sizeof r);
        for (int e = 0; e < 9; e++) entries[e][i] = r[e];
    }
    for (int e = 0; e < 9; e++) columns[e] = entries[e];
}

int main(int argc, char **argv) {
    static double ns[FORMS][MAX_ROUNDS], peak[MAX_ROUNDS], ratio[MAX_ROUNDS];
    int rounds = argc > 1 ? atoi(argv[1]) : 31;
    rounds = rounds < 1 ? 1 : rounds > MAX_ROUNDS ? MAX_ROUNDS : rounds;
    if (!can_run()) return 0;
    fill_rotations();
    fill_quarter();
    if (!*suffix) printf("n\tchannels\tform\tns\tof_fast\tGFLOP/s\tof_peak\n");
    for (int n = FIRST; n <= LAST; n++)
        for (int channels = 1; channels <= CHANNELS; channels += CHANNELS - 1) {
            for (int r = 0; r < rounds; r++) {
                peak[r] = time_peak();
                for (int f = 0; f < TIMED; f++) ns[f][r] = time_form((enum form)f, n, channels);
            }
            for (int f = 0; f < TIMED; f++) {
                // Against the fast form of the same kind: scalar, with vectors, or in batches.
                int fast = f <= IVANIC ? FAST_SCALAR : f <= EXACT ? FAST : FAST_BATCH;
                for (int r = 0; r < rounds; r++) ratio[r] = ns[f][r] / ns[fast][r];
                double of_fast = median_time(ratio, (size_t)rounds), sorted[MAX_ROUNDS];
                memcpy(sorted, ns[f], sizeof sorted);
                double time = median_time(sorted, (size_t)rounds);
                double rate = 2.0 * products((enum form)f, n) * channels / time;
                memcpy(sorted, peak, sizeof sorted);
                printf("%d\t%d\t%s%s\t%.1f\t%.2f\t%.1f\t%.2f\n", n, channels, form_names[f], suffix,
                       time, of_fast, rate, rate / median_time(sorted, (size_t)rounds));
            }
        }
    return 0;
}
