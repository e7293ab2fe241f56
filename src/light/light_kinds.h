// SPDX-License-Identifier: Apache-2.0
// Private to light/: functions for each kind of light, which light.c calls.
#ifndef LIGHT_KINDS_H
#define LIGHT_KINDS_H

#include "light/light.h"

// ---- Area lights (light_area.c) ---------------------------------------------------------------

// Pairs the triangles of an emitting mesh into faces, or builds its area_cdf; sets area, centre,
// strength and power. Fails with SATIN_ERROR_MEMORY.
satin_status light_area_prepare(struct satin_scene *scene, struct light *light);
// An estimate of the irradiance (luminance) from the light at p, which is 0 only if the light
// contributes none.
float light_area_estimate(const struct satin_scene *scene, const struct light *light, vec3 p);
bool light_area_sample(const struct satin_scene *scene, const struct light *light, vec3 p, float u,
                       float v, struct light_sample *out);
float light_area_pdf(const struct satin_scene *scene, const struct light *light, vec3 p, vec3 wi,
                     const struct interaction *s);
// A point drawn uniformly by area, the normal of its emitting side and its radiance.
struct light_point {
    vec3 p, n;
    rgb L;
    float pdf_a;
};
struct light_point light_area_point(const struct satin_scene *scene, const struct light *light,
                                    float u, float v);

// The front normal of a triangle of a mesh, whose length is twice the area.
vec3 light_triangle_normal(const struct shape *shape, uint32_t i);

// ---- Lights of many triangles (light_facing.c) --------------------------------------------------

// Builds facing_cdf of a mesh light, unless it would be large. Fails with SATIN_ERROR_MEMORY.
satin_status light_facing_build(struct satin_scene *scene, struct light *light);
// The distribution over the triangles of a mesh light for samples from p: by area, or by the area
// that faces points like p.
const float *light_facing_cdf(const struct light *light, const struct shape *shape, vec3 p);

// Whether p is so far from a mesh light that it sees all parts in about the same direction.
bool light_mesh_is_far(const struct light *light, vec3 p);

// ---- Lights of many triangles from near (light_slabs.c) -----------------------------------------

struct light_slab_point {
    vec3 p;
    uint32_t triangle;
    float pdf_a;  // density over area
};
// Sets the slabs of a mesh light, unless it has too many triangles. Fails with SATIN_ERROR_MEMORY.
satin_status light_slabs_build(struct satin_scene *scene, struct light *light);
// Draws a point of the mesh for p.
struct light_slab_point light_slabs_sample(const struct light_slabs *slabs, vec3 p, float u,
                                           float v);
// The density over area of drawing q.
float light_slabs_pdf(const struct light_slabs *slabs, vec3 p, vec3 q);
// The sum over parts of area over squared distance.
float light_slabs_estimate(const struct light_slabs *slabs, vec3 p);

// ---- Cylinders (light_cylinder.c) ---------------------------------------------------------------

struct light_tube_point {
    vec3 p, n;    // n: the outward normal
    vec2 uv;      // texture coordinates
    float pdf_w;  // density over solid angle
};
// Sets the tube of a cylinder that is round and emits outwards. Fails with SATIN_ERROR_MEMORY.
satin_status light_tube_build(struct satin_scene *scene, struct light *light);
// Draws a point of the tube for p outside it. False if points are to be drawn by area.
bool light_tube_sample(const struct light_tube *tube, vec3 p, float u, float v,
                       struct light_tube_point *out);
// Sets the density over solid angle at p of drawing q. False if points are drawn by area.
bool light_tube_pdf(const struct light_tube *tube, vec3 p, vec3 q, float *pdf_w);
// The mean squared inverse distance of the axis from p, or from where the axis is a radius away.
float light_tube_closeness(const struct light_tube *tube, vec3 p);

// ---- Faces (light_face.c) ---------------------------------------------------------------------

// 1 or -1, the factor by which a triangle's normal n, from the order of its vertices, is on the
// front side, as scene_intersect returns it.
float light_mesh_side(const struct shape *shape, const uint32_t index[3], vec3 n);
// Pairs triangles 2 i and 2 i + 1 into parallelograms. False if a pair does not form one.
bool light_faces_build(const struct shape *shape, struct light_face *face, uint32_t count);
// Draws a point of the face for p in front of it: by solid angle if the face is right-angled and
// its solid angle is not tiny, else by area. False if p is behind.
bool light_face_sample(const struct light_face *face, vec3 p, float u, float v, vec3 *q,
                       float *pdf_w);
// The density over solid angle at p of drawing q.
float light_face_pdf(const struct light_face *face, vec3 p, vec3 q);
// An estimate of the solid angle of the face from p; 0 if p is behind.
float light_face_estimate(const struct light_face *face, vec3 p);
// The texture coordinates at corner + s * edge_u + t * edge_v.
vec2 light_face_uv(const struct light_face *face, const struct mesh *mesh, float s, float t);
// The coordinates s and t of q = corner + s * edge_u + t * edge_v.
vec2 light_face_coordinates(const struct light_face *face, vec3 q);

// ---- Textured faces (light_texels.c) ----------------------------------------------------------

// Sets the grid of a face of a textured light. Fails with SATIN_ERROR_MEMORY.
satin_status light_texels_build(struct satin_scene *scene, const struct light *light,
                                struct light_face *face);
// Draw s and t by the grid, and return the density of that over the unit square.
vec2 light_texels_sample(const struct light_face *face, float u, float v);
float light_texels_density(const struct light_face *face, vec2 st);

// ---- Environments (light_environment.c) -------------------------------------------------------

// Builds the distribution of an envmap; sets strength and power. Fails with SATIN_ERROR_MEMORY.
satin_status light_environment_prepare(struct satin_scene *scene, struct light *light);

// ---- Boxes (light_box.c) and products (light_product.c) ---------------------------------------

// p, moved into the box if it is beyond or at a face.
vec3 light_box_inside(const struct light_box *box, vec3 p);
// p, or the nearest point from which no face is so near that its bins are at grazing angles alone.
vec3 light_box_apart(const struct light_box *box, vec3 p);
// The width of a bin along an axis.
float light_box_bin_width(const struct light_box *box, int axis);
// Draws a direction by the blocks and bins of the product, whose fraction must be > 0. *pdf_w is
// its density over solid angle.
vec3 light_product_sample(const struct light_product *product, float u, float v, float *pdf_w);
float light_product_pdf(const struct light_product *product, vec3 w);

// ---- Beams (light_beam.c) ---------------------------------------------------------------------

// Sets position, direction, strength and power. Fails with SATIN_ERROR_MEMORY.
satin_status light_beam_prepare(struct satin_scene *scene, struct light *light);
float light_beam_estimate(const struct satin_scene *scene, const struct light *light, vec3 p);
bool light_beam_sample(const struct satin_scene *scene, const struct light *light, vec3 p,
                       struct light_sample *out);

// ---- Emission (light_emit.c) ------------------------------------------------------------------

// The area of a box, projected along d.
float light_box_projected_area(const struct light_target *box, vec3 d);
// The area of the scene's bounds, projected along d, and the area of their surface.
float light_bounds_projected_area(const struct satin_scene *scene, vec3 d);
float light_bounds_area(const struct satin_scene *scene);

// ---- Lights at a point (light_point.c) --------------------------------------------------------

// Sets strength and power.
void light_point_prepare(struct light *light);
float light_point_estimate(const struct light *light, vec3 p);
bool light_point_sample(const struct light *light, vec3 p, struct light_sample *out);
// Draws a direction of emission. The second function returns the emitted light along d over the
// density *pdf_w [sr^-1] of that draw: it is color times the returned value, which is 0 if nothing
// is emitted or d is never drawn.
vec3 light_point_direction(const struct light *light, float u, float v);
float light_point_power(const struct light *light, vec3 d, rgb *color, float *pdf_w);
// 1 / the density of light_point_direction along the light's axis [sr].
float light_point_solid_angle(const struct light *light);
// The fraction of its intensity that a spot light emits at `cos_theta` from its axis.
float light_spot_falloff(const struct light *light, float cos_theta);
// The integrals of the falloff over the cone of full intensity and over the penumbra [sr].
void light_spot_solid_angles(const struct light *light, float *beam, float *penumbra);

// ---- Aim (light_aim.c) ------------------------------------------------------------------------

// With which probability a photon is aimed at each box: at covers in proportion to what they get of
// the light, and at spots equally.
struct light_mixture {
    int covers, count;
    float probability[LIGHT_BOXES];
};

// Rays along one direction through the boxes of an aim, uniform over their projected areas [m^2].
struct light_rays {
    const struct light_aim *aim;
    struct light_mixture mixture;
    float area[LIGHT_BOXES];
};
// False if there are none, as all covers are flat and edge-on.
bool light_aim_rays(const struct light_aim *aim, vec3 d, struct light_rays *out);
// The index of a box, chosen by *u, which is then rescaled to [0, 1).
int light_rays_choose(const struct light_rays *rays, float *u);
// 1 / the density of a ray that was drawn through box `chosen`; 0 if it misses all covers.
float light_rays_area(const struct light_rays *rays, float slack, int chosen,
                      const struct ray *ray);

// ---- Openings (light_openings.c) ----------------------------------------------------------------

// Whether light along d enters through any of them.
bool light_openings_face(const struct light_openings *openings, vec3 d);
// A point in the openings through which a ray along d enters the box, uniform over their projected
// area, for a d that light_openings_face allows; the box is the scene's or within it.
vec3 light_openings_point(const struct light_openings *openings, vec3 d, float u, float v);
// The density of such rays over the projected area [m^-2]; 0 if the ray does not enter there.
float light_openings_density(const struct light_openings *openings, const struct ray *ray);
// The largest density of rays along d.
float light_openings_most(const struct light_openings *openings, vec3 d);

// Cones from a point to the boxes of an aim. The solid angle is INFINITY for a box at which the
// light draws the direction itself, as its cone would be wider than what the light illuminates.
struct light_cone {
    vec3 axis;
    float cos_max, solid_angle;
};
struct light_cones {
    struct light_mixture mixture;
    struct light_cone cone[LIGHT_BOXES];
};
// solid_angle: 1 / the light's own largest density of directions [sr].
void light_aim_cones(const struct light_aim *aim, vec3 p, float solid_angle,
                     struct light_cones *out);
// Draws a direction by u and v. False: the light must draw it, by *u, which is rescaled, and v.
bool light_cones_draw(const struct light_cones *cones, float *u, float v, vec3 *d);
// The factor of the power of a photon along d, where pdf_w is the light's density; 0 if it misses
// all covers.
float light_cones_weight(const struct light_cones *cones, vec3 d, float pdf_w);

#endif
