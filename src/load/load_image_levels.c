// SPDX-License-Identifier: Apache-2.0
// Smaller copies of an image, each half the size of the one before, for lookups over an area. A
// texel of a copy is the mean of the area that it covers, even if the number of texels is odd.
//
// The rows of an environment are at equal angles from pole to pole, and light is interpolated
// between them. A row of its copy is a mean by the solid angles of the rows from which it would be
// interpolated, so that the light of all directions stays.
#include <stdlib.h>

#include "base/array.h"
#include "base/wide.h"
#include "load/load_build.h"

static int half_size(int n) { return n > 1 ? n / 2 : 1; }

enum { SPAN_MOST = 8 };

// Texels from * n / m to (from + 1) * n / m of n, each with the fraction that is covered. The
// function returns the sum of these fractions.
struct texel_span {
    int first, count;
    float fraction[SPAN_MOST];
};

static struct texel_span span_of(int from, int n, int m) {
    double left = (double)from * n / m, right = (double)(from + 1) * n / m;
    struct texel_span s = {.first = (int)left};
    for (int i = s.first; i < n && i < right && s.count < SPAN_MOST; i++)
        s.fraction[s.count++] =
            (float)((fmin(right, i + 1.0) - fmax(left, (double)i)) / (right - left));
    return s;
}

// The rows of an environment of n of which row `row` of m is the mean.
static struct texel_span environment_span(int row, int n, int m) {
    const double step = (double)(n - 1) / (m - 1), at = row * step, angle = M_PI / (n - 1);
    double weight[SPAN_MOST], sum = 0.0;
    struct texel_span s = {.first = (int)fmax(floor(at - step) + 1.0, 0.0)};
    for (int i = s.first; i < n && i < at + step && s.count < SPAN_MOST; i++) {
        // At a pole a triangle of this height has a sixth of the solid angle.
        const double solid = i > 0 && i < n - 1 ? sin(i * angle) : sin(angle) / 6.0;
        weight[s.count] = solid * (1.0 - fabs(i - at) / step);
        sum += weight[s.count++];
    }
    for (int i = 0; i < s.count; i++) s.fraction[i] = (float)(weight[i] / sum);
    return s;
}

// Computes a texel of the copy from rows of `width` texels.
WIDE_INLINE void shrink_texel(const float *row, size_t width, const struct texel_span *rows,
                              const struct texel_span *columns, size_t channels, float *texel) {
    float sum[4] = {0.0f};
    for (int j = 0; j < rows->count; j++) {
        const float *at = row + ((size_t)j * width + (size_t)columns->first) * channels;
        for (int i = 0; i < columns->count; i++)
            for (size_t c = 0; c < channels; c++)
                sum[c] += rows->fraction[j] * columns->fraction[i] * *at++;
    }
    for (size_t c = 0; c < channels; c++) texel[c] = sum[c];
}

WIDE_INLINE void shrink_row(const float *row, size_t from_width, const struct texel_span *rows,
                            const struct texel_span *column, int width, size_t channels,
                            float *texel) {
    for (int x = 0; x < width; x++)
        shrink_texel(row, from_width, rows, &column[x], channels, texel + (size_t)x * channels);
}

// The rows of a span as floats: those of the image, or those that its bytes stand for, which are
// put into `buffer`.
static const float *rows_of(const struct image *from, const struct texel_span *rows,
                            float *buffer) {
    const size_t row = (size_t)from->width * (size_t)from->channels;
    const size_t first = (size_t)rows->first * row;
    if (!from->byte) return from->texel + first;
    for (size_t i = 0; i < (size_t)rows->count * row; i++)
        buffer[i] = from->byte_value[from->byte[first + i]];
    return buffer;
}

static void shrink_image(const struct image *from, const struct image *to, bool environment,
                         const struct texel_span *column, float *buffer, float *texel) {
    const size_t channels = (size_t)from->channels, width = (size_t)from->width;
    for (int y = 0; y < to->height; y++, texel += (size_t)to->width * channels) {
        const struct texel_span rows = environment ? environment_span(y, from->height, to->height)
                                                   : span_of(y, from->height, to->height);
        const float *row = rows_of(from, &rows, buffer);
        // The numbers of channels that images have, as constants.
        if (channels == 1) shrink_row(row, width, &rows, column, to->width, 1, texel);
        if (channels == 3) shrink_row(row, width, &rows, column, to->width, 3, texel);
    }
}

bool load_image_coarser(struct arena *arena, const struct image *from, bool environment,
                        struct image *out) {
    const int width = half_size(from->width), height = half_size(from->height);
    const size_t texels = (size_t)width * (size_t)height;
    float *texel = arena_array_alone(arena, texels * (size_t)from->channels, sizeof *texel);
    struct texel_span *column = array_new_unset((size_t)width, sizeof *column);
    const size_t rows = from->byte ? SPAN_MOST * (size_t)from->width * (size_t)from->channels : 1;
    float *buffer = array_new_unset(rows, sizeof *buffer);
    if (!texel || !column || !buffer) {
        free(column);
        free(buffer);
        return false;
    }
    for (int x = 0; x < width; x++) column[x] = span_of(x, from->width, width);
    const struct image to = scene_image_make(width, height, from->channels, texel);
    shrink_image(from, &to, environment, column, buffer, texel);
    free(column);
    free(buffer);
    *out = to;
    return true;
}

bool load_image_levels(struct arena *arena, const struct image *image, struct image **level,
                       int *levels) {
    int count = 0;
    for (int w = image->width, h = image->height; w > 1 || h > 1;
         w = half_size(w), h = half_size(h))
        count++;
    struct image *made = arena_array(arena, (size_t)count, sizeof *made);
    if (!made) return false;
    for (int i = 0; i < count; i++)
        if (!load_image_coarser(arena, i ? &made[i - 1] : image, false, &made[i])) return false;
    *level = made;
    *levels = count;
    return true;
}
