// SPDX-License-Identifier: Apache-2.0
// A mesh in a plain Embree scene, for comparison with satin's own.
#ifndef BENCH_EMBREE_H
#define BENCH_EMBREE_H

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

#endif
