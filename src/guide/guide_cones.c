// SPDX-License-Identifier: Apache-2.0
// Cones towards photon clusters. An area that is lit by a spot, by the sun through a window or by a
// caustic is a small bright source for the rest of a room, which the stratified rays of a
// hemisphere hit only by chance. A point selects those clusters of the hierarchy that are much
// brighter than what it expects, that are small from there, and that are visible. Deviation:
// [Jensen 1995] guides by the photons themselves.
#include "guide/guide_clusters.h"

#define DENSE 16.0f         // irradiance of a dense cluster over that expected at the point
#define CONE_FAINT 0.0002f  // of the expected irradiance: clusters that contribute less get no rays
#define SINE_LEAST 1e-4f    // of half the angle, as directions are floats
#define NARROW 0.35f        // sine of a cone's largest half angle
#define SINE_MOVED 0.5f     // as NARROW, for a cone that is moved
// Least mean irradiance by area over that by power, for a cluster that is not split further.
#define UNIFORM_LEAST 0.4f
#define FILLED 0.2f  // fraction of a sphere's disc that its leaves should fill

// Makes the ray from the point to photon i of the node's sample of photons. False if the photon is
// below the horizon.
static bool ray_to_photon(const struct guide_clusters *clusters, const struct satin_scene *scene,
                          const struct guide_cluster *node, const struct guide_point *at, size_t i,
                          struct ray *out) {
    vec3 position =
        clusters->position[node->first + (2 * i + 1) * node->count / (2 * GUIDE_PROBES)];
    vec3 d = v3_sub(position, at->p);
    float distance = v3_len(d);
    if (!(v3_dot(d, at->n) > 0.0f)) return false;
    *out = scene_spawn(scene, at->p, at->ng, v3_mul(d, 1.0f / distance));
    out->tfar = 0.999f * distance;
    return true;
}

static void aim_cone(struct guide_cone *cone, vec3 p) {
    const vec3 d = v3_sub(cone->centre, p);
    const float distance = v3_len(d), sine = clampf(cone->radius / distance, SINE_LEAST, 1.0f);
    cone->axis = v3_mul(d, 1.0f / distance);
    cone->versine = sqrf(sine) / (1.0f + safe_sqrtf(1.0f - sqrf(sine)));
}

// Sets E, chance and filled of a cone whose axis is set, at `distance` from its centre and with
// `cosine` to the normal.
static void estimate_cone(struct guide_cone *cone, float distance, float cosine) {
    const struct guide_cluster *node = cone->cluster;
    const float diverging = 1.0f - v3_len(node->normal);
    const float facing = clampf(diverging - v3_dot(node->normal, cone->axis), 0.0f, 1.0f);
    cone->E = node->power * cosine * facing / (PI_F * sqrf(distance));
    cone->chance = cone->E / node->power * node->area;
    cone->filled = facing * node->area / (2.0f * PI_F * cone->versine * sqrf(distance));
}

// A node of the hierarchy to which the point may send rays.
struct candidate {
    const struct guide_cluster *node;
    // Bound of the variance of a ray that meets it by chance: of the irradiance from it, times its
    // own; 0: it is ignored.
    float most;
    bool narrow;  // whether it has a cone
    bool coarse;  // whether its children would be better targets
};

static struct candidate candidate_of(const struct guide_cluster *node, const struct guide_point *at,
                                     float expected) {
    struct candidate candidate = {.node = node};
    const vec3 d = v3_sub(node->centre, at->p);
    const float distance = v3_len(d), nearest = fmaxf(distance - node->radius, 0.0f);
    if (v3_dot(d, at->n) < -node->radius) return candidate;  // below the horizon
    if (node->dense < DENSE * expected) return candidate;
    if (node->power < CONE_FAINT * expected * PI_F * sqrf(nearest)) return candidate;
    candidate.narrow = node->radius < NARROW * distance;
    const bool sparse = node->area < FILLED * PI_F * sqrf(node->radius);
    const bool not_uniform = node->power < UNIFORM_LEAST * node->common * node->area;
    candidate.coarse = node->right > 0 && (!candidate.narrow || sparse || not_uniform);
    if (candidate.narrow || candidate.coarse)
        candidate.most =
            node->power * node->common / (PI_F * fmaxf(sqrf(nearest), sqrf(node->radius)));
    return candidate;
}

// The cone of a node from the point, as if all of it were visible.
static struct guide_cone cone_of(const struct guide_cluster *node, const struct guide_point *at) {
    const vec3 d = v3_sub(node->centre, at->p);
    const float distance = v3_len(d), sine = node->radius / distance;
    struct guide_cone cone = {.cluster = node, .centre = node->centre, .radius = node->radius};
    aim_cone(&cone, at->p);
    estimate_cone(&cone, distance, fmaxf(v3_dot(d, at->n) / distance, 0.25f * sine));
    return cone;
}

// Replaces, as long as they fit, the coarse candidate with the largest bound by those of its
// node's children.
static int refine(const struct guide_clusters *clusters, const struct guide_point *at,
                  float expected, struct candidate candidate[GUIDE_CONES]) {
    int count = 1;
    candidate[0] = candidate_of(clusters->node, at, expected);
    while (count < GUIDE_CONES) {
        int best = -1;
        for (int i = 0; i < count; i++)
            if (candidate[i].coarse && (best < 0 || candidate[i].most > candidate[best].most))
                best = i;
        if (best < 0) break;
        const struct guide_cluster *parent = candidate[best].node;
        candidate[best] = candidate_of(parent + 1, at, expected);
        const struct candidate right = candidate_of(clusters->node + parent->right, at, expected);
        if (right.most > 0.0f) candidate[count++] = right;
        if (!(candidate[best].most > 0.0f)) candidate[best] = candidate[--count];
        if (count == 0) break;
    }
    return count;
}

int guide_cones_from(const struct guide_clusters *clusters, const struct satin_scene *scene,
                     const struct guide_point *at, struct guide_cone out[GUIDE_CONES],
                     float *expected) {
    if (!clusters) return 0;
    if (!(*expected > 0.0f)) *expected = clusters->uniform;
    struct candidate candidate[GUIDE_CONES];
    const int candidates = refine(clusters, at, *expected, candidate);
    int count = 0;
    for (int i = 0; i < candidates; i++) {
        const struct guide_cluster *node = candidate[i].node;
        if (!candidate[i].narrow || !(candidate[i].most > 0.0f)) continue;
        struct guide_cone cone = cone_of(node, at);
        if (!(cone.E > 0.0f)) continue;
        int unoccluded = 0;
        struct ray ray;
        for (size_t k = 0; k < GUIDE_PROBES; k++)
            unoccluded +=
                ray_to_photon(clusters, scene, node, at, k, &ray) && !scene_occluded(scene, &ray);
        cone.E *= (float)unoccluded / GUIDE_PROBES;
        if (cone.E > 0.0f) out[count++] = cone;
    }
    return count;
}

int guide_cones_around(const struct guide_clusters *clusters, vec3 p, float expected,
                       struct guide_cone out[GUIDE_CONES]) {
    if (!clusters) return 0;
    const struct guide_point at = {.p = p};  // without a normal nothing is below the horizon
    struct candidate candidate[GUIDE_CONES];
    const int candidates =
        refine(clusters, &at, expected > 0.0f ? expected : clusters->uniform, candidate);
    int count = 0;
    for (int i = 0; i < candidates; i++) {
        const struct guide_cluster *node = candidate[i].node;
        if (candidate[i].narrow && candidate[i].most > 0.0f)
            out[count++] = (struct guide_cone){
                .cluster = node, .centre = node->centre, .radius = node->radius};
    }
    return count;
}

bool guide_cone_move(struct guide_cone *cone, vec3 p, vec3 n) {
    const vec3 d = v3_sub(cone->centre, p);
    if (!(v3_len2(d) > sqrf(cone->radius / SINE_MOVED))) return false;
    aim_cone(cone, p);
    const float distance = v3_len(d), sine = cone->radius / distance, up = v3_dot(cone->axis, n);
    estimate_cone(cone, distance, up > -sine ? fmaxf(up, 0.25f * sine) : 0.0f);
    return true;
}

bool guide_cone_visible(const struct guide_clusters *clusters, const struct satin_scene *scene,
                        const struct guide_cone *cone, const struct guide_point *at, size_t i) {
    struct ray ray;
    return ray_to_photon(clusters, scene, cone->cluster, at, i, &ray) &&
           !scene_occluded(scene, &ray);
}
