// SPDX-License-Identifier: Apache-2.0
// Passes shapes to Embree: triangle meshes as shared arrays; spheres, disks and cylinders as one
// user geometry on scene_quadric.c; instances as Embree's own. Traversal is ROBUST, so that no ray
// passes between two triangles of a shared edge.
#include "scene/scene_accel.h"

#include <stdlib.h>

#include "base/array.h"
#include "scene/scene_coincide.h"
#include "scene/scene_opacity.h"

// ---- Callbacks ----------------------------------------------------------------------------------

// A hit is accepted if both ends of the ray are farther from its plane than Embree's rounding. A
// nearer hit is tested again in double.
static bool guard_accepts(const struct guard *guard, const struct RTCRay *ray,
                          const struct RTCHit *hit, float end) {
    vec3 n = v3(hit->Ng_x, hit->Ng_y, hit->Ng_z), d = v3(ray->dir_x, ray->dir_y, ray->dir_z);
    double t = ray->tfar, distance = fabs(fmin(t, end - t) * v3_dot(n, d));  // times |n|
    if (distance > guard->error.most) return true;
    double n2 = v3_len2(n), by_area = guard->error.by_area;
    if (distance * distance > by_area * by_area * n2 * sqrt(n2)) return true;
    return scene_interaction_crosses(guard->mesh, hit->primID,
                                     v3(ray->org_x, ray->org_y, ray->org_z), d, ray->tnear, end);
}

static vec3 ray_origin(const struct RTCRay *ray) { return v3(ray->org_x, ray->org_y, ray->org_z); }
static vec3 direction_of(const struct RTCRay *ray) {
    return v3(ray->dir_x, ray->dir_y, ray->dir_z);
}

static bool mask_stops(const struct guard *guard, const struct RTCRay *ray,
                       const struct RTCHit *hit) {
    const struct mesh *mesh = guard->mesh;
    const vec2 bary = {hit->u, hit->v};
    const struct texture_lookup at = {scene_mesh_uv(mesh, hit->primID, bary), mesh, hit->primID,
                                      bary, 0.0f};
    struct ray same = {.o = ray_origin(ray), .d = direction_of(ray)};
    return scene_opacity_stops(guard->mask, &at, &same, hit->primID, ray->id != 0);
}

static void mesh_hit(const struct RTCFilterFunctionNArguments *args, float end) {
    const struct guard *guard = args->geometryUserPtr;
    const struct RTCRay *ray = (const struct RTCRay *)args->ray;
    const struct RTCHit *hit = (const struct RTCHit *)args->hit;
    if (!guard_accepts(guard, ray, hit, end) || (guard->mask && !mask_stops(guard, ray, hit)))
        args->valid[0] = 0;
}

static void mesh_any(const struct RTCFilterFunctionNArguments *args) {
    mesh_hit(args, ((const struct embree_occlusion *)args->context)->end);
}

static void mesh_nearest(const struct RTCFilterFunctionNArguments *args) {
    // The surface interaction will read the corners: prefetches their indices during the traversal.
    const struct guard *guard = args->geometryUserPtr;
    __builtin_prefetch(guard->mesh->index + (size_t)((const struct RTCHit *)args->hit)->primID * 3);
    mesh_hit(args, INFINITY);
}

// Rays hit curves from outside only, as in Mitsuba: a ray passes through an open end.
static void curve_any(const struct RTCFilterFunctionNArguments *args) {
    const struct RTCRay *ray = (const struct RTCRay *)args->ray;
    const struct RTCHit *hit = (const struct RTCHit *)args->hit;
    vec3 n = v3(hit->Ng_x, hit->Ng_y, hit->Ng_z), d = v3(ray->dir_x, ray->dir_y, ray->dir_z);
    if (v3_dot(n, d) > 0.0f) args->valid[0] = 0;
}

static void quadric_box(const struct RTCBoundsFunctionArguments *args) {
    const struct accel *accel = args->geometryUserPtr;
    vec3 lo, hi;
    scene_quadric_bounds(&accel->quadric[args->primID], &lo, &hi);
    args->bounds_o->lower_x = lo.x;
    args->bounds_o->lower_y = lo.y;
    args->bounds_o->lower_z = lo.z;
    args->bounds_o->upper_x = hi.x;
    args->bounds_o->upper_y = hi.y;
    args->bounds_o->upper_z = hi.z;
}

static bool quadric_hit(const struct quadric *q, const struct RTCRay *ray, float *t) {
    const vec3 o = ray_origin(ray), d = direction_of(ray);
    float near = ray->tnear;
    for (int crossing = 0; crossing < 2; crossing++) {
        if (!scene_quadric_intersect(q, o, d, near, ray->tfar, t)) return false;
        if (!q->mask) return true;
        struct interaction s;
        struct ray same = {.o = o, .d = d};
        scene_quadric_interaction(q, &same, *t, false, &s);
        struct texture_lookup at = scene_texture_at(s.uv);
        if (scene_opacity_stops(q->mask, &at, &same, q->shape + (uint32_t)crossing, ray->id != 0))
            return true;
        near = nextafterf(*t, INFINITY);  // t was rounded
    }
    return false;
}

static void quadric_nearest(const struct RTCIntersectFunctionNArguments *args) {
    const struct accel *accel = args->geometryUserPtr;
    struct RTCRayHit *ray_hit = (struct RTCRayHit *)args->rayhit;
    float t;
    if (!args->valid[0] || !quadric_hit(&accel->quadric[args->primID], &ray_hit->ray, &t)) return;
    ray_hit->ray.tfar = t;
    ray_hit->hit.primID = args->primID;
    ray_hit->hit.geomID = accel->quadric_id;
    ray_hit->hit.instID[0] = args->context->instID[0];
}

static void quadric_any(const struct RTCOccludedFunctionNArguments *args) {
    const struct accel *accel = args->geometryUserPtr;
    struct RTCRay *ray = (struct RTCRay *)args->ray;
    float t;
    if (args->valid[0] && quadric_hit(&accel->quadric[args->primID], ray, &t))
        ray->tfar = -INFINITY;
}

// ---- Building -----------------------------------------------------------------------------------

satin_status scene_accel_status(RTCDevice device, struct log log) {
    switch (rtcGetDeviceError(device)) {
        case RTC_ERROR_NONE:
            return SATIN_OK;
        case RTC_ERROR_OUT_OF_MEMORY:
            return log_fail(log, SATIN_ERROR_MEMORY,
                            "not enough memory for the ray tracing structure");
        default:
            return log_fail(log, SATIN_ERROR_INTERNAL,
                            "Embree could not build the ray tracing structure");
    }
}

static void attach(struct accel *accel, RTCGeometry geometry, uint32_t id) {
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(accel->scene, geometry, id);
    rtcReleaseGeometry(geometry);
}

static void attach_mesh(RTCDevice device, struct accel *accel, const struct mesh *mesh,
                        const struct material *mask, uint32_t id) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    if (!geometry) return;
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               mesh->position, 0, 3 * sizeof(float), mesh->vertex_count);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh->index, 0,
                               3 * sizeof(uint32_t), mesh->triangle_count);
    accel->guard[id] = (struct guard){mesh, mask, scene_interaction_error(mesh)};
    rtcSetGeometryUserData(geometry, &accel->guard[id]);
    rtcSetGeometryIntersectFilterFunction(geometry, mesh_nearest);
    rtcSetGeometryOccludedFilterFunction(geometry, mesh_any);
    attach(accel, geometry, id);
}

static void attach_curves(RTCDevice device, struct accel *accel, const struct curves *curves,
                          uint32_t id) {
    RTCGeometry geometry =
        rtcNewGeometry(device, curves->linear ? RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE
                                              : RTC_GEOMETRY_TYPE_ROUND_BSPLINE_CURVE);
    if (!geometry) return;
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4,
                               curves->point, 0, 4 * sizeof(float), curves->points);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, curves->first,
                               0, sizeof(uint32_t), curves->segments);
    if (curves->linear)
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_FLAGS, 0, RTC_FORMAT_UCHAR,
                                   curves->flags, 0, 1, curves->segments);
    rtcSetGeometryIntersectFilterFunction(geometry, curve_any);
    rtcSetGeometryOccludedFilterFunction(geometry, curve_any);
    attach(accel, geometry, id);
}

static void attach_quadrics(RTCDevice device, struct accel *accel) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    if (!geometry) return;
    rtcSetGeometryUserPrimitiveCount(geometry, accel->quadric_count);
    rtcSetGeometryUserData(geometry, accel);
    rtcSetGeometryBoundsFunction(geometry, quadric_box, NULL);
    rtcSetGeometryIntersectFunction(geometry, quadric_nearest);
    rtcSetGeometryOccludedFunction(geometry, quadric_any);
    attach(accel, geometry, accel->quadric_id);
}

static void attach_instance(RTCDevice device, struct accel *accel, const struct shape *shape,
                            const struct accel *group, uint32_t id) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    if (!geometry) return;
    rtcSetGeometryInstancedScene(geometry, group->scene);
    // The matrix without its last row.
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, shape->to_world.m);
    attach(accel, geometry, id);
}

// Finds the shapes that are left out because they coincide with others. The caller frees the
// result; NULL if there is no memory.
static bool *find_hidden(const struct satin_scene *scene, struct accel_shapes shapes,
                         struct accel *accel) {
    const uint32_t first = shapes.first, count = shapes.count;
    bool *hidden = array_new((size_t)count + 1, sizeof *hidden);
    uint32_t found = 0;
    if (hidden && scene_coincide_find(scene, first, count, shapes.group, hidden, &found))
        accel->hidden = array_new((size_t)found + 1, sizeof *accel->hidden);
    if (!accel->hidden) {
        free(hidden);
        return NULL;
    }
    for (uint32_t i = 0; i < count; i++)
        if (hidden[i]) accel->hidden[accel->hidden_count++] = first + i;
    return hidden;
}

// Sorts the shapes that are not hidden into geometries: meshes and curves first, then all quadrics,
// then instances.
static satin_status sort_shapes(const struct satin_scene *scene, struct accel_shapes shapes,
                                const bool *hidden, struct log log, struct accel *accel) {
    const uint32_t first = shapes.first, end = first + shapes.count, group = shapes.group;
    uint32_t n = 0;
    for (uint32_t i = first; i < end; i++) {
        const struct shape *shape = &scene->shape[i];
        if (shape->group != group || shape->kind == SHAPE_INSTANCE || hidden[i - first]) continue;
        if (shape->kind == SHAPE_MESH) {
            if (shape->mesh.triangle_count) accel->geometry_shape[n++] = i;
        } else if (shape->kind == SHAPE_CURVES) {
            accel->geometry_shape[n++] = i;
        } else if (scene_quadric_make(shape, i, &accel->quadric[accel->quadric_count])) {
            accel->quadric[accel->quadric_count++].mask = scene_opacity_of(scene, shape);
        } else {
            return log_fail(log, SATIN_ERROR_INPUT, "shape '%s' has a degenerate transform",
                            shape->name ? shape->name : "?");
        }
    }
    accel->quadric_id = n++;
    for (uint32_t i = first; i < end; i++) {
        const struct shape *shape = &scene->shape[i];
        if (shape->group == group && shape->kind == SHAPE_INSTANCE && !hidden[i - first])
            accel->geometry_shape[n++] = i;
    }
    accel->geometry_count = n;
    return SATIN_OK;
}

static satin_status attach_all(const struct satin_scene *scene, struct accel_shapes shapes,
                               struct log log, struct accel *accel) {
    const uint32_t count = shapes.count;
    accel->geometry_shape = array_new((size_t)count + 1, sizeof *accel->geometry_shape);
    accel->guard = array_new((size_t)count + 1, sizeof *accel->guard);
    accel->quadric = array_new(count, sizeof *accel->quadric);
    bool *hidden = find_hidden(scene, shapes, accel);
    if (!accel->geometry_shape || !accel->guard || !accel->quadric || !hidden) {
        free(hidden);
        return log_fail(log, SATIN_ERROR_MEMORY, "not enough memory for %u shapes", count);
    }
    satin_status status = sort_shapes(scene, shapes, hidden, log, accel);
    free(hidden);
    return status;
}

satin_status scene_accel_build(RTCDevice device, const struct satin_scene *scene,
                               struct accel_shapes shapes, const struct accel *groups,
                               struct log log, struct accel *accel) {
    satin_status status = attach_all(scene, shapes, log, accel);
    if (status != SATIN_OK) return status;
    accel->scene = rtcNewScene(device);
    if (!accel->scene) return scene_accel_status(device, log);
    rtcSetSceneBuildQuality(accel->scene, RTC_BUILD_QUALITY_MEDIUM);
    rtcSetSceneFlags(accel->scene, RTC_SCENE_FLAG_ROBUST);
    for (uint32_t id = 0; id < accel->geometry_count; id++) {
        if (id == accel->quadric_id) continue;
        const struct shape *shape = &scene->shape[accel->geometry_shape[id]];
        if (shape->kind == SHAPE_CURVES)
            attach_curves(device, accel, &shape->curves, id);
        else if (id < accel->quadric_id)
            attach_mesh(device, accel, &shape->mesh, scene_opacity_of(scene, shape), id);
        else
            attach_instance(device, accel, shape, &groups[shape->instance_of], id);
    }
    if (accel->quadric_count) attach_quadrics(device, accel);
    status = scene_accel_status(device, log);
    if (status != SATIN_OK) return status;
    rtcCommitScene(accel->scene);
    return scene_accel_status(device, log);
}

void scene_accel_free(struct accel *accel) {
    if (accel->scene) rtcReleaseScene(accel->scene);
    free(accel->geometry_shape);
    free(accel->guard);
    free(accel->quadric);
    free(accel->hidden);
}
