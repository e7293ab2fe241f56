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
#include "scene/scene_film_filter.h"
#include "scene/scene_hints.h"
#include "scene/scene_image.h"
#include "scene/scene_spectrum.h"

// ---- Textures -----------------------------------------------------------------------------------

enum texture_wrap { TEXTURE_REPEAT = 0, TEXTURE_MIRROR, TEXTURE_CLAMP, TEXTURE_ZERO, TEXTURE_ONE };
enum texture_kind {
    TEXTURE_CONSTANT = 0,
    TEXTURE_BITMAP,
    TEXTURE_CHECKERBOARD,
    TEXTURE_ATTRIBUTE,
    TEXTURE_GRID,   // lines where u or v is an integer
    TEXTURE_SCALED  // check[0] times `value`
};

struct texture {
    enum texture_kind kind;
    rgb value;                       // constant; scaled: the factor
    const struct texture *check[2];  // checkerboard: its two textures; grid: between the lines, and
                                     // the lines
    int nesting;                     // depth of nested checkerboards, grids and scales in it
    float to_uv[6];                  // uv' = (a b c; d e f) (u v 1)
    const struct image *image, *level;  // level: copies of half the size, a quarter, ...; or NULL
    int levels;
    bool filtered;  // whether it, or a texture nested in it, can be averaged over a footprint
    float unit;     // length of a unit of uv after to_uv, averaged over u and v
    enum texture_wrap wrap, wrap_v;  // along u and v
    bool nearest;                    // filter_type nearest; else bilinear
    const char *attribute;           // name of a mesh attribute; equal names have the same pointer
    float scale;                     // factor of the attribute; grid: half a line's width
    rgb mean;                        // average colour, for Russian roulette of photons among others
};

// The point of a surface at which a texture is looked up.
struct mesh;
struct texture_lookup {
    vec2 uv;
    const struct mesh *mesh;  // the mesh that has the attributes, or NULL
    uint32_t prim;
    vec2 bary;    // weights of the triangle's second and third corner
    float width;  // width of the area to average over, in uv; 0: a point
};
static inline struct texture_lookup scene_texture_at(vec2 uv) {
    return (struct texture_lookup){.uv = uv};
}

rgb scene_texture_eval(const struct texture *texture, const struct texture_lookup *at);
// The value of a texture that gives a number: the luminance of an image, the mean of a colour. Here
// a checkerboard begins with color1, because Mitsuba 3.9 exchanges its colours where it asks for a
// number.
float scene_texture_number(const struct texture *texture, const struct texture_lookup *at);
// The least and the largest number of the texture. False if they are unknown.
bool scene_texture_range(const struct texture *texture, float *lo, float *hi);
// The gradient of the texture's number with respect to u and v: that of a bitmap with bilinear
// filter, 0 of other textures.
vec2 scene_texture_gradient(const struct texture *texture, vec2 uv);

// The texture inside of all `scale` textures around it; NULL for NULL.
static inline const struct texture *scene_texture_unscaled(const struct texture *texture) {
    while (texture && texture->kind == TEXTURE_SCALED) texture = texture->check[0];
    return texture;
}
// The fraction of the plane that the lines of a grid cover.
static inline float scene_texture_lines(const struct texture *grid) {
    const float between = fmaxf(1.0f - 2.0f * grid->scale, 0.0f);
    return 1.0f - between * between;
}

// ---- Materials ----------------------------------------------------------------------------------

// A height map, or a map of normals in the surface's frame, that rotates the frame of a BRDF. At
// least one of the two is NULL.
struct material_bump {
    const struct texture *height, *normal;
    float scale;   // factor of the heights
    bool upright;  // normals that point away from the viewer are mirrored [Schuessler et al. 2017]
    bool shadows;  // whether slopes shadow light at grazing angles
    bool outside;  // twosided around it: the back shows the front's bumps from below, else its own
};
static inline bool scene_bump_used(const struct material_bump *bump) {
    return bump->height || bump->normal;
}

// A side of a surface: a BRDF with constants in `base`, and textures (or NULL) that replace slots
// of it. If component[0] is set, it is a blend of two sides instead. If one of them is a null BRDF,
// it is a mask: the surface has holes. At least one leaf of a tree is not null, unless there is
// only one leaf.
struct material_side {
    struct brdf base;
    const struct texture *slot[BRDF_SLOT_COUNT];
    struct material_bump bump[BRDF_BUMPS_MAX];  // the outermost is first
    bool one_sided;  // black from behind, in the back of a blend of which only other components are
                     // two-sided
    bool pointwise;  // a texture decides where it is shown: its colours are taken at the point, as
                     // their mean over a footprint would count those that are never shown
    uint32_t index;  // among the scene's sides that are not blends; a back may have that of the
                     // front
    const struct material_side *component[2];
    const struct texture *blend;  // weight of component[1]; NULL: a constant weight
    float weight;
    bool holes;  // whether it, or a leaf of it, is null
};

// The largest number of BRDFs that are blended on one side.
enum { MATERIAL_COMPONENTS_MAX = 16 };

struct material {
    const char *name;                  // the id of its bsdf element, or its model's name
    struct material_side front, back;  // both have the same holes
    bool two_sided;  // whether the back reflects (with `back`); else it is black unless it
                     // transmits
    bool tangent;    // whether frames follow dp/du
    bool filtered;   // whether it has bitmaps that can be averaged over a footprint
};

// The fraction of rays that the surface stops there, in [0, 1] (scene_opacity.c).
float scene_opacity_material(const struct material *m, const struct texture_lookup *at);
// Lets the reflection of smooth surfaces of constant roughness count as polished (brdf_polish).
void scene_material_polish(struct material *m);
// Calls fn for every side of m that is not a blend, and for those of the back if m is two-sided.
void scene_material_visit(const struct material *m,
                          void (*fn)(void *ctx, const struct material_side *side), void *ctx);
// Whether a side of m transmits light. Holes count only if `holes` is true.
bool scene_material_transmits(const struct material *m, bool holes);
// The lobes of the models of all sides, a mask of brdf_lobe. Holes count as in
// scene_material_transmits.
unsigned scene_material_lobes(const struct material *m, bool holes);

// ---- Shapes -------------------------------------------------------------------------------------

enum shape_kind {
    SHAPE_MESH = 0,
    SHAPE_SPHERE,
    SHAPE_DISK,
    SHAPE_CYLINDER,
    SHAPE_CURVES,
    SHAPE_INSTANCE  // a group of shapes with a transform
};

// Round tubes along curves, in world space or in that of a group.
struct curves {
    uint32_t points, segments;
    const float *point;     // 4 per control point: x, y, z, radius
    const uint32_t *first;  // first control point of each segment; a segment has 2 or 4
    const uint8_t *flags;   // 1: a segment of the same curve precedes this one; 2: one follows
    bool linear;            // straight segments; else cubic B-splines
};

// Numbers or colours of a mesh: at the vertices, and interpolated between them, or one per
// triangle.
struct mesh_attribute {
    const char *name;  // name by which textures refer to it
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
    const struct mesh_attribute *attribute;  // those that textures refer to
    int attribute_count;
};

static inline vec3 scene_mesh_vertex(const struct mesh *mesh, uint32_t i) {
    const float *p = mesh->position + 3 * (size_t)i;
    return v3(p[0], p[1], p[2]);
}

// The texture coordinates at the barycentric coordinates (b1, b2) of a triangle.
static inline vec2 scene_mesh_uv(const struct mesh *mesh, uint32_t triangle, vec2 bary) {
    if (!mesh->uv) return bary;
    const uint32_t *index = mesh->index + 3 * (size_t)triangle;
    const float *a = mesh->uv + 2 * (size_t)index[0], *b = mesh->uv + 2 * (size_t)index[1],
                *c = mesh->uv + 2 * (size_t)index[2], first = 1.0f - bary.x - bary.y;
    return (vec2){first * a[0] + bary.x * b[0] + bary.y * c[0],
                  first * a[1] + bary.x * b[1] + bary.y * c[1]};
}

struct shape {
    enum shape_kind kind;
    bool has_id;       // in the scene file
    const char *name;  // this id, or plugin-N for the N-th shape of the scene
    struct mesh mesh;  // SHAPE_MESH (rectangle and cube too)
    struct curves curves;
    struct mat4 to_world,
        to_object;   // other kinds: object space as in Mitsuba (unit sphere, disk, cylinder)
    vec3 centre;     // sphere: world
    float radius;    // sphere: world; instance: its contribution to the scene's epsilon
    uint32_t group;  // 1 + index of the group to which it belongs, in whose space it is; 0: none
    uint32_t instance_of;  // instance: index of its group
    vec3 lo, hi;           // instance (by scene_trace_build) and curves: bounds
    bool flip_normals;     // already applied to the normals of meshes and of surface interactions
    bool face_normals;
    bool deflects_little;  // curved glass that deflects most light only a little: see light_pane.h
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
// and ends of a sphere or cylinder included: sets to_world, to_object, centre and radius. If the
// transform mirrors a sphere, flip_normals is toggled, as the front is then inside, as in Mitsuba.
// False if the transform has no inverse.
bool scene_shape_transform(struct shape *shape, const struct mat4 *to_world);
// World-space area of a shape.
float scene_shape_area(const struct shape *shape);
// The corners of a world-space box around a shape. If the shape has no points, lo is above hi. For
// instances, call it after scene_trace_build.
void scene_shape_bounds(const struct shape *shape, vec3 *lo, vec3 *hi);
// Computes a box around curves.
void scene_curves_bound(const struct curves *curves, vec3 *lo, vec3 *hi);

// The mean of a texture that is an attribute, over the surface of the mesh.
rgb scene_attribute_mean(const struct mesh *mesh, const struct texture *texture);
// Whether the texture, or one nested in it, is an attribute of a mesh. False for NULL.
bool scene_attribute_used(const struct texture *texture);

// ---- Camera and scene ---------------------------------------------------------------------------

// The least angle of view in degrees: at a smaller one, the rays to both ends are equal in single
// precision.
#define SCENE_FOV_MIN 1e-5f

struct camera {
    struct mat4 to_world;
    bool orthographic;   // rays are parallel; with a lens, those of a point of the lens are
    bool spherical;      // the film is all directions, by longitude and latitude
    float tan_x, tan_y;  // half extents of the full film at unit distance; orthographic: at any
    float near_clip, far_clip;
    float aperture, focus_distance;  // of the lens, in camera space as clips; 0: pinhole, or none
    vec2 shift;                      // principal point offset, in film widths and heights
};

struct light;  // defined in folder light, as light_tree
struct light_tree;
struct trace;  // the Embree scene; only scene_trace.c accesses it

struct satin_scene {
    struct arena arena;  // owns every array below
    struct shape *shape;
    uint32_t shape_count;
    struct shape_group *group;
    uint32_t group_count;
    struct material *material;
    uint32_t material_count, side_count;  // side_count: number of indices of sides, see
                                          // material_side
    struct image_file *image;             // of bitmap textures
    uint32_t image_count, texture_count;
    struct scene_images images;  // these, and an environment's
    struct light *light;
    uint32_t light_count;
    const float *light_cdf;         // light_count + 1, by power; NULL without lights
    struct light_tree *light_tree;  // of many lights (light_tree.c), else NULL
    int32_t environment;            // index of the constant or envmap light, or -1
    bool panes;                     // whether some surface may be a pane (light_pane.c)
    struct camera camera;
    // The cameras of all images that are made with the same photons and records; NULL: `camera`
    // alone. All have the same film.
    const struct camera *view;
    uint32_t view_count;
    // With SATIN_SCENE_ALL_SENSORS: the cameras of all sensors, whose films have one size.
    struct camera *sensor;
    uint32_t sensor_count;
    struct scene_film film;
    struct scene_hints hints;
    struct trace *trace;
    vec3 bounds_lo, bounds_hi;  // of all surfaces; equal for an empty scene
    float radius;               // radius of a sphere around the bounds, > 0
    float epsilon;              // a length; coordinates are accurate to some ulp of it at best
    uint64_t triangle_count;
    uint64_t hash;                          // hash of everything that was read
    int sensor_index;                       // of `camera` among the sensors of the file
    const char *definitions;                // the parameters that were given: NAME=VALUE, commas
    uint64_t world;                         // hash without sensor and integrator
    struct fileio_files read;               // every file that was read, wholly or in part
    struct stats_span load_span, bvh_span;  // times of reading the scene, and of building the BVH,
                                            // which is within it
};

// Whether a shape, which must not be an instance, has an ideal specular lobe.
static inline bool scene_shape_has_delta(const struct satin_scene *scene, uint32_t shape) {
    const struct shape *s = &scene->shape[shape];
    return scene_material_lobes(&scene->material[s->material], s->light >= 0) & BRDF_DELTA;
}

// ---- Rays (scene_trace.c) -----------------------------------------------------------------------

// The height above a surface of a ray between two of its points, over its length, so that a curved
// surface does not occlude its own points.
#define SCENE_LIFT 0.1f

// Embree drops triangles with coordinates beyond 1.8e18, and aborts the process on rays that begin
// there. Therefore neither is passed to Embree beyond this limit.
#define SCENE_COORDINATE_MAX 1e18f

struct ray {
    vec3 o;
    float tnear;
    vec3 d;  // unit
    float tfar;
};

// A surface point that a ray hit.
struct interaction {
    vec3 p;              // on the surface within a few ulp
    vec3 ng;             // geometric normal, unit, on the front side, with flip_normals applied
    struct frame frame;  // shading frame; n on the side of ng
    vec2 uv;
    vec2 bary;          // triangles: weights of the second and third corner
    vec3 dp_du, dp_dv;  // of meshes only if the material's frames follow dp/du or an AOV needs them
    float t;
    float uv_rate;    // change of uv per length if the material is `filtered`, else 0
    float footprint;  // width of the area that the ray stands for, for textures; 0: a point
    uint32_t shape, prim, material, instance;  // instance: that shows it, counted from 1; 0: none
    int32_t light;                             // area light of the shape, or -1
};

// Builds the Embree scene of scene->shape and sets bounds, radius and triangle_count.
satin_status scene_trace_build(struct satin_scene *scene, struct log log);
void scene_trace_free(struct trace *trace);

// Finds the nearest hit in (tnear, tfar), with a footprint of 0. False if there is none. A ray that
// is not finite, or whose direction is zero, hits nothing.
bool scene_intersect(const struct satin_scene *scene, const struct ray *ray,
                     struct interaction *out);
// Finds the nearest surface in (tnear, tfar), ignoring the holes of masked ones: a point on it
// within the rounding of the ray, and its geometric normal (unit) on either side. Faster than
// scene_intersect. False if there is none.
bool scene_surface(const struct satin_scene *scene, const struct ray *ray, vec3 *p, vec3 *n);
// The distance of the nearest hit, or INFINITY if there is none. Faster than scene_intersect.
float scene_distance(const struct satin_scene *scene, const struct ray *ray);
bool scene_occluded(const struct satin_scene *scene, const struct ray *ray);
// Moves a surface point at least `margin` away from the edges of its triangle, or towards the
// centre of a triangle that is too small for that, by no more than `margin`. Points of other shapes
// are not moved.
vec3 scene_origin_shift(const struct satin_scene *scene, const struct interaction *s, float margin);
// The change of the shading normal s->frame.n, without bump and normal maps, per displacement dp
// along the surface at s. Of triangles and spheres outside of instances; else 0.
vec3 scene_normal_change(const struct satin_scene *scene, const struct interaction *s, vec3 dp);

// A bound of the distance between a surface point p, in float, and its surface.
float scene_rounding(const struct satin_scene *scene, vec3 p);
// A ray that leaves a surface point in direction d. Its origin is moved off the surface, to the
// side of d, by that bound, so that it does not hit that surface.
struct ray scene_spawn(const struct satin_scene *scene, vec3 p, vec3 ng, vec3 d);
// A ray as by scene_spawn towards the point q, which ends just before q. nq is the normal of the
// surface at q, or zero if q is not on a surface.
struct ray scene_spawn_to(const struct satin_scene *scene, vec3 p, vec3 ng, vec3 q, vec3 nq);

// The point at which textures are looked up for the surface interaction s.
static inline struct texture_lookup scene_interaction_texture_lookup(
    const struct satin_scene *scene, const struct interaction *s) {
    const struct mesh *mesh = &scene->shape[s->shape].mesh;
    return (struct texture_lookup){s->uv, mesh->attribute_count ? mesh : NULL, s->prim, s->bary,
                                   s->footprint * s->uv_rate};
}

// ---- Shading (scene_material.c) -----------------------------------------------------------------

// One of the BRDFs that are blended at s, for the direction wo (world, unit, away from the
// surface).
struct scene_component {
    const struct material_side *side;
    float weight;
};

// All components at s: at most MATERIAL_COMPONENTS_MAX, with weights over 0 that sum to 1. Holes
// are not among them, because rays have passed them, unless the surface emits light.
int scene_components(const struct satin_scene *scene, const struct interaction *s, vec3 wo,
                     struct scene_component out[MATERIAL_COMPONENTS_MAX]);
// One of the components, drawn with its weight as the probability. The draw depends on s and wo
// alone.
const struct material_side *scene_draw_component(const struct satin_scene *scene,
                                                 const struct interaction *s, vec3 wo);
// The BRDF of a component, with its textures looked up, and the frame of its local directions. n of
// that frame is on wo's side for a two-sided material, else that of the surface interaction,
// rotated by bump and normal maps. False if the component reflects nothing.
bool scene_component_brdf(const struct satin_scene *scene, const struct material_side *side,
                          const struct interaction *s, vec3 wo, struct brdf *brdf,
                          struct frame *frame);
// Does what scene_component_brdf does, for the component that scene_draw_component draws.
bool scene_brdf(const struct satin_scene *scene, const struct interaction *s, vec3 wo,
                struct brdf *brdf, struct frame *frame);
// The frame without bump and normal maps, on the side that scene_component_brdf uses.
struct frame scene_component_frame(const struct satin_scene *scene,
                                   const struct material_side *side, const struct interaction *s,
                                   vec3 wo);

// ---- Shading points (scene_shading_point.c) -----------------------------------------------------

// A surface point prepared for shading in direction wo.
struct shading_point {
    struct interaction interaction;
    struct brdf brdf;
    const struct material_side *side;  // the component of the blend
    struct frame frame;                // of the BRDF; n on the side that reflects
    struct frame base;                 // the frame without bumps, which records have
    vec3 wo_l;                         // towards the viewer, local
    vec3 ng;                           // geometric normal on the viewer's side
    unsigned lobes;                    // of the BRDF, 0 if it reflects nothing
};

// Prepares the point at which a ray along d hits s. If the material is a blend, one component is
// drawn.
void scene_shading_point_make(const struct satin_scene *scene, const struct interaction *s, vec3 d,
                              struct shading_point *out);
// Prepares the point with a given component.
void scene_shading_point_of(const struct satin_scene *scene, const struct material_side *side,
                            const struct interaction *s, vec3 d, struct shading_point *out);

// ---- Camera (scene_camera.c) --------------------------------------------------------------------

// The number of the scene's cameras, at least 1, and the camera of that index.
static inline uint32_t scene_camera_count(const struct satin_scene *scene) {
    return scene->view ? scene->view_count : 1;
}
static inline const struct camera *scene_camera_at(const struct satin_scene *scene,
                                                   uint32_t index) {
    return scene->view ? &scene->view[index] : &scene->camera;
}
// The camera of sample i of the scene's cameras: successive samples are distributed evenly to all
// of them, by the golden ratio.
static inline const struct camera *scene_camera_sample(const struct satin_scene *scene,
                                                       uint32_t i) {
    return scene_camera_at(
        scene, (uint32_t)((uint64_t)(i * 0x9e3779b9u) * scene_camera_count(scene) >> 32));
}
// The eye ray of one of the cameras through film position (x, y), in pixels of the full film with y
// down. (u, v) in [0, 1)^2 choose the point on the lens. *spread is the ray's width over distance:
// the footprint of a pixel at distance t is t * spread wide.
struct ray scene_camera_ray(const struct satin_scene *scene, const struct camera *camera, vec2 film,
                            vec2 lens, float *spread);
// Logs a warning, with its reason, if the camera sees no shape, and returns whether it did. There
// is no warning if the environment is visible, unless it is only the clip planes that hide all
// shapes (scene_camera_check.c).
bool scene_camera_check(const struct satin_scene *scene, const struct camera *camera,
                        struct log log);

#endif
