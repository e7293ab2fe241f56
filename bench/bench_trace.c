// SPDX-License-Identifier: Apache-2.0
// The cost of satin's ray queries compared to plain Embree: nanoseconds per ray of rtcIntersect1
// and rtcOccluded1 on a plain Embree scene, and of scene_distance, scene_occluded and
// scene_intersect on the same mesh of 98 thousand triangles with the same gather rays. Alternating,
// medians.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "base/sampling.h"
#include "bench_embree.h"
#include "bench_timing.h"
#include "load/load_build.h"

enum { ROWS = 157, COLUMNS = 314, RAYS = 200000, ROUNDS = 15 };

// A sphere with bumps, as a mesh with vertex normals.
static void make_grid_mesh(struct mesh *mesh) {
    float *position = array_new((size_t)ROWS * COLUMNS * 3 + 1, sizeof *position);
    float *normal = array_new((size_t)ROWS * COLUMNS * 3, sizeof *normal);
    uint32_t *index = array_new((size_t)(ROWS - 1) * COLUMNS * 6, sizeof *index);
    if (!position || !normal || !index) exit(1);
    uint32_t count = 0;
    for (uint32_t j = 0; j < ROWS; j++)
        for (uint32_t i = 0; i < COLUMNS; i++) {
            float theta = PI_F * ((float)j + 0.5f) / ROWS;
            float phi = 2.0f * PI_F * (float)i / COLUMNS;
            vec3 n = v3(sinf(theta) * cosf(phi), sinf(theta) * sinf(phi), cosf(theta));
            vec3 p = v3_mul(n, 1.0f + 0.1f * sinf(9.0f * theta) * cosf(7.0f * phi));
            size_t at = ((size_t)j * COLUMNS + i) * 3;
            memcpy(position + at, &p, sizeof p);
            memcpy(normal + at, &n, sizeof n);
            if (j + 1 == ROWS) continue;
            uint32_t a = j * COLUMNS + i, b = j * COLUMNS + (i + 1) % COLUMNS;
            const uint32_t quad[6] = {a, a + COLUMNS, b, b, a + COLUMNS, b + COLUMNS};
            memcpy(index + count, quad, sizeof quad);
            count += 6;
        }
    *mesh = (struct mesh){ROWS * COLUMNS, count / 3, position, normal, NULL, index, NULL, 0};
}

// Rays from the inside of the surface over the hemisphere: as final gathering traces them.
static struct ray *make_rays(const struct satin_scene *scene) {
    struct ray *ray = array_new(RAYS, sizeof *ray);
    struct rng rng = rng_make(1, RNG_TEST, 0);
    if (!ray) exit(1);
    for (int i = 0; i < RAYS;) {
        struct ray eye = {v3(0, 0, 0), 0.0f,
                          sample_uniform_sphere(rng_float(&rng), rng_float(&rng)), INFINITY};
        struct interaction s;
        if (!scene_intersect(scene, &eye, &s)) continue;
        struct frame frame = frame_from_normal(v3_neg(s.ng));
        for (int k = 0; k < 100; k++, i++) {
            vec3 d = sample_cosine_hemisphere(rng_float(&rng), rng_float(&rng));
            ray[i] = scene_spawn(scene, s.p, s.ng, frame_to_world(&frame, d));
        }
    }
    return ray;
}

enum query_side { BARE_INTERSECT, DISTANCE, INTERSECT, BARE_OCCLUDED, OCCLUDED, SIDES };

// Nanoseconds per ray; *sum keeps the compiler from removing the work.
static double run_queries(enum query_side side, RTCScene bare, const struct satin_scene *scene,
                          const struct ray *ray, float *sum) {
    double start = now_ns();
    for (int i = 0; i < RAYS; i++) {
        struct interaction s;
        if (side == BARE_INTERSECT) {
            struct RTCRayHit hit = bare_ray(&ray[i]);
            scene_embree_intersect(bare, &hit);
            *sum += hit.ray.tfar;
        } else if (side == DISTANCE) {
            *sum += scene_distance(scene, &ray[i]);
        } else if (side == INTERSECT) {
            if (scene_intersect(scene, &ray[i], &s)) *sum += s.p.x + s.frame.u.x;
        } else if (side == BARE_OCCLUDED) {
            struct RTCRayHit hit = bare_ray(&ray[i]);
            *sum += (float)scene_embree_occluded(bare, &hit.ray);
        } else {
            *sum += (float)scene_occluded(scene, &ray[i]);
        }
    }
    return (now_ns() - start) / RAYS;
}

int main(void) {
    struct shape shape = {.light = -1};
    struct material material = {0};
    struct satin_scene scene = {
        .shape = &shape, .shape_count = 1, .material = &material, .material_count = 1};
    make_grid_mesh(&shape.mesh);
    if (scene_trace_build(&scene, (struct log){0}) != SATIN_OK) return 1;
    const struct mesh *m = &shape.mesh;
    const struct bare_mesh mesh = {m->position, m->index, m->vertex_count, m->triangle_count};
    RTCDevice device = rtcNewDevice(NULL);
    RTCScene bare = bare_build(device, &mesh);
    struct ray *ray = make_rays(&scene);

    double time[SIDES][ROUNDS];
    float sum = 0.0f;
    for (int round = 0; round < ROUNDS; round++)
        for (int side = 0; side < SIDES; side++)
            time[side][round] = run_queries((enum query_side)side, bare, &scene, ray, &sum);
    static const char *const name[] = {"rtcIntersect1", "scene_distance", "scene_intersect",
                                       "rtcOccluded1", "scene_occluded"};
    double typical[SIDES];
    for (int side = 0; side < SIDES; side++) {
        typical[side] = median_time(time[side], ROUNDS);
        int base = side < BARE_OCCLUDED ? BARE_INTERSECT : BARE_OCCLUDED;
        printf("%-16s %7.1f ns   %.3f\n", name[side], typical[side], typical[side] / typical[base]);
    }
    rtcReleaseScene(bare);
    rtcReleaseDevice(device);
    scene_trace_free(scene.trace);
    free((void *)shape.mesh.position);
    free((void *)shape.mesh.normal);
    free((void *)shape.mesh.index);
    free(ray);
    return sum != sum;
}
