// SPDX-License-Identifier: Apache-2.0
// Private to shade/: light from records at a point, and the lobes that are left to other
// techniques.
#ifndef SHADE_RECORDS_H
#define SHADE_RECORDS_H

#include "shade/shade.h"

// The technique for each lobe at a point.
struct shade_plan {
    unsigned cached;                 // glossy and diffuse lobes from a radiance record
    unsigned diffuse;                // diffuse lobe from irradiance
    unsigned sampled;                // glossy lobes and transmission by importance sampling
    const struct brdf_range *table;  // of the glossy lobe, if it is cached
    int channels;
    float bump;  // fraction of the cached glossy light that bumps leave
};

void shade_plan_make(const struct shade *shade, const struct gather_point *p,
                     struct shade_plan *plan);

// The point of a cache lookup. If no record is accurate enough there, the nearest one up to the
// distance `fallback` is used.
static inline struct cache_lookup shade_lookup(const struct gather_point *p, float fallback) {
    return (struct cache_lookup){p->interaction.p, p->base.n, p->frame, fallback};
}

// Reads from radiance records the light that the glossy lobes reflect, without the factor
// brdf.specular, and the irradiance, if the plan uses them. If count is 0, both are unchanged.
struct cache_used shade_radiance(const struct shade *shade, const struct shade_plan *plan,
                                 const struct gather_point *p, const struct cache_lookup *at,
                                 rgb *glossy, rgb *E);
// The number by which records identify a point's glossy lobes; 0 if textures change their shape.
static inline uint32_t shade_lobe_number(const struct gather_point *p) {
    return shade_shape_textured(p->side) ? 0 : (uint32_t)p->side->index + 1;
}
// Sets the name and the mirror direction of a point's glossy lobe.
static inline void shade_lobe_name(const struct gather_point *p, struct cache_lobe *lobe) {
    lobe->name = shade_lobe_number(p);
    lobe->mirror = cache_mirror(&p->frame, p->wo_l);
}
// The fraction of the irradiance that the diffuse lobe reflects, per solid angle.
rgb shade_diffuse_albedo(const struct gather_point *p);

// The kinds of records that the plan of a point uses, a mask of 1 << cache_kind; 0: none.
unsigned shade_record_kinds(const struct shade *shade, const struct gather_point *p);

#endif
