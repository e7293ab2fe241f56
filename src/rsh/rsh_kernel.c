// SPDX-License-Identifier: Apache-2.0
// The products with vectors of the native width, and the table of an instruction set; one source
// for every instruction set.
#include "rsh/rsh_kernel.h"

#include "rsh/rsh_batch.h"
#include "rsh/rsh_rotate_lanes.h"
#include "rsh/rsh_tables.h"
#include "rsh/rsh_vector.h"

// A matrix of `count` rows of `row` coefficients.
struct row_matrix {
    size_t count, row;
    const float *first;
};

// One pass over all rows for `vectors` vectors of coefficients from the first one on. Of the last
// vector only the lanes from `skip` on are added, as it may overlap the one before.
INLINE void accumulate_columns(int vectors, int channels, struct row_matrix matrix,
                               const float *const value[3], size_t skip, float *out) {
    const size_t row = matrix.row;
    const float *at = matrix.first;
    vf sum[3][8];
    size_t last = (size_t)(vectors - 1);
    for (int a = 0; a < channels; a++)
        for (int j = 0; j < vectors; j++) sum[a][j] = (vf){0};
    for (size_t i = 0; i < matrix.count; i++, at += row) {
        vf v[3];
        for (int a = 0; a < channels; a++) v[a] = splat(value[a][i]);
        for (int j = 0; j < vectors; j++) {
            vf h = load(at + (size_t)j * W - ((size_t)j == last ? skip : 0));
            for (int a = 0; a < channels; a++) sum[a][j] += h * v[a];
        }
    }
    for (int a = 0; a < channels; a++) {
        float *to = out + (size_t)a * row;
        for (int j = 0; j < vectors; j++) {
            float lanes[W];
            store(lanes, sum[a][j]);
            for (size_t k = (size_t)j == last ? skip : 0; k < W; k++)
                to[(size_t)j * W + k - ((size_t)j == last ? skip : 0)] += lanes[k];
        }
    }
}

// The widest block whose sums of three channels stay in registers: 24 of 32 registers, or 12 of 16.
enum { KERNEL_BLOCK = RSH_WIDTH == 16 ? 8 : 4 };

INLINE void accumulate_channels(int channels, size_t count, size_t coefficients,
                                const float *matrix, const float *const value[3], float *out) {
    size_t k = 0;
    while (k < coefficients) {
        size_t left = coefficients - k, vectors = (left + W - 1) / W, skip = 0;
        if (vectors > KERNEL_BLOCK)
            vectors = KERNEL_BLOCK;
        else
            skip = vectors * W - left;
        const struct row_matrix columns = {count, coefficients, matrix + k};
        float *to = out + k;
        switch (vectors) {
#define CASE(n)                                                    \
    case n:                                                        \
        accumulate_columns(n, channels, columns, value, skip, to); \
        break
            CASE(1);
            CASE(2);
            CASE(3);
            CASE(4);
#if RSH_WIDTH == 16
            CASE(5);
            CASE(6);
            CASE(7);
            CASE(8);
#endif
#undef CASE
        }
        k += vectors * W - skip;
    }
}

// The instruction set that processes rows shorter than a vector.
#define NARROWER_avx512 rsh_kernels_avx2
#define NARROWER_avx2 rsh_kernels_sse2
#define NARROWER_sse2 rsh_kernels_plain
#define NARROWER_native rsh_kernels_plain

static void kernel_accumulate(size_t count, size_t coefficients, const float *matrix,
                              const float *const value[3], float *out) {
    if (coefficients < W)
        GLUE(NARROWER_, RSH_NAME).accumulate(count, coefficients, matrix, value, out);
    else if (value[1])
        accumulate_channels(3, count, coefficients, matrix, value, out);
    else
        accumulate_channels(1, count, coefficients, matrix, value, out);
}

// The last n % W terms are in the last vector, whose other lanes are masked out.
static void kernel_dot3(int n, int step, const float *a, const float *b, float out[3]) {
    static const float zeros_ones[2 * W] = {[W... 2 * W - 1] = 1.0f};
    if (n < W) {
        rsh_kernels_plain.dot3(n, step, a, b, out);
        return;
    }
    vf sum[3] = {{0}, {0}, {0}};
    int k = 0;
    for (; k + W <= n; k += W)
        for (int c = 0; c < 3; c++) sum[c] += load(a + c * step + k) * load(b + c * n + k);
    if (k < n) {
        vf mask = load(zeros_ones + (n - k));
        for (int c = 0; c < 3; c++)
            sum[c] += load(a + c * step + n - W) * mask * load(b + c * n + n - W);
    }
    for (int c = 0; c < 3; c++) out[c] = sum_lanes(sum[c]);
}

const struct rsh_kernels GLUE(rsh_kernels_, RSH_NAME) = {
    .name = TEXT(RSH_NAME),
    .eval_many = GLUE(rsh_eval_many_, RSH_NAME),
    .project = GLUE(rsh_project_, RSH_NAME),
    .accumulate = kernel_accumulate,
    .dot3 = kernel_dot3,
    .rotate = GLUE(rsh_rotate_lanes_, RSH_NAME),
    .convert = GLUE(rsh_convert_, RSH_NAME),
    .width = W,
    .angles = GLUE(rsh_angles_, RSH_NAME),
    .rotate_many = GLUE(rsh_rotate_many_, RSH_NAME),
    .convert_many = GLUE(rsh_convert_many_, RSH_NAME),
};
