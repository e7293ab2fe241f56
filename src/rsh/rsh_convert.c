// SPDX-License-Identifier: Apache-2.0
// Conversion between bases on lanes; one source for AVX2 and AVX-512: the build defines RSH_NAME,
// the suffix. Lanes 0 to 7 hold the coefficients of +m and lanes 8 to 15 those of -m, of one band:
// the low row for m = 0 .. 7, and for bands from 8 on also the high row for m = 8 .. 15.
#include <stddef.h>

#include "rsh/rsh_inline.h"
#include "rsh/rsh_lanes.h"
#include "rsh/rsh_rotate_lanes.h"

// Outputs computed at once; they load the same inputs.
enum { CONVERT_BLOCK = 4 };

// Loads m = base .. base + 7 of the band whose m = 0 is at `middle`, with 0 beyond l.
INLINE lanes load_row(const float *middle, int l, int base) {
    int count = l + 1 - base < 8 ? l + 1 - base : 8;
    return lanes_pair(eight_first(middle + base, count),
                      eight_reverse(eight_last(middle - base - 7, count)));
}

INLINE void store_row(lanes v, float *middle, int l, int base) {
    int count = l + 1 - base < 8 ? l + 1 - base : 8;
    // m = 0 is in both halves; the value of `plus` is stored last.
    eight_store_last(middle - base - 7, count, eight_reverse(lanes_high(v)));
    eight_store_first(middle + base, count, lanes_low(v));
}

// The rows of an input from number `base` on.
struct input_rows {
    const lanes *row;
    int base, count;
};

// Computes outputs o .. o + block - 1 from the rows, whose factors begin at f.
INLINE void convert_rows(int block, struct input_rows in, const float *f,
                         const ptrdiff_t strides[2], int o, float *out) {
    lanes sum[CONVERT_BLOCK];
    for (int k = 0; k < block; k++) sum[k] = lanes_zero();
    int i = in.base;
    do {
        for (int k = 0; k < block; k++)
            sum[k] = lanes_mad(lanes_twice(f + k * strides[0]), in.row[i], sum[k]);
        f += strides[1];
    } while (++i < in.count);
    for (int k = 0; k < block; k++) store_row(sum[k], out + (o + k) * (o + k + 1), o + k, in.base);
}

// Converts the low or the high rows: `factor` has eight numbers per (output, input), at the given
// strides.
INLINE void convert_half(const float *factor, const ptrdiff_t strides[2], int base,
                         const int bands[2], const float *in, float *out) {
    lanes row[RSH_MAX_ORDER];
    for (int i = base; i < bands[1]; i++) row[i] = load_row(in + i * (i + 1), i, base);
    const struct input_rows rows = {row, base, bands[1]};
    int o = base;
    for (; o + CONVERT_BLOCK <= bands[0]; o += CONVERT_BLOCK, factor += CONVERT_BLOCK * strides[0])
        convert_rows(CONVERT_BLOCK, rows, factor, strides, o, out);
    if (o + 3 == bands[0]) convert_rows(3, rows, factor, strides, o, out);
    if (o + 2 == bands[0]) convert_rows(2, rows, factor, strides, o, out);
    if (o + 1 == bands[0]) convert_rows(1, rows, factor, strides, o, out);
}

void GLUE(rsh_convert_, RSH_NAME)(const struct rsh_rows *rows, bool transposed, const int bands[2],
                                  const float *in, float *out) {
    const int low = 8 * rows->inputs, high = 8 * (rows->inputs - 8);
    const ptrdiff_t of_low[2] = {transposed ? 8 : low, transposed ? low : 8};
    const ptrdiff_t of_high[2] = {transposed ? 8 : high, transposed ? high : 8};
    convert_half(rows->low, of_low, 0, bands, in, out);
    if (bands[0] > 8 && bands[1] > 8) {
        convert_half(rows->high, of_high, 8, bands, in, out);
        return;
    }
    for (int l = 8; l < bands[0]; l++)
        for (int m = 8; m <= l; m++) out[l * (l + 1) + m] = out[l * (l + 1) - m] = 0.0f;
}
