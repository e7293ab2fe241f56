// SPDX-License-Identifier: Apache-2.0
// Serialized meshes of both versions and precisions, several in a file, and damaged ones.
#include <zlib.h>

#include "mesh_case.h"

struct mesh_bytes {
    unsigned char byte[8192];
    size_t size;
};

static void load_mesh_serialized_put(struct mesh_bytes *b, const void *data, size_t size) {
    memcpy(b->byte + b->size, data, size);
    b->size += size;
}

static void put_integer(struct mesh_bytes *b, uint64_t value, size_t size) {
    for (size_t i = 0; i < size; i++) b->byte[b->size++] = (unsigned char)(value >> 8 * i);
}

static void put_real(struct mesh_bytes *b, double value, bool wide) {
    float narrow = (float)value;
    if (wide)
        load_mesh_serialized_put(b, &value, sizeof value);
    else
        load_mesh_serialized_put(b, &narrow, sizeof narrow);
}

// The faults of a mesh that is written.
struct load_mesh_serialized_fault {
    uint64_t vertices, triangles;  // declared; 0: the truth
    uint32_t index;                // of the last corner; 0: the truth
    double coordinate;             // of the first vertex
};

// Appends a triangle with normals, uv and colours; z is that of its plane.
static void put_mesh(struct mesh_bytes *file, int version, bool wide, double z,
                     struct load_mesh_serialized_fault fault) {
    struct mesh_bytes raw = {.size = 0};
    put_integer(&raw, (wide ? 0x2000 : 0x1000) | 1 | 2 | 8, 4);
    if (version == 4) load_mesh_serialized_put(&raw, "name", 5);
    put_integer(&raw, fault.vertices ? fault.vertices : 3, 8);
    put_integer(&raw, fault.triangles ? fault.triangles : 1, 8);
    const double position[9] = {fault.coordinate, 0, z, 1, 0, z, 0, 1, z};
    for (int i = 0; i < 9; i++) put_real(&raw, position[i], wide);
    for (int i = 0; i < 9; i++) put_real(&raw, i % 3 == 2, wide);
    for (int i = 0; i < 6; i++) put_real(&raw, 0.125 * i, wide);
    for (int i = 0; i < 9; i++) put_real(&raw, 0.5, wide);
    put_integer(&raw, 0, 4);
    put_integer(&raw, 1, 4);
    put_integer(&raw, fault.index ? fault.index : 2, 4);
    put_integer(file, 0x041C, 2);
    put_integer(file, (uint64_t)version, 2);
    uLongf packed = sizeof file->byte - file->size;
    assert_int_equal(compress(file->byte + file->size, &packed, raw.byte, raw.size), Z_OK);
    file->size += packed;
}

static void put_file(struct mesh_bytes *file, int version, bool wide) {
    size_t start[3];
    *file = (struct mesh_bytes){.size = 0};
    for (int i = 0; i < 3; i++) {
        start[i] = file->size;
        put_mesh(file, version, wide, i, (struct load_mesh_serialized_fault){0});
    }
    for (int i = 0; i < 3; i++) put_integer(file, start[i], version == 4 ? 8 : 4);
    put_integer(file, 3, 4);
}

static satin_status load_mesh_serialized_read_index(struct mesh_case *c,
                                                    const struct mesh_bytes *file, int index) {
    struct mesh_request request = mesh_case_plain();
    request.shape_index = index;
    return mesh_case_read(c, load_mesh_serialized, request, file->byte, file->size);
}

static void versions_and_precisions_are_read(void **state) {
    (void)state;
    for (int version = 3; version <= 4; version++)
        for (int wide = 0; wide < 2; wide++)
            for (int i = 0; i < 3; i++) {
                struct mesh_bytes file;
                struct mesh_case c;
                put_file(&file, version, wide);
                assert_int_equal(load_mesh_serialized_read_index(&c, &file, i), SATIN_OK);
                assert_int_equal(c.mesh.vertex_count, 3);
                assert_int_equal(c.mesh.triangle_count, 1);
                assert_near3(mesh_case_vertex(c.mesh.position, 1), v3(1, 0, (float)i), 0.0f);
                assert_near3(mesh_case_vertex(c.mesh.normal, 2), v3(0, 0, 1), 0.0f);
                assert_float_equal(c.mesh.uv[5], 0.625f, 0.0f);
                const uint32_t index[3] = {0, 1, 2};
                assert_memory_equal(c.mesh.index, index, sizeof index);
                mesh_case_free(&c);
            }
}

static void refuse_index(const struct mesh_bytes *file, int index, const char *message) {
    struct mesh_case c;
    assert_int_equal(load_mesh_serialized_read_index(&c, file, index), SATIN_ERROR_INPUT);
    assert_string_equal(c.log.error, message);
    mesh_case_free(&c);
}

static void a_bad_table_is_refused(void **state) {
    (void)state;
    for (int version = 3; version <= 4; version++) {
        struct mesh_bytes file;
        put_file(&file, version, false);
        refuse_index(&file, 3, "mesh: there is no mesh 3 in it, only 0 to 2");
        refuse_index(&file, -1, "mesh: there is no mesh -1 in it, only 0 to 2");
        file.byte[file.size - 1] = 0x7f;
        refuse_index(&file, 1, "mesh: the table at its end is damaged");
        put_file(&file, version, false);
        file.byte[file.size - 4 - (version == 4 ? 8 : 4)] = 0xff;  // start of mesh 2
        file.byte[file.size - 3 - (version == 4 ? 8 : 4)] = 0xff;
        refuse_index(&file, 2, "mesh: the table at its end is damaged");
        put_file(&file, version, false);
        file.byte[file.size - 4 - (version == 4 ? 8 : 4)] ^= 1;
        refuse_index(&file, 2, "mesh: no mesh starts where its table says");
    }
}

static void refuse_mesh(struct load_mesh_serialized_fault fault, const char *message) {
    struct mesh_bytes file = {.size = 0};
    put_mesh(&file, 4, false, 0.0, fault);
    mesh_case_refuse(load_mesh_serialized, file.byte, file.size, message);
}

static void damaged_serialized_meshes_are_refused(void **state) {
    (void)state;
    struct mesh_bytes file = {.size = 0};
    put_mesh(&file, 4, true, 0.0, (struct load_mesh_serialized_fault){0});
    // The last bytes are zlib's checksum and the end of the block, which are not read.
    for (size_t cut = 0; cut + 8 < file.size; cut++)
        mesh_case_refuse(load_mesh_serialized, file.byte, cut, "mesh: it");
    file.byte[2] = 9;
    mesh_case_refuse(load_mesh_serialized, file.byte, file.size, "mesh: it is not a serialized");
    refuse_mesh((struct load_mesh_serialized_fault){.vertices = 1000000000},
                "mesh: its compressed data is cut short");
    refuse_mesh((struct load_mesh_serialized_fault){.triangles = 4000000000u},
                "mesh: its compressed data is cut");
    refuse_mesh((struct load_mesh_serialized_fault){.vertices = 1ull << 60},
                "mesh: 1152921504606846976 vertices and");
    refuse_mesh((struct load_mesh_serialized_fault){.index = 3},
                "mesh: triangle 0 refers to vertex 3, but there are 3");
    refuse_mesh((struct load_mesh_serialized_fault){.coordinate = NAN},
                "mesh: a number is not finite");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(versions_and_precisions_are_read),
        cmocka_unit_test(a_bad_table_is_refused),
        cmocka_unit_test(damaged_serialized_meshes_are_refused),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
