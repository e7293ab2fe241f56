// SPDX-License-Identifier: Apache-2.0
// Projection of weighted samples onto the harmonics, RSH_WIDTH samples per vector.
//
// The sums are not those of the harmonics but of f_k(z) Re, Im (x + i y)^m with one set of f_k for
// all m, so that f_k times the values is found once per k and every sum costs one multiply-add, for
// m = 0 one addition. A triangular matrix per m turns the sums into those of Y_(m+k)^m at the end
// (rsh_mix). The f_k are the Legendre functions of one m in the middle, which keeps the entries of
// the matrices small: sums enlarge their rounding by 7 at most up to order 10. Beyond it small and
// large m have sets of their own, and it is 5.
#include "rsh/rsh_directions.h"
#include "rsh/rsh_kernel.h"
#include "rsh/rsh_tables.h"

// Vectors of samples that share a pass over the sums; cosine and sine; channels.
enum { RUN = 4, PARTS = 2, MOST = 3 };
// Orders up to here take one set for all m; the others have the second from m = SECOND on.
enum { ONE_SET = 10, SECOND = 3 };

// Re, Im (x + i y)^m and z of RUN vectors of samples, and their values.
struct run {
    vf c[RSH_MAX_ORDER][RUN], s[RSH_MAX_ORDER][RUN], z[RUN], value[MOST][RUN];
};

INLINE void load_run(rsh_basis basis, int order, int channels, size_t first, size_t count,
                     const float *const d[3], const float *const value[3], struct run *r) {
    for (size_t i = 0; i < RUN; i++) {
        size_t at = first + i * W, left = at < count ? count - at : 0;
        struct directions v = load_directions(d, at, left);
        if (basis == RSH_HEMISPHERE) {
            vf s = stretch(&v.z);
            v.x *= s;
            v.y *= s;
            v.z = 2.0f * v.z - 1.0f;
        }
        r->c[1][i] = v.x, r->s[1][i] = v.y, r->z[i] = v.z;
        for (int a = 0; a < channels; a++) r->value[a][i] = load_values(value[a], at, left);
    }
    for (int m = 2; m < order; m += 2)
        for (int i = 0; i < RUN; i++) {
            const struct azimuth one = azimuth_of(r->c[1][i], r->s[1][i]);
            const struct azimuth even = azimuth_double(azimuth_of(r->c[m / 2][i], r->s[m / 2][i]));
            const struct azimuth odd = azimuth_add(even, one);
            r->c[m][i] = even.c, r->s[m][i] = even.s;
            r->c[m + 1][i] = odd.c, r->s[m + 1][i] = odd.s;
        }
}

// Adds g c_m and g s_m to the sums of one k, m = first .. end - 1; of m = 0 only the first is used.
INLINE vf *add_products(int channels, int first, int end, const struct run *r, vf g[MOST][RUN],
                        vf *sum) {
    int m = first;
    if (m == 0) {
        for (int a = 0; a < channels; a++)
            for (int i = 0; i < RUN; i++) sum[a] += g[a][i];
        sum += channels;
        m++;
    }
    for (; m < end; m++, sum += PARTS * channels) {
        vf total[MOST][PARTS];
        for (int p = 0; p < PARTS * channels; p++) total[p / PARTS][p % PARTS] = sum[p];
        for (int i = 0; i < RUN; i++) {
            vf c = r->c[m][i], s = r->s[m][i];
            RSH_KEEP(c);
            RSH_KEEP(s);
            for (int a = 0; a < channels; a++) {
                total[a][0] += g[a][i] * c;
                total[a][1] += g[a][i] * s;
            }
        }
        for (int p = 0; p < PARTS * channels; p++) sum[p] = total[p / PARTS][p % PARTS];
    }
    return sum;
}

// The sums of m = first .. end - 1, by k, then m, then channel.
INLINE vf *project_set(int order, int channels, int set, int first, int end, const struct run *r,
                       vf *sum) {
    const float *b = rsh_mix_recurrence[set];
    vf f[RUN], f1[RUN], g[MOST][RUN];
    for (int i = 0; i < RUN; i++) {
        f[i] = splat(1.0f);
        f1[i] = (vf){0};
        for (int a = 0; a < channels; a++) g[a][i] = r->value[a][i];
    }
    for (int k = 0; k < order - first; k++) {
        for (int i = 0; i < RUN && k > 0; i++) {
            vf next = r->z[i] * f[i] - b[k] * f1[i];
            f1[i] = f[i];
            f[i] = next;
            for (int a = 0; a < channels; a++) g[a][i] = f[i] * r->value[a][i];
        }
        sum = add_products(channels, first, end < order - k ? end : order - k, r, g, sum);
    }
    return sum;
}

// From the sums of one set to `out`.
INLINE const vf *mix_set(float scale, int order, int channels, int set, int first, int end,
                         const vf *sum, float *out) {
    float sums[RSH_MAX_ORDER][RSH_MAX_ORDER][MOST * PARTS] = {0};
    for (int k = 0; k < order - first; k++)
        for (int m = first; m < end && m < order - k; m++)
            for (int a = 0; a < channels; a++)
                for (int part = 0; part < (m ? PARTS : 1); part++)
                    sums[m][k][PARTS * a + part] = sum_lanes(*sum++);
    for (int m = first; m < end; m++)
        for (int k = 0; k < order - m; k++) {
            const float *mix = rsh_mix[set][m][k];
            float total[MOST * PARTS] = {0};
            for (int j = k & 1; j <= k; j += 2)
                for (int p = 0; p < MOST * PARTS; p++) total[p] += mix[j / 2] * sums[m][j][p];
            const int l = m + k;
            for (int a = 0; a < channels; a++) {
                float *to = out + a * order * order + l * (l + 1);
                to[m] += scale * total[PARTS * a];
                if (m) to[-m] += scale * total[PARTS * a + 1];
            }
        }
    return sum;
}

INLINE void project_channels(rsh_basis basis, int order, int channels, size_t count,
                             const float *const d[3], const float *const value[3], float *out) {
    vf sums[MOST * RSH_MAX_COEFFICIENTS];
    const int second = order <= ONE_SET ? order : SECOND;
    memset(sums, 0, (size_t)(channels * order * order) * sizeof *sums);
    for (size_t first = 0; first < count; first += RUN * W) {
        struct run r;
        load_run(basis, order, channels, first, count, d, value, &r);
        vf *sum = project_set(order, channels, 0, 0, second, &r, sums);
        if (second < order) project_set(order, channels, 1, second, order, &r, sum);
    }
    const float scale = basis == RSH_HEMISPHERE ? sqrtf(2.0f) : 1.0f;
    const vf *sum = mix_set(scale, order, channels, 0, 0, second, sums, out);
    if (second < order) mix_set(scale, order, channels, 1, second, order, sum, out);
}

void GLUE(rsh_project_, RSH_NAME)(rsh_basis basis, int order, size_t count, const float *x,
                                  const float *y, const float *z, const float *const value[3],
                                  float *out) {
    const float *const d[3] = {x, y, z};
    if (value[1])
        project_channels(basis, order, 3, count, d, value, out);
    else
        project_channels(basis, order, 1, count, d, value, out);
}
