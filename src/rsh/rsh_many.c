// SPDX-License-Identifier: Apache-2.0
// Rotation and alignment of many records, given as structures of arrays. Kernels get vectors of
// records; the last vector is padded in scratch, so that the result of a record does not depend on
// its index.
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "rsh/rsh_inline.h"
#include "rsh/rsh_kernel.h"

// Channels that are rotated at once, as many as the kernels process together.
enum { MANY_BLOCK = 3, SCRATCH = MANY_BLOCK * RSH_MAX_COEFFICIENTS * RSH_MAX_WIDTH };

// The operation that one call applies to every record.
struct many {
    const struct rsh_kernels *kernels;
    rsh_basis basis;
    int order, channels;
    enum rsh_method method;  // of every record; if EXACT with beta_limit > 0, that of records
                             // beyond the limit
    float beta_limit;
    bool transposed;
};

// A vector of records with up to MANY_BLOCK `channels`; its coefficients are `stride` apart.
struct channel_block {
    int channels;
    size_t stride;
    const float *in;
    float *out;
};

static void rotate_many_through_sphere(const struct many *j, const struct rsh_rotations *t,
                                       const struct channel_block *p) {
    float sphere[SCRATCH];
    const struct rsh_kernels *k = j->kernels;
    int larger = rsh_sphere_order(j->order);
    size_t width = (size_t)k->width, small = (size_t)(j->order * j->order) * p->stride;
    size_t large = (size_t)(larger * larger) * width;
    const struct rsh_rows *extension = &rsh_extension[j->order - 1];
    const int up[2] = {larger, j->order}, down[2] = {j->order, larger};
    const size_t to_sphere[2] = {width, p->stride}, back[2] = {p->stride, width};
    for (int c = 0; c < p->channels; c++)
        k->convert_many(j->transposed ? &rsh_restriction : extension, j->transposed, up, to_sphere,
                        p->in + (size_t)c * small, sphere + (size_t)c * large);
    k->rotate_many(t, larger, p->channels, width, sphere, sphere);
    for (int c = 0; c < p->channels; c++)
        k->convert_many(j->transposed ? extension : &rsh_restriction, j->transposed, down, back,
                        sphere + (size_t)c * large, p->out + (size_t)c * small);
}

static void rotate_exactly(const struct many *j, const struct rsh_rotations *t,
                           const struct channel_block *p) {
    if (j->basis == RSH_HEMISPHERE)
        rotate_many_through_sphere(j, t, p);
    else
        j->kernels->rotate_many(t, j->order, p->channels, p->stride, p->in, p->out);
}

// Computes both forms and selects for each record the one that its angle requires.
static void rotate_mixed(const struct many *j, const struct rsh_rotations rotations[2],
                         const bool *fast, const struct channel_block *p) {
    float exact[SCRATCH];
    size_t width = (size_t)j->kernels->width, n = (size_t)(j->order * j->order * p->channels);
    float padded[SCRATCH];
    for (size_t k = 0; k < n; k++)
        memcpy(padded + k * width, p->in + k * p->stride, width * sizeof *padded);
    rotate_exactly(j, &rotations[0], &(struct channel_block){p->channels, width, padded, exact});
    j->kernels->rotate_many(&rotations[1], j->order, p->channels, width, padded, padded);
    for (size_t k = 0; k < n; k++)
        for (size_t i = 0; i < width; i++)
            p->out[k * p->stride + i] = fast[i] ? padded[k * width + i] : exact[k * width + i];
}

// Rotates one vector of records in all channels, by their matrices.
static void rotate_vector(const struct many *j, const float r[9][RSH_MAX_WIDTH], size_t stride,
                          const float *in, float *out) {
    struct rsh_rotations rotations[2];  // by the exact and by the fast method
    bool fast[RSH_MAX_WIDTH];
    int width = j->kernels->width, count = 0;
    j->kernels->angles(r, false, &rotations[0]);
    rotations[0].method = j->method;
    for (int i = 0; i < width; i++) count += fast[i] = rotations[0].beta[i] <= j->beta_limit;
    if (count) {
        rotations[1] = rotations[0];
        if (j->basis == RSH_HEMISPHERE) j->kernels->angles(r, true, &rotations[1]);
        rotations[1].method = RSH_METHOD_TAYLOR_2;
    }
    size_t n = (size_t)(j->order * j->order) * stride;
    for (int c = 0; c < j->channels; c += MANY_BLOCK, in += MANY_BLOCK * n, out += MANY_BLOCK * n) {
        const struct channel_block p = {j->channels - c < MANY_BLOCK ? j->channels - c : MANY_BLOCK,
                                        stride, in, out};
        if (count == 0)
            rotate_exactly(j, &rotations[0], &p);
        else if (count == width)
            j->kernels->rotate_many(&rotations[1], j->order, p.channels, stride, in, out);
        else
            rotate_mixed(j, rotations, fast, &p);
    }
}

// Rotates the last `tail` of `count` records, fewer than a vector, padded with copies of the first
// of them.
static void rotate_tail(const struct many *j, const float r[9][RSH_MAX_WIDTH], size_t tail,
                        size_t count, const float *in, float *out) {
    float padded[SCRATCH];
    size_t width = (size_t)j->kernels->width, n = (size_t)(j->order * j->order);
    struct many one = *j;
    for (int c = 0; c < j->channels;
         c += MANY_BLOCK, in += MANY_BLOCK * n * count, out += MANY_BLOCK * n * count) {
        one.channels = j->channels - c < MANY_BLOCK ? j->channels - c : MANY_BLOCK;
        size_t rows = n * (size_t)one.channels;
        for (size_t k = 0; k < rows; k++)
            for (size_t i = 0; i < width; i++)
                padded[k * width + i] = in[k * count + (i < tail ? i : 0)];
        rotate_vector(&one, r, width, padded, padded);
        for (size_t k = 0; k < rows; k++)
            memcpy(out + k * count, padded + k * width, tail * sizeof *out);
    }
}

// Loads the entries of `count` records from `first` on, and those of the first of them into further
// lanes.
INLINE void load_entries(int lanes, const float *const a[9], size_t first, size_t count,
                         float f[9][RSH_MAX_WIDTH]) {
    for (int e = 0; e < 9; e++) {
        const float *from = a[e] + first;
        if (count == (size_t)lanes)
            memcpy(f[e], from, (size_t)lanes * sizeof **f);
        else
            for (int i = 0; i < lanes; i++) f[e][i] = from[(size_t)i < count ? i : 0];
    }
}

// Frames that are equal in all numbers have no rotation between them, even if they are not
// orthonormal, as in rsh_align.
INLINE void leave_out_equal(int lanes, const float f[9][RSH_MAX_WIDTH],
                            const float g[9][RSH_MAX_WIDTH], float r[9][RSH_MAX_WIDTH]) {
    int32_t differ[RSH_MAX_WIDTH] = {0}, equal = 0;
    for (int e = 0; e < 9; e++)
        for (int i = 0; i < lanes; i++) differ[i] |= f[e][i] != g[e][i] ? -1 : 0;
    for (int i = 0; i < lanes; i++) equal |= ~differ[i];
    for (int i = 0; i < lanes && equal; i++)
        for (int e = 0; e < 9 && !differ[i]; e++) r[e][i] = e % 4 == 0 ? 1.0f : 0.0f;
}

// The rotations of coordinates from frames a to frames b, or r = a if b is NULL, a record per lane.
// Sums are rounded as in rsh_align, so that angles that depend on rounding are the same.
INLINE void load_matrices(int lanes, const float *const a[9], const float *const *b, size_t first,
                          size_t count, float r[9][RSH_MAX_WIDTH]) {
    float f[9][RSH_MAX_WIDTH], g[9][RSH_MAX_WIDTH];
    if (!b) {
        load_entries(lanes, a, first, count, r);
        return;
    }
    load_entries(lanes, a, first, count, f);
    load_entries(lanes, b, first, count, g);
    for (int e = 0; e < 9; e++) {
        const float(*x)[RSH_MAX_WIDTH] = &g[e / 3 * 3], (*y)[RSH_MAX_WIDTH] = &f[e % 3 * 3];
        for (int i = 0; i < lanes; i++)
            r[e][i] = x[0][i] * y[0][i] + x[1][i] * y[1][i] + x[2][i] * y[2][i];
    }
    leave_out_equal(lanes, f, g, r);
}

// One function per width, so that loops over lanes are vectorised.
#define LOAD(lanes)                                                                             \
    static void load_rotations_##lanes(const float *const a[9], const float *const *b,          \
                                       size_t first, size_t count, float r[9][RSH_MAX_WIDTH]) { \
        load_matrices(lanes, a, b, first, count, r);                                            \
    }
LOAD(1)
LOAD(4)
LOAD(8)
LOAD(16)
#undef LOAD

typedef void load_rotations(const float *const a[9], const float *const *b, size_t first,
                            size_t count, float r[9][RSH_MAX_WIDTH]);

static load_rotations *loader_of(int width) {
    return width == 16  ? load_rotations_16
           : width == 8 ? load_rotations_8
           : width == 4 ? load_rotations_4
                        : load_rotations_1;
}

static bool all_in_range(const float *const a[9], size_t count) {
    uint32_t bad = 0;
    for (int e = 0; e < 9; e++)
        for (size_t i = 0; i < count; i++) bad |= !(fabsf(a[e][i]) <= RSH_MAX_ENTRY);
    return !bad;
}

static bool run_many(struct many *j, size_t count, const float *const a[9], const float *const *b,
                     const float *in, float *out) {
    if (!rsh_basis_ok(j->basis) || !rsh_order_ok(j->order)) return false;
    if (!all_in_range(a, count) || (b && !all_in_range(b, count))) return false;
    j->kernels = rsh_kernels_best();
    size_t width = (size_t)j->kernels->width;
    load_rotations *const load = loader_of(j->kernels->width);
    for (size_t i = 0; i < count; i += width) {
        float r[9][RSH_MAX_WIDTH];
        size_t left = count - i < width ? count - i : width;
        load(a, b, i, left, r);
        if (left == width)
            rotate_vector(j, r, count, in + i, out + i);
        else
            rotate_tail(j, r, left, count, in + i, out + i);
    }
    return true;
}

bool rsh_rotate_many(int order, int channels, size_t count, const float *const r[9],
                     const float *in, float *out) {
    struct many j = {.order = order, .channels = channels, .method = RSH_METHOD_EXACT};
    j.beta_limit = -1.0f;
    return run_many(&j, count, r, NULL, in, out);
}

bool rsh_rotate_taylor_many(rsh_taylor kind, int order, int channels, size_t count,
                            const float *const r[9], const float *in, float *out) {
    struct many j = {.order = order, .channels = channels, .beta_limit = -1.0f};
    return rsh_method_of_taylor(kind, &j.method) && run_many(&j, count, r, NULL, in, out);
}

// With a limit of 0 only hemispherical records whose normals agree use the fast form, which saves
// the conversion through the sphere.
static struct many align_many(const rsh_alignments *a, int order, int channels) {
    struct many j = {.basis = a->basis, .order = order, .channels = channels};
    j.method = RSH_METHOD_EXACT;
    j.beta_limit = a->beta_limit > 0.0f ? a->beta_limit : a->basis == RSH_HEMISPHERE ? 0.0f : -1.0f;
    return j;
}

bool rsh_align_many(const rsh_alignments *a, int order, int channels, size_t count, const float *in,
                    float *out) {
    struct many j = align_many(a, order, channels);
    return run_many(&j, count, a->from, a->to, in, out);
}

bool rsh_align_transposed_many(const rsh_alignments *a, int order, int channels, size_t count,
                               const float *in, float *out) {
    struct many j = align_many(a, order, channels);
    j.transposed = true;
    return run_many(&j, count, a->to, a->from, in, out);
}
