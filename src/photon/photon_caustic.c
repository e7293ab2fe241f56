// SPDX-License-Identifier: Apache-2.0
// Caustics at a point, from the caustic map: the precomputed irradiance of the nearest photon, or a
// density estimate at the point where that does not describe it. What a lobe reflects also depends
// on the directions of light: those of all photons of the estimate where the eye sees the point,
// those of a few photons at the hit of a gather ray. Lookups that would add little are made with a
// smaller probability; but not those of sparse light where the eye sees it: the nearest entry says
// little of it, and the pixels of the few lookups would be dots.
#include "photon/photon_cover.h"

// Limit of smoothed irradiance over that estimated at the point, and of its inverse.
#define RATIO_MOST 2.0f

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
                                 vec3 p, vec3 ng, int bounces, rgb *E, int *entry) {
    const struct photon_irradiance *r = &maps->caustic_irradiance;
    *E = rgb_grey(0.0f);
    *entry = photon_irradiance_entry(r, p, ng);
    if (*entry < 0) return READ_ENTRY;
    if (r->bounces && bounces >= 0 && r->bounces[*entry] > bounces) return READ_POINT;
    if (!maps->caustic.whole_disc[*entry] && !photon_irradiance_visible(r, scene, *entry, p, ng))
        return READ_POINT;
    const bool sparse = photon_irradiance_sparse(r, *entry);
    *E = sparse ? r->E[*entry] : photon_irradiance_value(r, *entry, p);
    return sparse ? READ_SPARSE : READ_ENTRY;
}

// The factor that removes the noise of an estimate: the smoothed irradiance over that estimated at
// the point. It is 1 where the estimate has none: facets that viewers see mirrored may reflect
// light that comes from behind the facets at its photons.
static float smoothing_factor(float smoothed, float estimated) {
    return estimated > 0.0f ? clampf(smoothed / estimated, 1.0f / RATIO_MOST, RATIO_MOST) : 1.0f;
}

// The probability of looking up a caustic of about this irradiance. A low-frequency lobe reflects
// at most some ten times as much of it as of the light beside it (LOBE), a diffuse one as much of
// both (DIFFUSE). If a caustic of less than a fifth of the light beside it is looked up with five
// times that fraction as the probability, the variance that this adds is less than a fifth of it
// times the square of all light.
#define DIFFUSE_LOOKUPS 5.0f
#define LOBE_LOOKUPS 50.0f
static float lookup_probability(rgb E, struct photon_other_light other, float lookups) {
    if (!(other.L > 0.0f)) return 1.0f;
    return clampf(lookups * rgb_luminance(E) / (PI_F * other.L), 0.1f, 1.0f);
}

// The radiance that a point reflects of all photons whose discs cover it, and their irradiance.
static rgb reflect_covering(const struct photon_maps *maps, vec3 p, vec3 ng,
                            const struct photon_reflection *at, rgb *E) {
    rgb L = rgb_grey(0.0f);
    *E = L;
    struct photon_cover_walk walk;
    photon_cover_begin(&walk, &maps->caustic, p, ng, KERNEL_PARABOLA);
    while (photon_cover_next(&walk)) {
        *E = rgb_add(*E, photon_disc_irradiance(&walk.disc));
        L = rgb_add(L, photon_disc_radiance(&walk.disc, at));
    }
    return L;
}

// The photons beside an entry in Morton order, and itself. They are some of those around it, and no
// search is needed to find them.
enum { NEIGHBOURS = 16, NEIGHBOURS_LEAST = 4 };

// The radiance that a point reflects of an entry's irradiance E, by the directions of photons
// beside the entry. False if these are too few.
static bool reflect_entry(const struct photon_maps *maps, int entry, rgb E, vec3 p, vec3 ng,
                          const struct photon_reflection *at, rgb *out) {
    const struct photon_map *map = &maps->caustic;
    int row[NEIGHBOURS], counted = 0;
    float distance2[NEIGHBOURS];
    struct photon_disc disc = {.map = map,
                               .p = p,
                               .n = ng,
                               .kernel = KERNEL_PARABOLA,
                               .row = row,
                               .distance2 = distance2,
                               .own = true};
    const size_t begin = entry > NEIGHBOURS / 2 ? (size_t)entry - NEIGHBOURS / 2 : 0;
    for (size_t i = begin; i < map->count && disc.count < NEIGHBOURS; i++) {
        row[disc.count] = (int)i;
        distance2[disc.count++] = v3_dist2(photon_position(map, i), p);
    }
    for (int i = 0; i < disc.count; i++) counted += photon_disc_weight(&disc, i) > 0.0f;
    if (counted < NEIGHBOURS_LEAST) return false;
    const rgb beside = photon_disc_irradiance_within(&disc, at->bounces),
              L = photon_disc_radiance(&disc, at);
    *out = rgb_make(beside.r > 0.0f ? L.r * E.r / beside.r : 0.0f,
                    beside.g > 0.0f ? L.g * E.g / beside.g : 0.0f,
                    beside.b > 0.0f ? L.b * E.b / beside.b : 0.0f);
    return true;
}

// How the map is read at a point, and the irradiance of the nearest entry. Where all facets of a
// map of normals face away from the light, their irradiance is black; but some of them are mirrored
// for the viewer, and reflect it.
static enum map_read read_map_at(const struct photon_maps *maps, const struct satin_scene *scene,
                                 const struct shading_point *point, int bounces, rgb *E,
                                 int *entry) {
    const enum map_read source =
        precomputed(maps, scene, point->interaction.p, point->ng, bounces, E, entry);
    return rgb_black(*E) && *entry >= 0 && brdf_has_bump(&point->brdf) ? READ_POINT : source;
}

static struct photon_reflection caustic_reflection(const struct shading_point *point,
                                                   const struct photon_caustic_limits *limits) {
    struct photon_reflection at =
        photon_reflection_make(&point->frame, &point->brdf, point->wo_l, limits->lobes);
    at.pdf_most = limits->pdf_most;
    if (limits->bounces >= 0) at.bounces = limits->bounces;
    return at;
}

rgb photon_caustic_at_hit(const struct photon_maps *maps, const struct satin_scene *scene,
                          const struct shading_point *point,
                          const struct photon_caustic_limits *limits,
                          struct photon_other_light other) {
    if (maps->caustic.count == 0 || limits->bounces == 0) return rgb_grey(0.0f);
    const vec3 p = point->interaction.p, ng = point->ng;
    rgb E, L;
    int entry;
    const enum map_read source = read_map_at(maps, scene, point, limits->bounces, &E, &entry);
    if (source == READ_ENTRY && rgb_black(E)) return E;
    const float chance = source == READ_POINT ? 1.0f : lookup_probability(E, other, LOBE_LOOKUPS);
    if (!(other.u < chance)) return rgb_grey(0.0f);
    const struct photon_reflection at = caustic_reflection(point, limits);
    if (source != READ_ENTRY || !reflect_entry(maps, entry, E, p, ng, &at, &L))
        L = reflect_covering(maps, p, ng, &at, &E);
    return rgb_scale(L, 1.0f / chance);
}

rgb photon_caustic(const struct photon_maps *maps, const struct satin_scene *scene,
                   const struct shading_point *point, const struct photon_caustic_limits *limits,
                   struct photon_other_light other) {
    if (maps->caustic.count == 0 || limits->bounces == 0) return rgb_grey(0.0f);
    const struct brdf *brdf = &point->brdf;
    const vec3 p = point->interaction.p, ng = point->ng, wo = point->wo_l;
    rgb E, estimated;
    int entry;
    // The irradiance of facets differs within a disc, so what a facet reflects depends on
    // directions.
    const bool diffuse = brdf_is_lambertian(brdf) && !brdf_has_bump(brdf);
    enum map_read source = READ_POINT;
    if (maps->area && (diffuse || maps->smooth))
        source = read_map_at(maps, scene, point, limits->bounces, &E, &entry);
    if (source == READ_ENTRY && diffuse)
        return rgb_mul(brdf_eval(brdf, wo, v3(0.0f, 0.0f, 1.0f), limits->lobes), E);
    if (source == READ_ENTRY && rgb_black(E)) return E;
    const float chance = source != READ_ENTRY ? 1.0f : lookup_probability(E, other, LOBE_LOOKUPS);
    if (!(other.u < chance)) return rgb_grey(0.0f);
    const struct photon_reflection at = caustic_reflection(point, limits);
    const rgb L = rgb_scale(reflect_covering(maps, p, ng, &at, &estimated), 1.0f / chance);
    if (source != READ_ENTRY) return L;
    return rgb_make(L.r * smoothing_factor(E.r, estimated.r),
                    L.g * smoothing_factor(E.g, estimated.g),
                    L.b * smoothing_factor(E.b, estimated.b));
}

rgb photon_caustic_irradiance(const struct photon_maps *maps, const struct satin_scene *scene,
                              vec3 p, vec3 n, int bounces, struct photon_other_light other) {
    if (maps->caustic.count == 0 || bounces == 0) return rgb_grey(0.0f);
    rgb E;
    int entry;
    const enum map_read source = precomputed(maps, scene, p, n, bounces, &E, &entry);
    if (source == READ_ENTRY) return E;
    const float chance =
        source == READ_SPARSE ? lookup_probability(E, other, DIFFUSE_LOOKUPS) : 1.0f;
    if (!(other.u < chance)) return rgb_grey(0.0f);
    if (bounces < 0) bounces = PHOTON_BOUNCES_MOST;
    struct photon_cover_walk walk;
    photon_cover_begin(&walk, &maps->caustic, p, n, KERNEL_PARABOLA);
    E = rgb_grey(0.0f);
    while (photon_cover_next(&walk))
        E = rgb_add(E, photon_disc_irradiance_within(&walk.disc, bounces));
    return rgb_scale(E, 1.0f / chance);
}
