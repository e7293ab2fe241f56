// SPDX-License-Identifier: Apache-2.0
// Harmonics of a BRDF's glossy lobe over all outgoing directions [K05 2.5, 3.4]: the coefficients
// of f_r cos(theta_i) at the nodes of a parabolic map, each with the least order that meets the
// error bound, interpolated linearly.
//
// The map takes wo to (x, y) / (1 + z) in the unit disk. Symmetry reduces it:
// - Isotropic: one radius (phi = 0) is enough. The lobe there is even in y, so only m >= 0 is
//   stored, and the lobe of another phi is that one rotated about z.
// - Anisotropic: one quadrant is enough, as these models are symmetric about the x and the y axis.
//   Mirroring a lobe changes the signs of coefficients. Nodes beyond the disk repeat its boundary.
//
// Deviation from [K05 (3.4)]: the order follows from the error of the reflected radiance, not from
// that of the BRDF. The power of light in a coefficient of band l falls as (l + 1)^-3 in both
// bases, as for any function with edges (measured: within a factor of about two). So the expected
// squared error is the power of the omitted bands over (l + 1)^3, relative to the same sum over all
// bands. This predicts the error within a factor of 1.5. A bound on the error of the BRDF itself
// would refuse lobes that end at the horizon, although they are represented as well
// (docs/experiments/gradients-and-harmonics.md).
#include "brdf/brdf_table.h"

#include <stdlib.h>

void brdf_table_free(struct brdf_table *table) {
    if (!table) return;
    free(table->c);
    free(table->order);
    free(table);
}

// ---- Looking up ---------------------------------------------------------------------------------

// The nodes around a direction and their weights.
struct corners {
    int count;
    size_t node[4];
    float weight[4];
};

// The cell and the position in it along one axis.
static int table_cell(const struct brdf_table *t, float position, float *fraction) {
    float x = position / brdf_table_step(t), last = (float)(t->side - 1);
    x = x > 0.0f ? minf(x, last) : 0.0f;
    int i = x < last ? (int)x : t->side - 2;
    *fraction = x - (float)i;
    return i;
}

static struct corners find_corners(const struct brdf_table *t, vec3 wo) {
    float scale = 1.0f / (1.0f + maxf(wo.z, 0.0f)), p, q;
    if (t->isotropic) {
        size_t i = (size_t)table_cell(t, scale * sqrtf(wo.x * wo.x + wo.y * wo.y), &p);
        return (struct corners){2, {i, i + 1}, {1.0f - p, p}};
    }
    size_t i = (size_t)table_cell(t, scale * fabsf(wo.x), &p), row = (size_t)t->side;
    i += row * (size_t)table_cell(t, scale * fabsf(wo.y), &q);
    return (struct corners){4,
                            {i, i + 1, i + row, i + row + 1},
                            {(1.0f - p) * (1.0f - q), p * (1.0f - q), (1.0f - p) * q, p * q}};
}

// The largest order of the nodes, or 0 if the error at one of them exceeds the bound.
static int corners_order(const struct brdf_table *t, const struct corners *at) {
    int order = 0;
    for (int i = 0; i < at->count; i++) {
        if (!t->order[at->node[i]]) return 0;
        if (t->order[at->node[i]] > order) order = t->order[at->node[i]];
    }
    return order;
}

int brdf_table_order(const struct brdf_table *table, vec3 wo) {
    struct corners at = find_corners(table, wo);
    return wo.z > 0.0f ? corners_order(table, &at) : 0;
}

// The lobe of phi = 0, rotated: cos(m phi_i) becomes cos(m (phi_i - phi)).
static void rotate_lobe(const struct brdf_table *t, const struct corners *at, vec3 wo, int order,
                        float *out) {
    float r = sqrtf(wo.x * wo.x + wo.y * wo.y), cos_m[TABLE_ORDER_MAX] = {1.0f},
          sin_m[TABLE_ORDER_MAX] = {0};
    float c = r > 0.0f ? wo.x / r : 1.0f, s = r > 0.0f ? wo.y / r : 0.0f;
    for (int m = 1; m < order; m++) {
        cos_m[m] = c * cos_m[m - 1] - s * sin_m[m - 1];
        sin_m[m] = s * cos_m[m - 1] + c * sin_m[m - 1];
    }
    const float *a = t->c + at->node[0] * t->values;
    for (int channel = 0; channel < t->channels; channel++, a += t->stride, out += order * order) {
        const float *b = a + t->values;
        for (int l = 0, k = 0; l < order; l++) {
            float *row = out + l * (l + 1);
            row[0] = at->weight[0] * a[k] + at->weight[1] * b[k];
            k++;
            for (int m = 1; m <= l; m++, k++) {
                float v = at->weight[0] * a[k] + at->weight[1] * b[k];
                row[m] = v * cos_m[m];
                row[-m] = v * sin_m[m];
            }
        }
    }
}

// The lobe of the first quadrant, mirrored to that of wo: y -> -y changes the sign of sin(m phi), x
// -> -x that of cos(m phi) for odd m and of sin(m phi) for even m.
static void mirror_lobe(const struct brdf_table *t, const struct corners *at, vec3 wo, int order,
                        float *out) {
    float sign[2 * TABLE_ORDER_MAX - 1], *middle = sign + TABLE_ORDER_MAX - 1;
    for (int m = 0; m < order; m++) {
        float odd = wo.x < 0.0f && m % 2 ? -1.0f : 1.0f;
        middle[m] = odd;
        middle[-m] = m ? ((wo.x < 0.0f) != (wo.y < 0.0f) ? -odd : odd) : odd;
    }
    for (int channel = 0; channel < t->channels; channel++, out += order * order) {
        const float *c[4];
        for (int i = 0; i < 4; i++)
            c[i] = t->c + at->node[i] * t->values + (size_t)channel * t->stride;
        for (int l = 0; l < order; l++)
            for (int k = l * l, m = -l; m <= l; k++, m++)
                out[k] = middle[m] * (at->weight[0] * c[0][k] + at->weight[1] * c[1][k] +
                                      at->weight[2] * c[2][k] + at->weight[3] * c[3][k]);
    }
}

int brdf_table_lookup(const struct brdf_table *table, vec3 wo, float *c) {
    struct corners at = find_corners(table, wo);
    int order = wo.z > 0.0f ? corners_order(table, &at) : 0;
    if (!order) return 0;
    if (table->isotropic)
        rotate_lobe(table, &at, wo, order, c);
    else
        mirror_lobe(table, &at, wo, order, c);
    return order;
}

int brdf_table_channels(const struct brdf_table *table) { return table->channels; }

struct brdf_table_info brdf_table_describe(const struct brdf_table *t) {
    struct brdf_table_info info = {.channels = t->channels};
    info.bytes = sizeof *t + t->nodes * (sizeof *t->order + t->values * sizeof *t->c);
    for (size_t node = 0; node < t->nodes; node++)
        if (t->order[node] > info.order) info.order = t->order[node];
    double all = 0.0, represented = 0.0;
    int cells = t->side - 1;
    float step = brdf_table_step(t);
    for (int j = 0; j < (t->isotropic ? 1 : cells); j++)
        for (int i = 0; i < cells; i++) {
            float p = step * ((float)i + 0.5f), q = t->isotropic ? 0.0f : step * ((float)j + 0.5f);
            float r2 = p * p + q * q;
            if (r2 > 1.0f) continue;
            double solid_angle = (t->isotropic ? p : 1.0f) / sqrf(1.0f + r2);
            float scale = 1.0f / (1.0f + r2);
            vec3 wo = v3(2.0f * p * scale, 2.0f * q * scale, (1.0f - r2) * scale);
            all += solid_angle;
            if (brdf_table_order(t, wo)) represented += solid_angle;
        }
    info.fraction = (float)(represented / all);
    return info;
}
