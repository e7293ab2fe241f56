// SPDX-License-Identifier: Apache-2.0
// Where to look for light: what a spot or the sun through a window lights, or a caustic, is to the
// rest of a room a small bright source, which the even rays of a hemisphere meet by luck. A point
// takes the places of the hierarchy that are much brighter than what it expects, that it sees as
// small, and that no wall hides [Jensen 1995 guides by the photons themselves].
#include "photon/photon_bright.h"

enum { PROBES = 4 };      // rays that tell whether a place is seen
#define DENSE 16.0f       // irradiance of a dense place over what is expected at the point
#define FAINT 0.0002f     // of what is expected: what comes from less is left to chance
#define SINE_LEAST 1e-4f  // of half an angle: directions are floats
#define NARROW 0.35f      // sine of a cone's largest half angle
#define EVEN 0.4f         // mean irradiance by area over that by power, of a place that is one
#define FILLED 0.2f       // of a sphere's disc that its leaves should fill

// How much of some of its photons is seen from p.
static float seen(const struct photon_bright *bright, const struct satin_scene *scene,
                  const struct photon_place *node, const struct photon_eye *eye) {
    int clear = 0;
    for (size_t i = 0; i < PROBES; i++) {
        vec3 place = bright->place[node->first + (2 * i + 1) * node->count / (2 * PROBES)];
        vec3 d = v3_sub(place, eye->p);
        float distance = v3_len(d);
        if (!(v3_dot(d, eye->n) > 0.0f)) continue;
        struct ray ray = scene_spawn(scene, eye->p, eye->ng, v3_mul(d, 1.0f / distance));
        ray.tfar = 0.999f * distance;
        clear += !scene_occluded(scene, &ray);
    }
    return (float)clear / PROBES;
}

void photon_cone_aim(struct photon_cone *cone, vec3 p) {
    const vec3 d = v3_sub(cone->center, p);
    const float distance = v3_len(d), sine = clampf(cone->radius / distance, SINE_LEAST, 1.0f);
    cone->axis = v3_mul(d, 1.0f / distance);
    cone->versine = sqrf(sine) / (1.0f + safe_sqrtf(1.0f - sqrf(sine)));
}

// A node as the point sees it.
struct view {
    const struct photon_place *node;
    float most;   // irradiance that may come from it at most; 0: it does not matter
    bool narrow;  // it has a cone
    bool coarse;  // its children would be seen better
};

static struct view view_of(const struct photon_place *node, const struct photon_eye *eye,
                           float expected) {
    struct view view = {.node = node};
    const vec3 d = v3_sub(node->center, eye->p);
    const float distance = v3_len(d), nearest = fmaxf(distance - node->radius, 0.0f);
    if (v3_dot(d, eye->n) < -node->radius) return view;  // below the horizon
    if (node->dense < DENSE * expected) return view;
    if (node->power < FAINT * expected * PI_F * sqrf(nearest)) return view;
    view.narrow = node->radius < NARROW * distance;
    const bool sparse = node->area < FILLED * PI_F * sqrf(node->radius);
    const bool uneven = node->power < EVEN * node->common * node->area;
    view.coarse = node->right > 0 && (!view.narrow || sparse || uneven);
    if (view.narrow || view.coarse)
        view.most = node->power / (PI_F * fmaxf(sqrf(nearest), sqrf(node->radius)));
    return view;
}

// False if nothing of the node is seen or comes.
static bool make_cone(const struct photon_bright *bright, const struct satin_scene *scene,
                      const struct photon_eye *eye, const struct photon_place *node,
                      struct photon_cone *out) {
    const vec3 d = v3_sub(node->center, eye->p);
    const float distance = v3_len(d), sine = node->radius / distance;
    const float cosine = fmaxf(v3_dot(d, eye->n) / distance, 0.25f * sine);
    const float turned = 1.0f - v3_len(node->normal);
    *out = (struct photon_cone){.center = node->center, .radius = node->radius};
    photon_cone_aim(out, eye->p);
    const float facing = clampf(turned - v3_dot(node->normal, out->axis), 0.0f, 1.0f);
    out->E = node->power * cosine * facing / (PI_F * sqrf(distance));
    out->chance = out->E / node->power * node->area;
    out->filled = facing * node->area / (2.0f * PI_F * out->versine * sqrf(distance));
    if (!(out->E > 0.0f)) return false;
    out->E *= seen(bright, scene, node, eye);
    return out->E > 0.0f;
}

// Replaces the view that may send most, of those that are coarse, by views of the node's children,
// as long as there is room.
static int refine(const struct photon_bright *bright, const struct photon_eye *eye, float expected,
                  struct view view[PHOTON_CONES]) {
    int count = 1;
    view[0] = view_of(bright->node, eye, expected);
    while (count < PHOTON_CONES) {
        int best = -1;
        for (int i = 0; i < count; i++)
            if (view[i].coarse && (best < 0 || view[i].most > view[best].most)) best = i;
        if (best < 0) break;
        const struct photon_place *parent = view[best].node;
        view[best] = view_of(parent + 1, eye, expected);
        const struct view right = view_of(bright->node + parent->right, eye, expected);
        if (right.most > 0.0f) view[count++] = right;
        if (!(view[best].most > 0.0f)) view[best] = view[--count];
        if (count == 0) break;
    }
    return count;
}

int photon_bright_cones(const struct photon_maps *maps, const struct satin_scene *scene,
                        const struct photon_eye *eye, struct photon_cone out[PHOTON_CONES],
                        float *expected) {
    const struct photon_bright *bright = maps ? maps->bright : NULL;
    if (!bright) return 0;
    float radius;
    *expected = rgb_luminance(photon_irradiance(maps, scene, eye->p, eye->ng, &radius));
    if (!(*expected > 0.0f)) *expected = bright->spread;
    struct view view[PHOTON_CONES];
    const int views = refine(bright, eye, *expected, view);
    int count = 0;
    for (int i = 0; i < views; i++)
        if (view[i].narrow && view[i].most > 0.0f)
            count += make_cone(bright, scene, eye, view[i].node, &out[count]);
    return count;
}
