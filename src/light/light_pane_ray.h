// SPDX-License-Identifier: Apache-2.0
// Private to light/: surfaces of panes, and rays that pass them (light_pane.c).
#ifndef LIGHT_PANE_RAY_H
#define LIGHT_PANE_RAY_H

#include "light/light.h"

enum { PANES_MAX = 32 };  // largest number of surfaces that a path passes

// Directions that differ by less are parallel [rad]. Panes of real scenes are parallel to 1e-5 by
// the six digits of their corners, and a lens or a waved pane deflects most light by more than
// 1e-2.
#define PARALLEL 1e-3f

static inline bool light_is_parallel(vec3 a, vec3 b) {
    return v3_dist2(a, b) < PARALLEL * PARALLEL;
}

// Whether the shading normals of a triangle do not vary.
bool light_is_flat(const struct mesh *mesh, uint32_t triangle);
// Whether the surface may belong to a pane: it is flat, a thin sheet of any form, or curved glass
// that deflects little (*curved), and not blended with other BRDFs, which rays pass at random.
bool light_may_be_pane(const struct satin_scene *scene, const struct interaction *s, vec3 wo,
                       bool *curved);

// A ray that passes through panes.
struct pane_ray {
    const struct satin_scene *scene;
    struct ray ray;
    rgb T;
    float eta;           // of the medium that it is in, relative to that at its start
    int crossed, panes;  // numbers of surfaces of panes: passed so far, and that it may pass
    bool curved;         // whether one of them was curved
    bool bundle;         // whether the following are computed
    vec3 dp[2], dd[2];   // derivatives of its point and direction by two numbers [Igehy 1999]
};
struct pane_ray light_pane_ray_begin(const struct satin_scene *scene, vec3 o, vec3 d, int panes);
// Passes the surface s that the ray has hit. False if it is stopped.
bool light_pane_ray_pass(struct pane_ray *ray, const struct interaction *s);
// Moves the derivatives of the point by a length along the ray.
void light_pane_ray_advance(struct pane_ray *ray, float length);
// Continues the ray from its hit s to the first surface that is of a light, in *s; *met is false if
// there is none. Returns false if it is stopped before that.
bool light_pane_ray_continue(struct pane_ray *ray, struct interaction *s, bool *met);
// Whether the ray is in the medium in which it began.
static inline bool light_pane_ray_is_outside(const struct pane_ray *ray) {
    return fabsf(ray->eta - 1.0f) < 1e-4f;
}

#endif
