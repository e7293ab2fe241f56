// SPDX-License-Identifier: Apache-2.0
// Interpolation of the nodes of a table from those of coarser grids, by cubic polynomials along
// each axis. The lobe of the quadrant is continued beyond its axes by its symmetry. Near the
// boundary of the disk, and near nodes that were skipped, polynomials through nodes on one side are
// taken.
#include "brdf/brdf_table.h"

// The error of a cubic polynomial falls 16-fold from grid to grid; where it has not yet begun to,
// by less.
static const float ERROR_FALLS = 8.0f;

// The weights of nodes at -5, -3, -1, 1; at -3, -1, 1, 3; and at -1, 1, 3, 5 steps.
static const float CUBIC[3][4] = {{0.0625f, -0.3125f, 0.9375f, 0.3125f},
                                  {-0.0625f, 0.5625f, 0.5625f, -0.0625f},
                                  {0.3125f, 0.9375f, -0.3125f, 0.0625f}};

// x -> -x changes the sign of cos(m phi) for odd m and of sin(m phi) for even m, y -> -y that of
// sin(m phi).
void brdf_table_signs(const struct table_nodes *nodes) {
    const struct brdf_table *t = nodes->table;
    for (int mirror = 0; mirror < 4; mirror++) {
        const bool x = mirror & 1, y = mirror >> 1;
        float *sign = nodes->sign[mirror];
        for (int l = 0; l < t->max_order; l++)
            for (int m = t->isotropic ? 0 : -l; m <= l; m++) {
                bool negative = x && m % 2;
                if (m < 0 && x != y) negative = !negative;
                *sign++ = negative ? -1.0f : 1.0f;
            }
    }
}

// Positions along one axis, perhaps negative, and their weights.
struct axis_stencil {
    int count, position[4];
    float weight[4];
};

static bool is_between(int position, int step) { return position / step % 2 != 0; }

static struct axis_stencil along_axis(int position, int step, int shift) {
    struct axis_stencil out = {1, {position}, {1.0f}};
    if (!is_between(position, step)) return out;
    out.count = 4;
    for (int k = 0; k < 4; k++) {
        out.position[k] = position + (2 * (k + shift) - 3) * step;
        out.weight[k] = CUBIC[shift + 1][k];
    }
    return out;
}

static struct table_stencil shifted_stencil(const struct table_nodes *nodes,
                                            struct table_position at, struct table_position shift) {
    const struct brdf_table *t = nodes->table;
    const struct axis_stencil x = along_axis(at.i, nodes->step, shift.i);
    const struct axis_stencil y = along_axis(at.j, nodes->step, shift.j);
    struct table_stencil out = {.complete = true, .refused = true};
    for (int k = 0; k < x.count * y.count; k++) {
        const int i = x.position[k % x.count], j = y.position[k / x.count];
        const struct table_position from = {i < 0 ? -i : i, j < 0 ? -j : j};
        if (from.i >= t->side || from.j >= t->side || !brdf_table_in_use(t, from)) {
            out.complete = false;
            continue;
        }
        const size_t node = (size_t)from.j * (size_t)t->side + (size_t)from.i;
        out.node[out.count] = node;
        out.weight[out.count] = x.weight[k % x.count] * y.weight[k / x.count];
        out.mirror[out.count++] = (i < 0) + 2 * (j < 0);
        if (!brdf_table_in_disk(t, from) || !(nodes->norm[node] > 0.0f)) out.complete = false;
        if (t->order[node]) out.refused = false;
    }
    return out;
}

struct table_stencil brdf_table_stencil(const struct table_nodes *nodes, struct table_position at) {
    static const struct table_position shift[] = {{-1, 0},  {0, -1}, {1, 0},  {0, 1},
                                                  {-1, -1}, {1, 1},  {-1, 1}, {1, -1}};
    const struct table_stencil centred = shifted_stencil(nodes, at, (struct table_position){0, 0});
    if (centred.complete || centred.refused) return centred;
    for (size_t k = 0; k < sizeof shift / sizeof *shift; k++) {
        if (shift[k].i && !is_between(at.i, nodes->step)) continue;
        if (shift[k].j && !is_between(at.j, nodes->step)) continue;
        const struct table_stencil shifted = shifted_stencil(nodes, at, shift[k]);
        if (shifted.complete) return shifted;
    }
    return centred;
}

float brdf_table_interpolate(const struct table_nodes *nodes, const struct table_stencil *from,
                             float *c) {
    const struct brdf_table *t = nodes->table;
    float norm = 0.0f;
    for (size_t k = 0; k < t->values; k++) c[k] = 0.0f;
    for (int n = 0; n < from->count; n++) {
        const float *in = t->c + from->node[n] * t->values, weight = from->weight[n];
        const float *sign = nodes->sign[from->mirror[n]];
        for (size_t channel = 0; channel < t->values; channel += t->stride)
            for (size_t k = 0; k < t->stride; k++)
                c[channel + k] += weight * sign[k] * in[channel + k];
        norm += weight * nodes->norm[from->node[n]];
    }
    return norm;
}

float brdf_table_expected_error(const struct table_nodes *nodes, const struct table_stencil *from) {
    const int coarser = 2 * nodes->step;
    float most = 0.0f;
    if (!from->complete) return INFINITY;
    for (int n = 0; n < from->count; n++) {
        const struct table_position at = brdf_table_position(nodes->table, from->node[n]);
        if (is_between(at.i, coarser) || is_between(at.j, coarser))
            most = maxf(most, nodes->error[from->node[n]]);
    }
    return most / ERROR_FALLS;
}
