// SPDX-License-Identifier: Apache-2.0
// Any bytes given to the mesh readers. The first one selects: 0 OBJ, 1 PLY, 2 serialized, 3 the
// inflated content of a serialized mesh, which is packed here so that mutations get past zlib, 4
// and 5 splines and linear curves; and 6 normals of an OBJ that are computed again. A valid mesh or
// one logged line, no crash, memory in proportion to the input.
#include "fuzz_case.h"
#include "load/load_build.h"

static void check_mesh(const struct mesh *mesh) {
    for (size_t i = 0; i < (size_t)mesh->triangle_count * 3; i++)
        if (mesh->index[i] >= mesh->vertex_count) abort();
    for (size_t i = 0; i < (size_t)mesh->vertex_count * 3; i++) {
        if (!isfinite(mesh->position[i])) abort();
        if (mesh->normal && !(fabsf(mesh->normal[i]) < 1.001f)) abort();
    }
}

static void check_curves(const struct curves *curves) {
    uint32_t needed = curves->linear ? 2 : 4;
    for (size_t i = 0; i < curves->segments; i++)
        if (curves->first[i] + needed > curves->points) abort();
    for (size_t i = 0; i < (size_t)curves->points * 4; i++)
        if (!isfinite(curves->point[i])) abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (!size) return 0;
    int kind = (*data++ & 7) % 7, lines = 0;
    size--;
    char path[FUZZ_PATH];
    int fd = kind == 3 ? fuzz_file_packed(data, size, path) : fuzz_file(data, size, path);
    struct arena arena = {0};
    struct load_source source = {{fuzz_count, &lines}, {"fuzz.xml", 1, 1}, &arena, path, NULL};
    struct mesh_request request = {.to_world = mat4_identity(), .face_normals = size & 1};
    request.shape_index = kind == 2 && size % 3 == 0;
    if (kind == 6) request.smooth_angle = 40.0f;
    request.face_normals = request.face_normals && kind != 6;
    struct mesh mesh;
    struct curves curves;
    satin_status status = kind == 4 || kind == 5
                              ? load_curves(&source, &request.to_world, kind == 5, &curves)
                          : kind == 0 || kind == 6 ? load_mesh_obj(&source, &request, &mesh)
                          : kind == 1              ? load_mesh_ply(&source, &request, &mesh)
                                                   : load_mesh_serialized(&source, &request, &mesh);
    if (lines != (status != SATIN_OK) || (status && status != SATIN_ERROR_INPUT)) abort();
    if (arena.bytes > (kind == 2 ? 50000 : 100) * size + 1000) abort();
    if (status == SATIN_OK && (kind == 4 || kind == 5)) check_curves(&curves);
    if (status == SATIN_OK && kind != 4 && kind != 5) check_mesh(&mesh);
    arena_free(&arena);
    close(fd);
    return 0;
}
