// SPDX-License-Identifier: Apache-2.0
// Density estimates from the k nearest photons [Jensen 2001, ch. 7]. Photons on the other side of
// the surface, or on a surface of another orientation or layer, are not counted, and the disc is
// divided by the area of the surface in it (photon_area.c). The radius is that of the outermost
// photon, which is not counted: the k - 1 others are uniform in the disc, so their number over its
// area is an unbiased density, while k over the area is too high by 1 / (k - 1). In the caustic map
// each photon has a kernel of its own radius (photon_radii.c) and is divided by the area of its own
// disc (photon_own_area.c); a point has the photons that cover it (photon_cover.c).
#include "photon/photon_own_area.h"

#include <math.h>

// Whether photon i, of normal n, is on the surface of the disc.
static bool is_on_surface(const struct photon_disc *disc, int i, vec3 n) {
    const size_t at = (size_t)disc->row[i];
    const float height = v3_dot(v3_sub(photon_position(disc->map, at), disc->p), disc->n);
    return photon_is_on_surface(disc->n, n, height, disc->own ? disc->map->radius2[at] : disc->r2);
}

static vec3 photon_normal(const struct photon_disc *disc, int i) {
    return photon_unpack(disc->map->photon[disc->row[i]].n);
}

static bool is_counted(const struct photon_disc *disc, int i) {
    const int at = disc->row[i];
    return at >= 0 && disc->distance2[i] < (disc->own ? disc->map->radius2[at] : disc->r2);
}

float photon_radius2(const struct photon_map *map, const int *row, const float *distance2, int k) {
    float far2 = 0.0f;
    bool full = true;
    for (int i = 0; i < k; i++) {
        if (row[i] < 0)
            full = false;
        else
            far2 = fmaxf(far2, distance2[i]);
    }
    const float most = map->radius_max;
    return full ? fminf(far2, most * most) : most * most;
}

// Whether a photon of the disc has found an edge near it, or none of them was tested.
static bool edge_near(const struct photon_disc *disc) {
    const struct photon_map *map = disc->map;
    if (!map->whole_disc) return true;
    int known = 0;
    for (int i = 0; i < disc->count; i++) {
        if (!is_counted(disc, i) || (size_t)disc->row[i] % map->stride != 0 ||
            !is_on_surface(disc, i, photon_normal(disc, i)))
            continue;
        if (!map->whole_disc[(size_t)disc->row[i] / map->stride]) return true;
        known++;
    }
    return known == 0;
}

// Moves the k smallest of n distances to the front, with their rows [Hoare 1961].
static void move_nearest(int *row, float *distance2, int n, int k) {
    int lo = 0, hi = n - 1;
    while (lo < hi) {
        const float pivot = distance2[lo + (hi - lo) / 2];
        int i = lo, j = hi;
        while (i <= j) {
            while (distance2[i] < pivot) i++;
            while (distance2[j] > pivot) j--;
            if (i > j) break;
            const float d2 = distance2[i];
            const int at = row[i];
            distance2[i] = distance2[j];
            row[i++] = row[j];
            distance2[j] = d2;
            row[j--] = at;
        }
        if (k - 1 <= j)
            hi = j;
        else if (k - 1 >= i)
            lo = i;
        else
            return;
    }
}

static float largest_distance(const float *distance2, int n) {
    float most = 0.0f;
    for (int i = 0; i < n; i++) most = fmaxf(most, distance2[i]);
    return most;
}

float photon_ring_radius(int *row, float *distance2, int k) {
    for (int i = 0; i < 2 * k; i++)
        if (row[i] < 0) distance2[i] = INFINITY;
    move_nearest(row, distance2, 2 * k, k);
    const float inner2 = largest_distance(distance2, k),
                outer2 = largest_distance(distance2 + k, k);
    return sqrtf(isfinite(outer2) ? outer2 - inner2 : inner2);
}

float photon_disc_counted(const struct photon_disc *disc, float most) {
    const float each = PI_F * disc->r2 * disc->scale;
    float counted = 0.0f;
    for (int i = 0; i < disc->count && counted < most; i++)
        if (photon_disc_weight(disc, i) > 0.0f) counted += each;
    return counted;
}

void photon_disc_scale(struct photon_disc *disc, const struct satin_scene *scene) {
    float fraction = 1.0f;
    disc->corrected = false;
    if (scene) {
        const int points = disc->points > 0 ? disc->points : AREA_POINTS;
        photon_area_make(scene, disc->p, disc->n, disc->r, points, &disc->area);
        disc->corrected = !disc->area.whole_disc;
        // In the narrowest cracks the area is nearly 0, and a single photon would be very bright.
        if (disc->corrected)
            fraction = fmaxf(photon_area_fraction(&disc->area, disc->kernel), 0.02f);
    }
    disc->scale = 1.0f / (PI_F * disc->r2 * fraction);
}

void photon_disc_make(const struct photon_query *query, const int *row, const float *distance2,
                      struct photon_disc *out) {
    out->map = query->map;
    out->p = query->p;
    out->n = query->n;
    out->kernel = query->kernel;
    out->count = query->k;
    out->row = row;
    out->distance2 = distance2;
    out->own = false;
    out->points = 0;
    out->corrected = false;
    out->scale = 0.0f;
    out->r2 = photon_radius2(query->map, row, distance2, query->k);
    out->r = sqrtf(out->r2);
    if (!(out->r > 0.0f)) return;
    bool measure = query->correction == AREA_MEASURED ||
                   (query->correction == AREA_IF_NEEDED && edge_near(out));
    photon_disc_scale(out, measure ? query->scene : NULL);
}

float photon_disc_weight(const struct photon_disc *disc, int i) {
    if (!is_counted(disc, i)) return 0.0f;
    const size_t at = (size_t)disc->row[i];
    const float d2 = disc->distance2[i];
    const vec3 n = photon_normal(disc, i);
    if (!is_on_surface(disc, i, n)) return 0.0f;
    if (disc->own) return photon_own_weight(disc->map, at, n, disc->p, d2, disc->kernel);
    if (disc->corrected) {
        vec3 d = v3_sub(photon_position(disc->map, at), disc->p);
        if (!photon_area_has(&disc->area, d, disc->r)) return 0.0f;
    }
    return disc->scale * photon_kernel_weight(disc->kernel, d2 / disc->r2);
}

rgb photon_disc_irradiance_within(const struct photon_disc *disc, int bounces) {
    rgb E = rgb_grey(0.0f);
    for (int i = 0; i < disc->count; i++) {
        const float weight = photon_disc_weight(disc, i);
        if (!(weight > 0.0f)) continue;
        const struct photon *photon = &disc->map->photon[disc->row[i]];
        if (photon->bounces <= bounces)
            E = rgb_mad(E, photon->power, weight * photon_unpack_tilt(photon->tilt));
    }
    return E;
}

rgb photon_disc_irradiance(const struct photon_disc *disc) {
    return photon_disc_irradiance_within(disc, PHOTON_BOUNCES_MOST);
}

rgb photon_disc_last(const struct photon_disc *disc) {
    rgb E = rgb_grey(0.0f);
    for (int i = 0; i < disc->count; i++) {
        const float weight = photon_disc_weight(disc, i);
        if (!(weight > 0.0f)) continue;
        const struct photon *photon = &disc->map->photon[disc->row[i]];
        if (photon->last) E = rgb_mad(E, photon->power, weight * photon_unpack_tilt(photon->tilt));
    }
    return E;
}

float photon_disc_clear(const struct photon_disc *disc) {
    return disc->corrected ? disc->r / photon_area_inverse(&disc->area) : disc->r;
}

// The copies of a divided photon are not independent: m of them together have m times the variance.
float photon_disc_variance(const struct photon_disc *disc) {
    float sum = 0.0f;
    for (int i = 0; i < disc->count; i++) {
        const float in_disc = photon_disc_weight(disc, i);
        if (!(in_disc > 0.0f)) continue;
        const struct photon *photon = &disc->map->photon[disc->row[i]];
        const float weight = in_disc * photon_unpack_tilt(photon->tilt);
        const rgb c = photon->power;
        const float together = 1.0f + (float)photon->copies;
        sum += together * weight * weight * (c.r * c.r + c.g * c.g + c.b * c.b);
    }
    return sum;
}

// ---- Reflected radiance -----------------------------------------------------------------------

rgb photon_disc_radiance(const struct photon_disc *disc, const struct photon_reflection *at) {
    rgb L = rgb_grey(0.0f);
    for (int i = 0; i < disc->count; i++) {
        float weight = photon_disc_weight(disc, i);
        if (!(weight > 0.0f)) continue;
        const struct photon *photon = &disc->map->photon[disc->row[i]];
        if (photon->bounces > at->bounces) continue;
        vec3 wi = photon_unpack(photon->wi), local = frame_to_local(at->frame, wi);
        float cosine = v3_dot(wi, photon_unpack(photon->n));
        if (!(local.z > 0.0f) || !(cosine > 0.0f)) continue;
        unsigned lobes = at->lobes;
        if (brdf_is_sharp(at->brdf, at->wo, local, at->pdf_most)) lobes &= ~(unsigned)BRDF_GLOSSY;
        const rgb f = brdf_eval(at->brdf, at->wo, local, lobes);
        weight *= fminf(local.z / cosine, PHOTON_TILT_MOST);
        L = rgb_mad(L, rgb_mul(f, photon->power), weight);
    }
    return L;
}

void photon_disc_find(const struct photon_query *query, int *row, float *distance2,
                      struct photon_disc *out) {
    const float q[3] = {query->p.x, query->p.y, query->p.z};
    photon_index_nearest(query->map->index, q, 1, query->k, photon_map_far2(query->map), row,
                         distance2);
    photon_disc_make(query, row, distance2, out);
    photon_disc_drop_hidden(query->scene, row, distance2, out);
}

rgb photon_radiance(const struct photon_maps *maps, const struct satin_scene *scene,
                    const struct shading_point *point, unsigned lobes, int bounces, float *radius) {
    *radius = INFINITY;
    if (maps->global.count == 0) return rgb_grey(0.0f);
    struct photon_query query = {&maps->global,
                                 scene,
                                 point->interaction.p,
                                 point->ng,
                                 maps->photon_k,
                                 KERNEL_FLAT,
                                 maps->area ? AREA_IF_NEEDED : AREA_WHOLE};
    struct photon_reflection at =
        photon_reflection_make(&point->frame, &point->brdf, point->wo_l, lobes);
    if (bounces >= 0) at.bounces = bounces;
    int row[PHOTON_K_MAX];
    float distance2[PHOTON_K_MAX];
    struct photon_disc disc;
    photon_disc_find(&query, row, distance2, &disc);
    *radius = photon_disc_reliable(&disc) ? disc.r : INFINITY;
    return photon_disc_radiance(&disc, &at);
}
