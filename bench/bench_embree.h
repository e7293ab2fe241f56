// SPDX-License-Identifier: Apache-2.0
// Meshes and rays as plain Embree has them, for comparison with satin's own.
#ifndef BENCH_EMBREE_H
#define BENCH_EMBREE_H

#include <math.h>

#include "scene/scene.h"
#include "scene/scene_embree.h"

// Three floats per vertex, padded as Embree wants them, and three indices per triangle; both must
// outlive the scene.
struct bare_mesh {
    const float *position;
    const uint32_t *index;
    uint32_t vertices, triangles;
};

static inline RTCScene bare_build(RTCDevice device, const struct bare_mesh *mesh) {
    RTCScene scene = rtcNewScene(device);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               mesh->position, 0, 12, mesh->vertices);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh->index, 0,
                               12, mesh->triangles);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcCommitScene(scene);
    return scene;
}

// A ray as Embree has it.
static inline struct RTCRayHit bare_ray(const struct ray *ray) {
    return (struct RTCRayHit){.ray = {.org_x = ray->o.x,
                                      .org_y = ray->o.y,
                                      .org_z = ray->o.z,
                                      .dir_x = ray->d.x,
                                      .dir_y = ray->d.y,
                                      .dir_z = ray->d.z,
                                      .tfar = INFINITY,
                                      .mask = ~0u},
                              .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
}

#endif
