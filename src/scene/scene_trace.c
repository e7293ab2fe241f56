// SPDX-License-Identifier: Apache-2.0
// Ray tracing: the only file on Embree. Triangle meshes share their arrays with Embree; spheres,
// disks and cylinders are one user geometry over scene_quadric.c; hits become surfels in
// scene_surfel.c. ROBUST traversal, so that no ray passes between two triangles of a shared edge.
#include <float.h>
#include <stdlib.h>

#include "base/array.h"
#include "scene/scene_embree.h"
#include "scene/scene_quadric.h"
#include "scene/scene_surfel.h"

// Embree aborts the process on rays beyond these, so they are looked at first.
static const float COORDINATE_MAX = 1e18f;

// A mesh as its filter sees it.
struct guard {
    const struct mesh *mesh;
    struct surfel_error error;
};

struct trace {
    RTCDevice device;
    RTCScene scene;
    uint32_t mesh_count;     // geometry ids 0 .. mesh_count - 1
    uint32_t *mesh_shape;    // geometry id -> shape
    struct guard *guard;     // geometry id -> its filter's data
    uint32_t quadric_count;  // primitives of geometry mesh_count
    struct quadric *quadric;
};

// ---- Callbacks ----------------------------------------------------------------------------------

// A hit whose plane is farther from the origin than Embree's rounding is real; a nearer one is
// looked at again in double.
static bool guard_accepts(const struct guard *guard, const struct RTCRay *ray,
                          const struct RTCHit *hit) {
    vec3 n = v3(hit->Ng_x, hit->Ng_y, hit->Ng_z), d = v3(ray->dir_x, ray->dir_y, ray->dir_z);
    double distance = fabs((double)ray->tfar * v3_dot(n, d));  // times |n|
    if (distance > guard->error.most) return true;
    double n2 = v3_len2(n), by_area = guard->error.by_area;
    if (distance * distance > by_area * by_area * n2 * sqrt(n2)) return true;
    return surfel_crosses(guard->mesh, hit->primID, v3(ray->org_x, ray->org_y, ray->org_z), d,
                          ray->tnear);
}

static void mesh_any(const struct RTCFilterFunctionNArguments *args) {
    if (!guard_accepts(args->geometryUserPtr, (const struct RTCRay *)args->ray,
                       (const struct RTCHit *)args->hit))
        args->valid[0] = 0;
}

static void mesh_nearest(const struct RTCFilterFunctionNArguments *args) {
    // The surfel will want the corners: their indices come while the traversal goes on.
    const struct guard *guard = args->geometryUserPtr;
    __builtin_prefetch(guard->mesh->index + (size_t)((const struct RTCHit *)args->hit)->primID * 3);
    mesh_any(args);
}

static void quadric_box(const struct RTCBoundsFunctionArguments *args) {
    const struct trace *trace = args->geometryUserPtr;
    float lo[3], hi[3];
    quadric_bounds(&trace->quadric[args->primID], lo, hi);
    args->bounds_o->lower_x = lo[0];
    args->bounds_o->lower_y = lo[1];
    args->bounds_o->lower_z = lo[2];
    args->bounds_o->upper_x = hi[0];
    args->bounds_o->upper_y = hi[1];
    args->bounds_o->upper_z = hi[2];
}

static bool quadric_hit(const struct quadric *q, const struct RTCRay *ray, float *t) {
    return quadric_intersect(q, v3(ray->org_x, ray->org_y, ray->org_z),
                             v3(ray->dir_x, ray->dir_y, ray->dir_z), ray->tnear, ray->tfar, t);
}

static void quadric_nearest(const struct RTCIntersectFunctionNArguments *args) {
    const struct trace *trace = args->geometryUserPtr;
    struct RTCRayHit *ray_hit = (struct RTCRayHit *)args->rayhit;
    float t;
    if (!args->valid[0] || !quadric_hit(&trace->quadric[args->primID], &ray_hit->ray, &t)) return;
    ray_hit->ray.tfar = t;
    ray_hit->hit.primID = args->primID;
    ray_hit->hit.geomID = trace->mesh_count;
}

static void quadric_any(const struct RTCOccludedFunctionNArguments *args) {
    const struct trace *trace = args->geometryUserPtr;
    struct RTCRay *ray = (struct RTCRay *)args->ray;
    float t;
    if (args->valid[0] && quadric_hit(&trace->quadric[args->primID], ray, &t))
        ray->tfar = -INFINITY;
}

// ---- Building -----------------------------------------------------------------------------------

static satin_status embree_status(RTCDevice device, struct log log) {
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

static void attach(struct trace *trace, RTCGeometry geometry, uint32_t id) {
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(trace->scene, geometry, id);
    rtcReleaseGeometry(geometry);
}

static void attach_mesh(struct trace *trace, const struct mesh *mesh, uint32_t id) {
    RTCGeometry geometry = rtcNewGeometry(trace->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    if (!geometry) return;
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               mesh->position, 0, 3 * sizeof(float), mesh->vertex_count);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh->index, 0,
                               3 * sizeof(uint32_t), mesh->triangle_count);
    trace->guard[id] = (struct guard){mesh, surfel_error(mesh)};
    rtcSetGeometryUserData(geometry, &trace->guard[id]);
    rtcSetGeometryIntersectFilterFunction(geometry, mesh_nearest);
    rtcSetGeometryOccludedFilterFunction(geometry, mesh_any);
    attach(trace, geometry, id);
}

static void attach_quadrics(struct trace *trace) {
    RTCGeometry geometry = rtcNewGeometry(trace->device, RTC_GEOMETRY_TYPE_USER);
    if (!geometry) return;
    rtcSetGeometryUserPrimitiveCount(geometry, trace->quadric_count);
    rtcSetGeometryUserData(geometry, trace);
    rtcSetGeometryBoundsFunction(geometry, quadric_box, NULL);
    rtcSetGeometryIntersectFunction(geometry, quadric_nearest);
    rtcSetGeometryOccludedFunction(geometry, quadric_any);
    attach(trace, geometry, trace->mesh_count);
}

// Sorts the shapes into meshes and quadrics.
static satin_status collect(struct trace *trace, const struct satin_scene *scene, struct log log) {
    trace->mesh_shape = array_new(scene->shape_count, sizeof *trace->mesh_shape);
    trace->guard = array_new(scene->shape_count, sizeof *trace->guard);
    trace->quadric = array_new(scene->shape_count, sizeof *trace->quadric);
    if (!trace->mesh_shape || !trace->guard || !trace->quadric)
        return log_fail(log, SATIN_ERROR_MEMORY, "not enough memory for %u shapes",
                        scene->shape_count);
    for (uint32_t i = 0; i < scene->shape_count; i++) {
        const struct shape *shape = &scene->shape[i];
        if (shape->kind == SHAPE_MESH) {
            if (shape->mesh.triangle_count) trace->mesh_shape[trace->mesh_count++] = i;
        } else if (quadric_make(shape, i, &trace->quadric[trace->quadric_count])) {
            trace->quadric_count++;
        } else {
            return log_fail(log, SATIN_ERROR_INPUT, "shape '%s' has a degenerate transform",
                            shape->name ? shape->name : "?");
        }
    }
    return SATIN_OK;
}

static satin_status build(struct trace *trace, const struct satin_scene *scene, struct log log) {
    satin_status status = collect(trace, scene, log);
    if (status != SATIN_OK) return status;
    // On all cores: the trees of 1, 2 and 8 threads answered alike where several triangles tie.
    trace->device = rtcNewDevice(NULL);
    if (!trace->device) return embree_status(NULL, log);
    trace->scene = rtcNewScene(trace->device);
    if (!trace->scene) return embree_status(trace->device, log);
    rtcSetSceneBuildQuality(trace->scene, RTC_BUILD_QUALITY_MEDIUM);
    rtcSetSceneFlags(trace->scene, RTC_SCENE_FLAG_ROBUST);
    for (uint32_t i = 0; i < trace->mesh_count; i++)
        attach_mesh(trace, &scene->shape[trace->mesh_shape[i]].mesh, i);
    if (trace->quadric_count) attach_quadrics(trace);
    status = embree_status(trace->device, log);
    if (status != SATIN_OK) return status;
    rtcCommitScene(trace->scene);
    return embree_status(trace->device, log);
}

static void set_bounds(struct satin_scene *scene, const struct trace *trace) {
    struct RTCBounds box;
    rtcGetSceneBounds(trace->scene, &box);
    vec3 lo = v3(box.lower_x, box.lower_y, box.lower_z);
    vec3 hi = v3(box.upper_x, box.upper_y, box.upper_z);
    bool empty = !(lo.x <= hi.x && lo.y <= hi.y && lo.z <= hi.z);
    scene->bounds_lo = empty ? v3(0, 0, 0) : lo;
    scene->bounds_hi = empty ? v3(0, 0, 0) : hi;
    float radius = 0.5f * v3_len(v3_sub(scene->bounds_hi, scene->bounds_lo));
    scene->radius = radius > 0.0f ? radius : 1.0f;
    scene->triangle_count = 0;
    for (uint32_t i = 0; i < scene->shape_count; i++)
        if (scene->shape[i].kind == SHAPE_MESH)
            scene->triangle_count += scene->shape[i].mesh.triangle_count;
}

satin_status scene_trace_build(struct satin_scene *scene, struct log log) {
    struct trace *trace = calloc(1, sizeof *trace);
    if (!trace)
        return log_fail(log, SATIN_ERROR_MEMORY, "not enough memory for the ray tracing structure");
    satin_status status = build(trace, scene, log);
    if (status != SATIN_OK) {
        scene_trace_free(trace);
        return status;
    }
    set_bounds(scene, trace);
    scene->trace = trace;
    return SATIN_OK;
}

void scene_trace_free(struct trace *trace) {
    if (!trace) return;
    if (trace->scene) rtcReleaseScene(trace->scene);
    if (trace->device) rtcReleaseDevice(trace->device);
    free(trace->mesh_shape);
    free(trace->guard);
    free(trace->quadric);
    free(trace);
}

// ---- Queries ------------------------------------------------------------------------------------

// Copies the ray for Embree; false if it is none that can hit. Comparisons are false for NaN.
static bool ray_load(const struct ray *ray, struct RTCRay *out) {
    float origin = fabsf(ray->o.x) + fabsf(ray->o.y) + fabsf(ray->o.z);
    float length = fabsf(ray->d.x) + fabsf(ray->d.y) + fabsf(ray->d.z);
    if (!(origin < COORDINATE_MAX && length < COORDINATE_MAX && length > 0.0f)) return false;
    if (!(ray->tnear >= 0.0f && ray->tfar > ray->tnear)) return false;
    out->org_x = ray->o.x;
    out->org_y = ray->o.y;
    out->org_z = ray->o.z;
    out->tnear = ray->tnear;
    out->dir_x = ray->d.x;
    out->dir_y = ray->d.y;
    out->dir_z = ray->d.z;
    out->time = 0.0f;
    out->tfar = ray->tfar;
    out->mask = ~0u;
    out->id = 0;
    out->flags = 0;
    return true;
}

bool scene_intersect(const struct satin_scene *scene, const struct ray *ray, struct surfel *out) {
    struct RTCRayHit hit;
    if (!ray_load(ray, &hit.ray)) return false;
    hit.hit.geomID = hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    const struct trace *trace = scene->trace;
    embree_intersect(trace->scene, &hit);
    if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    bool is_mesh = hit.hit.geomID < trace->mesh_count;
    uint32_t index =
        is_mesh ? trace->mesh_shape[hit.hit.geomID] : trace->quadric[hit.hit.primID].shape;
    const struct shape *shape = &scene->shape[index];
    bool tangent = scene->material[shape->material].anisotropic;
    if (is_mesh)
        surfel_triangle(scene, shape, hit.hit.primID, hit.hit.u, hit.hit.v, tangent, out);
    else
        quadric_surfel(&trace->quadric[hit.hit.primID], ray, hit.ray.tfar, tangent, out);
    out->t = hit.ray.tfar;
    out->shape = index;
    out->prim = is_mesh ? hit.hit.primID : 0;
    out->material = shape->material;
    out->light = shape->light;
    return true;
}

float scene_distance(const struct satin_scene *scene, const struct ray *ray) {
    struct RTCRayHit hit;
    if (!ray_load(ray, &hit.ray)) return INFINITY;
    hit.hit.geomID = hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    embree_intersect(scene->trace->scene, &hit);
    return hit.hit.geomID == RTC_INVALID_GEOMETRY_ID ? INFINITY : hit.ray.tfar;
}

bool scene_occluded(const struct satin_scene *scene, const struct ray *ray) {
    struct RTCRay query;
    return ray_load(ray, &query) && embree_occluded(scene->trace->scene, &query);
}
