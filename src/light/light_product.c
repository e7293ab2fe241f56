// SPDX-License-Identifier: Apache-2.0
// Samples the visible-environment histogram of a cell by the product of what is visible and of how
// much of it a point receives (product importance sampling [Clarberg et al. 2005]). By what is
// visible alone, a third of the samples of a furnished room went below the horizon of their point.
// Of a block of bins, the solid angle and the cosine are those of its middle, with its radius added
// to distance and height, so that no bin above the horizon has no weight.
#include "base/sampling.h"
#include "light/light_kinds.h"

enum { BLOCK_SIDE = LIGHT_BLOCK_SIDE, BLOCK_COLUMNS = LIGHT_BLOCK_COLUMNS };

// Bins so near the foot of a point on their face have most of their solid angle in a small part.
static const float NEAR_BINS = 2.0f;

// ---- The histogram ------------------------------------------------------------------------------

// The bin of a block that is in one of its rows and columns.
static size_t bin_in_block(size_t block_row, size_t block_column, size_t row, size_t column) {
    return (block_row * BLOCK_SIDE + row) * LIGHT_HISTOGRAM_SIDE + block_column * BLOCK_SIDE +
           column;
}

// Appends the block to the last row if it has one of the bins.
static void append_block(const bool bin[LIGHT_HISTOGRAM_BINS], size_t row, size_t column,
                         struct light_blocks *out) {
    const size_t block = out->first[out->rows + 1];
    bool any = false;
    for (size_t i = 0; i < BLOCK_SIDE * BLOCK_SIDE; i++)
        any |= bin[bin_in_block(row, column, i / BLOCK_SIDE, i % BLOCK_SIDE)];
    if (!any) return;
    const int first = (int)bin_in_block(row, column, 0, 0),
              last = (int)bin_in_block(row, column, BLOCK_SIDE - 1, BLOCK_SIDE - 1);
    const vec3 middle = v3_mul(v3_add(light_box_point(&out->box, first, 0.0f, 0.0f),
                                      light_box_point(&out->box, last, 1.0f, 1.0f)),
                               0.5f);
    out->column[block] = (uint8_t)column;
    out->x[block] = middle.x;
    out->y[block] = middle.y;
    out->z[block] = middle.z;
    out->first[out->rows + 1]++;
}

void light_blocks_build(const struct light_box *box, const bool bin[LIGHT_HISTOGRAM_BINS],
                        struct light_blocks *out) {
    out->box = *box;
    out->rows = 0;
    out->first[0] = 0;
    for (size_t row = 0; row < LIGHT_BLOCK_ROWS; row++) {
        if (row % BLOCK_COLUMNS == 0) out->face[row / BLOCK_COLUMNS] = out->rows;
        out->first[out->rows + 1] = out->first[out->rows];
        for (size_t column = 0; column < BLOCK_COLUMNS; column++)
            append_block(bin, row, column, out);
        if (out->first[out->rows + 1] > out->first[out->rows]) out->row[out->rows++] = (uint8_t)row;
    }
    out->face[6] = out->rows;
}

// The weight of a bin of a block, of which the first has this one.
static float weight_in_block(const float *first, size_t i) {
    return first[i / BLOCK_SIDE * LIGHT_HISTOGRAM_SIDE + i % BLOCK_SIDE];
}

static float sum_block(const float *first) {
    float sum = 0.0f;
    for (size_t i = 0; i < BLOCK_SIDE * BLOCK_SIDE; i++) sum += weight_in_block(first, i);
    return sum;
}

static float weight_in_steps(float weight, float largest, float steps) {
    return weight > 0.0f ? ceilf(steps * (weight / largest)) : 0.0f;
}

static void set_bins(const float *first, uint8_t bin[BLOCK_SIDE][BLOCK_SIDE]) {
    float most = 0.0f;
    for (size_t i = 0; i < BLOCK_SIDE * BLOCK_SIDE; i++)
        most = maxf(most, weight_in_block(first, i));
    for (size_t i = 0; i < BLOCK_SIDE * BLOCK_SIDE; i++)
        bin[i / BLOCK_SIDE][i % BLOCK_SIDE] =
            (uint8_t)weight_in_steps(weight_in_block(first, i), most, UINT8_MAX);
}

void light_histogram_build(const float weight[LIGHT_HISTOGRAM_BINS], float fraction,
                           const struct light_blocks *blocks, struct light_histogram *out) {
    float sum[LIGHT_BLOCKS], largest = 0.0f;
    const size_t count = blocks->first[blocks->rows];
    for (size_t at = 0; at < blocks->rows; at++)
        for (size_t i = blocks->first[at]; i < blocks->first[at + 1]; i++) {
            const float *first = weight + bin_in_block(blocks->row[at], blocks->column[i], 0, 0);
            sum[i] = sum_block(first);
            largest = maxf(largest, sum[i]);
            set_bins(first, out->bin[i]);
        }
    for (size_t i = 0; i < count; i++)
        out->weight[i] = (uint16_t)weight_in_steps(sum[i], largest, UINT16_MAX);
    out->fraction = fraction;
    out->blocks = blocks;
}

// ---- The product --------------------------------------------------------------------------------

// What the weights of the blocks of a face follow from. Lengths are relative to the largest extent
// of the box, so that their powers are in the range of floats whatever the unit of the scene is.
struct face_of_blocks {
    vec3 p, n;
    bool both;
    float scale;   // 1 / extent
    float height;  // of p above the face
    float radius;  // of a block
};

static struct face_of_blocks face_from(const struct light_box *box, const struct light_receiver *at,
                                       vec3 p, int f) {
    const int axis = f / 2;
    const float scale = 1.0f / v3_max_abs(v3_sub(box->hi, box->lo)),
                side = light_box_bin_width(box, (axis + 1) % 3),
                other = light_box_bin_width(box, (axis + 2) % 3);
    const float distance = v3_along(f % 2 ? box->hi : box->lo, axis) - v3_along(p, axis);
    return (struct face_of_blocks){
        .p = p,
        .n = at->n,
        .both = at->both,
        .scale = scale,
        .height = scale * fabsf(distance),
        .radius = 0.5f * BLOCK_SIDE * scale * sqrtf(side * side + other * other)};
}

static void set_block_weights(const struct light_histogram *h, const struct face_of_blocks *face,
                              size_t first, size_t end, float *weight) {
    const struct light_blocks *b = h->blocks;
    const float r = face->radius;
    for (size_t i = first; i < end; i++) {
        const float x = (b->x[i] - face->p.x) * face->scale,
                    y = (b->y[i] - face->p.y) * face->scale,
                    z = (b->z[i] - face->p.z) * face->scale;
        const float along = face->n.x * x + face->n.y * y + face->n.z * z;
        const float above = maxf((face->both ? fabsf(along) : along) + r, 0.0f);
        const float t2 = x * x + y * y + z * z + r * r;
        weight[i] = (float)h->weight[i] * face->height * above / (t2 * t2);
    }
}

// Whether the histogram has an opening in face f less than NEAR_BINS from the foot of p on it.
static bool opens_near(const struct light_histogram *h, int f, vec3 p) {
    const struct light_blocks *b = h->blocks;
    const int next = (f / 2 + 1) % 3, last = (f / 2 + 2) % 3;
    const float side = (0.5f * BLOCK_SIDE + NEAR_BINS) * light_box_bin_width(&b->box, next),
                other = (0.5f * BLOCK_SIDE + NEAR_BINS) * light_box_bin_width(&b->box, last);
    for (size_t i = b->first[b->face[f]]; i < b->first[b->face[f + 1]]; i++) {
        const vec3 d = v3(b->x[i] - p.x, b->y[i] - p.y, b->z[i] - p.z);
        if (h->weight[i] && fabsf(v3_along(d, next)) < side && fabsf(v3_along(d, last)) < other)
            return true;
    }
    return false;
}

// The point from which directions to the bins are drawn at `at`: apart from a face only where that
// is open there, as at the reveal of a window.
static vec3 origin_of(const struct light_histogram *h, vec3 at) {
    const struct light_box *box = &h->blocks->box;
    const vec3 in = light_box_inside(box, at), apart = light_box_apart(box, at);
    float x[3];
    for (int axis = 0; axis < 3; axis++) {
        const float from = v3_along(in, axis), away = v3_along(apart, axis);
        const bool moved = from != away && opens_near(h, 2 * axis + (from > away), in);
        x[axis] = moved ? away : from;
    }
    return v3(x[0], x[1], x[2]);
}

void light_product_make(const struct light_histogram *histogram, const struct light_receiver *at,
                        struct light_product *out) {
    const struct light_blocks *blocks = histogram->blocks;
    const vec3 p = origin_of(histogram, at->p);
    out->histogram = histogram;
    out->p = p;
    out->sum = 0.0f;
    for (int f = 0; f < 6; f++) {
        const size_t rows = blocks->face[f + 1];
        size_t row = blocks->face[f], i = blocks->first[row];
        if (row == rows) continue;
        const struct face_of_blocks face = face_from(&blocks->box, at, p, f);
        set_block_weights(histogram, &face, i, blocks->first[rows], out->block);
        for (; row < rows; row++) {
            float sum = 0.0f;
            for (; i < blocks->first[row + 1]; i++) sum += out->block[i];
            out->row[row] = sum;
            out->sum += sum;
        }
    }
    out->fraction = out->sum > 0.0f ? histogram->fraction : 0.0f;
}

// ---- Samples ------------------------------------------------------------------------------------

// Draws one of n items by their weights, of which some are > 0 and whose sum is known. *u is
// rescaled to [0, 1) within it.
static size_t draw_item(const float *weight, size_t n, float sum, float *u) {
    float rest = *u * sum;
    size_t last = 0;
    for (size_t i = 0; i < n; i++) {
        if (!(weight[i] > 0.0f)) continue;
        last = i;
        if (rest < weight[i]) break;
        rest -= weight[i];
    }
    *u = minf(rest / weight[last], SAMPLE_BELOW_ONE);
    return last;
}

// The sums of the weights of the bins in each row of a block. Returns the sum of all.
static float sum_rows(const struct light_histogram *h, size_t block, float sum[BLOCK_SIDE]) {
    float all = 0.0f;
    for (size_t i = 0; i < BLOCK_SIDE; i++) {
        const uint8_t *bin = h->bin[block][i];
        sum[i] = (float)(bin[0] + bin[1] + bin[2] + bin[3]);
        all += sum[i];
    }
    return all;
}

vec3 light_product_sample(const struct light_product *product, float u, float v, float *pdf_w) {
    const struct light_histogram *h = product->histogram;
    const struct light_blocks *blocks = h->blocks;
    const size_t at = draw_item(product->row, blocks->rows, product->sum, &u),
                 first = blocks->first[at];
    const size_t block = first + draw_item(product->block + first, blocks->first[at + 1] - first,
                                           product->row[at], &v);
    float row_weight[BLOCK_SIDE], bin_weight[BLOCK_SIDE];
    const float all = sum_rows(h, block, row_weight);
    const size_t row = draw_item(row_weight, BLOCK_SIDE, all, &u);
    for (size_t i = 0; i < BLOCK_SIDE; i++) bin_weight[i] = (float)h->bin[block][row][i];
    const size_t column = draw_item(bin_weight, BLOCK_SIDE, row_weight[row], &v);
    const int bin = (int)bin_in_block(blocks->row[at], blocks->column[block], row, column);
    float density;
    const vec3 w = light_box_direction(&blocks->box, product->p, bin, u, v, &density);
    *pdf_w = product->block[block] / product->sum * (bin_weight[column] / all) * density;
    return w;
}

float light_product_pdf(const struct light_product *product, vec3 w) {
    const struct light_histogram *h = product->histogram;
    const struct light_blocks *blocks = h->blocks;
    float density;
    const size_t bin = (size_t)light_box_bin(&blocks->box, product->p, w, &density);
    const size_t row = bin / LIGHT_HISTOGRAM_SIDE, column = bin % LIGHT_HISTOGRAM_SIDE;
    size_t at = blocks->face[row / LIGHT_HISTOGRAM_SIDE];
    while (at < blocks->rows && blocks->row[at] < row / BLOCK_SIDE) at++;
    if (at == blocks->rows || blocks->row[at] != row / BLOCK_SIDE) return 0.0f;
    size_t block = blocks->first[at];
    const size_t end = blocks->first[at + 1];
    while (block < end && blocks->column[block] != column / BLOCK_SIDE) block++;
    if (block == end || !(product->block[block] > 0.0f)) return 0.0f;
    float row_weight[BLOCK_SIDE];
    const float all = sum_rows(h, block, row_weight);
    const float of_bin = (float)h->bin[block][row % BLOCK_SIDE][column % BLOCK_SIDE];
    return product->block[block] / product->sum * (of_bin / all) * density;
}
