// SPDX-License-Identifier: Apache-2.0
// The hot functions in vectors of the native width, one source for every instruction set.
//
// Evaluation and projection handle RSH_WIDTH directions per vector. The Legendre functions are kept
// monic, so a step of their recurrence is a product and a fused multiply-add, and the
// normalisation is applied once per coefficient at the end. Projection folds the factor
// Re, Im (x + i y)^m into the values, so that each coefficient costs one fused multiply-add.
#include "rsh/rsh_kernel.h"

#include <math.h>

#include "rsh/rsh_batch.h"
#include "rsh/rsh_tables.h"
#include "rsh/rsh_turn.h"
#include "rsh/rsh_vector.h"

enum { RUN = 4 };

struct directions {
    vf x, y, z;
};

// The hemisphere's directions are turned into the sphere's, as in rsh_eval. `keep` lanes are real,
// the others get the pole.
INLINE struct directions load_directions(rsh_basis basis, const float *const d[3], size_t first,
                                         size_t keep) {
    float tail[3][W];
    struct directions v;
    if (keep < W) {
        for (int i = 0; i < W; i++)
            for (int a = 0; a < 3; a++)
                tail[a][i] = (size_t)i < keep ? d[a][first + (size_t)i] : (float)(a == 2);
        v = (struct directions){load(tail[0]), load(tail[1]), load(tail[2])};
    } else {
        v = (struct directions){load(d[0] + first), load(d[1] + first), load(d[2] + first)};
    }
    if (basis == RSH_HEMISPHERE) {
        float z[W], s[W];
        store(z, v.z);
        for (int i = 0; i < W; i++) {
            z[i] = z[i] > 0.0f ? z[i] : 0.0f;
            z[i] = z[i] < 1.0f ? z[i] : 1.0f;
            s[i] = 2.0f * sqrtf(z[i] / (1.0f + z[i]));
        }
        v = (struct directions){v.x * load(s), v.y * load(s), 2.0f * load(z) - 1.0f};
    }
    return v;
}

INLINE vf load_values(const float *value, size_t first, size_t keep) {
    if (keep >= W) return load(value + first);
    float tail[W] = {0};
    memcpy(tail, value + first, keep * sizeof *tail);
    return load(tail);
}

// The functions of one vector of directions go to out[k * count], `keep` lanes of each.
INLINE void put(float *out, vf v, size_t keep) {
    if (keep == W)
        store(out, v);
    else
        memcpy(out, &v, keep * sizeof *out);
}

// One (l, m): the monic Legendre function p times the parts of the azimuth.
INLINE void put_pair(float *out, size_t shift, vf p, vf c, vf s, size_t keep) {
    if (shift) put(out - shift, p * s, keep);
    put(out + shift, p * c, keep);
}

// One m: l = m .. order - 1, for c and s = Re, Im (x + i y)^m.
INLINE void eval_column(int order, int m, vf z, vf c, vf s, size_t count, size_t keep, float *out) {
    const float *norm = rsh_norm + m * RSH_MAX_ORDER, *b = rsh_recurrence + m * RSH_MAX_ORDER;
    const size_t shift = (size_t)m * count, two = 2 * count;
    float *to = out + (size_t)(m * (m + 1)) * count;
    put_pair(to, shift, splat(norm[m]), c, s, keep);
    vf p1 = splat(1.0f), p = z;
    for (int l = m + 1; l < order; l++) {
        to += (size_t)l * two;
        put_pair(to, shift, p * norm[l], c, s, keep);
        if (l + 1 == order) break;
        vf next = z * p - b[l + 1] * p1;
        p1 = p;
        p = next;
    }
}

// Re, Im (x + i y)^m.
struct azimuth {
    vf c, s;
};

INLINE struct azimuth next_azimuth(struct azimuth a, struct directions v) {
    return (struct azimuth){v.x * a.c - v.y * a.s, v.x * a.s + v.y * a.c};
}

// All m < RSH_STEEP side by side, by differences of u = 1 - |z|.
INLINE void eval_steep(int order, struct directions v, const struct azimuth *a, size_t count,
                       size_t keep, float *out) {
    vf u = (v.x * v.x + v.y * v.y) / (1.0f + magnitude(v.z)), sign = with_sign(splat(1.0f), v.z);
    vf q[RSH_STEEP], d[RSH_STEEP];
    struct azimuth part[2][RSH_STEEP];  // of even and of odd l - m
    for (int m = 0; m < RSH_STEEP; m++) {
        q[m] = splat(1.0f);
        d[m] = (vf){0};
        part[0][m] = a[m];
        part[1][m] = (struct azimuth){a[m].c * sign, a[m].s * sign};
    }
    for (int l = 0; l < order; l++)
        for (int m = 0; m < RSH_STEEP; m++) {
            if (m > l) break;
            const int at = m * RSH_MAX_ORDER + l;
            if (l > m) {
                d[m] = rsh_keep[at] * d[m] - (rsh_bend[at] * u) * q[m];
                q[m] += d[m];
            }
            struct azimuth p = part[(l - m) & 1][m];
            put_pair(out + (size_t)(l * (l + 1)) * count, (size_t)m * count, q[m] * rsh_pole[at],
                     p.c, p.s, keep);
        }
}

// All functions of one vector of directions.
INLINE void eval_vector(int order, struct directions v, float scale, size_t count, size_t keep,
                        float *out) {
    struct azimuth a[RSH_STEEP + 1] = {{splat(scale), {0}}};
    for (int m = 0; m < RSH_STEEP; m++) a[m + 1] = next_azimuth(a[m], v);
    eval_steep(order, v, a, count, keep, out);
    struct azimuth at = a[RSH_STEEP];
    for (int m = RSH_STEEP; m < order; m++, at = next_azimuth(at, v))
        eval_column(order, m, v.z, at.c, at.s, count, keep, out);
}

static void kernel_eval_many(rsh_basis basis, int order, size_t count, const float *x,
                             const float *y, const float *z, float *out) {
    const float *const d[3] = {x, y, z};
    for (size_t first = 0; first < count; first += W) {
        size_t keep = count - first < W ? count - first : W;
        struct directions v = load_directions(basis, d, first, keep);
        float scale = basis == RSH_HEMISPHERE ? sqrtf(2.0f) : 1.0f;
        if (keep == W)
            eval_vector(order, v, scale, count, W, out + first);
        else
            eval_vector(order, v, scale, count, keep, out + first);
    }
}

// Adds to the sums of (l, +-m), l = m .. order - 1, of all channels: per l, channel by channel, the
// sum of p c and, unless m is 0, that of p s.
INLINE vf *project_column(int order, int channels, int m, bool with_sine, const vf z[RUN],
                          vf c[3][RUN], vf s[3][RUN], vf *sum) {
    const float *b = rsh_recurrence + m * RSH_MAX_ORDER;
    vf p[RUN], p1[RUN];
    for (int i = 0; i < RUN; i++) {
        p[i] = splat(1.0f);
        p1[i] = (vf){0};
    }
    for (int l = m; l < order; l++) {
        if (l > m)
            for (int i = 0; i < RUN; i++) {
                vf next = z[i] * p[i] - b[l] * p1[i];
                p1[i] = p[i];
                p[i] = next;
            }
        for (int a = 0; a < channels; a++) {
            for (int i = 0; i < RUN; i++) sum[0] += p[i] * c[a][i];
            sum++;
            if (!with_sine) continue;
            for (int i = 0; i < RUN; i++) sum[0] += p[i] * s[a][i];
            sum++;
        }
    }
    return sum;
}

INLINE void project_channels(rsh_basis basis, int order, int channels, size_t count,
                             const float *const d[3], const float *const value[3], float *out) {
    vf sums[3 * RSH_MAX_COEFFICIENTS];
    int n = order * order;
    memset(sums, 0, (size_t)(channels * n) * sizeof *sums);
    for (size_t first = 0; first < count; first += RUN * W) {
        vf c[3][RUN], s[3][RUN], x[RUN], y[RUN], z[RUN];
        for (size_t i = 0; i < RUN; i++) {
            size_t at = first + i * W, left = at < count ? count - at : 0;
            struct directions v = load_directions(basis, d, at, left);
            x[i] = v.x, y[i] = v.y, z[i] = v.z;
            for (int a = 0; a < channels; a++) c[a][i] = load_values(value[a], at, left);
        }
        vf *sum = project_column(order, channels, 0, false, z, c, s, sums);
        for (int m = 1; m < order; m++) {
            for (int a = 0; a < channels; a++)
                for (int i = 0; i < RUN; i++) {
                    vf t = m == 1 ? c[a][i] * x[i] : c[a][i] * x[i] - s[a][i] * y[i];
                    s[a][i] = m == 1 ? c[a][i] * y[i] : c[a][i] * y[i] + s[a][i] * x[i];
                    c[a][i] = t;
                }
            sum = project_column(order, channels, m, true, z, c, s, sum);
        }
    }
    const vf *sum = sums;
    float scale = basis == RSH_HEMISPHERE ? sqrtf(2.0f) : 1.0f;
    for (int m = 0; m < order; m++)
        for (int l = m; l < order; l++)
            for (int a = 0; a < channels; a++) {
                float f = scale * rsh_norm[m * RSH_MAX_ORDER + l], *to = out + a * n + l * (l + 1);
                to[m] += f * sum_lanes(*sum++);
                if (m) to[-m] += f * sum_lanes(*sum++);
            }
}

static void kernel_project(rsh_basis basis, int order, size_t count, const float *x, const float *y,
                           const float *z, const float *const value[3], float *out) {
    const float *const d[3] = {x, y, z};
    if (value[1])
        project_channels(basis, order, 3, count, d, value, out);
    else
        project_channels(basis, order, 1, count, d, value, out);
}

// One pass over all rows for `vectors` vectors of coefficients, begun at `matrix`; the last vector
// adds its lanes from `skip` on (it may overlap the one before).
INLINE void accumulate_columns(int vectors, int channels, size_t count, size_t row,
                               const float *matrix, const float *const value[3], size_t skip,
                               float *out) {
    vf sum[3][8];
    size_t last = (size_t)(vectors - 1);
    for (int a = 0; a < channels; a++)
        for (int j = 0; j < vectors; j++) sum[a][j] = (vf){0};
    for (size_t i = 0; i < count; i++, matrix += row) {
        vf v[3];
        for (int a = 0; a < channels; a++) v[a] = splat(value[a][i]);
        for (int j = 0; j < vectors; j++) {
            vf h = load(matrix + (size_t)j * W - ((size_t)j == last ? skip : 0));
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

// The widest block whose sums of three channels stay in registers: 24 of 32, or 12 of 16.
enum { BLOCK = RSH_WIDTH == 16 ? 8 : 4 };

INLINE void accumulate_channels(int channels, size_t count, size_t coefficients,
                                const float *matrix, const float *const value[3], float *out) {
    size_t k = 0;
    while (k < coefficients) {
        size_t left = coefficients - k, vectors = (left + W - 1) / W, skip = 0;
        if (vectors > BLOCK)
            vectors = BLOCK;
        else
            skip = vectors * W - left;
        const float *m = matrix + k;
        float *to = out + k;
        switch (vectors) {
#define CASE(n)                                                                   \
    case n:                                                                       \
        accumulate_columns(n, channels, count, coefficients, m, value, skip, to); \
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

// Who takes rows shorter than a vector.
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

// The last n % W terms come with the last vector, whose other lanes are masked out.
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
    .eval_many = kernel_eval_many,
    .project = kernel_project,
    .accumulate = kernel_accumulate,
    .dot3 = kernel_dot3,
    .turn = GLUE(rsh_turn_, RSH_NAME),
    .convert = GLUE(rsh_convert_, RSH_NAME),
    .width = W,
    .angles = GLUE(rsh_angles_, RSH_NAME),
    .turn_many = GLUE(rsh_turn_many_, RSH_NAME),
    .convert_many = GLUE(rsh_convert_many_, RSH_NAME),
};
