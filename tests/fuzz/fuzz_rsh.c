// SPDX-License-Identifier: Apache-2.0
// Fuzzes the harmonics: any order, any floats as directions, matrices, angles and coefficients. A
// refused call writes nothing, no call writes past its output, and bounded coefficients with any
// matrix that is accepted give finite numbers.
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "rsh/rsh.h"

enum { MOST = RSH_MAX_COEFFICIENTS, CHANNELS = 3, RECORDS = 19 };
static const float MARK = 12345.0f;

struct input {
    const uint8_t *data;
    size_t size, at;
};

static uint8_t take_byte(struct input *in) { return in->size ? in->data[in->at++ % in->size] : 0; }

// Half of the floats have any bits, the others are within 1.
static float take_float(struct input *in, bool wild) {
    uint32_t bits = 0;
    for (int i = 0; i < 4; i++) bits = bits << 8 | take_byte(in);
    float f;
    memcpy(&f, &bits, sizeof f);
    return wild ? f : (float)(int32_t)bits / 2147483648.0f;
}

static void fail_unless(bool good) {
    if (!good) abort();
}

// Checks what a call may have written to out[size].
static void fuzz_rsh_check(bool done, bool finite, const float *out, size_t size, size_t all) {
    for (size_t i = done ? size : 0; i < all; i++) fail_unless(out[i] == MARK);
    for (size_t i = 0; i < size && done && finite; i++) fail_unless(isfinite(out[i]));
}

static void mark(float *out, size_t count) {
    for (size_t i = 0; i < count; i++) out[i] = MARK;
}

static void fuzz_values(struct input *in, int order, rsh_basis basis, bool wild) {
    static float out[3 * MOST + 1], v[CHANNELS * MOST], x[RECORDS], y[RECORDS], z[RECORDS],
        many[MOST * RECORDS + 1];
    size_t n = order >= 1 && order <= RSH_MAX_ORDER ? (size_t)(order * order) : 0,
           all = 3 * MOST + 1;
    for (int i = 0; i < RECORDS; i++) {
        x[i] = take_float(in, wild);
        y[i] = take_float(in, wild);
        z[i] = take_float(in, wild);
    }
    for (int i = 0; i < CHANNELS * MOST; i++) v[i] = take_float(in, false);
    const float w[3] = {x[0], y[0], z[0]};
    mark(out, all);
    fuzz_rsh_check(rsh_eval(basis, order, w, out), !wild, out, n, all);
    mark(out, all);
    bool done = rsh_eval_derivatives(basis, order, w, out, out + n, out + 2 * n);
    fuzz_rsh_check(done, !wild, out, 3 * n, all);
    mark(many, MOST * RECORDS + 1);
    done = rsh_eval_many(basis, order, RECORDS, x, y, z, many);
    fuzz_rsh_check(done, !wild, many, n * RECORDS, MOST * RECORDS + 1);
    for (size_t i = 0; i < all; i++) out[i] = i < 3 * n ? 0.0f : MARK;
    if (rsh_project(basis, order, &(rsh_samples){RECORDS, x, y, z, x, y, z}, out))
        fuzz_rsh_check(true, !wild, out, 3 * n, all);
    mark(out, all);
    fuzz_rsh_check(rsh_value(basis, order, CHANNELS, v, w, out), !wild, out, CHANNELS, all);
    mark(out, all);
    fuzz_rsh_check(rsh_dot3(order, 1 + 2 * (take_byte(in) & 1), v, v, out), true, out, 3, all);
    mark(out, all);
    fuzz_rsh_check(rsh_convolve(order, CHANNELS, v, v, out), true, out, CHANNELS * n, all);
    const rsh_convention c = {(rsh_normalisation)(take_byte(in) % 5), take_byte(in) & 1,
                              (rsh_layout)(take_byte(in) % 4)};
    size_t size = (size_t)rsh_convention_size(order, c.layout);
    mark(out, all);
    fuzz_rsh_check(rsh_export(&c, order, 1, v, out), true, out, size, all);
    mark(out, all);
    fuzz_rsh_check(rsh_import(&c, order, 1, v, out), false, out, n, all);
}

// Single records; `r` and `s` are two matrices or frames.
static void fuzz_rotation(struct input *in, int order, const float r[9], const float s[9]) {
    static float out[CHANNELS * MOST + 1], v[CHANNELS * MOST], blocks[3 * RSH_MAX_BLOCKS + 1];
    size_t n = order >= 1 && order <= RSH_MAX_ORDER ? (size_t)(CHANNELS * order * order) : 0;
    size_t all = CHANNELS * MOST + 1;
    rsh_basis basis = (rsh_basis)(take_byte(in) % 3);
    rsh_taylor kind = (rsh_taylor)(take_byte(in) % 4);
    const rsh_alignment alignment = {basis, r, s, take_float(in, true)};
    for (int i = 0; i < CHANNELS * MOST; i++) v[i] = take_float(in, false);
    for (int call = 0; call < 12; call++) {
        bool done = false, finite = true;
        mark(out, all);
        switch (call) {
            case 0:
                done = rsh_rotate(order, CHANNELS, r, v, out);
                break;
            case 1:
                done = rsh_rotate_zxzxz(order, CHANNELS, r, v, out);
                break;
            case 2:
                done = rsh_rotate_stretched(order, CHANNELS, r, v, out);
                break;
            case 3:
                done = rsh_rotate_taylor(kind, order, CHANNELS, r, v, out);
                break;
            case 4:
                done = rsh_rotate_z(order, CHANNELS, r[0], v, out);
                break;
            case 5:
                done = rsh_rotate_y(order, CHANNELS, r[0], v, out);
                break;
            case 6:
                done = rsh_rotate_zyz(order, CHANNELS, rsh_zyz_of_matrix(r), v, out);
                break;
            case 7:
                done = rsh_align(&alignment, order, CHANNELS, v, out);
                break;
            case 8:
                done = rsh_align_transposed(&alignment, order, CHANNELS, v, out);
                break;
            case 9:
                done = rsh_rotate_ivanic(order, CHANNELS, r, v, out);
                break;
            case 10:  // series at large angles may overflow
                done = rsh_rotate_y_taylor(kind, order, CHANNELS, r[1], v, out), finite = false;
                break;
            default:
                done = rsh_flip_phase(order, CHANNELS, v, out);
        }
        fuzz_rsh_check(done, finite, out, n, all);
    }
    mark(blocks, 3 * RSH_MAX_BLOCKS + 1);
    bool done = rsh_rotation_y_derivatives(order, r[0], 2, blocks);
    fuzz_rsh_check(done, true, blocks, 3 * (size_t)rsh_blocks_size(order), 3 * RSH_MAX_BLOCKS + 1);
}

static void fuzz_many(struct input *in, int order, bool wild) {
    static float v[MOST * RECORDS], out[MOST * RECORDS + 1], a[9][RECORDS], b[9][RECORDS];
    const float *from[9], *to[9];
    size_t count = take_byte(in) % (RECORDS + 1), all = MOST * RECORDS + 1;
    size_t n = order >= 1 && order <= RSH_MAX_ORDER ? (size_t)(order * order) * count : 0;
    rsh_basis basis = (rsh_basis)(take_byte(in) % 3);
    float limit = take_float(in, true);
    for (int e = 0; e < 9; e++) {
        for (int i = 0; i < RECORDS; i++) {
            a[e][i] = take_float(in, wild);
            b[e][i] = take_float(in, false);
        }
        from[e] = a[e], to[e] = b[e];
    }
    for (int i = 0; i < MOST * RECORDS; i++) v[i] = take_float(in, false);
    mark(out, all);
    fuzz_rsh_check(rsh_rotate_many(order, 1, count, from, v, out), true, out, n, all);
    mark(out, all);
    bool done =
        rsh_rotate_taylor_many((rsh_taylor)(take_byte(in) % 4), order, 1, count, from, v, out);
    fuzz_rsh_check(done, true, out, n, all);
    mark(out, all);
    const rsh_alignments there = {basis, from, to, limit}, back = {basis, to, from, limit};
    fuzz_rsh_check(rsh_align_many(&there, order, 1, count, v, out), true, out, n, all);
    mark(out, all);
    done = rsh_align_transposed_many(&back, order, 1, count, v, out);
    fuzz_rsh_check(done, true, out, n, all);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    struct input in = {data, size, 0};
    uint8_t first = take_byte(&in);
    int order = first == 255 ? INT32_MAX : first == 254 ? INT32_MIN : first % 20 - 1;
    bool wild = take_byte(&in) & 1;
    float r[9], s[9];
    for (int i = 0; i < 9; i++) {
        r[i] = take_float(&in, wild);
        s[i] = take_float(&in, false);
    }
    fuzz_values(&in, order, (rsh_basis)(first & 1), wild);
    fuzz_rotation(&in, order, r, s);
    fuzz_many(&in, order, wild);
    return 0;
}
