// SPDX-License-Identifier: Apache-2.0
// The diffuse bounces of gather rays that continue because the photons' estimate at their hit is
// not reliable (gather_bounces.c), as where it is nearer than a photon lookup can resolve. Photon
// clusters may be visible from the hit y although they are not from the site: near the edge between
// a wall and a ceiling, a lit patch on the ceiling is visible from the wall, but not from the
// ceiling. A bounce by the BRDF alone hits such a cluster so rarely that one hit outweighs all
// other rays of its hemisphere. Therefore some of the bounces go to the clusters around the site
// that are visible from y. The balance heuristic [Veach and Guibas 1995] weights both kinds of
// samples, so the mean does not change.
#include "gather/gather_near.h"

// The largest fraction of the bounces from y that go to photon clusters.
static const float GUIDED = 0.5f;

// Clusters that contribute less than this fraction of the light at y get no bounces.
static const float NEAR_FAINT = 0.002f;

// Single rays go to clusters only if without them they add more than this to the variance of one
// ray over the squared mean, which for other light is about 1.
static const float VARIANCE_LEAST = 0.02f;

// A cluster that is not visible from any probe may be visible from other hits: its least weight,
// over that of one visible from all.
static const float VISIBLE_LEAST = 0.05f;

// The least fraction of a cone that is assumed to be lit.
static const float FILLED_LEAST = 0.01f;

bool gather_is_near(const struct gather *g, float t, float radius, float discs) {
    return t < fmaxf(radius, fminf(discs * radius, g->lookup_max));
}

// Whether the ray of a hit continues by a bounce that is aimed.
static bool continues(const struct gather_hits *hits, size_t i) {
    const unsigned lobes = hits->hit[i].point.lobes;
    return lobes & BRDF_DIFFUSE ? !hits->reliable[i] : gather_aims_bounce(lobes, lobes);
}

// Selects hits distributed uniformly over those that continue, and returns their number.
static int choose_probes(const struct gather_hits *hits, size_t all,
                         struct gather_probe probe[GUIDE_PROBES]) {
    size_t continued = 0, at = 0;
    int count = 0;
    for (size_t i = 0; i < all; i++) continued += continues(hits, i);
    for (size_t i = 0; i < all && count < GUIDE_PROBES; i++) {
        if (!continues(hits, i)) continue;
        if (at++ * GUIDE_PROBES < (size_t)count * continued) continue;
        const struct shading_point *y = &hits->hit[i].point;
        probe[count++] = (struct gather_probe){{y->interaction.p, gather_viewer_normal(y), y->ng},
                                               rgb_luminance(hits->E[i])};
    }
    return count;
}

// Whether a cluster contributes enough at a point that its cone was moved to.
static bool cluster_matters(const struct guide_cone *cone, float rest, bool single) {
    return single ? sqrf(cone->E) > VARIANCE_LEAST * cone->chance * sqrf(cone->E + rest)
                  : cone->E > NEAR_FAINT * (cone->E + rest);
}

float gather_visible_fraction(const struct gather *g, const struct gather_probe *probe, int probes,
                              bool single, struct guide_cone cone) {
    int matters = 0, unoccluded = 0;
    for (int i = 0; i < probes; i++) {
        const struct guide_point *at = &probe[i].at;
        if (!guide_cone_move(&cone, at->p, at->n)) continue;
        if (!cluster_matters(&cone, probe[i].rest, single)) continue;
        unoccluded += guide_cone_visible(g->clusters, g->scene, &cone, at, (size_t)i);
        matters++;
    }
    return matters ? fmaxf((float)unoccluded / (float)matters, VISIBLE_LEAST) : 0.0f;
}

void gather_near_probe(const struct gather *g, const struct gather_hits *hits, size_t count,
                       struct gather_near *near) {
    struct gather_cones *cones = &near->cones;
    struct gather_probe probe[GUIDE_PROBES];
    if (!g->options->gather_near || (near->single && near->state == NEAR_PROBED) ||
        (near->state != NEAR_NOT_SEARCHED && near->found == 0))
        return;
    const int probes = choose_probes(hits, count, probe);
    if (probes == 0) return;
    if (near->state == NEAR_NOT_SEARCHED)
        near->found = guide_cones_around(g->clusters, near->p, near->expected, cones->cone);
    near->state = NEAR_PROBED;
    cones->count = 0;
    for (int c = 0; c < near->found; c++) {
        const struct guide_cone cone = cones->cone[c];
        const float visible = gather_visible_fraction(g, probe, probes, near->single, cone);
        if (!(visible > 0.0f)) continue;
        cones->cone[c] = cones->cone[cones->count];
        cones->cone[cones->count] = cone;
        cones->visible[cones->count++] = visible;
    }
}

// The cones from y.
struct choices {
    struct guide_cone cone[GUIDE_CONES];
    float weight[GUIDE_CONES], all;
    int count;
};

// The light that lobes reflect from a cone's cluster, over what a diffuse lobe that reflects all
// light would reflect.
static float lobe_factor(const struct shading_point *y, unsigned lobes, vec3 axis) {
    if (lobes == BRDF_DIFFUSE) return 1.0f;
    const rgb f = brdf_eval(&y->brdf, y->wo_l, frame_to_local(&y->frame, axis), lobes);
    return PI_F * rgb_luminance(f);
}

static void move_cones(const struct gather_cones *cones, const struct shading_point *y,
                       unsigned lobes, struct choices *out) {
    const vec3 n = gather_viewer_normal(y);
    out->count = 0;
    out->all = 0.0f;
    for (int c = 0; c < cones->count; c++) {
        struct guide_cone *cone = &out->cone[out->count];
        *cone = cones->cone[c];
        if (!guide_cone_move(cone, y->interaction.p, n) || !(cone->E > 0.0f)) continue;
        // Least variance: in proportion to the standard deviation of one ray into the cone.
        const float deviation = cone->E / sqrtf(clampf(cone->filled, FILLED_LEAST, 1.0f));
        const float weight = cones->visible[c] * deviation * lobe_factor(y, lobes, cone->axis);
        if (!(weight > 0.0f)) continue;
        out->weight[out->count] = weight;
        out->all += out->weight[out->count++];
    }
}

// Draws a direction to one of the clusters, with probability `guided`, or by the lobes of y. Sets
// *out except pdf_w. Returns the density of the direction; 0: there is none.
static float draw_both(const struct choices *at, float guided, const struct shading_point *y,
                       unsigned lobes, float u_lobe, vec2 u, struct brdf_sample *out) {
    int own = -1;  // the cone from which the direction is drawn, even if rounding moves it outside
    if (u_lobe < guided) {
        float left = u_lobe / guided * at->all;
        for (own = 0; own + 1 < at->count && left >= at->weight[own]; own++)
            left -= at->weight[own];
        out->wi = frame_to_local(&y->frame, guide_cone_sample(&at->cone[own], u));
        out->lobe = lobes;
        if (!(out->wi.z * y->wo_l.z > 0.0f)) return 0.0f;
    } else if (!brdf_sample_wi(&y->brdf, y->wo_l, sample_rest(u_lobe, guided), u, lobes,
                               BRDF_RADIANCE, out)) {
        return 0.0f;
    }
    const vec3 w = frame_to_world(&y->frame, out->wi);
    float density = (1.0f - guided) * brdf_pdf(&y->brdf, y->wo_l, out->wi, lobes);
    for (int c = 0; c < at->count; c++)
        if (c == own || guide_cone_holds(&at->cone[c], w))
            density += guided * at->weight[c] / at->all / (2.0f * PI_F * at->cone[c].versine);
    if (!(density > 0.0f)) return 0.0f;
    const rgb f = brdf_eval(&y->brdf, y->wo_l, out->wi, lobes);
    out->weight = rgb_scale(f, fabsf(out->wi.z) / density);
    return rgb_black(out->weight) ? 0.0f : density;
}

bool gather_near_bounce(const struct gather_cones *cones, const struct shading_point *y,
                        unsigned lobes, float E, float u_lobe, vec2 u, struct brdf_sample *out) {
    if (!gather_near_sample(cones, y, lobes, E, u_lobe, u, out)) return false;
    out->pdf_w = brdf_pdf(&y->brdf, y->wo_l, out->wi, lobes);
    return true;
}

bool gather_near_sample(const struct gather_cones *cones, const struct shading_point *p,
                        unsigned lobes, float E, float u_lobe, vec2 u, struct brdf_sample *out) {
    struct choices at;
    move_cones(cones, p, lobes, &at);
    if (at.count == 0)
        return brdf_sample_wi(&p->brdf, p->wo_l, u_lobe, u, lobes, BRDF_RADIANCE, out);
    float rest = E;
    if (lobes != BRDF_DIFFUSE) rest *= rgb_luminance(brdf_albedo(&p->brdf, p->wo_l, lobes));
    const float guided = fminf(at.all / (at.all + rest), GUIDED);
    const float density = draw_both(&at, guided, p, lobes, u_lobe, u, out);
    if (!(density > 0.0f)) return false;
    out->pdf_w = density;
    return true;
}
