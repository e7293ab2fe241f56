// SPDX-License-Identifier: Apache-2.0
// <shape>: meshes from files, rectangles and cubes as meshes, spheres, disks and cylinders as exact
// surfaces. Frames, orientation and texture coordinates are Mitsuba 3's.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "load/load_plugins_shape.h"
#include "load/load_state.h"

const struct param_spec load_shape_to_world = {"to_world",
                                               PARAM_TRANSFORM,
                                               "1",
                                               0,
                                               0,
                                               NULL,
                                               "The transform from object space to world space."};
const struct param_spec load_shape_flip_normals = {
    "flip_normals",
    PARAM_BOOLEAN,
    "false",
    0,
    0,
    NULL,
    "If true, normals are flipped, so that the other side is the front."};
static const struct param_spec silhouette = {"silhouette_sampling_weight",
                                             PARAM_FLOAT,
                                             "1",
                                             0,
                                             0,
                                             NULL,
                                             "It has no effect: Mitsuba uses it for derivatives."};
static const struct param_spec mesh_file = {"filename", PARAM_STRING,    NULL, 0, PARAM_REQUIRED,
                                            NULL,       "The mesh file."};
static const struct param_spec shape_index = {"shape_index",
                                              PARAM_INTEGER,
                                              "0",
                                              RANGE_NOT_NEGATIVE,
                                              0,
                                              NULL,
                                              "The index of the mesh in the file, from 0."};
static const struct param_spec face_normals = {
    "face_normals",
    PARAM_BOOLEAN,
    "false",
    0,
    0,
    NULL,
    "If true, the mesh has facets: its vertex normals are ignored."};
static const struct param_spec smooth_angle = {
    "max_smooth_angle",
    PARAM_FLOAT,
    NULL,
    RANGE_NOT_NEGATIVE,
    0,
    NULL,
    "If given, new vertex normals are computed, which are smooth across edges whose angle is less "
    "than this, in degrees, as in Mitsuba 0.6."};
static const struct param_spec flip_v = {"flip_tex_coords",
                                         PARAM_BOOLEAN,
                                         "true",
                                         0,
                                         0,
                                         NULL,
                                         "If true, texture coordinate v becomes 1 - v."};
static const struct param_spec keep_v = {"flip_tex_coords",
                                         PARAM_BOOLEAN,
                                         "false",
                                         0,
                                         0,
                                         NULL,
                                         "If true, texture coordinate v becomes 1 - v."};
static const struct param_spec colors_srgb = {
    "srgb",
    PARAM_BOOLEAN,
    "true",
    0,
    0,
    NULL,
    "If true, the colours that texture `vertexcolors` shows are sRGB, else linear."};
static const struct param_spec centre = {
    "center", PARAM_POINT, "0 0 0", 0, 0, NULL, "The centre in object space."};
static const struct param_spec radius = {
    "radius",
    PARAM_FLOAT,
    "1",
    RANGE_ANY,
    0,
    NULL,
    "The radius in object space, which is not 0. If it is negative, the inside is the front."};
static const struct param_spec axis_start = {
    "p0", PARAM_POINT, "0 0 0", 0, 0, NULL, "The start of the axis in object space."};
static const struct param_spec axis_end = {
    "p1", PARAM_POINT, "0 0 1", 0, 0, NULL, "The end of the axis in object space."};

typedef const struct param_spec *const param_list[];
static param_list obj_params = {&mesh_file,           &face_normals,
                                &smooth_angle,        &flip_v,
                                &load_shape_to_world, &load_shape_flip_normals,
                                &silhouette,          NULL};
static param_list ply_params = {&mesh_file,
                                &face_normals,
                                &smooth_angle,
                                &keep_v,
                                &colors_srgb,
                                &load_shape_to_world,
                                &load_shape_flip_normals,
                                &silhouette,
                                NULL};
static param_list serialized_params = {&mesh_file,
                                       &shape_index,
                                       &face_normals,
                                       &smooth_angle,
                                       &keep_v,
                                       &load_shape_to_world,
                                       &load_shape_flip_normals,
                                       &silhouette,
                                       NULL};
static param_list flat_params = {&face_normals, &load_shape_to_world, &load_shape_flip_normals,
                                 &silhouette, NULL};
static param_list sphere_params = {
    &centre, &radius, &load_shape_to_world, &load_shape_flip_normals, &silhouette, NULL};
static param_list disk_params = {&load_shape_to_world, &load_shape_flip_normals, &silhouette, NULL};
static param_list cylinder_params = {
    &axis_start, &axis_end, &radius, &load_shape_to_world, &load_shape_flip_normals,
    &silhouette, NULL};

static const struct param_spec curve_file = {"filename",
                                             PARAM_STRING,
                                             NULL,
                                             0,
                                             PARAM_REQUIRED,
                                             NULL,
                                             "The file of curves. Each line `x y z radius` is a "
                                             "control point; blank lines separate curves."};
static param_list curve_params = {&curve_file, &load_shape_to_world, &load_shape_flip_normals,
                                  &silhouette, NULL};

typedef satin_status (*mesh_reader)(const struct load_source *, const struct mesh_request *,
                                    struct mesh *);
typedef satin_status (*mesh_maker)(struct arena *, const struct mesh_request *, struct mesh *);

static struct mesh_request request_of(const struct params *p) {
    return (struct mesh_request){.to_world = load_param(p, "to_world")->m,
                                 .flip_normals = load_param(p, "flip_normals")->b,
                                 .face_normals = load_param(p, "face_normals")->b};
}

static satin_status read_meshes(struct load_state *loader, const struct params *p,
                                struct mesh_request request, mesh_reader read, struct shape *shape,
                                struct mesh *out) {
    request.attributes = loader->wanted;
    request.flip_tex_coords = load_param(p, "flip_tex_coords")->b;
    request.linear_colors = load_params_has(p, "srgb") && !load_param(p, "srgb")->b;
    const struct param_value *angle = load_param(p, "max_smooth_angle");
    if (angle->given && angle->f <= 180.0f) request.smooth_angle = angle->f;
    if (angle->given && (angle->f > 180.0f || request.face_normals))
        return load_refuse(loader, p,
                           angle->f > 180.0f ? "its max_smooth_angle is over 180 degrees"
                                             : "it has both face_normals and max_smooth_angle");
    // At 0 no edge is smooth.
    if (angle->given && !(angle->f > 0.0f)) request.face_normals = true;
    struct load_source source;
    satin_status status = load_file_source(loader, load_param(p, "filename"), &source);
    if (status != SATIN_OK) return status;
    status = read(&source, &request, out);
    free((char *)source.path);
    shape->face_normals = request.face_normals;
    return status;
}

satin_status load_shape_obj(struct load_state *loader, const struct params *p,
                            const struct obj_materials *materials, struct shape *shape,
                            struct mesh *out) {
    struct mesh_request request = request_of(p);
    request.material = materials->name;
    request.material_count = materials->count;
    request.others = materials->others;
    return read_meshes(loader, p, request, load_mesh_obj, shape, out);
}

static satin_status build_obj(struct load_state *loader, const struct params *p, void *object) {
    struct shape *shape = object;
    return load_shape_obj(loader, p, &(struct obj_materials){0}, shape, &shape->mesh);
}

static satin_status build_ply(struct load_state *loader, const struct params *p, void *object) {
    struct shape *shape = object;
    return read_meshes(loader, p, request_of(p), load_mesh_ply, shape, &shape->mesh);
}

static satin_status build_serialized(struct load_state *loader, const struct params *p,
                                     void *object) {
    struct shape *shape = object;
    struct mesh_request request = request_of(p);
    request.shape_index = load_param(p, "shape_index")->i;
    return read_meshes(loader, p, request, load_mesh_serialized, shape, &shape->mesh);
}

static satin_status make_mesh(struct load_state *loader, const struct params *p,
                              struct shape *shape, mesh_maker make) {
    struct mesh_request request = request_of(p);
    shape->face_normals = request.face_normals;
    satin_status status = make(&loader->scene->arena, &request, &shape->mesh);
    if (status == SATIN_ERROR_INPUT) return load_refuse(loader, p, "to_world makes it too large");
    return status == SATIN_ERROR_MEMORY ? load_no_memory(loader) : status;
}

static satin_status build_rectangle(struct load_state *loader, const struct params *p,
                                    void *object) {
    return make_mesh(loader, p, object, load_mesh_rectangle);
}

static satin_status build_cube(struct load_state *loader, const struct params *p, void *object) {
    return make_mesh(loader, p, object, load_mesh_cube);
}

static satin_status transform_shape(struct load_state *loader, const struct params *p,
                                    struct shape *shape, const struct mat4 *m) {
    return scene_shape_transform(shape, m) ? SATIN_OK
                                           : load_refuse(loader, p, "to_world is singular");
}

static satin_status build_sphere(struct load_state *loader, const struct params *p, void *object) {
    struct shape *shape = object;
    float r = load_param(p, "radius")->f;
    struct mat4 scale = mat4_scale(v3(r, r, r));
    struct mat4 translate = mat4_translate(load_param(p, "center")->v);
    struct mat4 m = mat4_mul(&translate, &scale);
    m = mat4_mul(&load_param(p, "to_world")->m, &m);
    shape->kind = SHAPE_SPHERE;
    if (r == 0.0f) return load_refuse(loader, p, "its radius is 0");
    if (!load_transform_similar(&load_param(p, "to_world")->m))
        return load_refuse(loader, p, "to_world stretches or shears it, but it must stay round");
    if (mat4_det3(&load_param(p, "to_world")->m) == 0.0)
        return load_refuse(loader, p, "to_world is singular");
    if (!scene_shape_transform(shape, &m) || !(shape->radius > 0.0f) || !isfinite(shape->radius) ||
        !v3_finite(shape->centre))
        return load_refuse(loader, p, "it is too small or too large");
    return SATIN_OK;
}

static satin_status build_disk(struct load_state *loader, const struct params *p, void *object) {
    struct shape *shape = object;
    shape->kind = SHAPE_DISK;
    return transform_shape(loader, p, shape, &load_param(p, "to_world")->m);
}

static satin_status build_cylinder(struct load_state *loader, const struct params *p,
                                   void *object) {
    struct shape *shape = object;
    vec3 p0 = load_param(p, "p0")->v, axis = v3_sub(load_param(p, "p1")->v, p0);
    float r = load_param(p, "radius")->f, length = v3_len(axis);
    shape->kind = SHAPE_CYLINDER;
    if (r == 0.0f) return load_refuse(loader, p, "its radius is 0");
    if (!(length > 0.0f) || !isfinite(length)) return load_refuse(loader, p, "p0 and p1 coincide");
    struct frame f = frame_from_normal(v3_mul(axis, 1.0f / length));
    struct mat4 axes = {{{f.u.x, f.v.x, f.n.x, p0.x},
                         {f.u.y, f.v.y, f.n.y, p0.y},
                         {f.u.z, f.v.z, f.n.z, p0.z},
                         {0, 0, 0, 1}}};
    struct mat4 scale = mat4_scale(v3(r, r, length));
    struct mat4 m = mat4_mul(&axes, &scale);
    m = mat4_mul(&load_param(p, "to_world")->m, &m);
    return transform_shape(loader, p, shape, &m);
}

static satin_status build_curves(struct load_state *loader, const struct params *p,
                                 struct shape *shape, bool linear) {
    struct load_source source;
    satin_status status = load_file_source(loader, load_param(p, "filename"), &source);
    if (status != SATIN_OK) return status;
    shape->kind = SHAPE_CURVES;
    status = load_curves(&source, &load_param(p, "to_world")->m, linear, &shape->curves);
    free((char *)source.path);
    if (status == SATIN_OK) scene_curves_bound(&shape->curves, &shape->lo, &shape->hi);
    return status;
}

static satin_status build_spline(struct load_state *loader, const struct params *p, void *object) {
    return build_curves(loader, p, object, false);
}

static satin_status build_line(struct load_state *loader, const struct params *p, void *object) {
    return build_curves(loader, p, object, true);
}

const struct plugin_spec load_shape_plugins[] = {
    {XML_SHAPE, "obj", "a Wavefront OBJ mesh, with a BRDF or one for each of its materials",
     obj_params, SHAPE_CHILDREN, build_obj, false},
    {XML_SHAPE, "ply", "a PLY mesh, text or binary", ply_params, SHAPE_CHILDREN, build_ply, false},
    {XML_SHAPE, "serialized", "a mesh in Mitsuba's binary format", serialized_params,
     SHAPE_CHILDREN, build_serialized, false},
    {XML_SHAPE, "rectangle", "[-1, 1]^2 in the xy plane, facing +z", flat_params, SHAPE_CHILDREN,
     build_rectangle, false},
    {XML_SHAPE, "cube", "[-1, 1]^3", flat_params, SHAPE_CHILDREN, build_cube, false},
    {XML_SHAPE, "sphere", "a sphere, which to_world may not stretch or shear", sphere_params,
     SHAPE_CHILDREN, build_sphere, false},
    {XML_SHAPE, "disk", "the unit disk in the xy plane, facing +z", disk_params, SHAPE_CHILDREN,
     build_disk, false},
    {XML_SHAPE, "cylinder", "an open cylinder, facing outside", cylinder_params, SHAPE_CHILDREN,
     build_cylinder, false},
    {XML_SHAPE, "bsplinecurve", "round tubes along cubic B-splines", curve_params, SHAPE_CHILDREN,
     build_spline, false},
    {XML_SHAPE, "linearcurve", "round tubes along straight segments", curve_params, SHAPE_CHILDREN,
     build_line, false},
    {0}};
