// SPDX-License-Identifier: Apache-2.0
// Ray tracing on Embree, which only this file and scene_accel.c use: the scene as an acceleration
// structure, groups of shapes as structures below it, and the queries. Hits become surface
// interactions in scene_interaction.c, scene_quadric.c and, for instances, scene_instance.c.
#include <float.h>
#include <stdlib.h>

#include "base/array.h"
#include "scene/scene_accel.h"
#include "scene/scene_curve.h"
#include "scene/scene_instance.h"

struct trace {
    RTCDevice device;
    struct accel top;
    struct accel *group;
    uint32_t group_count;
};

// ---- Building -----------------------------------------------------------------------------------

static bool bounds_of(const struct accel *accel, vec3 *lo, vec3 *hi) {
    struct RTCBounds box;
    rtcGetSceneBounds(accel->scene, &box);
    *lo = v3(box.lower_x, box.lower_y, box.lower_z);
    *hi = v3(box.upper_x, box.upper_y, box.upper_z);
    return lo->x <= hi->x && lo->y <= hi->y && lo->z <= hi->z;
}

static satin_status build_structures(struct trace *trace, struct satin_scene *scene,
                                     struct log log) {
    trace->group = array_new(scene->group_count, sizeof *trace->group);
    if (!trace->group)
        return log_fail(log, SATIN_ERROR_MEMORY, "not enough memory for the ray tracing structure");
    // Built by all cores: trees built by 1, 2 and 8 threads gave the same hits where several
    // triangles tie.
    trace->device = rtcNewDevice(NULL);
    if (!trace->device) return scene_accel_status(NULL, log);
    trace->group_count = scene->group_count;
    for (uint32_t g = 0; g < scene->group_count; g++) {
        const struct shape_group *group = &scene->group[g];
        const struct accel_shapes shapes = {group->first, group->count, g + 1};
        satin_status status =
            scene_accel_build(trace->device, scene, shapes, NULL, log, &trace->group[g]);
        if (status != SATIN_OK) return status;
    }
    for (uint32_t i = 0; i < scene->shape_count; i++) {
        struct shape *shape = &scene->shape[i];
        vec3 lo, hi;
        if (shape->kind != SHAPE_INSTANCE) continue;
        if (!bounds_of(&trace->group[shape->instance_of], &lo, &hi)) lo = hi = v3(0, 0, 0);
        scene_instance_bound(shape, lo, hi);
    }
    const struct accel_shapes top = {0, scene->shape_count, 0};
    return scene_accel_build(trace->device, scene, top, trace->group, log, &trace->top);
}

static satin_status build_trace(struct trace *trace, struct satin_scene *scene, struct log log) {
    const struct stats_span begin = stats_span_begin();
    const satin_status status = build_structures(trace, scene, log);
    scene->bvh_span = stats_span_since(begin);
    return status;
}

static void set_bounds(struct satin_scene *scene, const struct trace *trace) {
    vec3 lo, hi;
    bool empty = !bounds_of(&trace->top, &lo, &hi);
    scene->bounds_lo = empty ? v3(0, 0, 0) : lo;
    scene->bounds_hi = empty ? v3(0, 0, 0) : hi;
    float radius = 0.5f * v3_len(v3_sub(scene->bounds_hi, scene->bounds_lo));
    scene->radius = radius > 0.0f ? radius : 1.0f;
    scene->epsilon = 0x1p-20f * scene->radius;
    scene->triangle_count = 0;
    for (uint32_t i = 0; i < scene->shape_count; i++) {
        const struct shape *shape = &scene->shape[i];
        if (shape->kind == SHAPE_MESH) scene->triangle_count += shape->mesh.triangle_count;
        if (shape->kind == SHAPE_INSTANCE) scene->epsilon = fmaxf(scene->epsilon, shape->radius);
    }
}

// A lamp that no ray meets is none (light.c).
static void darken_hidden(struct satin_scene *scene, const struct accel *accel) {
    for (uint32_t i = 0; i < accel->hidden_count; i++) scene->shape[accel->hidden[i]].light = -1;
}

// Coincident shapes are usually a mistake in the scene: only the first of them is visible.
static void warn_of_hidden(const struct satin_scene *scene, const struct trace *trace,
                           struct log log) {
    uint32_t hidden = trace->top.hidden_count;
    uint32_t first = hidden ? trace->top.hidden[0] : UINT32_MAX;
    for (uint32_t g = 0; g < trace->group_count; g++) {
        const struct accel *accel = &trace->group[g];
        hidden += accel->hidden_count;
        if (accel->hidden_count && accel->hidden[0] < first) first = accel->hidden[0];
    }
    if (!hidden) return;
    const char *name = scene->shape[first].name;
    log_message(log, SATIN_LOG_WARNING,
                "%u of %u shapes lie exactly where earlier ones do, which hide them; the first is "
                "shape %u, '%s'",
                hidden, scene->shape_count, first + 1, name ? name : "?");
}

// Rays start 8 ulps of a coordinate off surfaces (scene_interaction.h). Where this is more than a
// thousandth of the scene, shadows and corners move visibly: by 1 % of a block of 8 x 8 pixels.
#define ORIGIN_OFFSET (8.0f * 0x1p-24f)
#define ORIGIN_FRACTION 1e-3f
// Densities of paths have products of two squared distances, and those of lights cubes of the size.
// Those of a hundredth of the least size, and of the largest size, are in the range of float.
#define SCENE_EXTENT_MIN 3.3e-8f  // (1.2e-38)^(1/4) * 100
#define SCENE_EXTENT_MAX 7e12f    // (3.4e38)^(1/3)

// Warns if the scene lies where single precision is too coarse for it.
static void warn_of_precision(const struct satin_scene *scene, struct log log) {
    const float far = fmaxf(v3_max_abs(scene->bounds_lo), v3_max_abs(scene->bounds_hi)),
                extent = v3_len(v3_sub(scene->bounds_hi, scene->bounds_lo)),
                lost = ORIGIN_OFFSET * far;
    if (!(extent > 0.0f)) return;
    if (lost > ORIGIN_FRACTION * extent)
        log_message(log, SATIN_LOG_WARNING,
                    "the scene is %.3g units large and lies %.3g units from the origin, where "
                    "single precision loses details below %.2g units: move it to the origin",
                    (double)extent, (double)far, (double)lost);
    if (extent < SCENE_EXTENT_MIN || extent > SCENE_EXTENT_MAX)
        log_message(log, SATIN_LOG_WARNING,
                    "the scene is %.3g units large, but light is only accurate in single precision "
                    "between %.2g and %.2g: scale it",
                    (double)extent, (double)SCENE_EXTENT_MIN, (double)SCENE_EXTENT_MAX);
}

satin_status scene_trace_build(struct satin_scene *scene, struct log log) {
    struct trace *trace = calloc(1, sizeof *trace);
    if (!trace)
        return log_fail(log, SATIN_ERROR_MEMORY, "not enough memory for the ray tracing structure");
    satin_status status = build_trace(trace, scene, log);
    if (status != SATIN_OK) {
        scene_trace_free(trace);
        return status;
    }
    set_bounds(scene, trace);
    darken_hidden(scene, &trace->top);
    for (uint32_t g = 0; g < trace->group_count; g++) darken_hidden(scene, &trace->group[g]);
    warn_of_hidden(scene, trace, log);
    warn_of_precision(scene, log);
    scene->trace = trace;
    return SATIN_OK;
}

void scene_trace_free(struct trace *trace) {
    if (!trace) return;
    scene_accel_free(&trace->top);
    for (uint32_t g = 0; g < trace->group_count; g++) scene_accel_free(&trace->group[g]);
    if (trace->device) rtcReleaseDevice(trace->device);
    free(trace->group);
    free(trace);
}

// ---- Queries ------------------------------------------------------------------------------------

// Copies the ray for Embree. False if the ray cannot hit anything; comparisons are false for NaN.
static bool ray_load(const struct ray *ray, struct RTCRay *out) {
    float origin = fabsf(ray->o.x) + fabsf(ray->o.y) + fabsf(ray->o.z);
    float length = fabsf(ray->d.x) + fabsf(ray->d.y) + fabsf(ray->d.z);
    if (!(origin < SCENE_COORDINATE_MAX && length < SCENE_COORDINATE_MAX && length > 0.0f))
        return false;
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

static void interaction_of_curve(const struct shape *shape, const struct RTCRayHit *hit,
                                 const struct ray *ray, bool tangent, struct interaction *out) {
    struct curve_hit at = {.segment = hit->hit.primID,
                           .u = hit->hit.u,
                           .p = v3_mad(ray->o, hit->ray.tfar, ray->d),
                           .n = v3(hit->hit.Ng_x, hit->hit.Ng_y, hit->hit.Ng_z),
                           .flip = shape->flip_normals};
    scene_curve_interaction(&shape->curves, &at, tangent, out);
}

// Fills a surface interaction except t; ray and result are in the accel's own space.
static void interaction_of(const struct satin_scene *scene, const struct accel *accel,
                           const struct RTCRayHit *hit, const struct ray *ray, float margin,
                           struct interaction *out) {
    bool quadric = hit->hit.geomID == accel->quadric_id;
    uint32_t index =
        quadric ? accel->quadric[hit->hit.primID].shape : accel->geometry_shape[hit->hit.geomID];
    const struct shape *shape = &scene->shape[index];
    bool tangent = scene->material[shape->material].tangent;
    bool rate = scene->material[shape->material].filtered;
    bool partials = tangent || scene->hints.aovs.partials;
    struct interaction_hit at = {hit->hit.primID, hit->hit.u, hit->hit.v, tangent,
                                 partials,        rate,       margin};
    if (quadric)
        scene_quadric_interaction(&accel->quadric[hit->hit.primID], ray, hit->ray.tfar, tangent,
                                  out);
    else if (shape->kind == SHAPE_CURVES)
        interaction_of_curve(shape, hit, ray, tangent, out);
    else
        scene_interaction_triangle(scene, shape, &at, out);
    if (!rate)
        out->uv_rate = 0.0f;
    else if (shape->kind != SHAPE_MESH)
        out->uv_rate = 1.0f / sqrtf(fmaxf(v3_len(v3_cross(out->dp_du, out->dp_dv)), 1e-20f));
    out->shape = index;
    out->instance = 0;
    out->prim = quadric ? 0 : hit->hit.primID;
    out->material = shape->material;
    out->light = shape->light;
}

// Sets a query for the nearest hit, without one so far. False if the ray cannot hit anything.
static bool query_load(const struct ray *ray, struct RTCRayHit *out) {
    out->hit.geomID = out->hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    return ray_load(ray, &out->ray);
}

// Sets *out to what a query has hit. False if that is nothing.
static bool hit_interaction(const struct satin_scene *scene, const struct ray *ray,
                            const struct RTCRayHit *hit, struct interaction *out) {
    const struct trace *trace = scene->trace;
    if (hit->hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    if (hit->hit.instID[0] == RTC_INVALID_GEOMETRY_ID) {
        interaction_of(scene, &trace->top, hit, ray, 0.0f, out);
    } else {
        const uint32_t instance = trace->top.geometry_shape[hit->hit.instID[0]];
        const struct shape *shape = &scene->shape[instance];
        struct ray local = scene_instance_ray(shape, ray);
        float margin = scene_instance_margin(scene, shape, v3_mad(ray->o, hit->ray.tfar, ray->d));
        interaction_of(scene, &trace->group[shape->instance_of], hit, &local, margin, out);
        bool tangent = scene->material[out->material].tangent;
        scene_instance_to_world(shape, tangent, tangent || scene->hints.aovs.partials, out);
        out->instance = instance + 1;
    }
    out->t = hit->ray.tfar;
    out->footprint = 0.0f;
    return true;
}

bool scene_intersect(const struct satin_scene *scene, const struct ray *ray,
                     struct interaction *out) {
    struct RTCRayHit hit;
    if (!query_load(ray, &hit)) return false;
    scene_embree_intersect(scene->trace->top.scene, &hit);
    return hit_interaction(scene, ray, &hit, out);
}

// Whether a hit is one of a triangle that no instance shows.
static bool is_triangle(const struct satin_scene *scene, const struct RTCRayHit *hit) {
    const struct accel *top = &scene->trace->top;
    if (hit->hit.instID[0] != RTC_INVALID_GEOMETRY_ID || hit->hit.geomID == top->quadric_id)
        return false;
    return scene->shape[top->geometry_shape[hit->hit.geomID]].kind == SHAPE_MESH;
}

bool scene_surface(const struct satin_scene *scene, const struct ray *ray, vec3 *p, vec3 *n) {
    struct RTCRayHit hit;
    if (!query_load(ray, &hit)) return false;
    hit.ray.id = true;  // read by the masks
    scene_embree_intersect(scene->trace->top.scene, &hit);
    if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    if (is_triangle(scene, &hit)) {
        const vec3 ng = v3(hit.hit.Ng_x, hit.hit.Ng_y, hit.hit.Ng_z);
        const float length2 = v3_len2(ng);
        *p = v3_mad(ray->o, hit.ray.tfar, ray->d);
        *n = v3_mul(ng, 1.0f / sqrtf(length2));
        if (length2 > FLT_MIN && length2 < FLT_MAX) return true;
    }
    struct interaction s;
    hit_interaction(scene, ray, &hit, &s);
    *p = s.p;
    *n = s.ng;
    return true;
}

float scene_distance(const struct satin_scene *scene, const struct ray *ray) {
    struct RTCRayHit hit;
    if (!query_load(ray, &hit)) return INFINITY;
    scene_embree_intersect(scene->trace->top.scene, &hit);
    return hit.hit.geomID == RTC_INVALID_GEOMETRY_ID ? INFINITY : hit.ray.tfar;
}

bool scene_occluded(const struct satin_scene *scene, const struct ray *ray) {
    struct RTCRay query;
    return ray_load(ray, &query) && scene_embree_occluded(scene->trace->top.scene, &query);
}
