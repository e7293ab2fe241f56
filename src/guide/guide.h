// SPDX-License-Identifier: Apache-2.0
// Where samples should go: what the eye sees of the scene, which lights matter there, where
// emission is aimed, and where light comes down so densely that gather rays should be sent there.
// Nothing here knows the photon map. Functions may be called from any thread unless they take a
// pool.
#ifndef GUIDE_GUIDE_H
#define GUIDE_GUIDE_H

#include "base/parallel.h"
#include "light/light.h"
#include "satin/options.h"
#include "scene/scene.h"

// ---- The view (guide_view.c) ------------------------------------------------------------------

// What the eye sees of the scene. Boxes hold all, nine tenths and half of the points.
enum { GUIDE_VIEW_BOXES = LIGHT_SPOTS / 2, GUIDE_VIEW_PATHS = 1024 };
enum { GUIDE_VIEW_CHUNK = 16 };  // paths that a worker takes at a time
struct guide_view {
    float ray_length;                // median of gather rays; INFINITY if they meet nothing
    int seen_count, specular_count;  // points; 0: no boxes
    struct light_target seen[GUIDE_VIEW_BOXES], specular[GUIDE_VIEW_BOXES];
};
// On all threads of the pool; a NULL pool is one thread. The same for any number of them.
void guide_view_make(const struct satin_scene *scene, uint64_t seed, struct parallel *pool,
                     struct guide_view *out);
// Follows the ray through ideal specular surfaces to one with a smooth lobe, with normal *n; false
// if there is none. *ray becomes its last segment; *chain gets the surfaces, not the lengths.
bool guide_view_follow(const struct satin_scene *scene, struct ray *ray, struct rng *rng,
                       struct interaction *s, vec3 *n, struct light_chain *chain);
// Follows the ray of path i of GUIDE_VIEW_PATHS from the eye in the same way.
bool guide_view_eye(const struct satin_scene *scene, uint32_t i, struct rng *rng,
                    struct interaction *s, vec3 *n);
// Aims at what is small against `all`, the box of everything that matters.
void guide_view_aim(const struct guide_view *view, struct light_target all, struct light_aim *out);

// Whether a shape that is no instance has an ideal specular lobe.
static inline bool shape_has_delta(const struct satin_scene *scene, uint32_t shape) {
    const struct shape *s = &scene->shape[shape];
    return material_lobes(&scene->material[s->material], s->light >= 0) & BRDF_DELTA;
}

// ---- Paths of lights (guide_allocation.c) -----------------------------------------------------

// How the paths of a pass are allocated to the lights.
enum { GUIDE_ALLOCATION_LIGHTS = 16 };
struct guide_allocation {
    bool by_power;                            // `fraction` is not set
    float fraction[GUIDE_ALLOCATION_LIGHTS];  // of all paths, by light
};
// By what each light brings to what is seen; threads as of guide_view_make.
void guide_allocation_make(const struct satin_scene *scene, uint64_t seed, struct parallel *pool,
                           struct guide_allocation *out);

// ---- Aim of emission (guide_emission.c) -------------------------------------------------------

// Where in the space of emission caustic paths start.
struct guide_emission;
struct guide_emission_request {
    const struct satin_scene *scene;
    const struct guide_view *view;
    uint64_t seed, paths;
};
// Finds by a coarse pass of single rays which parts of each light's emission meet a surface with
// a delta lobe first. *out is NULL if no material has one.
satin_status guide_emission_build(const struct guide_emission_request *request,
                                  struct parallel *pool, struct log log,
                                  struct guide_emission **out);
void guide_emission_free(struct guide_emission *emission);  // NULL is allowed
// How many of the `paths` of the pass leave light i.
uint64_t guide_emission_paths(const struct guide_emission *emission, uint32_t light);
// Path `index` of guide_emission_paths(light): replaces its well-spread numbers by ones in the
// cells that matter and returns the factor of its power.
float guide_emission_warp(const struct guide_emission *emission, uint32_t light, uint64_t index,
                          float u[4]);
// Where its photons are aimed.
const struct light_aim *guide_emission_aim(const struct guide_emission *emission);

// ---- Visibility of lights (guide_visibility.c) ------------------------------------------------

// What is visible of the lights from points along paths from the eye, kept in cells of a tree.
struct guide_visibility;
// *out is NULL where nothing is to learn: a single light that is no environment, more lights than
// are weighed, or nothing that paths from the eye meet. SATIN_CANCELLED or SATIN_ERROR_MEMORY.
satin_status guide_visibility_build(const struct satin_scene *scene, const satin_options *options,
                                    struct parallel *pool, struct guide_visibility **out);
void guide_visibility_free(struct guide_visibility *visibility);  // NULL is allowed
size_t guide_visibility_bytes(const struct guide_visibility *visibility);
// What is visible of the lights around p, for sampling direct light; NULL: all.
struct light_visibility guide_visibility_at(const struct guide_visibility *visibility, vec3 p);

// ---- Photon clusters (guide_clusters.c) -------------------------------------------------------

// A photon where it came down: power in luminance [W], geometric normal (unit) on its side.
struct guide_photon {
    vec3 p, n;
    float power;
};
// Spheres around clusters of photons, where light comes down densely.
struct guide_clusters;
// Of photons that stand for all light. *out is NULL if they are too few. SATIN_CANCELLED or
// SATIN_ERROR_MEMORY.
satin_status guide_clusters_build(const struct satin_scene *scene,
                                  const struct guide_photon *photon, size_t count,
                                  struct parallel *pool, struct log log,
                                  struct guide_clusters **out);
void guide_clusters_free(struct guide_clusters *clusters);  // NULL is allowed
size_t guide_clusters_bytes(const struct guide_clusters *clusters);

// ---- Cones of clusters (guide_cones.c) --------------------------------------------------------

// From where light is gathered.
struct guide_eye {
    vec3 p, n, ng;  // hemisphere about n; geometric normal on the same side
};

// The sphere of a cluster, and the directions in which it appears.
struct guide_cluster;
struct guide_cone {
    const struct guide_cluster *cluster;
    vec3 center, axis;
    float radius, versine;  // of the sphere; 1 - cosine of the half angle
    float E;                // roughly what a white surface there adds to the irradiance [W m^-2]
    float chance;           // roughly that a cosine-weighted ray meets what is bright,
    float filled;           // and that one within the cone does; over 1: more than the cone holds
};
enum { GUIDE_CONES = 48 };

// Cones of the clusters that the eye sees, returned is how many. *expected is roughly the
// irradiance at p by indirect light; where it is not positive it becomes that of light spread over
// the whole scene. Which cones there are does not depend on what gather rays find.
int guide_cones_from(const struct guide_clusters *clusters, const struct satin_scene *scene,
                     const struct guide_eye *eye, struct guide_cone out[GUIDE_CONES],
                     float *expected);
// Finds clusters for surfaces near p that face anywhere and may see what p does not:
// guide_cone_move makes cones of them. `expected` [W m^-2] is the irradiance there. None if
// `clusters` is NULL.
int guide_cones_around(const struct guide_clusters *clusters, vec3 p, float expected,
                       struct guide_cone out[GUIDE_CONES]);
// Changes axis, versine, E and filled to those at p with normal n, as if nothing stood between; E
// is 0 below the horizon. False if p is so near to the sphere that the cone would be wide.
bool guide_cone_move(struct guide_cone *cone, vec3 p, vec3 n);
// Whether the eye sees point i of the GUIDE_PROBES by which the cone's cluster is probed.
enum { GUIDE_PROBES = 4 };
bool guide_cone_visible(const struct guide_clusters *clusters, const struct satin_scene *scene,
                        const struct guide_cone *cone, const struct guide_eye *eye, size_t i);

// ---- Rays to clusters (guide_rays.c) ----------------------------------------------------------

// The cones that a point sees, and how many rays it sends into each beside the stratified rays of
// its hemisphere.
struct guide_rays {
    struct guide_cone cone[GUIDE_CONES];
    int rays[GUIDE_CONES];       // each a power of 2
    float density[GUIDE_CONES];  // of a cone's rays over solid angle
    int first[GUIDE_CONES];      // number of a cone's first ray, in the order of drawing
    int count;                   // of cones
};
// The cones that the eye sees, with rays allocated; `expected` as guide_cones_from has it. None if
// `clusters` is NULL.
void guide_rays_make(const struct guide_clusters *clusters, const struct satin_scene *scene,
                     const struct guide_eye *eye, size_t stratified, float *expected,
                     struct guide_rays *out);
// Allocates rays to the cones and drops the cones that get none.
void guide_rays_allocate(struct guide_rays *rays, float expected, size_t stratified);

// Where drawing stands: the caller fills the first two, the rest is 0 before the first ray.
struct guide_draw {
    uint64_t stream;  // random stream of the point
    vec3 n;           // no ray goes below its horizon
    int cone, ray;    // that are next
    int drawn;        // how many rays were
};
// Draws the direction of the next ray and sets `first`; false after the last one. *density gets
// that of its cone.
bool guide_rays_draw(struct guide_rays *rays, struct guide_draw *draw, vec3 *w, float *density);
// Weight of a ray along w, by the balance heuristic, when all rays count as stratified ones do, of
// which there are `density` per solid angle there. `drawn`: the number of the ray in the order of
// drawing, when all were drawn; negative: it is a stratified one.
float guide_rays_weight(const struct guide_rays *rays, int drawn, vec3 w, float density);

// A direction of constant density in the cone, and whether a direction is in it.
vec3 guide_cone_sample(const struct guide_cone *cone, vec2 u);
bool guide_cone_holds(const struct guide_cone *cone, vec3 w);

#endif
