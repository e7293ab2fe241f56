// SPDX-License-Identifier: Apache-2.0
// Building a table of harmonics [K05 3.4]. To project a lobe takes .01 to .3 ms, and an anisotropic
// table has 3,400 nodes in use. But the coefficients are smooth functions of the direction, except
// near the horizon, so nodes are added in ever finer grids, and only some of them are projected:
// - A node is interpolated from those of coarser grids if this was accurate enough for its
//   neighbours of the next coarser grid, for which the error is known.
// - A node amid directions that are not represented is skipped. No lookup reads it.
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "brdf/brdf_models.h"
#include "brdf/brdf_project.h"
#include "brdf/brdf_table.h"

enum {
    RADIUS_NODES = 256,   // isotropic: a node every half degree at normal incidence
    QUADRANT_NODES = 65,  // anisotropic, per side
    // The steps of the coarsest grids. Of 4,000 directions of each of 37 lobes, none that is
    // represented was skipped.
    RADIUS_COARSEST = 16,
    QUADRANT_COARSEST = 8
};
// The largest error that is expected of an interpolated node, relative to the norm: less than that
// of lookups between nodes, which is .2 to 2e-4 along the radius and .1 to 3e-3 in the quadrant
// (rms over all directions).
static const float RADIUS_ERROR = 1e-4f, QUADRANT_ERROR = 1e-3f;

struct table_build {
    const struct brdf *brdf;  // from brdf_white
    const struct brdf_fit *fit;
    struct brdf_table *table;
    struct project_rule rule;
    struct project_points *points;  // one for each worker
    struct table_nodes nodes;
    // The nodes of the current grid that are projected:
    size_t *node;  // [count]
    size_t count;
    float *c;                      // [count][values]
    struct projected_node *found;  // [count]
};

struct projected_node {
    float norm;   // squared
    float error;  // of interpolation instead; INFINITY: not known
};

// ---- One node -----------------------------------------------------------------------------------

// The outgoing direction of a node.
static vec3 node_direction(const struct brdf_table *t, struct table_position at) {
    const float step = brdf_table_step(t), limit = step * (float)(t->side - 1);
    float p = step * (float)at.i, q = step * (float)at.j, r = sqrtf(p * p + q * q);
    if (r > limit) p *= limit / r, q *= limit / r, r = limit;
    const float scale = 1.0f / (1.0f + r * r);
    return v3(2.0f * p * scale, 2.0f * q * scale, (1.0f - r * r) * scale);
}

// The power of light in a coefficient of band l, relative to band 0.
static double band_power(int l) { return 1.0 / ((l + 1.0) * (l + 1.0) * (l + 1.0)); }

// Sums the squares of the coefficients [channels][stride] of each band.
static void band_squares(const struct brdf_table *t, const float *c, double *band) {
    for (int l = 0; l < t->max_order; l++) band[l] = 0.0;
    for (int channel = 0; channel < t->channels; channel++)
        for (int l = 0; l < t->max_order; l++)
            for (int m = t->isotropic ? 0 : -l; m <= l; m++) band[l] += (double)sqrf(*c++);
}

// The least order with a small enough error of the reflected radiance; if there is none, the
// largest or 0, as the fit says. The part of the squared norm that is in no band is assumed to be
// in the next one.
static int least_order(const struct table_build *b, const float *c, double norm) {
    const int max_order = b->table->max_order;
    const double max_error = (double)b->fit->max_error;
    double band[TABLE_ORDER_MAX], rest = norm, all = 0.0;
    if (!(norm > 0.0)) return 0;
    band_squares(b->table, c, band);
    for (int l = 0; l < max_order; l++) {
        rest -= band[l];
        band[l] *= band_power(l);
        all += band[l];
    }
    all += fmax(rest, 0.0) * band_power(max_order);
    double missing = all;
    for (int l = 0; l < max_order; l++) {
        missing -= band[l];
        if (missing <= max_error * max_error * all) return l + 1;
    }
    return b->fit->always ? max_order : 0;
}

// The distance of the coefficients of two nodes, relative to the squared norm of one.
static float relative_distance(const struct brdf_table *t, const float *a, const float *b,
                               float norm) {
    double sum = 0.0;
    for (size_t k = 0; k < t->values; k++) sum += (double)sqrf(a[k] - b[k]);
    return norm > 0.0f ? (float)sqrt(sum / (double)norm) : INFINITY;
}

// ---- One grid -----------------------------------------------------------------------------------

static void project_nodes(void *ctx, size_t begin, size_t end, int worker) {
    const struct table_build *b = ctx;
    const struct brdf_table *t = b->table;
    const struct project_target target = {t->basis, t->max_order, t->channels, t->isotropic};
    for (size_t n = begin; n < end; n++) {
        const struct table_position at = brdf_table_position(t, b->node[n]);
        float all[TABLE_VALUES_MAX] = {0}, instead[TABLE_VALUES_MAX];
        float *c = b->c + n * t->values, *out = c;
        const float norm = (float)brdf_project_glossy(b->brdf, node_direction(t, at), target,
                                                      &b->rule, b->points + worker, all);
        for (int channel = 0; channel < t->channels; channel++)
            for (int l = 0; l < t->max_order; l++)
                for (int m = t->isotropic ? 0 : -l; m <= l; m++)
                    *out++ = all[channel * t->max_order * t->max_order + l * (l + 1) + m];
        const struct table_stencil from = brdf_table_stencil(&b->nodes, at);
        b->found[n] = (struct projected_node){norm, INFINITY};
        if (!from.complete) continue;
        brdf_table_interpolate(&b->nodes, &from, instead);
        b->found[n].error = relative_distance(t, instead, c, norm);
    }
}

// Keeps what is known of a node whose coefficients are in the table.
static void set_node(struct table_build *b, size_t node, float norm, float error) {
    const struct brdf_table *t = b->table;
    b->nodes.norm[node] = norm;
    b->nodes.error[node] = error;
    t->order[node] = (uint8_t)least_order(b, t->c + node * t->values, (double)norm);
}

static bool in_grid(const struct table_build *b, struct table_position at, bool coarsest) {
    const int step = b->nodes.step, coarser = 2 * step;
    if (at.i % step || at.j % step || !brdf_table_in_use(b->table, at)) return false;
    return coarsest || at.i % coarser || at.j % coarser;
}

// Skips or interpolates nodes of the grid, and lists the others.
static void visit_grid(struct table_build *b, bool coarsest) {
    const struct brdf_table *t = b->table;
    const float most = t->isotropic ? RADIUS_ERROR : QUADRANT_ERROR;
    b->count = 0;
    for (size_t node = 0; node < t->nodes; node++) {
        const struct table_position at = brdf_table_position(t, node);
        if (!in_grid(b, at, coarsest)) continue;
        const struct table_stencil from =
            coarsest ? (struct table_stencil){0} : brdf_table_stencil(&b->nodes, at);
        if (from.count && from.refused) continue;
        const float expected = brdf_table_expected_error(&b->nodes, &from);
        if (expected <= most)
            set_node(b, node, brdf_table_interpolate(&b->nodes, &from, t->c + node * t->values),
                     expected);
        else
            b->node[b->count++] = node;
    }
}

static satin_status make_grid(struct table_build *b, struct parallel *pool, bool coarsest) {
    const size_t size = b->table->values * sizeof *b->c;
    visit_grid(b, coarsest);
    if (!b->count) return SATIN_OK;
    b->c = array_new(b->count, size);
    b->found = array_new(b->count, sizeof *b->found);
    satin_status status = b->c && b->found ? SATIN_OK : SATIN_ERROR_MEMORY;
    const struct parallel_results results = {.slot = {{b->c, size}, {b->found, sizeof *b->found}},
                                             .journaled = true};
    if (!status && !parallel_for_results(pool, b->count, 1, project_nodes, b, &results))
        status = SATIN_CANCELLED;
    for (size_t n = 0; n < b->count && !status; n++) {
        memcpy(b->table->c + b->node[n] * b->table->values, b->c + n * b->table->values, size);
        set_node(b, b->node[n], b->found[n].norm, b->found[n].error);
    }
    free(b->c);
    free(b->found);
    return status;
}

// ---- The table ----------------------------------------------------------------------------------

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
    t->values = (size_t)t->channels * t->stride;
    t->c = array_new(t->nodes * t->values, sizeof *t->c);
    t->order = array_new(t->nodes, sizeof *t->order);
    if (t->c && t->order) return t;
    brdf_table_free(t);
    return NULL;
}

static satin_status build_new(struct table_build *b, struct brdf_table *t, int threads) {
    struct table_nodes *nodes = &b->nodes;
    b->table = t;
    b->points = array_new((size_t)threads, sizeof *b->points);
    b->node = array_new(t->nodes, sizeof *b->node);
    *nodes = (struct table_nodes){.table = t};
    nodes->norm = array_new(t->nodes, sizeof *nodes->norm);
    nodes->error = array_new(t->nodes, sizeof *nodes->error);
    nodes->sign[0] = array_new(4 * t->stride, sizeof *nodes->sign[0]);
    if (!b->points || !b->node || !nodes->norm || !nodes->error || !nodes->sign[0])
        return SATIN_ERROR_MEMORY;
    for (size_t k = 1; k < 4; k++) nodes->sign[k] = nodes->sign[0] + k * t->stride;
    brdf_table_signs(nodes);
    brdf_project_rule_make(&b->rule);
    return SATIN_OK;
}

static void build_free(struct table_build *b) {
    free(b->points);
    free(b->node);
    free(b->nodes.norm);
    free(b->nodes.error);
    free(b->nodes.sign[0]);
}

satin_status brdf_table_build(const struct brdf *b, const struct brdf_fit *fit,
                              struct parallel *pool, struct brdf_table **out) {
    const int max_order = fit->max_order;
    if (!(b->model->lobes & BRDF_GLOSSY) || max_order < 1 || max_order > TABLE_ORDER_MAX)
        return SATIN_ERROR_ARGUMENT;
    const struct brdf white = brdf_white(b);
    struct brdf_table *t = table_new(&white, brdf_rsh_basis(fit->basis), max_order);
    if (!t) return SATIN_ERROR_MEMORY;
    struct table_build build = {.brdf = &white, .fit = fit};
    satin_status status = build_new(&build, t, parallel_threads(pool));
    const int coarsest = t->isotropic ? RADIUS_COARSEST : QUADRANT_COARSEST;
    for (int step = coarsest; step > 0 && !status; step /= 2) {
        build.nodes.step = step;
        status = make_grid(&build, pool, step == coarsest);
    }
    build_free(&build);
    if (status)
        brdf_table_free(t);
    else
        *out = t;
    return status;
}
