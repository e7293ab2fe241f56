// SPDX-License-Identifier: Apache-2.0
// Private to gather/: hits that are near their site, and the diffuse bounces of gather rays that
// continue.
#ifndef GATHER_NEAR_H
#define GATHER_NEAR_H

#include "gather/gather_scratch.h"

// The number of radii of its lookup within which a hit is near. Nearer than one radius the lookup
// would blur over the start of the ray. Up to a few, the discs of few lookups cover a part of the
// hemisphere that matters, and their noise shows: with one radius the foot of a glossy wall had
// patches 6 to 11 % off at production in the case metal-room, and 50 to 250 positions of 5x5 pixels
// over 5 % off. With two and, for radiance records, whose lobes cover small parts of the
// directions, four, these were 6 to 74, in the same time. The inside of a gap of .02, lit by
// lookups of some .1 at its opening, had 2.8 times its light without the rule behind the first
// hit, 1.9 with one radius, 1.3 with two.
#define GATHER_NEAR_DISCS 2.0f
#define GATHER_NEAR_DISCS_RADIANCE 4.0f

// Whether a hit at distance t is near, where its lookup has this radius; never farther than one
// radius or the largest reliable one, as else most hits of a coarse photon map would be near.
bool gather_is_near(const struct gather *g, float t, float radius, float discs);

// The shading normal on the viewer's side. Frames of BRDFs that transmit keep the side of the
// surface, from whichever side it is seen.
static inline vec3 gather_viewer_normal(const struct shading_point *y) {
    return y->wo_l.z < 0.0f ? v3_neg(y->frame.n) : y->frame.n;
}

// Whether the estimate at a hit is read, where its lookup has this radius. If not, the ray
// continues; without option gather-near every estimate is read.
static inline bool gather_is_reliable(const struct gather *g, const struct shading_point *y,
                                      float radius, bool near) {
    const bool averted = v3_dot(gather_viewer_normal(y), y->ng) < 0.0f;
    return !(g->options->gather_near && (near || averted || radius > g->lookup_max));
}

// The cones of photon clusters to which directions are drawn, each with the fraction of a few test
// points from which its cluster is visible, never 0.
struct gather_cones {
    struct guide_cone cone[GUIDE_CONES];
    float visible[GUIDE_CONES];
    int count;
};

// What is known of the clusters around a site.
enum gather_near_state {
    NEAR_NOT_SEARCHED,  // nothing; they are searched at the first hit whose ray continues
    NEAR_SEARCHED,      // the clusters, but not from where they are visible
    NEAR_PROBED         // also which of them contribute to hits
};

// The photon clusters around a site, for the bounces of rays that continue.
struct gather_near {
    float discs;     // GATHER_NEAR_DISCS or GATHER_NEAR_DISCS_RADIANCE
    vec3 p;          // the site
    float expected;  // approximate irradiance at the site [W m^-2]
    bool single;     // for single rays: the clusters that contribute to the first hits that
                     // continue are those of all further hits
    enum gather_near_state state;
    struct gather_cones cones;  // clusters that contribute to hits, from NEAR_PROBED on
    int found;                  // cones in cones.cone, from NEAR_SEARCHED on: those that do not
                                // contribute follow
};

// Whether the rays are those of a record, whose light the image shows over an area: they read what
// is reliable alone, with strict lookups. Single rays also read what may be wrong, as the noise of
// paths would be visible: with strict lookups for them, too, the image of a dark glossy floor had
// 1.7 times the error (docs/experiments/first-passes.md).
static inline bool gather_near_of_record(const struct gather_near *near) {
    return near && !near->single;
}

// A point from which the visibility of clusters is tested, and the irradiance there by other light.
struct gather_probe {
    struct guide_point at;
    float rest;  // [W m^-2]
};
// The fraction of the GUIDE_PROBES or fewer probes from which the cone's cluster is visible, among
// those to which it contributes; 0 if there are none. For `single` rays the least contribution is
// larger.
float gather_visible_fraction(const struct gather *g, const struct gather_probe *probe, int probes,
                              bool single, struct guide_cone cone);

// Finds the clusters around the site of `near` that contribute to those of the first `count` hits
// whose rays continue. Changes nothing if there is none, or if the clusters are those of earlier
// hits. E and `reliable` of the hits must be known.
void gather_near_probe(const struct gather *g, const struct gather_hits *hits, size_t count,
                       struct gather_near *near);

// Whether bounces by `lobes` of a surface that has the lobes `all` are aimed at clusters: those of
// the diffuse lobe, and glossy ones where there is none, as of metal. To aim those of coats, whose
// light is faint, costs more than it gains.
static inline bool gather_aims_bounce(unsigned all, unsigned lobes) {
    return lobes == BRDF_DIFFUSE || (lobes == BRDF_GLOSSY && !(all & BRDF_DIFFUSE));
}
// Draws a direction from which y reflects light by the lobes: by these themselves or to one of the
// clusters. E [W m^-2] is the luminance of the first-pass irradiance at y. Otherwise as
// brdf_sample_wi; pdf_w is that of the lobes alone, for MIS with light samples.
bool gather_near_bounce(const struct gather_cones *cones, const struct shading_point *y,
                        unsigned lobes, float E, float u_lobe, vec2 u, struct brdf_sample *out);

// Does what gather_near_bounce does, by any smooth lobes of a point near which the cones' site is.
// pdf_w is the density of the direction.
bool gather_near_sample(const struct gather_cones *cones, const struct shading_point *p,
                        unsigned lobes, float E, float u_lobe, vec2 u, struct brdf_sample *out);

// ---- gather_ray.c
// As gather_rays, with guided bounces from hits near the site of `near`, which hits complete (see
// gather_near_probe); NULL: no bounces are guided.
void gather_rays_guided(const struct gather *g, struct gather_scratch *scratch,
                        struct gather_ray *rays, size_t count, uint64_t stream,
                        struct gather_near *near);

#endif
