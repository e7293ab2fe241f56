// SPDX-License-Identifier: Apache-2.0
// Fits planes to values at sites, by weighted least squares over their neighbours, and replaces
// values by the planes where they differ by no more than noise.
#include <float.h>
#include <math.h>

#include "photon/photon_caustic_smooth.h"

enum {
    PLANE_NEIGHBOURS = 24,  // largest number of neighbours of a site
    FIT_LEAST = 8,          // least number of neighbours that must be visible from a site for a fit
    MIXED = 5               // sites from which a value is read; the farthest has no weight
};
#define PLANE_FACING 0.8f  // least cosine between the normals of one surface
// Fraction of the noise that remains in the difference from a plane, as discs of neighbours
// overlap.
#define RESIDUAL 0.6f
// Mean squared differences in units of that noise: from PRESERVED_FROM on an increasing fraction is
// preserved; beyond DIFFERS_MOST larger ones count the same. With 1.5 and 3 walls of a bathroom had
// spots where noise was taken for detail. With 2 and 4 a border of light was softer: its error is
// 1.12 times that without smoothing, 1.09 with the others (docs/experiments/caustics.md).
#define PRESERVED_FROM 2.0f
#define DIFFERS_MOST 6.0f
#define PLANE_DEVIATIONS 4.0f  // beyond which a difference is not noise

// The squared difference in units of the squared values to which noise is relative. A factor too
// high counts like the same factor too low.
static float difference(rgb a, rgb b) {
    return photon_rgb_square(rgb_sub(a, b)) /
           fmaxf(sqrtf(photon_rgb_square(a) * photon_rgb_square(b)), FLT_MIN);
}

// ---- Planes -------------------------------------------------------------------------------------

struct neighbour {
    float x, y, weight;
    uint32_t site;
};

// Finds the values to which a site's plane is fitted: near ones of its orientation that are visible
// from it.
static int find_neighbours(const struct photon_fitting *loop, size_t site, struct neighbour *out) {
    const struct photon_sites *sites = loop->sites;
    int row[PLANE_NEIGHBOURS], count = 0;
    float distance2[PLANE_NEIGHBOURS], far2 = 0.0f;
    photon_index_nearest(sites->index, sites->position.row + 6 * site, 1, PLANE_NEIGHBOURS,
                         INFINITY, row, distance2);
    for (int i = 0; i < PLANE_NEIGHBOURS; i++)
        if (row[i] >= 0) far2 = fmaxf(far2, distance2[i]);
    const vec3 p = photon_entry_position(&sites->position, site),
               n = photon_entry_normal(&sites->position, site);
    const struct frame frame = frame_from_normal(n);
    for (int i = 0; i < PLANE_NEIGHBOURS; i++) {
        if (row[i] < 0 || !(distance2[i] < far2)) continue;
        const size_t at = (size_t)row[i];
        if (v3_dot(photon_entry_normal(&sites->position, at), n) < PLANE_FACING) continue;
        if (at != site && photon_entry_position_hidden(&sites->position, loop->scene, at, p, n))
            continue;
        const vec3 d = v3_sub(photon_entry_position(&sites->position, at), p);
        const float weight = 1.0f - distance2[i] / far2;
        out[count++] =
            (struct neighbour){v3_dot(d, frame.u), v3_dot(d, frame.v), weight, (uint32_t)at};
    }
    return count;
}

// The plane through values by weighted least squares, with fewer unknowns if they are on a line.
// Returns its value at the site.
static rgb fit_plane(const struct photon_sites *sites, const struct neighbour *near, int count,
                     struct slope *out) {
    double s = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
    rgb c = rgb_grey(0.0f), cx = c, cy = c;
    for (int i = 0; i < count; i++) {
        const double w = near[i].weight, u = near[i].x, v = near[i].y;
        const rgb value = rgb_scale(sites->value[near[i].site], near[i].weight);
        s += w, x += w * u, y += w * v;
        xx += w * u * u, xy += w * u * v, yy += w * v * v;
        c = rgb_add(c, value);
        cx = rgb_mad(cx, value, near[i].x);
        cy = rgb_mad(cy, value, near[i].y);
    }
    // By the adjugate of the symmetric matrix of the normal equations.
    const double a = xx * yy - xy * xy, b = xy * y - x * yy, d = x * xy - xx * y;
    const double e = s * yy - y * y, g = x * y - s * xy, h = s * xx - x * x;
    const double det = s * a + x * b + y * d;
    out->u = out->v = rgb_grey(0.0f);
    if (!(det > 1e-3 * s * xx * yy)) return rgb_scale(c, (float)(1.0 / s));
    const float k = (float)(1.0 / det);
    const float m[6] = {(float)a * k, (float)b * k, (float)d * k,
                        (float)e * k, (float)g * k, (float)h * k};
    out->u = rgb_mad(rgb_mad(rgb_scale(c, m[1]), cx, m[3]), cy, m[4]);
    out->v = rgb_mad(rgb_mad(rgb_scale(c, m[2]), cx, m[4]), cy, m[5]);
    return rgb_mad(rgb_mad(rgb_scale(c, m[0]), cx, m[1]), cy, m[2]);
}

static rgb plane_at(rgb value, const struct slope *slope, float x, float y) {
    return rgb_mad(rgb_mad(value, slope->u, x), slope->v, y);
}

static void fit_site(const struct photon_fitting *loop, size_t i) {
    struct photon_sites *sites = loop->sites;
    struct neighbour near[PLANE_NEIGHBOURS];
    const int count = find_neighbours(loop, i, near);
    loop->plane[i] = sites->value[i];
    sites->slope[i] = (struct slope){.differs = DIFFERS_MOST};
    if (count < FIT_LEAST) return;
    loop->plane[i] = fit_plane(sites, near, count, &sites->slope[i]);
    float differs = 0.0f, sum = 0.0f;
    for (int k = 0; k < count; k++) {
        const rgb there = plane_at(loop->plane[i], &sites->slope[i], near[k].x, near[k].y);
        const float noise = fmaxf(sites->noise[near[k].site], FLT_MIN);
        differs += near[k].weight * difference(sites->value[near[k].site], there) / noise;
        sum += near[k].weight;
    }
    differs /= RESIDUAL * sum;
    sites->slope[i].differs = differs < DIFFERS_MOST ? differs : DIFFERS_MOST;
}

// A few neighbours may differ by more than noise at random, so the mean over neighbouring planes
// decides.
static void evaluate_site(const struct photon_fitting *loop, size_t i) {
    struct neighbour near[PLANE_NEIGHBOURS];
    const int count = find_neighbours(loop, i, near);
    float differs = 0.0f, sum = 0.0f;
    for (int k = 0; k < count; k++) {
        differs += near[k].weight * loop->sites->slope[near[k].site].differs;
        sum += near[k].weight;
    }
    loop->sites->slope[i].preserved =
        sum > 0.0f ? clampf(differs / sum - PRESERVED_FROM, 0.0f, 1.0f) : 1.0f;
}

void photon_fit_planes(void *fitting, size_t begin, size_t end, int worker) {
    (void)worker;
    for (size_t i = begin; i < end; i++) fit_site(fitting, i);
}

void photon_evaluate_planes(void *fitting, size_t begin, size_t end, int worker) {
    (void)worker;
    for (size_t i = begin; i < end; i++) evaluate_site(fitting, i);
}

// ---- Reading ------------------------------------------------------------------------------------

// The value at a position, from the planes of the sites around it.
static rgb read_value(const struct photon_reading *loop, size_t i) {
    const struct photon_sites *sites = loop->sites;
    const vec3 p = photon_entry_position(loop->position, i);
    int row[MIXED];
    float distance2[MIXED], far2 = 0.0f, sum = 0.0f, preserved = 0.0f, noise = 0.0f;
    rgb plane = rgb_grey(0.0f);
    photon_index_nearest(sites->index, loop->position->row + 6 * i, 1, MIXED, INFINITY, row,
                         distance2);
    for (int k = 0; k < MIXED; k++)
        if (row[k] >= 0) far2 = fmaxf(far2, distance2[k]);
    for (int k = 0; k < MIXED; k++) {
        if (row[k] < 0 || !(distance2[k] < far2)) continue;
        const size_t at = (size_t)row[k];
        const vec3 q = photon_entry_position(&sites->position, at),
                   n = photon_entry_normal(&sites->position, at), d = v3_sub(p, q);
        if (photon_entry_position_hidden(loop->position, loop->scene, i, q, n)) continue;
        const struct frame frame = frame_from_normal(n);
        const float near = 1.0f - distance2[k] / far2, weight = near * near;
        const rgb here =
            plane_at(sites->value[at], &sites->slope[at], v3_dot(d, frame.u), v3_dot(d, frame.v));
        sum += weight;
        preserved += weight * sites->slope[at].preserved;
        noise += weight * sites->noise[at];
        plane = rgb_mad(plane, here, weight);
    }
    if (!(sum > 0.0f)) return loop->value[i];
    plane = rgb_scale(plane, 1.0f / sum);
    const float most = PLANE_DEVIATIONS * PLANE_DEVIATIONS * noise / sum;
    const float differs = fmaxf(difference(loop->value[i], plane), FLT_MIN);
    preserved = fmaxf(preserved / sum, 1.0f - most / differs);
    if (!(preserved < 1.0f)) return loop->value[i];
    const rgb c = rgb_mad(plane, rgb_sub(loop->value[i], plane), preserved);
    return rgb_at_least(c, 0.0f);
}

void photon_read_planes(void *ctx, size_t begin, size_t end, int worker) {
    (void)worker;
    const struct photon_reading *loop = ctx;
    for (size_t i = begin; i < end; i++) loop->value[i] = read_value(loop, i);
}
