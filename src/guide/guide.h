// SPDX-License-Identifier: Apache-2.0
// Where samples should go: which points are seen, which lights contribute there, where emission is
// aimed, and at which clusters of photons gather rays are aimed. Nothing here depends on the photon
// map. Functions may be called from any thread unless they take a pool.
#ifndef GUIDE_GUIDE_H
#define GUIDE_GUIDE_H

#include "base/parallel.h"
#include "light/light.h"
#include "satin/options.h"
#include "scene/scene.h"

// ---- What is seen (guide_seen.c) ---------------------------------------------------------------

// The points that are seen. The boxes hold all, nine tenths and half of them.
enum { GUIDE_SEEN_BOXES = LIGHT_SPOTS / 2, GUIDE_SEEN_PATHS_MAX = 1024 };
enum { GUIDE_SEEN_CHUNK = 16 };  // paths per chunk
struct guide_seen {
    float ray_length;           // median length of gather rays; INFINITY if they hit nothing
    int count, specular_count;  // numbers of points; 0: there are no boxes
    struct light_target box[GUIDE_SEEN_BOXES], specular_box[GUIDE_SEEN_BOXES];
};
// Follows this many paths from the cameras of the scene, at most GUIDE_SEEN_PATHS_MAX, on all
// threads of the pool; a NULL pool is one thread. The result does not depend on their number.
void guide_seen_make(const struct satin_scene *scene, uint64_t seed, int paths,
                     struct parallel *pool, struct guide_seen *out);
// Follows the ray through ideal specular surfaces to one with a smooth lobe, whose normal is *n.
// False if there is none. *ray becomes its last segment; *chain gets the surfaces without the
// lengths.
bool guide_seen_follow(const struct satin_scene *scene, struct ray *ray, struct rng *rng,
                       struct interaction *s, vec3 *n, struct light_chain *chain);
// Does what guide_seen_follow does, for the eye ray of path i, of one of the scene's cameras.
bool guide_seen_eye(const struct satin_scene *scene, uint32_t i, struct rng *rng,
                    struct interaction *s, vec3 *n);

// ---- Paths of lights (guide_allocation.c) -----------------------------------------------------

// The allocation of the paths of a pass to the lights.
enum { GUIDE_ALLOCATION_LIGHTS = 16 };
struct guide_allocation {
    bool by_power;                            // allocation by power; `fraction` is not set
    float fraction[GUIDE_ALLOCATION_LIGHTS];  // fraction of all paths, by light
};
// Allocates by the contribution of each light to the points that are seen. Paths and
// threads as for guide_seen_make.
void guide_allocation_make(const struct satin_scene *scene, uint64_t seed, int paths,
                           struct parallel *pool, struct guide_allocation *out);

// ---- The region that is seen (guide_region.c) ---------------------------------------------------

// The surfaces that are seen, in boxes.
struct guide_region;
// Finds them by this many paths from the eye. False, with *out unchanged, if there is no memory.
// The caller frees *out. Threads as for guide_seen_make.
bool guide_region_make(const struct satin_scene *scene, uint64_t seed, int paths,
                       struct parallel *pool, struct guide_region **out);
void guide_region_free(struct guide_region *region);  // NULL is allowed
// Whether the point is in the region.
bool guide_region_holds(const struct guide_region *region, vec3 p);

// ---- Aim (guide_aim.c) --------------------------------------------------------------------------

// The boxes at which light is aimed that may become a caustic. False if there is no such light.
bool guide_aim_make(const struct satin_scene *scene, const struct guide_seen *seen,
                    struct light_aim *out);

// ---- Emission of caustics (guide_emission.c) ----------------------------------------------------

// A caustic path that starts at the numbers u of its light's emission, and the root of the squared
// powers of the photons that it stores where they are seen.
struct guide_emission_sample {
    float u[4], power;
};
// The paths of a pilot, which start uniformly over the numbers, the same number from each light, in
// the order of the lights.
struct guide_emission_pilot {
    const struct satin_scene *scene;
    struct light_aim aim;  // with which they were emitted
    size_t per_light;
    struct guide_emission_sample *sample;  // is reordered
};
// The distribution of caustic paths over the lights and over the space of their emission.
struct guide_emission;
// Learns it from the pilot; the caller frees *out. SATIN_ERROR_MEMORY.
satin_status guide_emission_learn(const struct guide_emission_pilot *pilot, struct log log,
                                  struct guide_emission **out);
void guide_emission_free(struct guide_emission *emission);  // NULL is allowed
// The number of a pass's `paths` that start from a light.
uint64_t guide_emission_paths(const struct guide_emission *emission, uint64_t paths,
                              uint32_t light);
// Replaces the random numbers of path `index` of guide_emission_paths by those of this
// distribution. Returns the factor of its power.
float guide_emission_warp(const struct guide_emission *emission, uint64_t paths, uint32_t light,
                          uint64_t index, float u[4]);
// The boxes at which the photons are aimed.
const struct light_aim *guide_emission_aim(const struct guide_emission *emission);

// ---- Visibility of lights (guide_visibility.c) ------------------------------------------------

// The visibility of the lights from points on paths from the eye, stored in cells of a tree.
struct guide_visibility;
// How much is measured. All numbers are at least 1.
struct guide_visibility_samples {
    int paths;       // from the eye, on which the points are
    int box_rays;    // rays per path that find the box whose faces have the bins of directions
    int bin_rays;    // rays through each bin
    int open_bins;   // the largest number of bins through which a cell traces all of them
    int light_rays;  // rays from a cell to each light
};
// *out is NULL if there is nothing to measure: if no light comes from infinitely far and there is a
// single one or more than are weighted individually, or if paths from the eye hit nothing.
// SATIN_CANCELLED or SATIN_ERROR_MEMORY.
satin_status guide_visibility_build(const struct satin_scene *scene, uint64_t seed,
                                    struct guide_visibility_samples samples, struct parallel *pool,
                                    struct guide_visibility **out);
void guide_visibility_free(struct guide_visibility *visibility);  // NULL is allowed
// The most bytes that it can have in this scene.
double guide_visibility_most(const struct satin_scene *scene);
size_t guide_visibility_bytes(const struct guide_visibility *visibility);
// How many of the bytes of guide_visibility_most were never written, and so take no memory.
size_t guide_visibility_unused(const struct satin_scene *scene,
                               const struct guide_visibility *visibility);
// Whether openings are so small that hardly any ray from the points leaves the scene.
bool guide_visibility_small(const struct guide_visibility *visibility);
// The aim at the openings through which the environment is visible; NULL if they are not small. It
// is owned by `visibility`, which may be NULL.
const struct light_aim *guide_visibility_aim(const struct guide_visibility *visibility);
// The visibility of the lights from a point, for sampling direct light, and in *product what the
// result points to. NULL: all is visible.
struct light_visibility guide_visibility_at(const struct guide_visibility *visibility,
                                            const struct light_receiver *at,
                                            struct light_product *product);

// ---- Photon clusters (guide_clusters.c) -------------------------------------------------------

// A photon at a surface: power in luminance [W], and geometric normal (unit) on its side.
struct guide_photon {
    vec3 p, n;
    float power;
};
// Spheres around clusters of photons, which are densely lit areas.
struct guide_clusters;
// Builds clusters from photons of all classes. *out is NULL if there are too few. SATIN_CANCELLED
// or SATIN_ERROR_MEMORY.
satin_status guide_clusters_build(const struct satin_scene *scene,
                                  const struct guide_photon *photon, size_t count,
                                  struct parallel *pool, struct log log,
                                  struct guide_clusters **out);
void guide_clusters_free(struct guide_clusters *clusters);  // NULL is allowed
size_t guide_clusters_bytes(const struct guide_clusters *clusters);

// ---- Cones of clusters (guide_cones.c) --------------------------------------------------------

// A point at which light is gathered.
struct guide_point {
    vec3 p, n, ng;  // the hemisphere is around n; ng is the geometric normal on the same side
};

// The sphere of a cluster, and the cone of directions towards it.
struct guide_cluster;
struct guide_cone {
    const struct guide_cluster *cluster;
    vec3 centre, axis;
    float radius, versine;  // of the sphere; 1 - cosine of the half angle
    float E;                // approximate irradiance from it, if it reflects all light [W m^-2]
    float chance;           // approximate probability that a cosine-weighted ray hits its lit area
    // Approximate probability that a ray within the cone hits that area; over 1 if the area is
    // larger than the cone.
    float filled;
};
enum { GUIDE_CONES = 48 };

// Finds the cones of the clusters that are visible from the point, and returns their number.
// *expected is the approximate irradiance by indirect light at p; if it is not positive, it is set
// to that of light distributed over the whole scene. The cones do not depend on what gather rays
// hit.
int guide_cones_from(const struct guide_clusters *clusters, const struct satin_scene *scene,
                     const struct guide_point *at, struct guide_cone out[GUIDE_CONES],
                     float *expected);
// Finds clusters for surfaces of any orientation near p, which may be visible there although they
// are not visible from p. guide_cone_move makes cones of them. `expected` [W m^-2] is the
// irradiance there. Returns 0 if `clusters` is NULL.
int guide_cones_around(const struct guide_clusters *clusters, vec3 p, float expected,
                       struct guide_cone out[GUIDE_CONES]);
// Sets axis, versine, E, chance and filled to those at p with normal n, without testing occlusion;
// E is 0 below the horizon. False if p is so near to the sphere that the cone would be wide.
bool guide_cone_move(struct guide_cone *cone, vec3 p, vec3 n);
// Whether probe i of the GUIDE_PROBES of the cone's cluster is visible from the point.
enum { GUIDE_PROBES = 4 };
bool guide_cone_visible(const struct guide_clusters *clusters, const struct satin_scene *scene,
                        const struct guide_cone *cone, const struct guide_point *at, size_t i);

// ---- Rays to clusters (guide_rays.c) ----------------------------------------------------------

// The cones that are visible from a point, and the number of rays to each in addition to the
// stratified rays of its hemisphere.
struct guide_rays {
    struct guide_cone cone[GUIDE_CONES];
    int rays[GUIDE_CONES];       // number of rays, each a power of 2
    float density[GUIDE_CONES];  // density of a cone's rays over solid angle
    int first[GUIDE_CONES];      // index of a cone's first ray, in the order of drawing
    int count;                   // number of cones
};
// Allocates rays to the `count` cones of guide_cones_from, and drops cones that get none.
void guide_rays_allocate(struct guide_rays *rays, float expected, size_t stratified);

// The state of drawing rays. The caller sets the first two members; the others are 0 before the
// first ray.
struct guide_draw {
    uint64_t stream;  // random stream of the point
    vec3 n;           // rays are not drawn below its horizon
    int cone, ray;    // the next ones
    int drawn;        // number of rays that were drawn
};
// Draws the direction of the next ray and sets `first`. False after the last ray. *density is set
// to that of its cone.
bool guide_rays_draw(struct guide_rays *rays, struct guide_draw *draw, vec3 *w, float *density);
// The weight of a ray along w by the balance heuristic, relative to the stratified rays, of which
// there are `density` per solid angle there. `drawn` is the index of the ray in the order of
// drawing, after all were drawn; negative: it is a stratified ray.
float guide_rays_weight(const struct guide_rays *rays, int drawn, vec3 w, float density);

// Draws a direction uniformly in the cone; and tests whether a direction is in it.
vec3 guide_cone_sample(const struct guide_cone *cone, vec2 u);
bool guide_cone_holds(const struct guide_cone *cone, vec3 w);

#endif
