// SPDX-License-Identifier: Apache-2.0
// The hot functions in vectors of the native width, one source for every instruction set.
//
// Evaluation and projection handle RSH_WIDTH directions per vector. The Legendre functions are kept
// monic, so a step of their recurrence is two operations, and the normalisation is applied once per
// coefficient at the end. Evaluation runs it on 1 - |z|, found in double, so that it is right to
// 1e-6 also where functions are steep. Projection folds the factor Re, Im (x + i y)^m into the
// values, so that each coefficient costs one fused multiply-add.
#include "rsh/rsh_kernel.h"

#include <math.h>

#include "rsh/rsh_batch.h"
#include "rsh/rsh_tables.h"
#include "rsh/rsh_turn.h"
#include "rsh/rsh_vector.h"

// Vectors of directions that share a pass over the sums; vectors prepared ahead of their
// evaluation.
enum { RUN = 4, AHEAD = 4 };
// Orders up to here take only m < FEW_STEEP by differences, which costs more than the recurrence.
enum { GENTLE_ORDER = 10, FEW_STEEP = 2 };

struct directions {
    vf x, y, z;
};

// `keep` lanes are real, the others get the pole.
INLINE struct directions load_directions(const float *const d[3], size_t first, size_t keep) {
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
    return v;
}

// The hemisphere's direction is turned into the sphere's, as in rsh_eval.
INLINE struct directions stretch(rsh_basis basis, struct directions v) {
    if (basis != RSH_HEMISPHERE) return v;
    float z[W], s[W];
    store(z, v.z);
    for (int i = 0; i < W; i++) {
        z[i] = z[i] > 0.0f ? z[i] : 0.0f;
        z[i] = z[i] < 1.0f ? z[i] : 1.0f;
        s[i] = 2.0f * sqrtf(z[i] / (1.0f + z[i]));
    }
    return (struct directions){v.x * load(s), v.y * load(s), 2.0f * load(z) - 1.0f};
}

INLINE vf load_values(const float *value, size_t first, size_t keep) {
    if (keep >= W) return load(value + first);
    float tail[W] = {0};
    memcpy(tail, value + first, keep * sizeof *tail);
    return load(tail);
}

// Where to evaluate: the direction as given, u = 1 - |z| and the sign of z once it is the sphere's,
// and the factor that makes x and y the sphere's: size (1 + grow), grow being tiny.
struct place {
    vf x, y, u, sign, size, grow;
};

// Re, Im (x + i y)^m size^m.
struct azimuth {
    vf c, s;
};

// Functions (l, -m) and (l, m): the Legendre function p times the parts of the azimuth.
INLINE void put_pair(float *out, size_t shift, vf p, struct azimuth a) {
    if (shift) store(out - shift, p * a.s);
    store(out + shift, p * a.c);
}

INLINE struct azimuth next_azimuth(struct azimuth a, const struct place *v) {
    return (struct azimuth){v->size * (v->x * a.c - v->y * a.s),
                            v->size * (v->x * a.s + v->y * a.c)};
}

// In double, because degree l makes l (l + 1) / 2 times as much of the error of u and m times as
// much of that of the factor. Lengths are set right as in rsh_eval.
INLINE struct place place_of(bool hemisphere, struct directions v) {
    float x[W], y[W], z[W], u[W], sign[W], size[W], grow[W];
    store(x, v.x);
    store(y, v.y);
    store(z, v.z);
    for (int i = 0; i < W; i++) {
        if (hemisphere) {
            z[i] = z[i] > 0.0f ? z[i] : 0.0f;
            z[i] = z[i] < 1.0f ? z[i] : 1.0f;
        }
        double a = (double)x[i], b = (double)y[i], c = (double)z[i];
        double off = 0.5 - 0.5 * (a * a + b * b + c * c);
        c += c * off;
        size[i] = 1.0f;
        grow[i] = (float)off;
        if (hemisphere) {
            // 2 sqrt(z / (1 + z)), and how far its square is off.
            size[i] = 2.0f * sqrtf(z[i] / (1.0f + z[i]));
            double square = (double)size[i] * (double)size[i];
            grow[i] += (float)(4.0 * c - square * (1.0 + c)) / (8.0f * z[i] + 1e-30f);
            c = 2.0 * c - 1.0;
        }
        u[i] = (float)(1.0 - fabs(c));
        sign[i] = copysignf(1.0f, (float)c);
    }
    return (struct place){v.x, v.y, load(u), load(sign), load(size), load(grow)};
}

// The two factors of functions (l, +-m) that belong to m, for even and for odd l - m: what follows
// is of |z|.
struct sides {
    struct azimuth of[2];
};

INLINE struct sides sides_of(struct azimuth a, int m, const struct place *v) {
    vf right = 1.0f + (float)m * v->grow;
    a.c *= right;
    a.s *= right;
    return (struct sides){{a, {a.c * v->sign, a.s * v->sign}}};
}

// One m: l = m .. order - 1. As |z| = 1 - u, the recurrence is p - u p - b p1, which near the pole
// loses nothing of u.
INLINE void eval_column(int order, int m, vf u, struct sides a, size_t count, float *out) {
    const float *norm = rsh_norm + m * RSH_MAX_ORDER, *b = rsh_recurrence + m * RSH_MAX_ORDER;
    const size_t shift = (size_t)m * count, two = 2 * count;
    float *to = out + (size_t)(m * (m + 1)) * count;
    vf p1 = {0}, p = splat(1.0f);
    for (int l = m; l < order; l += 2) {
        put_pair(to, shift, p * norm[l], a.of[0]);
        if (l + 1 == order) break;
        p1 = (p - u * p) - b[l + 1] * p1;
        to += (size_t)(l + 1) * two;
        put_pair(to, shift, p1 * norm[l + 1], a.of[1]);
        if (l + 2 >= order) break;
        p = (p1 - u * p1) - b[l + 2] * p;
        to += (size_t)(l + 2) * two;
    }
}

// All m < `steep` side by side, by differences of u.
INLINE void eval_steep(int order, int steep, vf u, const struct sides *a, size_t count,
                       float *out) {
    vf q[RSH_STEEP], d[RSH_STEEP];
    for (int m = 0; m < steep; m++) {
        q[m] = splat(1.0f);
        d[m] = (vf){0};
    }
    for (int l = 0; l < order; l++)
        for (int m = 0; m < steep && m <= l; m++) {
            const int at = m * RSH_MAX_ORDER + l;
            if (l > m) {
                d[m] -= (rsh_bend[at] * u) * q[m];
                q[m] += rsh_keep[at] * d[m];
            }
            put_pair(out + (size_t)(l * (l + 1)) * count, (size_t)m * count, q[m] * rsh_pole[at],
                     a[m].of[(l - m) & 1]);
        }
}

// All functions of one vector of directions.
INLINE void eval_vector(int order, int steep, const struct place *v, float scale, size_t count,
                        float *out) {
    struct azimuth a = {splat(scale), {0}};
    struct sides sides[RSH_STEEP];
    for (int m = 0; m < steep; m++, a = next_azimuth(a, v)) sides[m] = sides_of(a, m, v);
    eval_steep(order, steep, v->u, sides, count, out);
    for (int m = steep; m < order; m++, a = next_azimuth(a, v))
        eval_column(order, m, v->u, sides_of(a, m, v), count, out);
}

static void kernel_eval_many(rsh_basis basis, int order, size_t count, const float *x,
                             const float *y, const float *z, float *out) {
    const float *const d[3] = {x, y, z};
    const float scale = basis == RSH_HEMISPHERE ? sqrtf(2.0f) : 1.0f;
    for (size_t first = 0; first < count; first += AHEAD * W) {
        struct place v[AHEAD];
        const size_t left = count - first;
        const size_t vectors = left < AHEAD * W ? (left + W - 1) / W : AHEAD;
        // Those of the next vectors need not wait for the stores of the functions.
        for (size_t i = 0; i < vectors; i++) {
            struct directions w = load_directions(d, first + i * W, left - i * W);
            v[i] = basis == RSH_HEMISPHERE ? place_of(true, w) : place_of(false, w);
        }
        for (size_t i = 0; i < vectors; i++) {
            const size_t at = first + i * W, keep = count - at;
            float tail[RSH_MAX_COEFFICIENTS * W], *to = keep < W ? tail : out + at;
            const size_t step = keep < W ? W : count;
            if (order > GENTLE_ORDER)
                eval_vector(order, RSH_STEEP, &v[i], scale, step, to);
            else
                eval_vector(order, FEW_STEEP, &v[i], scale, step, to);
            for (int k = 0; k < order * order && keep < W; k++)
                memcpy(out + (size_t)k * count + at, tail + k * W, keep * sizeof *out);
        }
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
            struct directions v = stretch(basis, load_directions(d, at, left));
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
