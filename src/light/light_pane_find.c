// SPDX-License-Identifier: Apache-2.0
// Finds the shapes of a scene that are panes: flat or thin sheets of clear glass, and curved glass
// that deflects little, by trial rays.
#include "base/sampling.h"
#include "light/light_kinds.h"
#include "light/light_pane_ray.h"

// Rays per curved shape, of which about .82 deflect little in the glass of bulbs, .04 in the rods
// that hold their filaments, and none in a ball. If none of the first FIRST_TRIALS does, no more
// are tried: a scene may have 20,000 balls.
enum { TRIALS = 64, FIRST_TRIALS = 8 };

// Curved glass is a pane if it deflects at least half of the rays that enter it by less [rad].
static const float LITTLE = 0.05f;

static bool is_clear(const struct satin_scene *scene, const struct shape *shape) {
    const struct material_side *side = &scene->material[shape->material].front;
    return !side->component[0] && (side->base.model->lobes & BRDF_DELTA) &&
           brdf_transmits(&side->base);
}

// Drinking glasses and lenses are not flat anywhere, so that shadow rays need not test what they
// hit there.
static bool is_flat_somewhere(const struct mesh *mesh) {
    for (uint32_t i = 0; i < mesh->triangle_count; i++)
        if (light_is_flat(mesh, i)) return true;
    return false;
}

static bool is_curved_somewhere(const struct mesh *mesh) {
    for (uint32_t i = 0; i < mesh->triangle_count; i++)
        if (!light_is_flat(mesh, i)) return true;
    return false;
}

// ---- Trials -------------------------------------------------------------------------------------

// A point of a shape and its normal on the outside of the glass.
struct trial_point {
    const struct shape *shape;
    vec3 p, n;
};

// The factor of a normal on the front side, which is inside the glass if the IOR of the other side
// is the lower one: so the inner surface of a bulb may be modelled.
static float outside(const struct satin_scene *scene, const struct shape *shape) {
    return scene->material[shape->material].front.base.ior < 1.0f ? -1.0f : 1.0f;
}

// The length of n is twice the area.
static struct trial_point triangle_middle(const struct shape *shape, uint32_t i) {
    const struct mesh *mesh = &shape->mesh;
    const uint32_t *index = mesh->index + 3 * (size_t)i;
    const vec3 a = scene_mesh_vertex(mesh, index[0]), b = scene_mesh_vertex(mesh, index[1]),
               c = scene_mesh_vertex(mesh, index[2]);
    return (struct trial_point){shape, v3_mul(v3_add(a, v3_add(b, c)), 1.0f / 3.0f),
                                light_triangle_normal(shape, i)};
}

// Whether a ray from there, onto the glass, leaves it in nearly the same direction.
static bool deflects_little(const struct satin_scene *scene, struct trial_point at, vec3 from) {
    const vec3 d = v3_neg(from);
    struct pane_ray ray =
        light_pane_ray_begin(scene, scene_spawn(scene, at.p, at.n, from).o, d, PANES_MAX);
    struct interaction s;
    do {
        if (!scene_intersect(scene, &ray.ray, &s)) return false;
        // Shapes that only instances show are hit elsewhere.
        if (ray.crossed == 0 && &scene->shape[s.shape] != at.shape) return false;
        if (s.instance || !light_pane_ray_pass(&ray, &s)) return false;
    } while (!light_pane_ray_is_outside(&ray));
    return v3_dist2(ray.ray.d, d) < sqrf(LITTLE);
}

static int trial(const struct satin_scene *scene, struct trial_point at, uint32_t i) {
    const vec2 u = sample_sobol2(i, 0);
    at.n = v3_mul(v3_unit(at.n), outside(scene, at.shape));
    const struct frame frame = frame_from_normal(at.n);
    return deflects_little(scene, at, frame_to_world(&frame, sample_cosine_hemisphere(u.x, u.y)));
}

static int mesh_trials(const struct satin_scene *scene, const struct shape *shape, int trials) {
    const uint32_t triangles = shape->mesh.triangle_count;
    double area = 0.0, sum = 0.0;
    int little = 0, k = 0;
    for (uint32_t i = 0; i < triangles; i++) area += (double)v3_len(triangle_middle(shape, i).n);
    for (uint32_t i = 0; i < triangles; i++) {
        const struct trial_point at = triangle_middle(shape, i);
        sum += (double)v3_len(at.n);
        for (; k < trials && ((double)k + 0.5) * area < trials * sum; k++)
            little += trial(scene, at, (uint32_t)k);
    }
    return little;
}

static int sphere_trials(const struct satin_scene *scene, const struct shape *shape, int trials) {
    int little = 0;
    for (int k = 0; k < trials; k++) {
        const vec2 u = sample_sobol2((uint32_t)k, 1);
        const vec3 outward = sample_uniform_sphere(u.x, u.y);
        const struct trial_point at = {shape, v3_mad(shape->centre, shape->radius, outward),
                                       shape->flip_normals ? v3_neg(outward) : outward};
        little += trial(scene, at, (uint32_t)k);
    }
    return little;
}

// Whether at least half of the trials, distributed evenly over the area, deflect little.
static bool passes(const struct satin_scene *scene, const struct shape *shape) {
    for (int trials = FIRST_TRIALS;; trials = TRIALS) {
        const int little = shape->kind == SHAPE_MESH ? mesh_trials(scene, shape, trials)
                                                     : sphere_trials(scene, shape, trials);
        if (trials == TRIALS) return 2 * little >= TRIALS;
        if (little == 0) return false;
    }
}

// Whether the shape may be curved glass.
static bool may_deflect_little(const struct satin_scene *scene, const struct shape *shape) {
    if (!is_clear(scene, shape) || shape->light >= 0) return false;
    const struct material_side *side = &scene->material[shape->material].front;
    if (side->base.model->thin || scene_bump_used(&side->bump[0])) return false;
    return shape->kind == SHAPE_SPHERE ||
           (shape->kind == SHAPE_MESH && is_curved_somewhere(&shape->mesh));
}

void light_find_panes(struct satin_scene *scene) {
    scene->panes = false;
    for (uint32_t i = 0; i < scene->shape_count; i++)
        scene->shape[i].deflects_little = may_deflect_little(scene, &scene->shape[i]);
    for (uint32_t i = 0; i < scene->shape_count; i++) {
        struct shape *shape = &scene->shape[i];
        if (shape->kind == SHAPE_INSTANCE || !is_clear(scene, shape)) continue;
        const bool pane = scene->material[shape->material].front.base.model->thin ||
                          shape->kind == SHAPE_DISK ||
                          (shape->kind == SHAPE_MESH && is_flat_somewhere(&shape->mesh));
        shape->deflects_little = shape->deflects_little && passes(scene, shape);
        scene->panes = scene->panes || pane || shape->deflects_little;
    }
}
