// SPDX-License-Identifier: Apache-2.0
// PLY: one mesh in text, little-endian and big-endian with every scalar type, and hostile files.
#include "mesh_case.h"

// A body being written in one of the three formats.
struct body {
    char bytes[4096];
    size_t size;
    int format;  // 0 text, 1 little-endian, 2 big-endian
};

static void load_mesh_ply_put(struct body *body, const char *type, double value) {
    if (body->format == 0) {
        body->size += (size_t)sprintf(body->bytes + body->size, "%.9g ", value);
        return;
    }
    union {
        float f;
        double d;
        int64_t i;
        unsigned char byte[8];
    } bits = {.i = (int64_t)value};
    size_t size = strstr(type, "64") || !strcmp(type, "double") ? 8
                  : strstr(type, "8") || strstr(type, "char")   ? 1
                  : strstr(type, "16") || strstr(type, "short") ? 2
                                                                : 4;
    if (!strcmp(type, "float") || !strcmp(type, "float32")) bits.f = (float)value;
    if (!strcmp(type, "double") || !strcmp(type, "float64")) bits.d = value;
    for (size_t k = 0; k < size; k++)
        body->bytes[body->size++] = (char)bits.byte[body->format == 1 ? k : size - 1 - k];
}

// A pyramid's four sides and its base: a quad and triangles, with normals, uv, and properties and
// elements that mean nothing to us, before, between and after.
static void write_pyramid(struct body *body, int format, const char *real, const char *integer,
                          const char *small) {
    static const char *const name[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    *body = (struct body){.format = format};
    body->size = (size_t)sprintf(
        body->bytes,
        "ply\r\nformat %s 1.0\r\ncomment element face 7\r\nobj_info x\r\n"
        "element before 2\nproperty list %s %s junk\nproperty %s other\n"
        "element vertex 5\nproperty %s x\nproperty %s confidence\nproperty %s y\nproperty %s z\n"
        "property %s nx\nproperty %s ny\nproperty %s nz\nproperty %s s\nproperty %s t\n"
        "element face 5\nproperty %s flags\nproperty list %s %s vertex_indices\n"
        "property list uchar float texcoord\n"
        "element after 1\nproperty double last\nend_header\n",
        name[format], small, real, integer, real, small, real, real, real, real, real, real, real,
        integer, small, integer);
    for (int i = 0; i < 2; i++) {
        load_mesh_ply_put(body, small, i + 1);
        for (int k = 0; k <= i; k++) load_mesh_ply_put(body, real, 0.5);
        load_mesh_ply_put(body, integer, 99);
    }
    static const double corner[5][3] = {
        {-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {0, 0, 1.5}};
    for (int i = 0; i < 5; i++) {
        load_mesh_ply_put(body, real, corner[i][0]);
        load_mesh_ply_put(body, small, 3);
        for (int k = 1; k < 3; k++) load_mesh_ply_put(body, real, corner[i][k]);
        for (int k = 0; k < 3; k++) load_mesh_ply_put(body, real, corner[i][k] * 2 - (k == 2));
        load_mesh_ply_put(body, real, 0.25 * i);
        load_mesh_ply_put(body, real, 1.0 - 0.125 * i);
    }
    static const int face[5][5] = {
        {3, 0, 1, 4}, {3, 1, 2, 4}, {3, 2, 3, 4}, {3, 3, 0, 4}, {4, 3, 2, 1, 0}};
    for (int i = 0; i < 5; i++) {
        load_mesh_ply_put(body, integer, 7);
        load_mesh_ply_put(body, small, face[i][0]);
        for (int k = 1; k <= face[i][0]; k++) load_mesh_ply_put(body, integer, face[i][k]);
        load_mesh_ply_put(body, "uchar", i == 2);
        if (i == 2) load_mesh_ply_put(body, "float", 0.5);
        if (format == 0) body->bytes[body->size - 1] = '\n';
    }
    load_mesh_ply_put(body, "double", 0.5);
}

static void every_format_and_type_is_read(void **state) {
    (void)state;
    static const char *const type[][3] = {
        {"float", "int", "uchar"},     {"double", "uint", "char"},   {"float32", "int32", "uint8"},
        {"float64", "uint32", "int8"}, {"float", "short", "ushort"}, {"double", "uint16", "int16"},
        {"float", "uchar", "int"}};
    for (size_t i = 0; i < sizeof type / sizeof *type; i++)
        for (int format = 0; format < 3; format++) {
            struct body body;
            struct mesh_case c;
            write_pyramid(&body, format, type[i][0], type[i][1], type[i][2]);
            assert_int_equal(
                mesh_case_read(&c, load_mesh_ply, mesh_case_plain(), body.bytes, body.size),
                SATIN_OK);
            const struct mesh *m = &c.mesh;
            assert_int_equal(m->vertex_count, 5);
            assert_int_equal(m->triangle_count, 6);
            assert_near3(mesh_case_vertex(m->position, 4), v3(0, 0, 1.5f), 0.0f);
            assert_near3(mesh_case_vertex(m->normal, 4), v3(0, 0, 1), 0.0f);
            assert_float_equal(m->uv[6], 0.75f, 0.0f);
            assert_float_equal(m->uv[7], 0.625f, 0.0f);
            const uint32_t last[6] = {3, 2, 1, 3, 1, 0};
            assert_memory_equal(m->index + 12, last, sizeof last);
            mesh_case_free(&c);
            // A file that is cut anywhere in the body is refused.
            size_t header = (size_t)(strstr(body.bytes, "end_header\n") - body.bytes) + 11;
            for (size_t cut = header; cut + (format ? 1 : 5) < body.size; cut += 3)
                mesh_case_refuse(load_mesh_ply, body.bytes, cut, "mesh:");
        }
}

#define VERTEX "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
#define FACE "element face 1\nproperty list uchar int vertex_index\n"
#define TEXT "ply\nformat ascii 1.0\n"
#define BINARY "ply\nformat binary_little_endian 1.0\n"
#define CORNERS "0 0 0\n1 0 0\n0 1 0\n"

static void wrong_ply_files_are_refused(void **state) {
    (void)state;
    static const struct {
        const char *text, *message;
    } wrong[] = {
        {"", "mesh: it is not a PLY file"},
        {"plyx\n", "mesh: it is not a PLY file"},
        {"ply\n", "mesh: its header has no end_header"},
        {"ply\nend_header\n", "mesh: its header names no format"},
        {"ply\nformat ascii 2.0\nend_header\n", "mesh:2: unknown format"},
        {"ply\nformat text 1.0\nend_header\n", "mesh:2: unknown format"},
        {TEXT "property float x\nend_header\n", "mesh:3: a property before the first element"},
        {TEXT "element vertex -1\nend_header\n", "mesh:3: expected: element NAME COUNT"},
        {TEXT "element vertex 1x\nend_header\n", "mesh:3: expected: element NAME COUNT"},
        {TEXT "element vertex 1\nelement vertex 2\n", "mesh:4: this element was declared before"},
        {TEXT "element vertex 1\nproperty real x\nend_header\n", "mesh:4: unknown type"},
        {TEXT "element face 1\nproperty list float int vertex_index\n", "mesh:4: unknown type"},
        {TEXT "element vertex 1\nproperty float\nend_header\n", "mesh:4: expected: property"},
        {TEXT "what is this\nend_header\n", "mesh:3: unknown word in the header"},
        {TEXT FACE "end_header\n3 0 1 2\n", "mesh: there is no vertex with x, y and z in it"},
        {TEXT VERTEX "end_header\n" CORNERS, "mesh: there is no face with a list of vertices"},
        {TEXT VERTEX FACE "end_header\n" CORNERS "3 0 1 3\n",
         "mesh:13: face 0 refers to vertex 3, but there are 3"},
        {TEXT VERTEX FACE "end_header\n" CORNERS "3 0 -1 2\n", "mesh:13: face 0 refers to vertex"},
        {TEXT VERTEX FACE "end_header\n" CORNERS "999 0 1 2\n", "mesh:13: face 0: its list of"},
        {TEXT VERTEX FACE "end_header\n" CORNERS "2 0 1   \n", "mesh: no face has three corners"},
        {TEXT VERTEX FACE "end_header\n0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n", "mesh:11: vertex 1: a "},
        {TEXT VERTEX FACE "end_header\n0 0 0\n1 1e40 0\n0 1 0\n3 0 1 2\n",
         "mesh:11: vertex 1: a coordinate is not finite"},
        {TEXT
         "element vertex 1000000000\nproperty float x\nproperty float y\nproperty float z\n" FACE
         "end_header\n" CORNERS,
         "mesh: 1000000000 items are declared, but the file"},
        {BINARY "element vertex 99999999999999999999\nproperty float x\nproperty float y\n"
                "property float z\n" FACE "end_header\nabcdefghijkl",
         "mesh: 9"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        mesh_case_refuse(load_mesh_ply, wrong[i].text, strlen(wrong[i].text), wrong[i].message);
}

// Elements without properties take no bytes, so that their count is free: it must not cost time.
static void empty_elements_are_skipped(void **state) {
    (void)state;
    static const char text[] =
        TEXT "element nothing 1000000000000\n" VERTEX FACE "end_header\n" CORNERS "3 0 1 2";
    struct mesh_case c;
    assert_int_equal(mesh_case_read(&c, load_mesh_ply, mesh_case_plain(), text, sizeof text - 1),
                     SATIN_OK);
    assert_int_equal(c.mesh.triangle_count, 1);
    mesh_case_free(&c);
}

static void bad_binary_lists_are_refused(void **state) {
    (void)state;
    char file[512];
    size_t header = (size_t)sprintf(file, "%s",
                                    BINARY VERTEX
                                    "element face 1\nproperty list uint float vertex_index\n"
                                    "end_header\n");
    static const float corner[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    memcpy(file + header, corner, sizeof corner);
    size_t at = header + sizeof corner;
    const uint32_t length[] = {0xffffffffu, 4, 0x80000000u};
    const float index[3] = {0, 1, 2};
    memcpy(file + at + 4, index, sizeof index);
    for (int i = 0; i < 3; i++) {
        memcpy(file + at, &length[i], 4);
        mesh_case_refuse(load_mesh_ply, file, at + 16, "mesh: face 0: its list of vertices");
    }
    const uint32_t three = 3;
    const float bad[] = {NAN, INFINITY, -1.0f, 3.0f, 1e30f};
    memcpy(file + at, &three, 4);
    for (int i = 0; i < 5; i++) {
        memcpy(file + at + 8, &bad[i], 4);
        mesh_case_refuse(load_mesh_ply, file, at + 16, "mesh: face 0 refers to vertex");
    }
    const float nan = NAN;
    memcpy(file + header + 4, &nan, 4);
    mesh_case_refuse(load_mesh_ply, file, at + 16, "mesh: vertex 0: a coordinate is not finite");
}

// Reads a triangle and a quad with the given properties; `names` are the attributes asked for.
static void load_mesh_ply_read_attributes(struct mesh_case *c, const char *vertex, const char *face,
                                          const char *corner, const char *last,
                                          const char *const names[]) {
    char text[2048];
    const char *of_vertex = *vertex ? corner : "";
    int size = snprintf(text, sizeof text,
                        TEXT
                        "element vertex 4\nproperty float x\nproperty float y\n%sproperty "
                        "float z\nelement face 2\n%sproperty list uchar int vertex_index\n"
                        "end_header\n0 0 %s 0\n1 0 %s 0\n1 1 %s 0\n0 1 %s 1\n"
                        "%s 3 0 1 2\n%s 4 0 1 2 3\n",
                        vertex, face, of_vertex, of_vertex, of_vertex, *vertex ? last : "",
                        *face ? corner : "", *face ? last : "");
    struct mesh_request request = mesh_case_plain();
    for (; names[request.attributes.count]; request.attributes.count++)
        request.attributes.name[request.attributes.count] = names[request.attributes.count];
    assert_int_equal(mesh_case_read(c, load_mesh_ply, request, text, (size_t)size), SATIN_OK);
}

// Names and values are those of Mitsuba 3.9.
static void attributes_of_meshes_are_kept(void **state) {
    (void)state;
    static const char *const names[] = {"vertex_color", "vertex_heat", "vertex_tint_color",
                                        "vertex_pair",  "face_color",  "vertex_gone",
                                        "face_tint",    NULL};
    struct mesh_case c;
    load_mesh_ply_read_attributes(
        &c,
        "property uchar blue\nproperty uchar red\nproperty uchar green\n"
        "property ushort heat_x\nproperty float tint_r\nproperty float tint_g\n"
        "property float tint_b\nproperty float pair_x\nproperty float pair_y\n",
        "", "30 10 20 65535 .1 .2 .3 5 6", "33 11 22 0 .4 .5 .6 7 8", names);
    assert_int_equal(c.mesh.attribute_count, 3);
    static const float color[6] = {10, 20, 30, 11, 22, 33},
                       tint[6] = {.1f, .2f, .3f, .4f, .5f, .6f};
    const struct mesh_attribute *a = c.mesh.attribute;
    assert_true(a[0].name == names[0] && a[0].channels == 3 && !a[0].per_triangle);
    assert_memory_equal(a[0].value + 6, color, sizeof color);
    assert_true(a[1].name == names[1] && a[1].channels == 1);
    assert_true(a[1].value[2] == 1.0f && a[1].value[3] == 0.0f);
    assert_true(a[2].name == names[2]);
    assert_memory_equal(a[2].value + 6, tint, sizeof tint);
    mesh_case_free(&c);
    // The quad is two triangles, with its value each.
    load_mesh_ply_read_attributes(
        &c, "",
        "property float r\nproperty float g\nproperty float b\n"
        "property float tint_1\nproperty float tint_2\nproperty float tint_3\n",
        "1 2 3 7 8 9", "4 5 6 10 11 12", names);
    assert_int_equal(c.mesh.attribute_count, 2);
    static const float faces[2][9] = {{1, 2, 3, 4, 5, 6, 4, 5, 6},
                                      {7, 8, 9, 10, 11, 12, 10, 11, 12}};
    for (int i = 0; i < 2; i++) {
        a = &c.mesh.attribute[i];
        assert_true(a->name == names[i ? 6 : 4] && a->channels == 3 && a->per_triangle);
        assert_memory_equal(a->value, faces[i], sizeof faces[i]);
    }
    mesh_case_free(&c);
}

// Names and values are those of Mitsuba 0.6: fractions, decoded from sRGB.
static void colours_of_the_older_version_are_kept(void **state) {
    (void)state;
    static const char *const names[] = {LOAD_VERTEX_COLORS, NULL};
    static const char *const form = "property %s %sred\nproperty %s %sgreen\nproperty %s %sblue\n";
    static const struct {
        const char *type, *before, *values;
        float expected[3];
    } cases[] = {{"uchar", "", "255 51 0", {1.0f, 0.03310477f, 0.0f}},
                 {"float", "diffuse_", "1 .2 .02", {1.0f, 0.03310477f, 0.00154799f}},
                 {"ushort", "", "65535 13107 0", {1.0f, 0.03310477f, 0.0f}}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct mesh_case c;
        char vertex[256];
        snprintf(vertex, sizeof vertex, form, cases[i].type, cases[i].before, cases[i].type,
                 cases[i].before, cases[i].type, cases[i].before);
        load_mesh_ply_read_attributes(&c, vertex, "", cases[i].values, cases[i].values, names);
        assert_int_equal(c.mesh.attribute_count, 1);
        const struct mesh_attribute *a = c.mesh.attribute;
        assert_true(a->name == names[0] && a->channels == 3 && !a->per_triangle);
        for (int k = 0; k < 3; k++)
            assert_float_equal(a->value[9 + k], cases[i].expected[k], 1e-6f);
        mesh_case_free(&c);
    }
    // If the colours are asked for by the names of both versions, only the first are read.
    static const char *const both[] = {"vertex_color", LOAD_VERTEX_COLORS, NULL};
    struct mesh_case c;
    load_mesh_ply_read_attributes(&c,
                                  "property uchar red\nproperty uchar green\nproperty uchar blue\n",
                                  "", "7 8 9", "7 8 9", both);
    assert_int_equal(c.mesh.attribute_count, 1);
    assert_true(c.mesh.attribute[0].name == both[0] && c.mesh.attribute[0].value[1] == 8.0f);
    mesh_case_free(&c);
}

static void negative_values_count_as_0(void **state) {
    (void)state;
    static const char *const names[] = {"vertex_heat", "face_heat", NULL};
    struct mesh_case c;
    load_mesh_ply_read_attributes(&c, "property float heat_x\n", "", "-1", "3", names);
    const float *value = c.mesh.attribute[0].value;
    assert_true(value[0] == 0.0f && value[2] == 0.0f && value[3] == 3.0f);
    assert_string_equal(c.log.warning, "mesh: 3 values of vertex_heat are negative and count as 0");
    mesh_case_free(&c);
    load_mesh_ply_read_attributes(&c, "", "property float heat_x\n", "2", "-7", names);
    value = c.mesh.attribute[0].value;
    assert_true(value[0] == 2.0f && value[1] == 0.0f && value[2] == 0.0f);
    mesh_case_free(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_format_and_type_is_read),
        cmocka_unit_test(wrong_ply_files_are_refused),
        cmocka_unit_test(attributes_of_meshes_are_kept),
        cmocka_unit_test(colours_of_the_older_version_are_kept),
        cmocka_unit_test(negative_values_count_as_0),
        cmocka_unit_test(empty_elements_are_skipped),
        cmocka_unit_test(bad_binary_lists_are_refused),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
