// SPDX-License-Identifier: Apache-2.0
// Density estimates from the k nearest photons [Jensen 2001, ch. 7]. Photons on the other side of
// the surface, or on a surface of another orientation or layer, are not counted, and the disc is
// divided by the area of the surface in it (photon_area.c). The radius is that of the outermost
// photon, which is not counted: the k - 1 others are uniform in the disc, so their number over its
// area is an unbiased density, while k over the area is too high by 1 / (k - 1). In the caustic map
// each photon has a kernel of its own radius (photon_radii.c), and counts only in the discs in
// which it is among the k nearest.
#include "photon/photon_map.h"

// Largest distance of a photon from the plane of the disc, as a fraction of its radius.
#define LAYER 0.35f
// Limit of smoothed irradiance over that estimated at the point, and of its inverse.
#define RATIO_MOST 2.0f

// Whether photon i is on the surface of the disc, by its normal and its distance from the plane.
static bool is_on_surface(const struct photon_disc *disc, int i) {
    const struct photon_map *map = disc->map;
    size_t at = (size_t)disc->row[i];
    if (v3_dot(photon_unpack(map->photon[at].n), disc->n) < PHOTON_FACING) return false;
    float height = v3_dot(v3_sub(photon_position(map, at), disc->p), disc->n);
    return fabsf(height) <= LAYER * disc->r;
}

static bool is_counted(const struct photon_disc *disc, int i) {
    return disc->row[i] >= 0 && disc->distance2[i] < disc->r2;
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
            !is_on_surface(disc, i))
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

static uint64_t point_key(vec3 p) {
    union {
        float f[3];
        uint32_t u[3];
    } bits = {{p.x, p.y, p.z}};
    return rng_mix(bits.u[0] ^ rng_mix((uint64_t)bits.u[1] << 32 | bits.u[2]));
}

void photon_disc_scale(struct photon_disc *disc, const struct satin_scene *scene) {
    float fraction = 1.0f;
    disc->corrected = false;
    if (scene) {
        photon_area_make(scene, disc->p, disc->n, disc->r, point_key(disc->p), &disc->area);
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
    out->radius2 = query->radius2;
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
    if (!is_counted(disc, i) || !is_on_surface(disc, i)) return 0.0f;
    if (disc->corrected) {
        vec3 d = v3_sub(photon_position(disc->map, (size_t)disc->row[i]), disc->p);
        if (!photon_area_has(&disc->area, d, disc->r)) return 0.0f;
    }
    const float r2 = disc->radius2 ? disc->radius2[disc->row[i]] : disc->r2,
                d2 = disc->distance2[i];
    if (!(d2 < r2)) return 0.0f;
    return disc->scale * (disc->r2 / r2) * photon_kernel_weight(disc->kernel, d2 / r2);
}

rgb photon_disc_irradiance_within(const struct photon_disc *disc, int bounces) {
    rgb E = rgb_grey(0.0f);
    for (int i = 0; i < disc->count; i++) {
        const float weight = photon_disc_weight(disc, i);
        if (!(weight > 0.0f)) continue;
        const struct photon *photon = &disc->map->photon[disc->row[i]];
        if (photon->bounces <= bounces) E = rgb_mad(E, photon->power, weight);
    }
    return E;
}

rgb photon_disc_irradiance(const struct photon_disc *disc) {
    return photon_disc_irradiance_within(disc, PHOTON_BOUNCES_MOST);
}

int photon_disc_bounces(const struct photon_disc *disc) {
    int most = 0;
    for (int i = 0; i < disc->count; i++) {
        if (!(photon_disc_weight(disc, i) > 0.0f)) continue;
        const int bounces = disc->map->photon[disc->row[i]].bounces;
        if (bounces > most) most = bounces;
    }
    return most;
}

rgb photon_disc_last(const struct photon_disc *disc) {
    rgb E = rgb_grey(0.0f);
    for (int i = 0; i < disc->count; i++) {
        const float weight = photon_disc_weight(disc, i);
        if (!(weight > 0.0f) || !disc->map->photon[disc->row[i]].last) continue;
        E = rgb_mad(E, disc->map->photon[disc->row[i]].power, weight);
    }
    return E;
}

float photon_disc_clear(const struct photon_disc *disc) {
    float inverse = 1.0f;
    for (int i = 0; disc->corrected && i < AREA_SECTORS; i++)
        inverse = fmaxf(inverse, disc->area.inverse[i]);
    return disc->r / inverse;
}

float photon_disc_variance(const struct photon_disc *disc) {
    float sum = 0.0f;
    for (int i = 0; i < disc->count; i++) {
        const float weight = photon_disc_weight(disc, i);
        if (!(weight > 0.0f)) continue;
        const rgb c = disc->map->photon[disc->row[i]].power;
        sum += weight * weight * (c.r * c.r + c.g * c.g + c.b * c.b);
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
        // Limited, because the few photons at grazing angles would be very bright.
        weight *= fminf(local.z / cosine, 4.0f);
        L = rgb_mad(L, rgb_mul(f, photon->power), weight);
    }
    return L;
}

// Searches the photons of a disc; row and distance2 have PHOTON_K_MAX items.
static void find_disc(const struct photon_query *query, int *row, float *distance2,
                      struct photon_disc *out) {
    const float q[3] = {query->p.x, query->p.y, query->p.z};
    photon_index_nearest(query->map->index, q, 1, query->k, photon_map_far2(query->map), row,
                         distance2);
    photon_disc_make(query, row, distance2, out);
}

// The radiance reflected from the photons around the point and, if E is not NULL, their irradiance.
static rgb estimate(const struct photon_query *query, const struct photon_reflection *at,
                    float *radius, rgb *E) {
    int row[PHOTON_K_MAX];
    float distance2[PHOTON_K_MAX];
    struct photon_disc disc;
    find_disc(query, row, distance2, &disc);
    *radius = disc.r;
    if (E) *E = photon_disc_irradiance(&disc);
    return photon_disc_radiance(&disc, at);
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
                                 maps->area ? AREA_IF_NEEDED : AREA_WHOLE,
                                 NULL};
    struct photon_reflection at =
        photon_reflection_make(&point->frame, &point->brdf, point->wo_l, lobes);
    if (bounces >= 0) at.bounces = bounces;
    return estimate(&query, &at, radius, NULL);
}

// How the caustic map is read at a point.
enum map_read {
    READ_ENTRY,   // from the nearest entry
    READ_SPARSE,  // by an estimate at the point, as the nearest entry has fewer than k photons
    READ_POINT    // by an estimate at the point, as the nearest entry is behind a wall, or has
                  // photons that have bounced too often
};

// Reads the precomputed irradiance of the caustic map. An estimate of all photons within the
// largest radius has their energy if it is made at every point, but not if it is read from the
// nearest photon: of light that fades between sparse photons half was lost.
static enum map_read precomputed(const struct photon_maps *maps, const struct satin_scene *scene,
                                 vec3 p, vec3 ng, int bounces, rgb *E) {
    const struct photon_irradiance *r = &maps->caustic_irradiance;
    *E = rgb_grey(0.0f);
    const int entry = photon_irradiance_entry(r, p, ng);
    if (entry < 0) return READ_ENTRY;
    if (r->bounces && bounces >= 0 && r->bounces[entry] > bounces) return READ_POINT;
    if (!maps->caustic.whole_disc[entry] && !photon_irradiance_visible(r, scene, entry, p, ng))
        return READ_POINT;
    const bool sparse = photon_irradiance_sparse(r, entry);
    *E = sparse ? r->E[entry] : photon_irradiance_value(r, entry, p);
    return sparse ? READ_SPARSE : READ_ENTRY;
}

// The factor that removes the noise of an estimate: the smoothed irradiance over that estimated at
// the point. A channel without light stays black.
static float smoothing_factor(float smoothed, float estimated) {
    return estimated > 0.0f ? clampf(smoothed / estimated, 1.0f / RATIO_MOST, RATIO_MOST) : 0.0f;
}

// The probability of looking up a caustic of about this irradiance. A low-frequency lobe reflects
// at most some ten times as much of it as of the light beside it.
static float lookup_probability(rgb E, struct photon_other_light other) {
    if (!(other.L > 0.0f)) return 1.0f;
    return clampf(50.0f * rgb_luminance(E) / (PI_F * other.L), 0.1f, 1.0f);
}

static struct photon_query caustic_query(const struct photon_maps *maps,
                                         const struct satin_scene *scene, vec3 p, vec3 ng) {
    return (struct photon_query){&maps->caustic,
                                 scene,
                                 p,
                                 ng,
                                 maps->caustic_k,
                                 KERNEL_PARABOLA,
                                 maps->area ? AREA_IF_NEEDED : AREA_WHOLE,
                                 maps->caustic.radius2};
}

rgb photon_caustic(const struct photon_maps *maps, const struct satin_scene *scene,
                   const struct shading_point *point, const struct photon_caustic_limits *limits,
                   struct photon_other_light other) {
    if (maps->caustic.count == 0 || limits->bounces == 0) return rgb_grey(0.0f);
    const struct brdf *brdf = &point->brdf;
    const vec3 p = point->interaction.p, ng = point->ng, wo = point->wo_l;
    rgb E, estimated;
    float radius;
    const bool diffuse = brdf->model->lobes == BRDF_DIFFUSE;
    enum map_read source = READ_POINT;
    if (maps->area && (diffuse || maps->smooth))
        source = precomputed(maps, scene, p, ng, limits->bounces, &E);
    if (source == READ_ENTRY && diffuse)
        return rgb_mul(brdf_eval(brdf, wo, v3(0.0f, 0.0f, 1.0f), limits->lobes), E);
    if (source == READ_ENTRY && rgb_black(E)) return E;
    const float chance = source == READ_POINT ? 1.0f : lookup_probability(E, other);
    if (!(other.u < chance)) return rgb_grey(0.0f);
    const struct photon_query query = caustic_query(maps, scene, p, ng);
    struct photon_reflection at = photon_reflection_make(&point->frame, brdf, wo, limits->lobes);
    at.pdf_most = limits->pdf_most;
    if (limits->bounces >= 0) at.bounces = limits->bounces;
    const rgb L = rgb_scale(estimate(&query, &at, &radius, &estimated), 1.0f / chance);
    if (source != READ_ENTRY) return L;
    return rgb_make(L.r * smoothing_factor(E.r, estimated.r),
                    L.g * smoothing_factor(E.g, estimated.g),
                    L.b * smoothing_factor(E.b, estimated.b));
}

rgb photon_caustic_irradiance(const struct photon_maps *maps, const struct satin_scene *scene,
                              vec3 p, vec3 n, int bounces, struct photon_other_light other) {
    if (maps->caustic.count == 0 || bounces == 0) return rgb_grey(0.0f);
    rgb E;
    const enum map_read source = precomputed(maps, scene, p, n, bounces, &E);
    if (source == READ_ENTRY) return E;
    const float chance = source == READ_SPARSE ? lookup_probability(E, other) : 1.0f;
    if (!(other.u < chance)) return rgb_grey(0.0f);
    const struct photon_query query = caustic_query(maps, scene, p, n);
    struct photon_disc disc;
    int row[PHOTON_K_MAX];
    float distance2[PHOTON_K_MAX];
    find_disc(&query, row, distance2, &disc);
    if (bounces < 0) bounces = PHOTON_BOUNCES_MOST;
    return rgb_scale(photon_disc_irradiance_within(&disc, bounces), 1.0f / chance);
}
