// SPDX-License-Identifier: Apache-2.0
// Single gather rays, of samples near which no record is. Few rays by the BRDF alone hit
// a small bright cluster of photons so rarely that one hit outshines its pixel. Therefore some of
// them go to the clusters that are visible from the point, and so do the bounces of those whose hit
// is near it. The clusters are found once for neighbouring points; the balance heuristic [Veach and
// Guibas 1995] weights both kinds of rays, so that the mean is the same.
#include <stdlib.h>

#include "gather/gather_near.h"

// Points within this many pixels have their clusters in common, if the angle between their normals
// is small. What is visible differs little between them, and cones are moved to each point.
static const float COMMON_PIXELS = 4.0f, COMMON_COSINE = 0.95f;

// The clusters around a surface point with the normal n: those that are visible from there, and
// those to which bounces from near hits are guided.
struct gather_single_clusters {
    vec3 n;
    struct gather_cones to;
    struct gather_near near;
};

enum { FOUND_MOST = 8 };  // points that the samples of a row of pixels alternate between
struct gather_singles {
    int count, next;
    struct gather_single_clusters found[FOUND_MOST];
};

struct gather_singles *gather_singles_new(void) {
    return calloc(1, sizeof(struct gather_singles));
}

void gather_singles_free(struct gather_singles *singles) { free(singles); }

void gather_singles_begin(struct gather_singles *singles) { singles->count = singles->next = 0; }

static void find_clusters(const struct gather *g, const struct shading_point *p,
                          struct gather_single_clusters *out) {
    const struct guide_point at = {p->interaction.p, gather_viewer_normal(p), p->ng};
    struct gather_cones *to = &out->to;
    struct gather_near *near = &out->near;
    out->n = at.n;
    to->count = near->found = near->cones.count = 0;
    near->discs = GATHER_NEAR_DISCS;
    near->p = at.p;
    near->expected = 0.0f;
    near->single = true;
    near->state = NEAR_SEARCHED;
    if (!g->options->guide_clusters || !g->clusters) return;
    float radius;
    near->expected =
        rgb_luminance(photon_irradiance_at(g->maps, g->scene, at.p, at.ng, &radius, NULL));
    const struct guide_cone *cone = near->cones.cone;
    struct gather_probe probe[GUIDE_PROBES];
    for (int i = 0; i < GUIDE_PROBES; i++) probe[i] = (struct gather_probe){at, near->expected};
    near->found = guide_cones_around(g->clusters, at.p, near->expected, near->cones.cone);
    for (int c = 0; c < near->found; c++) {
        const float visible = gather_visible_fraction(g, probe, GUIDE_PROBES, true, cone[c]);
        if (!(visible > 0.0f)) continue;
        to->cone[to->count] = cone[c];
        to->visible[to->count++] = visible;
    }
}

struct gather_single_clusters *gather_single_find(const struct gather *g,
                                                  const struct shading_point *p, float pixel,
                                                  struct gather_singles *singles) {
    const vec3 n = gather_viewer_normal(p);
    for (int i = 0; i < singles->count; i++) {
        struct gather_single_clusters *clusters = &singles->found[i];
        if (v3_dot(clusters->n, n) > COMMON_COSINE &&
            v3_dist2(clusters->near.p, p->interaction.p) < sqrf(COMMON_PIXELS * pixel))
            return clusters;
    }
    struct gather_single_clusters *clusters = &singles->found[singles->next];
    singles->next = (singles->next + 1) % FOUND_MOST;
    if (singles->count < FOUND_MOST) singles->count++;
    find_clusters(g, p, clusters);
    return clusters;
}

bool gather_single_sample(const struct gather_single_clusters *clusters,
                          const struct shading_point *p, unsigned lobes, float u_lobe, vec2 u,
                          struct brdf_sample *out) {
    return gather_near_sample(&clusters->to, p, lobes, clusters->near.expected, u_lobe, u, out);
}

void gather_single_rays(const struct gather *g, struct gather_scratch *scratch,
                        struct gather_single_clusters *clusters, struct gather_ray *rays,
                        size_t count, uint64_t stream) {
    gather_rays_guided(g, scratch, rays, count, stream, &clusters->near);
}
