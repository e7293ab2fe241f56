// SPDX-License-Identifier: Apache-2.0
// Scatters a photon by the adjoint BSDF [Veach 1997, 5.3.2]: the viewer of the BSDF is where the
// photon goes. Some maps mirror their normals for viewers who would see them from behind
// [Schuessler et al. 2017], so the frame of the BSDF depends on the direction that is drawn. Then
// directions are drawn in either frame, and evaluated in that of their viewer.
#include "photon/photon_scatter.h"

#include "base/sampling.h"

// Normals whose cosine is larger count as equal: of the directions by the cosine about one of them,
// one in 2,500 has a cosine about the other that is over 1.5 times larger.
static const float TILTED_COSINE = 0.9998f;

// ---- Facets -------------------------------------------------------------------------------------

static bool same_normal(vec3 a, vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

static bool is_mirrored_by_maps(const struct material_side *side) {
    for (int i = 0; i < BRDF_BUMPS_MAX && scene_bump_used(&side->bump[i]); i++)
        if (side->bump[i].upright) return true;
    return false;
}

// The facet for a viewer in direction wo.
static bool facet_towards(const struct photon_surface *at, vec3 wo, struct photon_facet *out) {
    return scene_component_brdf(at->scene, at->side, at->s, wo, &out->brdf, &out->frame);
}

// The probability of the other facet. Where its mirrored direction has viewers who see this one,
// only the tail of its lobe counts.
static float other_probability(const struct photon_surface *at, vec3 upright) {
    const struct photon_facet *front = &at->facet[0], *other = &at->facet[1];
    const float cosine = v3_dot(at->wi, other->frame.n);
    if (!(cosine * v3_dot(at->wi, upright) > 0.0f)) return 0.0f;
    if (brdf_transmits(&other->brdf)) return 0.5f;
    const vec3 mirror = v3_mad(v3_neg(at->wi), 2.0f * cosine, other->frame.n);
    if (v3_dot(mirror, front->frame.n) <= 0.0f) return 0.5f;
    return 0.25f * (1.0f - v3_dot(front->frame.n, other->frame.n));
}

// Adds the facet that viewers see who are behind the first one, but above the surface.
static void add_mirrored(struct photon_surface *at) {
    struct photon_facet *front = &at->facet[0];
    const vec3 up = scene_component_frame(at->scene, at->side, at->s, at->wi).n;
    const vec3 along = v3_mad(front->frame.n, -v3_dot(front->frame.n, up), up);
    const float sine = v3_len(along);
    if (!(sine > 1e-4f)) return;
    // Halfway between the surface and the plane of the facet.
    const vec3 behind =
        v3_unit(v3_mad(v3_mul(up, sine), -(1.0f + v3_dot(front->frame.n, up)) / sine, along));
    if (!facet_towards(at, behind, &at->facet[1])) return;
    if (same_normal(at->facet[1].frame.n, front->frame.n)) return;
    at->facets = 2;
    at->facet[1].probability = other_probability(at, up);
    front->probability = 1.0f - at->facet[1].probability;
}

bool photon_surface_make(const struct satin_scene *scene, const struct interaction *s, vec3 wi,
                         struct photon_surface *out) {
    out->scene = scene;
    out->s = s;
    out->side = scene_draw_component(scene, s, wi);
    out->wi = wi;
    out->n = v3_dot(s->ng, wi) < 0.0f ? v3_neg(s->ng) : s->ng;
    out->facets = 1;
    out->facet[0].probability = 1.0f;
    if (!facet_towards(out, wi, &out->facet[0])) return false;
    if (is_mirrored_by_maps(out->side)) add_mirrored(out);
    return true;
}

float photon_factor_in(const struct photon_surface *at, const struct frame *frame) {
    return fabsf(v3_dot(at->wi, frame->n)) / fabsf(v3_dot(at->wi, at->n));
}

// ---- Directions ---------------------------------------------------------------------------------

// Draws one of the facets by *u, which it leaves in [0, 1).
static const struct photon_facet *draw_facet(const struct photon_surface *at, float *u) {
    const float other = 1.0f - at->facet[0].probability;
    if (at->facets == 1 || !(other > 0.0f)) return &at->facet[0];
    if (*u < other) {
        *u = minf(*u / other, SAMPLE_BELOW_ONE);
        return &at->facet[1];
    }
    *u = sample_rest(*u, other);
    return &at->facet[0];
}

// The density with which the facets' lobes are drawn.
static float facets_pdf(const struct photon_surface *at, vec3 wo) {
    float pdf = 0.0f;
    for (int i = 0; i < at->facets; i++) {
        const struct photon_facet *f = &at->facet[i];
        const vec3 wi_l = frame_to_local(&f->frame, at->wi), wo_l = frame_to_local(&f->frame, wo);
        if (f->probability > 0.0f) pdf += f->probability * brdf_pdf(&f->brdf, wi_l, wo_l, BRDF_ALL);
    }
    return pdf;
}

// Directions in the facet's plane carry no power, and their adjoint factor has no value.
static bool leaves_plane(const struct photon_facet *facet, vec3 wo) {
    return v3_dot(wo, facet->frame.n) != 0.0f;
}

// Draws a direction by the lobes of a facet, which is returned; NULL if the sample fails.
static const struct photon_facet *draw_lobe(const struct photon_surface *at, unsigned lobes, vec3 u,
                                            struct photon_scattered *out) {
    const struct photon_facet *facet = draw_facet(at, &u.x);
    const vec3 wi_l = frame_to_local(&facet->frame, at->wi);
    if (!brdf_sample_wi(&facet->brdf, wi_l, u.x, (vec2){u.y, u.z}, lobes, BRDF_POWER, &out->sample))
        return NULL;
    out->frame = facet->frame;
    out->wo = frame_to_world(&facet->frame, out->sample.wi);
    return leaves_plane(facet, out->wo) ? facet : NULL;
}

// A direction that was drawn by a facet counts only if its viewer sees this facet.
static bool is_shown(const struct photon_surface *at, const struct photon_facet *facet,
                     struct photon_scattered *out) {
    if (at->facets == 1) return true;
    struct photon_facet shown;
    if (!facet_towards(at, out->wo, &shown) || !same_normal(shown.frame.n, facet->frame.n))
        return false;
    out->sample.weight = rgb_scale(out->sample.weight, 1.0f / facet->probability);
    return true;
}

bool photon_scatter_along(const struct photon_surface *at, float pdf,
                          struct photon_scattered *out) {
    struct photon_facet shown;
    const struct photon_facet *facet = &at->facet[0];
    if (at->facets > 1) {
        if (!facet_towards(at, out->wo, &shown)) return false;
        facet = &shown;
    }
    if (!leaves_plane(facet, out->wo)) return false;
    const vec3 wi_l = frame_to_local(&facet->frame, at->wi);
    const vec3 wo_l = frame_to_local(&facet->frame, out->wo);
    // The viewer is where the photon goes, and the slopes of a map shadow where it comes from.
    const rgb f = brdf_eval(&facet->brdf, wo_l, wi_l, BRDF_SMOOTH);
    out->frame = facet->frame;
    out->sample = (struct brdf_sample){.wi = wo_l,
                                       .weight = rgb_scale(f, fabsf(wo_l.z) / pdf),
                                       .pdf_w = pdf,
                                       .probability = 1.0f,
                                       .eta = 1.0f,
                                       .lobe = BRDF_DIFFUSE};
    return true;
}

static float tilted_pdf(const struct photon_surface *at, vec3 wo) {
    const float by_surface = fmaxf(v3_dot(wo, at->n) / PI_F, 0.0f);
    return 0.5f * (facets_pdf(at, wo) + by_surface);
}

// The cosine about a tilted normal is small where that about the surface's need not be, and their
// ratio has no limit. So half of the directions of smooth lobes are drawn by the cosine about the
// surface's normal.
static bool draw_tilted(const struct photon_surface *at, vec3 u, struct photon_scattered *out) {
    if (u.x < 0.5f) {
        const struct frame flat = frame_from_normal(at->n);
        out->wo = frame_to_world(&flat, sample_cosine_hemisphere(u.y, u.z));
    } else {
        const struct photon_facet *facet =
            draw_lobe(at, BRDF_ALL, v3(sample_rest(u.x, 0.5f), u.y, u.z), out);
        if (!facet) return false;
        if (out->sample.lobe & BRDF_DELTA) {
            out->sample.weight = rgb_scale(out->sample.weight, 2.0f);
            return is_shown(at, facet, out);
        }
    }
    const float pdf = tilted_pdf(at, out->wo);
    return pdf > 0.0f && photon_scatter_along(at, pdf, out);
}

// Whether directions are drawn about the surface's normal too: where a photon meets a smooth lobe
// about another normal. What transmits is left out, as half of its directions are on the other
// side.
static bool is_tilted(const struct photon_surface *at, unsigned lobes) {
    const struct photon_facet *facet = &at->facet[0];
    return lobes == BRDF_ALL && fabsf(v3_dot(facet->frame.n, at->n)) < TILTED_COSINE &&
           brdf_lobes(&facet->brdf) & BRDF_SMOOTH && !brdf_transmits(&facet->brdf);
}

bool photon_scatter(const struct photon_surface *at, unsigned lobes, struct rng *rng,
                    struct photon_scattered *out) {
    const float u_lobe = rng_float(rng), x = rng_float(rng), y = rng_float(rng);
    const vec3 u = v3(u_lobe, x, y);
    if (is_tilted(at, lobes)) return draw_tilted(at, u, out);
    const struct photon_facet *facet = draw_lobe(at, lobes, u, out);
    return facet && is_shown(at, facet, out);
}

float photon_scatter_pdf(const struct photon_surface *at, vec3 wo) {
    return is_tilted(at, BRDF_ALL) ? tilted_pdf(at, wo) : facets_pdf(at, wo);
}
