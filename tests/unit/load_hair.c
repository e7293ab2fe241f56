// SPDX-License-Identifier: Apache-2.0
// Strands of Mitsuba 0.6: both forms of the file, which points become one segment, what a reduction
// leaves, and the place that every error names.
#include "mesh_case.h"

#define HEADER "BINARY_HAIR"

struct hair_case {
    struct scene_case log;
    struct arena arena;
    uint64_t hash;
    struct curves curves;
};

static struct hair_request plain_hair(void) {
    return (struct hair_request){.to_world = mat4_identity(), .radius = 0.5f};
}

static satin_status load_hair_read(struct hair_case *c, struct hair_request request,
                                   const void *data, size_t size) {
    *c = (struct hair_case){.hash = 1};
    struct log log = scene_case_begin(&c->log);
    scene_case_bytes("a.hair", data, size);
    const struct load_source source = {log, {"scene.xml", 3, 7}, &c->arena, "a.hair", &c->hash};
    const satin_status status = load_hair(&source, &request, &c->curves);
    assert_int_equal(c->log.errors, status == SATIN_OK ? 0 : 1);
    assert_true(c->arena.bytes <= 10 * size + 1000);
    return status;
}

static void load_hair_read_text(struct hair_case *c, struct hair_request request,
                                const char *text) {
    if (load_hair_read(c, request, text, strlen(text)) != SATIN_OK) fail_msg("%s", c->log.error);
}

static void check_points(const struct curves *curves, const vec3 *expected, uint32_t count) {
    assert_int_equal(curves->points, count);
    for (uint32_t i = 0; i < count; i++) {
        const float *p = curves->point + 4 * i;
        assert_near3(v3(p[0], p[1], p[2]), expected[i], 1e-6f);
    }
}

// A binary file.
struct strand_file {
    char data[512];
    size_t size;
};

static struct strand_file begin_file(uint32_t vertices) {
    struct strand_file file = {HEADER, sizeof HEADER - 1};
    for (int i = 0; i < 4; i++) file.data[file.size++] = (char)(vertices >> 8 * i & 255);
    return file;
}

static void put_floats(struct strand_file *file, const float *value, size_t count) {
    memcpy(file->data + file->size, value, count * sizeof *value);
    file->size += count * sizeof *value;
}

static const vec3 two_strands[5] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {5, 5, 5}, {5, 5, 6}};

static void check_two_strands(const struct curves *curves) {
    static const uint32_t first[3] = {0, 1, 3};
    static const uint8_t flags[3] = {2, 1, 0};
    check_points(curves, two_strands, 5);
    assert_true(curves->linear && curves->segments == 3);
    assert_memory_equal(curves->first, first, sizeof first);
    assert_memory_equal(curves->flags, flags, sizeof flags);
    for (int i = 0; i < 5; i++) assert_float_equal(curves->point[4 * i + 3], 0.5f, 0.0f);
}

static void both_forms_are_read(void **state) {
    (void)state;
    struct hair_case c;
    // Blank lines and comments separate strands; a strand of one point, or of equal ones, is none.
    load_hair_read_text(&c, plain_hair(),
                        "# hair\n\n0 0 0\r\n1 0 0\n  1 1 0  \n\n \t\n7 7 7\n\n8 8 8\n8 8 8\n#x\n"
                        "5 5 5\n5 5 5\n5 5 6");
    check_two_strands(&c.curves);
    assert_true(c.hash != 1);
    arena_free(&c.arena);
    struct strand_file file = begin_file(6);
    static const float value[20] = {0, 0, 0, 1,         0, 0, 1, 1, 0, INFINITY,
                                    7, 7, 7, -INFINITY, 5, 5, 5, 5, 5, 6};
    put_floats(&file, value, 20);
    assert_int_equal(load_hair_read(&c, plain_hair(), file.data, file.size), SATIN_OK);
    check_two_strands(&c.curves);
    arena_free(&c.arena);
    // A separator at the end is no vertex. More is not read, as in Mitsuba.
    put_floats(&file, value + 9, 1);
    assert_int_equal(load_hair_read(&c, plain_hair(), file.data, file.size), SATIN_OK);
    assert_int_equal(c.log.warnings, 0);
    arena_free(&c.arena);
    put_floats(&file, value, 2);
    assert_int_equal(load_hair_read(&c, plain_hair(), file.data, file.size), SATIN_OK);
    check_two_strands(&c.curves);
    assert_string_equal(c.log.warning,
                        "a.hair: 12 bytes after the last of 6 vertices are not read");
    arena_free(&c.arena);
}

// Angles are between world space directions, of the next point and of the segment so far.
static void segments_that_go_straight_on_are_one(void **state) {
    (void)state;
    // Directions of 0, 6, 12, 18 and 80 degrees.
    static const char arc[] =
        "0 0 0\n1 0 0\n1.9945219 .10452846 0\n2.9726695 .31244015 0\n3.923726 .62145714 0\n"
        "4.0973742 1.6062649 0\n";
    struct hair_request request = plain_hair();
    struct hair_case c;
    request.angle_threshold = 5.9f;
    load_hair_read_text(&c, request, arc);
    assert_int_equal(c.curves.segments, 5);
    arena_free(&c.arena);
    // 6 degrees are near the first, 12 are 9 from the mean of both, and 18 are 12 from all three.
    request.angle_threshold = 10.0f;
    load_hair_read_text(&c, request, arc);
    static const vec3 expected[4] = {{0, 0, 0},
                                     {2.9726695f, .31244015f, 0},
                                     {3.923726f, .62145714f, 0},
                                     {4.0973742f, 1.6062649f, 0}};
    check_points(&c.curves, expected, 4);
    arena_free(&c.arena);
    request.angle_threshold = 90.0f;
    load_hair_read_text(&c, request, arc);
    assert_int_equal(c.curves.segments, 1);
    arena_free(&c.arena);
    // A transform that flattens the arc makes the angles smaller.
    request.angle_threshold = 1.0f;
    request.to_world = mat4_scale(v3(2, 1e-3f, 1));
    load_hair_read_text(&c, request, arc);
    assert_int_equal(c.curves.segments, 1);
    assert_near3(v3(c.curves.point[4], c.curves.point[5], 0), v3(8.194748f, .00160626f, 0), 1e-5f);
    arena_free(&c.arena);
}

// The fraction of strands that is left out is the reduction, and does not depend on the rest.
static void reductions_leave_out_strands(void **state) {
    (void)state;
    enum { STRANDS = 4000 };
    char *text = malloc(STRANDS * 40);
    assert_non_null(text);
    size_t size = 0;
    for (int i = 0; i < STRANDS; i++)
        size += (size_t)sprintf(text + size, "%d 0 0\n%d 1 0\n\n\n", i, i);
    for (int i = 0; i < 4; i++) {
        struct hair_case c, again;
        struct hair_request request = plain_hair();
        request.reduction = 0.25f * (float)i;
        assert_int_equal(load_hair_read(&c, request, text, size), SATIN_OK);
        assert_int_equal(load_hair_read(&again, request, text, size), SATIN_OK);
        // Five standard deviations of a binomial distribution: at most 5 * sqrt(4000) / 2.
        const double expected = STRANDS * (1.0 - request.reduction);
        assert_true(fabs(c.curves.segments - expected) <= (i ? 158.0 : 0.0));
        assert_true(c.curves.points == 2 * c.curves.segments);
        assert_int_equal(again.curves.segments, c.curves.segments);
        assert_memory_equal(again.curves.point, c.curves.point, c.curves.points * 16);
        arena_free(&c.arena);
        arena_free(&again.arena);
    }
    free(text);
}

// As in Mitsuba 0.6, what follows the third number of a line is not read.
static void lines_may_be_longer(void **state) {
    (void)state;
    static const char text[] = "0 0 0 7\n1 0 0 .5 red\n";
    struct hair_case c;
    assert_int_equal(load_hair_read(&c, plain_hair(), text, sizeof text - 1), SATIN_OK);
    assert_int_equal(c.curves.segments, 1);
    assert_true(c.curves.point[4] == 1.0f && c.curves.point[5] == 0.0f);
    assert_non_null(strstr(c.log.warning, "a.hair: of 2 lines only the first three numbers are"));
    arena_free(&c.arena);
}

static void an_error_names_its_line_or_byte(void **state) {
    (void)state;
    static const char *const wrong[][2] = {
        {"", "a.hair: there is no strand of two points in it"},
        {"1 1 1\n\n2 2 2\n", "a.hair: there is no strand of two points in it"},
        {"0 0 0\n1 0\n", "a.hair:2: expected a point: x y z"},
        {"0 0 0\n1 0 0\n\nhair\n", "a.hair:4: expected a point: x y z"},
        {"0 0 0\n\n\n1 nan 0\n", "a.hair:4: expected a point: x y z"},
        {"0 0 0\n1 1e30 0\n", "a.hair:2: the point is out of range"},
        {"0 0 0\n1 1e300 0\n", "a.hair:2: the point is out of range"}};
    struct hair_case c;
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        assert_int_equal(load_hair_read(&c, plain_hair(), wrong[i][0], strlen(wrong[i][0])),
                         SATIN_ERROR_INPUT);
        assert_string_equal(c.log.error, wrong[i][1]);
        arena_free(&c.arena);
    }
    static const float value[8] = {0, 0, 0, INFINITY, 1, NAN, 0, 0};
    static const struct {
        uint32_t count;
        size_t values;
        const char *message;
    } damaged[] = {
        {0, 0, "a.hair: there is no strand of two points in it"},
        {4000000000u, 3, "a.hair: byte 27: the file ends after 1 of 4000000000 vertices"},
        {2, 4, "a.hair: byte 31: the file ends after 1 of 2 vertices"},
        {2, 6, "a.hair: byte 39: the file ends after 1 of 2 vertices"},
        {2, 7, "a.hair: byte 31: the vertex is not finite or out of range"},
        {1, 3, "a.hair: there is no strand of two points in it"}};
    for (size_t i = 0; i < sizeof damaged / sizeof *damaged; i++) {
        struct strand_file file = begin_file(damaged[i].count);
        put_floats(&file, value, damaged[i].values);
        assert_int_equal(load_hair_read(&c, plain_hair(), file.data, file.size), SATIN_ERROR_INPUT);
        assert_string_equal(c.log.error, damaged[i].message);
        arena_free(&c.arena);
    }
    assert_int_equal(load_hair_read(&c, plain_hair(), HEADER "\1", 12), SATIN_ERROR_INPUT);
    assert_string_equal(c.log.error,
                        "a.hair: byte 12: the file ends before the number of vertices");
    arena_free(&c.arena);
}

#define HAIR(version, more)                                         \
    "<scene version='" version                                      \
    "'>\n<sensor type='perspective'/>\n<shape type='hair'><string " \
    "name='filename' value='a.hair'/>" more "</shape></scene>"

static void the_parameters_are_those_of_version_06(void **state) {
    (void)state;
    scene_case_file("a.hair", "0 0 0\n1 0 0\n2 .05 0\n3 .1 0\n");
    struct scene_case c;
    satin_scene *scene = scene_case_load(&c, HAIR("0.6.0", ""));
    if (!scene) fail_msg("%s", c.error);
    // The default threshold joins the last two segments, whose angles are 2.86 and 0 degrees.
    assert_int_equal(scene->shape[0].curves.segments, 2);
    assert_float_equal(scene->shape[0].curves.point[3], 0.025f, 0.0f);
    satin_scene_free(scene);
    scene = scene_case_load(
        &c, HAIR("0.6.0",
                 "<float name='angleThreshold' value='3'/><float name='radius' value='.1'/>"
                 "<float name='reduction' value='.05'/><transform name='toWorld'>"
                 "<scale x='2' y='2' z='3'/></transform>"));
    if (!scene) fail_msg("%s", c.error);
    assert_int_equal(scene->shape[0].curves.segments, 1);
    assert_float_equal(scene->shape[0].curves.point[3], 0.3f / 0.95f, 1e-6f);
    struct ray ray = {{1.5f, 0, 5}, 0, {0, 0, -1}, INFINITY};
    struct interaction s;
    assert_true(scene_intersect(scene, &ray, &s));
    satin_scene_free(scene);
}

static void wrong_parameters_are_refused(void **state) {
    (void)state;
    static const char *const cases[][2] = {
        {"<float name='radius' value='0'/>", "scene.xml:3:60: radius is 0, but must be positive"},
        {"<float name='reduction' value='1'/>",
         "scene.xml:3:1: shape 'hair': its reduction must be less than 1"},
        {"<float name='angle_threshold' value='91'/>",
         "scene.xml:3:1: shape 'hair': its angle_threshold must be at most 90 degrees"},
        {"<transform name='to_world'><scale z='0'/></transform>",
         "scene.xml:3:1: shape 'hair': to_world makes its radius 0 or too large"},
        {"<float name='reduction' value='.9999'/>",
         "a.hair: no strand with a segment is left of 1 after the reduction"},
        {"<emitter type='area'/>", "scene.xml:3:1: shape 'hair': curves cannot emit"},
        {"<bsdf type='dielectric'/>", "scene.xml:3:1: shape 'hair': curves cannot transmit light"}};
    scene_case_file("a.hair", "0 0 0\n1 0 0\n");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct scene_case c;
        char text[1024];
        snprintf(text, sizeof text, HAIR("3.0.0", "%s"), cases[i][0]);
        assert_null(scene_case_load(&c, text));
        assert_string_equal(c.error, cases[i][1]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(both_forms_are_read),
                                       cmocka_unit_test(segments_that_go_straight_on_are_one),
                                       cmocka_unit_test(reductions_leave_out_strands),
                                       cmocka_unit_test(lines_may_be_longer),
                                       cmocka_unit_test(an_error_names_its_line_or_byte),
                                       cmocka_unit_test(the_parameters_are_those_of_version_06),
                                       cmocka_unit_test(wrong_parameters_are_refused)};
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
