// SPDX-License-Identifier: Apache-2.0
// Projection of weighted samples onto the harmonics, RSH_WIDTH samples per vector.
//
// The sums are not those of the harmonics, but of f_k(z) Re, Im (x + i y)^m with one set of f_k for
// all m. So f_k times the values is computed once per k, and every sum costs one multiply-add, or
// one addition for m = 0. At the end a triangular matrix per m converts the sums to those of
// Y_(m+k)^m (rsh_mix). The f_k are Gegenbauer polynomials, scaled so that a step of their
// recurrence is one multiply-add. Those of Chebyshev's second kind are between the Legendre
// functions of m = 0 and of m = 1, which keeps the entries of the matrices small: they multiply the
// rounding of the sums by 7 at most up to order 10. Beyond that order small and large m have
// different sets, and the factor is 5.
#include "rsh/rsh_directions.h"
#include "rsh/rsh_kernel.h"
#include "rsh/rsh_tables.h"

// Vectors of samples per pass over the sums; cosine and sine; channels.
enum { RUN = 4, PHASES = 2, MOST = 3 };
// Up to order ONE_SET all m have one set of functions; larger orders use the second set from m =
// SECOND on.
enum { ONE_SET = 10, SECOND = 3 };
// The stride of the sums of one k and m: PHASES * MOST, and two unused.
enum { SPACE = 8 };
typedef float sextet __attribute__((vector_size(4 * SPACE)));

// Re and Im (x + i y)^m of RUN vectors of samples.
struct phases {
    vf c[RUN], s[RUN];
};

// RUN vectors of samples with 2 z. The values are the caller's arrays or a padded copy.
struct project_run {
    struct phases phase[RSH_MAX_ORDER];
    vf z[RUN];
    const float *value[MOST];
    float padded[MOST][RUN * W];
};

INLINE void load_run(rsh_basis basis, int channels, size_t first, size_t count,
                     const float *const d[3], const float *const value[3], struct project_run *r) {
    for (size_t i = 0; i < RUN; i++) {
        size_t at = first + i * W, left = at < count ? count - at : 0;
        struct directions v = load_directions(d, at, left);
        if (basis == RSH_HEMISPHERE) {
            vf s = stretch_height(&v.z);
            v.x *= s;
            v.y *= s;
            v.z = 2.0f * v.z - 1.0f;
        }
        r->phase[1].c[i] = v.x, r->phase[1].s[i] = v.y, r->z[i] = v.z + v.z;
    }
    const bool whole = count - first >= RUN * W;
    for (int a = 0; a < channels; a++) {
        r->value[a] = whole ? value[a] + first : r->padded[a];
        if (whole) continue;
        memset(r->padded[a], 0, sizeof r->padded[a]);
        memcpy(r->padded[a], value[a] + first, (count - first) * sizeof *value[a]);
    }
}

// Adds g to the sums of m = 0.
INLINE vf *add_zonal(int channels, vf g[MOST][RUN], vf *sum) {
    for (int a = 0; a < channels; a++) sum[a] += (g[a][0] + g[a][1]) + (g[a][2] + g[a][3]);
    return sum + channels;
}

// Adds g times cosine and sine to the sums of one m. The run is added up before it is added to the
// sums, because these adders work at the same time as the products.
INLINE vf *add_phase(int channels, const struct phases *t, vf g[MOST][RUN], vf *sum) {
    vf total[MOST][PHASES];
    for (int i = 0; i < RUN; i++) {
        vf c = t->c[i], s = t->s[i];
        RSH_KEEP(c);
        RSH_KEEP(s);
        for (int a = 0; a < channels; a++) {
            total[a][0] = i ? total[a][0] + g[a][i] * c : g[a][i] * c;
            total[a][1] = i ? total[a][1] + g[a][i] * s : g[a][i] * s;
        }
    }
    for (int p = 0; p < PHASES * channels; p++) sum[p] += total[p / PHASES][p % PHASES];
    return sum + PHASES * channels;
}

// Computes (x + i y)^m from smaller powers.
INLINE void next_phase(int m, struct phases *phase) {
    const struct phases *half = phase + m / 2, *other = phase + (m + 1) / 2;
    for (int i = 0; i < RUN; i++) {
        const struct azimuth a = azimuth_of(half->c[i], half->s[i]);
        const struct azimuth t =
            m % 2 ? azimuth_add(a, azimuth_of(other->c[i], other->s[i])) : azimuth_double(a);
        phase[m].c[i] = t.c, phase[m].s[i] = t.s;
    }
}

// Adds to the sums of m = first .. end - 1, ordered by k, then m, then channel, and returns the
// next sum. Set 0, which begins at m = 0, also computes the powers of x + i y.
INLINE vf *project_set(int order, int channels, int set, int first, int end, struct project_run *r,
                       vf *sum) {
    vf f[RUN], f1[RUN], g[MOST][RUN];
    for (int i = 0; i < RUN; i++) {
        f[i] = splat(1.0f);
        f1[i] = (vf){0};
        for (int a = 0; a < channels; a++) g[a][i] = load(r->value[a] + i * W);
    }
    for (int k = 0; k < order - first; k++) {
        for (int i = 0; i < RUN && k > 0; i++) {
            const vf z = set == 0 ? r->z[i] : rsh_mix_step[set][k] * r->z[i];
            vf next = z * f[i] - f1[i];
            f1[i] = f[i];
            f[i] = next;
            for (int a = 0; a < channels; a++) g[a][i] = next * load(r->value[a] + i * W);
        }
        const int last = end < order - k ? end : order - k;
        if (set == 0) sum = add_zonal(channels, g, sum);
        for (int m = set == 0 ? 1 : first; m < last; m++) {
            if (k == 0 && set == 0 && m > 1) next_phase(m, r->phase);
            sum = add_phase(channels, &r->phase[m], g, sum);
        }
    }
    return sum;
}

// The functions of one set: those of m from `first` to `end` - 1.
struct mixed_set {
    int number, first, end;
};

// Converts the sums of one set, now one number each, and adds them to `out`. Returns the sums of
// the next set.
INLINE const float *mix_set(struct mixed_set set, float scale, int order, int channels,
                            const float *sum, float *out) {
    const int first = set.first, end = set.end;
    const float *row[RSH_MAX_ORDER];
    for (int k = 0; k < order - first; k++) {
        const int last = end < order - k ? end : order - k;
        row[k] = sum;
        sum += channels * (PHASES * (last - first) - (first == 0));
    }
    for (int m = first; m < end; m++) {
        const int at = m ? channels * (PHASES * (m - first) - (first == 0)) : 0;
        for (int k = 0; k < order - m; k++) {
            const float *mix = rsh_mix[set.number][m][k];
            sextet total = {0};
            for (int j = k & 1; j <= k; j += 2) {
                sextet v;
                memcpy(&v, row[j] + at, sizeof v);
                total += (scale * mix[j / 2]) * v;
            }
            float *to = out + (m + k) * (m + k + 1);
            for (int a = 0; a < channels; a++, to += order * order) {
                to[m] += total[m ? PHASES * a : a];
                if (m) to[-m] += total[PHASES * a + 1];
            }
        }
    }
    return sum;
}

// Adds the lanes of all sums and converts them.
INLINE void mix_sums(rsh_basis basis, int order, int channels, int second, const vf *sums,
                     float *out) {
    float sum[MOST * RSH_MAX_COEFFICIENTS + SPACE];
    const float scale = basis == RSH_HEMISPHERE ? sqrtf(2.0f) : 1.0f;
    for (int i = 0; i < channels * order * order; i += 4) {
        const quartet v = sum_four(sums + i);
        memcpy(sum + i, &v, sizeof v);
    }
    memset(sum + channels * order * order, 0, SPACE * sizeof *sum);
    const float *next = mix_set((struct mixed_set){0, 0, second}, scale, order, channels, sum, out);
    if (second < order)
        mix_set((struct mixed_set){1, second, order}, scale, order, channels, next, out);
}

// One function per shape: inlined into one function, they would leave too few registers.
#define PROJECT_SHAPE(name, channels, set)                                              \
    static __attribute__((noinline))                                                    \
    vf *project_##name(int order, int first, int end, struct project_run *r, vf *sum) { \
        return project_set(order, channels, set, first, end, r, sum);                   \
    }
PROJECT_SHAPE(one, 1, 0)
PROJECT_SHAPE(one_more, 1, 1)
PROJECT_SHAPE(three, 3, 0)
PROJECT_SHAPE(three_more, 3, 1)
#undef PROJECT_SHAPE

INLINE void project_one_run(int order, int channels, int second, struct project_run *r, vf *sums) {
    if (channels == 1)
        sums = project_one(order, 0, second, r, sums);
    else
        sums = project_three(order, 0, second, r, sums);
    for (int m = second; m < order; m++) next_phase(m, r->phase);
    if (second < order && channels == 1) project_one_more(order, second, order, r, sums);
    if (second < order && channels == 3) project_three_more(order, second, order, r, sums);
}

INLINE void project_channels(rsh_basis basis, int order, int channels, size_t count,
                             const float *const d[3], const float *const value[3], float *out) {
    vf sums[MOST * RSH_MAX_COEFFICIENTS + 4];
    const int second = order <= ONE_SET ? order : SECOND;
    memset(sums, 0, (size_t)(channels * order * order + 4) * sizeof *sums);
    for (size_t first = 0; first < count; first += RUN * W) {
        struct project_run r;
        load_run(basis, channels, first, count, d, value, &r);
        project_one_run(order, channels, second, &r, sums);
    }
    mix_sums(basis, order, channels, second, sums, out);
}

void GLUE(rsh_project_, RSH_NAME)(rsh_basis basis, int order, size_t count, const float *const d[3],
                                  const float *const value[3], float *out) {
    if (value[1])
        project_channels(basis, order, 3, count, d, value, out);
    else
        project_channels(basis, order, 1, count, d, value, out);
}
