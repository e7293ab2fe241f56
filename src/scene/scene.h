// SPDX-License-Identifier: Apache-2.0
// A loaded scene: surfaces, materials, textures, lights, camera, film. Immutable after loading, so
// every function here may be called from any thread.
#ifndef SCENE_SCENE_H
#define SCENE_SCENE_H

#include <stddef.h>
#include <stdint.h>

#include "base/arena.h"
#include "base/fileio_files.h"
#include "base/frame.h"
#include "base/log.h"
#include "base/mat4.h"
#include "base/parallel.h"
#include "base/rng.h"
#include "base/stats.h"
#include "brdf/brdf.h"
#include "satin/scene.h"
#include "scene/scene_hints.h"
#include "scene/scene_spectrum.h"

// ---- Textures ---------------------------------------------------------------------------------

enum texture_wrap { TEXTURE_REPEAT = 0, TEXTURE_MIRROR, TEXTURE_CLAMP };
enum texture_kind {
    TEXTURE_CONSTANT = 0,
    TEXTURE_BITMAP,
    TEXTURE_CHECKERBOARD,
    TEXTURE_ATTRIBUTE,
    TEXTURE_GRID,   // lines around the integers of u and v
    TEXTURE_SCALED  // check[0] times `value`
};

// Linear texels; `channels` 1 or 3. Owned by the scene's arena.
struct image {
    int width, height, channels;
    const float *texel;  // row by row from the top
};

// A file of texels, with the smaller copies that wide lookups take.
struct image_file {
    const char *path;
    const struct image *image, *level;  // level: half its size, a quarter, ...; NULL if raw
    int levels;
    bool raw;
};

struct texture {
    enum texture_kind kind;
    rgb value;                          // constant; scaled: the factor
    const struct texture *check[2];     // checkerboard: what it changes between; grid: lines second
    int nesting;                        // of checkerboards and the like in it
    float to_uv[6];                     // uv' = (a b c; d e f) (u v 1)
    const struct image *image, *level;  // level: half its size, a quarter, ...; or NULL
    int levels;
    bool filtered;                   // it, or what is nested in it, can be averaged over a width
    float texels;                    // of the image along a unit of uv, the mean of both directions
    enum texture_wrap wrap, wrap_v;  // along u and v
    bool nearest;                    // filter_type nearest; else bilinear
    const char *attribute;           // name of a mesh attribute, the same pointer for the same name
    float scale;                     // of the attribute; grid: half a line's width
    rgb mean;                        // average colour, for photon roulette and the like
};

// Where a texture is looked up: a point of a surface.
struct mesh;
struct texture_lookup {
    vec2 uv;
    const struct mesh *mesh;  // whose attributes there are; NULL: none
    uint32_t prim;
    vec2 bary;    // weights of the triangle's second and third corner
    float width;  // of the area to average over, in uv; 0: a point
};
static inline struct texture_lookup texture_at(vec2 uv) {
    return (struct texture_lookup){.uv = uv};
}

rgb texture_eval(const struct texture *texture, const struct texture_lookup *at);
// A texture that gives a number: an image's luminance, a colour's mean. A checkerboard then begins
// with color1, as in Mitsuba 3.9, which exchanges its colours where it asks for a number.
float texture_number(const struct texture *texture, const struct texture_lookup *at);
// The least and the largest number that it gives; false if that is not known.
bool texture_range(const struct texture *texture, float *lo, float *hi);
// The gradient of its number by u and v; of a bitmap with bilinear filter, else 0.
vec2 texture_gradient(const struct texture *texture, vec2 uv);

// What is in it once its factors are taken off; NULL of NULL.
static inline const struct texture *texture_unscaled(const struct texture *texture) {
    while (texture && texture->kind == TEXTURE_SCALED) texture = texture->check[0];
    return texture;
}
// The part of the plane that the lines of a grid cover.
static inline float texture_lines(const struct texture *grid) {
    const float between = fmaxf(1.0f - 2.0f * grid->scale, 0.0f);
    return 1.0f - between * between;
}

// ---- Materials --------------------------------------------------------------------------------

// Rotates the frame of a BRDF by a height map or by a map of normals in the surface's frame; one of
// both is NULL, or both.
struct material_bump {
    const struct texture *height, *normal;
    float scale;   // of the bumps
    bool upright;  // normals that point away from the viewer are mirrored [Schuessler et al. 2017]
    bool shadows;  // slopes shadow light that comes in flat
    bool outside;  // of twosided: the back shows the bumps from below, else its own
};
static inline bool bump_used(const struct material_bump *r) { return r->height || r->normal; }

// A side of a surface: a BRDF with constants in `base`, and textures (or NULL) that replace slots
// of it; or, if component[0] is set, a blend of two sides. Where one of them is nothing (a null
// BRDF) it is a mask: the surface has holes. At least one leaf of a tree is not nothing, unless it
// is the only one.
struct material_side {
    struct brdf base;
    const struct texture *slot[BRDF_SLOT_COUNT];
    struct material_bump bump[BRDF_BUMPS_MAX];  // the outermost first
    bool one_sided;  // at the back of a blend that is two-sided in other components only
    uint32_t index;  // of the scene's sides that are no blends; a back may have the front's
    const struct material_side *component[2];
    const struct texture *blend;  // weight of component[1]; NULL: constant
    float weight;
    bool holes;  // it is nothing; or a leaf of it is
};

// No more BRDFs may be blended on one side.
enum { MATERIAL_COMPONENTS_MAX = 16 };

struct material {
    const char *name;                  // the id of its bsdf element, or its model's name
    struct material_side front, back;  // with the same holes
    bool two_sided;  // the back reflects too (with `back`); else it is black unless it transmits
    bool tangent;    // frames follow dp/du
    bool filtered;   // colours come from bitmaps that can be averaged
};

// The fraction of rays that are stopped there, in [0, 1] (scene_opacity.c).
float material_opacity(const struct material *m, const struct texture_lookup *at);
// Calls fn for every side of m that is no blend; those of the back if it is two-sided.
void material_visit(const struct material *m,
                    void (*fn)(void *ctx, const struct material_side *side), void *ctx);
// Whether light passes through one of them; holes count if asked for.
bool material_transmits(const struct material *m, bool holes);
// The lobes of their models, a mask of brdf_lobe; likewise.
unsigned material_lobes(const struct material *m, bool holes);

// ---- Shapes -----------------------------------------------------------------------------------

enum shape_kind {
    SHAPE_MESH = 0,
    SHAPE_SPHERE,
    SHAPE_DISK,
    SHAPE_CYLINDER,
    SHAPE_CURVES,
    SHAPE_INSTANCE  // a group of shapes, moved by a transform
};

// Round tubes along curves, in world space or that of a group.
struct curves {
    uint32_t points, segments;
    const float *point;     // 4 per control point: x, y, z, radius
    const uint32_t *first;  // first control point of each segment, which takes 2 or 4
    const uint8_t *flags;   // 1: a segment goes before this one in its curve; 2: one comes after
    bool linear;            // straight segments; else cubic B-splines
};

// Numbers or colours at the vertices of a mesh, interpolated between them, or one for each
// triangle.
struct mesh_attribute {
    const char *name;  // as textures have it
    bool per_triangle;
    int channels;  // 1 or 3
    const float *value;
};

struct mesh {
    uint32_t vertex_count, triangle_count;
    const float *position;  // 3 per vertex, world space, 1 float of padding after the last
    const float *normal;    // 3 per vertex, unit, world space; NULL: face normals
    const float *uv;        // 2 per vertex; NULL: barycentric
    const uint32_t *index;  // 3 per triangle
    const struct mesh_attribute *attribute;  // those that textures ask for
    int attribute_count;
};

struct shape {
    enum shape_kind kind;
    const char *name;
    struct mesh mesh;  // SHAPE_MESH (rectangle and cube too)
    struct curves curves;
    struct mat4 to_world,
        to_object;   // the others: object space as in Mitsuba (unit sphere, disk, cylinder)
    vec3 center;     // sphere: world
    float radius;    // sphere: world; instance: what it adds to the scene's epsilon
    uint32_t group;  // 1 + index of the group that it is a part of, in whose space it is; 0: none
    uint32_t instance_of;  // instance: index of its group
    vec3 lo, hi;           // instance (by scene_trace_build) and curves: bounds
    bool flip_normals;     // already applied to a mesh's vertex normals and to surface interactions
    bool face_normals;
    uint32_t material;
    int32_t light;          // index of its area light or -1
    float area;             // world space
    const float *area_cdf;  // mesh with a light: triangle_count + 1; else NULL
};

// Shapes `first` to `first + count - 1`. Rays hit them only through the instances of the group.
struct shape_group {
    uint32_t first, count;
};

// Sets the transform of a sphere, disk or cylinder from its object space, with the centre, radius
// and ends of a sphere or cylinder included: sets to_world, to_object, center and radius. If the
// transform mirrors a sphere, flip_normals is toggled, as the front is then inside, as in Mitsuba.
// False if the transform has no inverse.
bool scene_shape_transform(struct shape *shape, const struct mat4 *to_world);
// World-space area of a shape.
float scene_shape_area(const struct shape *shape);
// The corners of a world-space box around a shape; lo is above hi if the shape has no points.
// Instances: after scene_trace_build.
void scene_shape_bounds(const struct shape *shape, vec3 *lo, vec3 *hi);
// A box around tubes.
void scene_curves_bound(const struct curves *curves, vec3 *lo, vec3 *hi);

// The mean of a texture, where it is an attribute over the surface of the mesh.
rgb attribute_mean(const struct mesh *mesh, const struct texture *texture);
// Whether the texture, or one nested in it, is an attribute of a mesh; NULL: no texture.
bool attribute_used(const struct texture *texture);

// ---- Camera and film --------------------------------------------------------------------------

struct camera {
    struct mat4 to_world;
    bool orthographic;   // all rays are parallel
    float tan_x, tan_y;  // half extents of the full film at unit distance; orthographic: at any
    float near_clip, far_clip;
    float aperture;  // lens radius; 0: pinhole
    float focus_distance;
    vec2 shift;  // principal point offset, in film widths and heights
};

enum filter_kind { FILTER_BOX = 0, FILTER_TENT, FILTER_GAUSSIAN, FILTER_CUBIC, FILTER_LANCZOS };

struct film_spec {
    int width, height;  // full film
    int crop_x, crop_y, crop_width, crop_height;
    enum filter_kind filter;
    float radius, stddev;  // in pixels
    float b, c;            // cubic: its parameters
};

struct light;  // of light.h, as is the next
struct light_tree;
struct trace;  // the Embree scene; scene_trace.c alone knows it

struct satin_scene {
    struct arena arena;  // owns every array below
    struct shape *shape;
    uint32_t shape_count;
    struct shape_group *group;
    uint32_t group_count;
    struct material *material;
    uint32_t material_count, side_count;  // the latter: numbers of sides, see material_side
    struct image_file *image;             // of bitmap textures
    uint32_t image_count, texture_count;
    struct light *light;
    uint32_t light_count;
    const float *light_cdf;         // light_count + 1, by power; NULL without lights
    struct light_tree *light_tree;  // of many lights (light_tree.c), else NULL
    int32_t environment;            // index of the constant or envmap light, or -1
    bool panes;                     // some surface may be a pane's (light_pane.c)
    struct camera camera;
    struct film_spec film;
    struct scene_hints hints;
    struct trace *trace;
    vec3 bounds_lo, bounds_hi;  // of all surfaces; equal for an empty scene
    float radius;               // of the sphere around the bounds, > 0
    float epsilon;              // a length: coordinates are good to some ulp of it at least
    uint64_t triangle_count;
    uint64_t hash;             // of everything that was read
    uint64_t world;            // the same without how it is looked at: sensor and integrator
    struct fileio_files read;  // every file of which something was read
    struct stats_span load_span, bvh_span;  // reading it; building the BVH, a part of that
};

// ---- Rays (scene_trace.c) ---------------------------------------------------------------------

// Embree drops triangles with coordinates beyond 1.8e18 and aborts the process on rays from there,
// so neither is given to it beyond this.
#define SCENE_COORDINATE_MAX 1e18f

struct ray {
    vec3 o;
    float tnear;
    vec3 d;  // unit
    float tfar;
};

// A surface point that a ray hit.
struct interaction {
    vec3 p;              // on the surface to a few ulp
    vec3 ng;             // geometric normal, unit; the front side, with flip_normals applied
    struct frame frame;  // shading frame; n on the side of ng
    vec2 uv;
    vec2 bary;          // triangles: weights of the second and third corner
    vec3 dp_du, dp_dv;  // of meshes only if the material's frames follow dp/du or AOVs ask for it
    float t;
    float uv_rate;    // uv per length if the material is `filtered`, else 0
    float footprint;  // width of the area that the ray stands for, for textures; 0: a point
    uint32_t shape, prim, material;
    int32_t light;  // area light of the shape, or -1
};

// Builds the Embree scene over scene->shape and sets bounds, radius and triangle_count.
satin_status scene_trace_build(struct satin_scene *scene, struct log log);
void scene_trace_free(struct trace *trace);

// The nearest hit in (tnear, tfar), or false; footprint 0. A ray that is not finite, or has no
// direction, hits nothing.
bool scene_intersect(const struct satin_scene *scene, const struct ray *ray,
                     struct interaction *out);
// scene_intersect for a ray to which masked surfaces are whole.
bool scene_intersect_whole(const struct satin_scene *scene, const struct ray *ray,
                           struct interaction *out);
// Only the distance: INFINITY if there is no hit. Cheaper than scene_intersect.
float scene_distance(const struct satin_scene *scene, const struct ray *ray);
bool scene_occluded(const struct satin_scene *scene, const struct ray *ray);

// A surface point moved off the edges of its triangle by `margin` where it is nearer, or as far
// towards the triangle's centre, by no more than `margin`. Points of other shapes stay.
vec3 scene_off_edges(const struct satin_scene *scene, const struct interaction *s, float margin);

// A ray that leaves a surface point in direction d: its origin is moved off the surface, to the
// side that d points to, by a bound of the rounding error there, so that it does not hit the
// surface it leaves.
struct ray scene_spawn(const struct satin_scene *scene, vec3 p, vec3 ng, vec3 d);
// A ray as scene_spawn makes it, towards the point q; it ends just before q. Normal nq of the
// surface at q, or zero if q is free.
struct ray scene_spawn_to(const struct satin_scene *scene, vec3 p, vec3 ng, vec3 q, vec3 nq);

// Where textures are looked up at s.
static inline struct texture_lookup interaction_texture_lookup(const struct satin_scene *scene,
                                                               const struct interaction *s) {
    const struct mesh *mesh = &scene->shape[s->shape].mesh;
    return (struct texture_lookup){s->uv, mesh->attribute_count ? mesh : NULL, s->prim, s->bary,
                                   s->footprint * s->uv_rate};
}

// ---- Shading (scene_material.c) ---------------------------------------------------------------

// One of the BRDFs that are blended at s, for the direction wo (world, unit, away from the
// surface).
struct scene_component {
    const struct material_side *side;
    float weight;
};

// All of them: at most MATERIAL_PARTS_MAX; weights over 0 that sum to 1. Rays have passed the holes
// of s, so these are no components, but where it emits.
int scene_components(const struct satin_scene *scene, const struct interaction *s, vec3 wo,
                     struct scene_component out[MATERIAL_COMPONENTS_MAX]);
// One, drawn with its weight as the probability, by s and wo alone.
const struct material_side *scene_component(const struct satin_scene *scene,
                                            const struct interaction *s, vec3 wo);
// The BRDF of a component, with its textures looked up, and the frame that its local directions
// refer to: n on wo's side for a two-sided material, else the surface interaction's, rotated by
// bump and normal maps. False if the component reflects nothing.
bool scene_component_brdf(const struct satin_scene *scene, const struct material_side *side,
                          const struct interaction *s, vec3 wo, struct brdf *brdf,
                          struct frame *frame);
// That of scene_component.
bool scene_brdf(const struct satin_scene *scene, const struct interaction *s, vec3 wo,
                struct brdf *brdf, struct frame *frame);
// The frame without bumps, on the side that scene_component_brdf takes.
struct frame scene_component_frame(const struct satin_scene *scene,
                                   const struct material_side *side, const struct interaction *s,
                                   vec3 wo);

// ---- Camera (scene_camera.c) ------------------------------------------------------------------

// The eye ray through film position (x, y) in pixels of the full film, y down; lens point from (u,
// v). `spread` gets the ray's width per distance: a pixel's footprint at distance t is t * spread
// wide.
struct ray camera_ray(const struct satin_scene *scene, float x, float y, float u, float v,
                      float *spread);
// Logs a warning, with its reason, if the camera sees no shape, and no environment or one in whose
// light the clip planes alone hide all shapes (scene_camera_check.c).
void camera_check(const struct satin_scene *scene, struct log log);

// ---- Filter (scene_filter.c) -------------------------------------------------------------------

// Offset from a pixel's centre drawn by u from the film's filter, one without negative lobes,
// truncated so that the position stays inside [lo, hi) (the crop window), as a renormalised filter
// at the border does.
float film_filter_sample(const struct film_spec *film, float centre, float lo, float hi, float u);

// film_filter_sample from tables, for every filter. The sample counts `weight` times: 1, or where
// lobes of the filter are negative on average 1, and less than 0 in the lobes.
enum { FILM_FILTER_STEPS = 1024 };
struct film_filter {
    const struct film_spec *film;
    float inverse[FILM_FILTER_STEPS + 2];  // offset at u = i / FILM_FILTER_STEPS
    // With negative lobes: integrals from the left end, of the filter and of its absolute value.
    float sum[FILM_FILTER_STEPS + 1], size[FILM_FILTER_STEPS + 1];
};
struct film_offset {
    float x, weight;
};
// Whether it is negative somewhere.
bool film_filter_has_lobes(const struct film_spec *film);
void film_filter_make(const struct film_spec *film, struct film_filter *out);
struct film_offset film_filter_offset(const struct film_filter *filter, float centre, float lo,
                                      float hi, float u);

#endif
