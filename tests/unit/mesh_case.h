// SPDX-License-Identifier: Apache-2.0
// For tests of the mesh readers: bytes written to a file of the test's folder, and read.
#ifndef MESH_CASE_H
#define MESH_CASE_H

#include "load/load_build.h"
#include "scene_case.h"

typedef satin_status (*mesh_reader)(const struct load_source *, const struct mesh_request *,
                                    struct mesh *);

struct mesh_case {
    struct scene_case log;
    struct arena arena;
    uint64_t hash;
    struct mesh mesh;
};

static inline struct mesh_request mesh_case_plain(void) {
    return (struct mesh_request){.to_world = mat4_identity()};
}

static inline satin_status mesh_case_read(struct mesh_case *c, mesh_reader read,
                                          struct mesh_request request, const void *data,
                                          size_t size) {
    *c = (struct mesh_case){.hash = 1};
    struct log log = scene_case_begin(&c->log);
    scene_case_bytes("mesh", data, size);
    struct load_source source = {log, {"scene.xml", 3, 7}, &c->arena, "mesh", &c->hash};
    satin_status status = read(&source, &request, &c->mesh);
    assert_int_equal(c->log.errors, status == SATIN_OK ? 0 : 1);
    return status;
}

// Reads an invalid file: SATIN_ERROR_INPUT and a message that begins with `expected`.
static inline void mesh_case_refuse(mesh_reader read, const void *data, size_t size,
                                    const char *expected) {
    struct mesh_case c;
    assert_int_equal(mesh_case_read(&c, read, mesh_case_plain(), data, size), SATIN_ERROR_INPUT);
    if (strncmp(c.log.error, expected, strlen(expected)) != 0)
        assert_string_equal(c.log.error, expected);
    // The memory that a reader may take before it fails is in proportion to the file.
    assert_true(c.arena.bytes <= 64 * size + 4096);
    arena_free(&c.arena);
}

static inline void mesh_case_free(struct mesh_case *c) { arena_free(&c->arena); }

static inline vec3 mesh_case_vertex(const float *values, uint32_t i) {
    return v3(values[i * 3], values[i * 3 + 1], values[i * 3 + 2]);
}

static inline void assert_near3(vec3 a, vec3 b, float tolerance) {
    if (v3_max_abs(v3_sub(a, b)) <= tolerance) return;
    print_error("(%g %g %g) is not (%g %g %g)\n", a.x, a.y, a.z, b.x, b.y, b.z);
    fail();
}

#endif
