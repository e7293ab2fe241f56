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
// (docs/experiments.md).
#include <stdlib.h>

#include "base/array.h"
#include "brdf/brdf_models.h"
#include "brdf/brdf_project.h"

enum {
    RADIUS_NODES = 256,   // isotropic: a node every half degree at normal incidence
    QUADRANT_NODES = 65,  // anisotropic, per side
    ORDER_MAX = 14
};

struct brdf_table {
    bool isotropic;
    rsh_basis basis;
    int max_order, channels;
    int side;        // nodes along the radius or a side of the quadrant
    size_t nodes;    // side or side^2
    size_t stride;   // coefficients of one channel of one node
    float *c;        // [nodes][channels][stride]
    uint8_t *order;  // [nodes]; 0: the error exceeds the bound
};

// ---- Building -----------------------------------------------------------------------------------

// The distance of nodes. They begin at the centre, and the last one is half a step before the
// boundary, where some models are infinite.
static float node_step(const struct brdf_table *t) { return 1.0f / ((float)t->side - 0.5f); }

// Whether a cell that touches the disk has this node as a corner.
static bool node_in_use(const struct brdf_table *t, size_t node) {
    if (t->isotropic) return true;
    size_t i = node % (size_t)t->side, j = node / (size_t)t->side;
    float p = i ? (float)(i - 1) : 0.0f, q = j ? (float)(j - 1) : 0.0f;
    return sqrtf(p * p + q * q) * node_step(t) < 1.0f;
}

// The outgoing direction of a node.
static vec3 node_direction(const struct brdf_table *t, size_t node) {
    float step = node_step(t), limit = step * (float)(t->side - 1);
    float p = step * (float)(t->isotropic ? node : node % (size_t)t->side);
    float q = t->isotropic ? 0.0f : step * (float)(node / (size_t)t->side);
    float r = sqrtf(p * p + q * q);
    if (r > limit) p *= limit / r, q *= limit / r, r = limit;
    float scale = 1.0f / (1.0f + r * r);
    return v3(2.0f * p * scale, 2.0f * q * scale, (1.0f - r * r) * scale);
}

// The power of light in a coefficient of band l, relative to band 0.
static double band_power(int l) { return 1.0 / ((l + 1.0) * (l + 1.0) * (l + 1.0)); }

// The least order with a small enough error of the reflected radiance; if there is none, the
// largest or 0, as the fit says. The part of the squared norm that is in no band is assumed to be
// in the next one.
static int least_order(const struct brdf_fit *fit, int channels, const float *c, double norm) {
    const int max_order = fit->max_order;
    const double max_error = (double)fit->max_error;
    double band[ORDER_MAX], rest = norm, all = 0.0, missing;
    if (!(norm > 0.0)) return 0;
    for (int l = 0; l < max_order; l++) {
        band[l] = 0.0;
        for (int channel = 0; channel < channels; channel++)
            for (int m = l * l; m < (l + 1) * (l + 1); m++)
                band[l] += (double)sqrf(c[channel * max_order * max_order + m]);
        rest -= band[l];
        band[l] *= band_power(l);
        all += band[l];
    }
    all += fmax(rest, 0.0) * band_power(max_order);
    missing = all;
    for (int l = 0; l < max_order; l++) {
        missing -= band[l];
        if (missing <= max_error * max_error * all) return l + 1;
    }
    return fit->always ? max_order : 0;
}

struct table_build {
    const struct brdf *brdf;
    struct brdf_table *table;
    const struct brdf_fit *fit;
    struct project_rule rule;
    struct project_points *points;  // one for each worker
};

static void build_nodes(void *ctx, size_t begin, size_t end, int worker) {
    const struct table_build *b = ctx;
    struct brdf_table *t = b->table;
    int count = t->max_order * t->max_order;
    for (size_t node = begin; node < end; node++) {
        float c[3 * ORDER_MAX * ORDER_MAX] = {0};
        if (!node_in_use(t, node)) continue;
        vec3 wo = node_direction(t, node);
        const struct project_target target = {t->basis, t->max_order, t->channels, t->isotropic};
        double norm = brdf_project_glossy(b->brdf, wo, target, &b->rule, b->points + worker, c);
        float *out = t->c + node * (size_t)t->channels * t->stride;
        for (int channel = 0; channel < t->channels; channel++, out += t->stride)
            for (int l = 0, k = 0; l < t->max_order; l++)
                for (int m = -l; m <= l; m++) {
                    float *v = c + channel * count + l * (l + 1) + m;
                    if (t->isotropic && m < 0)
                        *v = 0.0f;
                    else
                        out[k++] = *v;
                }
        t->order[node] = (uint8_t)least_order(b->fit, t->channels, c, norm);
    }
}

// Whether the glossy lobe with `specular` 1 is the same in all channels.
static bool is_grey(const struct brdf *b) {
    for (int i = 0; i < 3; i++) {
        vec3 w = v3(sqrtf(1.0f - sqrf(1.0f - 0.4f * (float)i)), 0.0f, 1.0f - 0.4f * (float)i);
        rgb diffuse, f;
        b->model->eval(b, w, v3(-w.x, 0.0f, w.z), &diffuse, &f);
        if (f.r != f.g || f.g != f.b) return false;
    }
    return true;
}

static struct brdf_table *table_new(const struct brdf *b, rsh_basis basis, int max_order) {
    struct brdf_table *t = array_new(1, sizeof *t);
    if (!t) return NULL;
    t->isotropic = brdf_isotropic(b);
    t->basis = basis;
    t->max_order = max_order;
    t->channels = is_grey(b) ? 1 : 3;
    t->side = t->isotropic ? RADIUS_NODES : QUADRANT_NODES;
    t->nodes = (size_t)t->side * (t->isotropic ? 1u : (size_t)t->side);
    t->stride = (size_t)(t->isotropic ? max_order * (max_order + 1) / 2 : max_order * max_order);
    t->c = array_new(t->nodes * (size_t)t->channels * t->stride, sizeof *t->c);
    t->order = array_new(t->nodes, sizeof *t->order);
    if (t->c && t->order) return t;
    brdf_table_free(t);
    return NULL;
}

satin_status brdf_table_build(const struct brdf *b, const struct brdf_fit *fit,
                              struct parallel *pool, struct brdf_table **out) {
    const int max_order = fit->max_order;
    if (!(b->model->lobes & BRDF_GLOSSY) || max_order < 1 || max_order > ORDER_MAX)
        return SATIN_ERROR_ARGUMENT;
    struct brdf white = *b;
    white.specular = rgb_grey(1.0f);
    struct brdf_table *t = table_new(&white, brdf_rsh_basis(fit->basis), max_order);
    struct table_build build = {.brdf = &white, .table = t, .fit = fit};
    brdf_project_rule_make(&build.rule);
    build.points = array_new((size_t)parallel_threads(pool), sizeof *build.points);
    satin_status status = t && build.points ? SATIN_OK : SATIN_ERROR_MEMORY;
    struct parallel_results nodes = {.journaled = true};
    if (!status) {
        nodes.slot[0] =
            (struct parallel_slot){t->c, (size_t)t->channels * t->stride * sizeof *t->c};
        nodes.slot[1] = (struct parallel_slot){t->order, sizeof *t->order};
    }
    if (!status && !parallel_for_results(pool, t->nodes, 4, build_nodes, &build, &nodes))
        status = SATIN_CANCELLED;
    free(build.points);
    if (status)
        brdf_table_free(t);
    else
        *out = t;
    return status;
}

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
    float x = position / node_step(t), last = (float)(t->side - 1);
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
    float r = sqrtf(wo.x * wo.x + wo.y * wo.y), cos_m[ORDER_MAX] = {1.0f}, sin_m[ORDER_MAX] = {0};
    float c = r > 0.0f ? wo.x / r : 1.0f, s = r > 0.0f ? wo.y / r : 0.0f;
    for (int m = 1; m < order; m++) {
        cos_m[m] = c * cos_m[m - 1] - s * sin_m[m - 1];
        sin_m[m] = s * cos_m[m - 1] + c * sin_m[m - 1];
    }
    const float *a = t->c + at->node[0] * (size_t)t->channels * t->stride;
    for (int channel = 0; channel < t->channels; channel++, a += t->stride, out += order * order) {
        const float *b = a + (size_t)t->channels * t->stride;
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
    float sign[2 * ORDER_MAX - 1], *middle = sign + ORDER_MAX - 1;
    for (int m = 0; m < order; m++) {
        float odd = wo.x < 0.0f && m % 2 ? -1.0f : 1.0f;
        middle[m] = odd;
        middle[-m] = m ? ((wo.x < 0.0f) != (wo.y < 0.0f) ? -odd : odd) : odd;
    }
    size_t node_size = (size_t)t->channels * t->stride;
    for (int channel = 0; channel < t->channels; channel++, out += order * order) {
        const float *c[4];
        for (int i = 0; i < 4; i++)
            c[i] = t->c + at->node[i] * node_size + (size_t)channel * t->stride;
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
    info.bytes =
        sizeof *t + t->nodes * (sizeof *t->order + (size_t)t->channels * t->stride * sizeof *t->c);
    for (size_t node = 0; node < t->nodes; node++)
        if (t->order[node] > info.order) info.order = t->order[node];
    double all = 0.0, represented = 0.0;
    int cells = t->side - 1;
    float step = node_step(t);
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
