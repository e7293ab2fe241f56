// SPDX-License-Identifier: Apache-2.0
// Small scenes for tests, filled in by hand: shapes, materials and lights of a struct satin_scene.
// A failure to build one fails the test.
#ifndef TEST_SCENE_H
#define TEST_SCENE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "light/light.h"
#include "load/load_build.h"

enum { TEST_SHAPES = 32, TEST_MATERIALS = 8, TEST_LIGHTS = 64 };

struct test_scene {
    struct satin_scene scene;
    struct shape shape[TEST_SHAPES];
    struct material material[TEST_MATERIALS];
    struct light light[TEST_LIGHTS];
};

static inline void test_scene_init(struct test_scene *t) {
    memset(t, 0, sizeof *t);
    t->scene.shape = t->shape;
    t->scene.material = t->material;
    t->scene.light = t->light;
    t->scene.environment = -1;
}

static inline void test_scene_free(struct test_scene *t) {
    scene_trace_free(t->scene.trace);
    arena_free(&t->scene.arena);
}

// A material of the model by name, equal on both sides unless it is a dielectric.
static inline uint32_t test_material(struct test_scene *t, const char *model, rgb diffuse,
                                     rgb specular) {
    struct material *m = &t->material[t->scene.material_count];
    struct brdf b = {.model = brdf_find(model),
                     .diffuse = diffuse,
                     .specular = specular,
                     .transmittance = rgb_grey(1.0f),
                     .ior = 1.5f,
                     .alpha_u = 0.1f,
                     .alpha_v = 0.1f,
                     .exponent = 20.0f};
    assert_non_null(b.model);
    assert_int_equal(brdf_prepare(&b, &t->scene.arena, NULL), SATIN_OK);
    *m = (struct material){.name = model, .front = {.base = b}, .back = {.base = b}};
    m->two_sided = !b.model->transmits;
    m->front.holes = m->back.holes = b.model == brdf_find("null");
    return t->scene.material_count++;
}

static inline uint32_t test_diffuse(struct test_scene *t, float r, float g, float b) {
    return test_material(t, "diffuse", rgb_make(r, g, b), rgb_grey(0.0f));
}

static inline struct mat4 test_transform(vec3 move, vec3 size) {
    struct mat4 m = mat4_translate(move), s = mat4_scale(size);
    return mat4_mul(&m, &s);
}

static inline uint32_t test_add_shape(struct test_scene *t, struct shape shape) {
    assert_true(t->scene.shape_count < TEST_SHAPES);
    shape.name = "shape";
    shape.light = -1;
    shape.area = scene_shape_area(&shape);
    t->shape[t->scene.shape_count] = shape;
    return t->scene.shape_count++;
}

// Adds the square [-1, 1]^2 facing +z, transformed.
static inline uint32_t test_rectangle(struct test_scene *t, struct mat4 m, uint32_t material) {
    struct shape s = {.kind = SHAPE_MESH, .material = material};
    struct mesh_request request = {.to_world = m};
    assert_int_equal(load_mesh_rectangle(&t->scene.arena, &request, &s.mesh), SATIN_OK);
    return test_add_shape(t, s);
}

// Adds the cube [-1, 1]^3. If `inside`, its faces look inwards.
static inline uint32_t test_cube(struct test_scene *t, struct mat4 m, bool inside,
                                 uint32_t material) {
    struct shape s = {.kind = SHAPE_MESH, .material = material, .flip_normals = inside};
    struct mesh_request request = {.to_world = m, .flip_normals = inside};
    assert_int_equal(load_mesh_cube(&t->scene.arena, &request, &s.mesh), SATIN_OK);
    return test_add_shape(t, s);
}

static inline uint32_t test_quadric(struct test_scene *t, enum shape_kind kind, struct mat4 m,
                                    bool inside, uint32_t material) {
    struct shape s = {.kind = kind, .material = material, .flip_normals = inside};
    assert_true(scene_shape_transform(&s, &m));
    return test_add_shape(t, s);
}

static inline uint32_t test_light(struct test_scene *t, struct light light) {
    assert_true(t->scene.light_count < TEST_LIGHTS);
    if (light.kind == LIGHT_CONSTANT || light.kind == LIGHT_ENVMAP)
        t->scene.environment = (int32_t)t->scene.light_count;
    t->light[t->scene.light_count] = light;
    return t->scene.light_count++;
}

static inline uint32_t test_area_light(struct test_scene *t, uint32_t shape, rgb radiance) {
    t->shape[shape].light = (int32_t)t->scene.light_count;
    return test_light(t, (struct light){.kind = LIGHT_AREA, .value = radiance, .shape = shape});
}

// Must be called after all is added. Builds the structures that trace rays and sample lights.
static inline void test_scene_finish(struct test_scene *t) {
    struct log quiet = {0};
    assert_int_equal(scene_trace_build(&t->scene, quiet), SATIN_OK);
    assert_int_equal(light_prepare(&t->scene, quiet), SATIN_OK);
}

// A floor at z = -1 and, with `walls`, the rest of a room of half-width 1 whose wall at x = 1 has a
// slit above z = .2.
static inline void test_slit_room(struct test_scene *t, bool walls) {
    const uint32_t grey = test_diffuse(t, 0.5f, 0.5f, 0.5f);
    test_cube(t, test_transform(v3(0, 0, -1.05f), v3(1, 1, 0.05f)), false, grey);
    if (!walls) return;
    test_cube(t, test_transform(v3(0, 0, 1.05f), v3(1, 1, 0.05f)), false, grey);
    test_cube(t, test_transform(v3(-1.05f, 0, 0), v3(0.05f, 1.1f, 1.1f)), false, grey);
    test_cube(t, test_transform(v3(1.05f, 0, -0.4f), v3(0.05f, 1.1f, 0.6f)), false, grey);
    test_cube(t, test_transform(v3(1.05f, 0, 0.8f), v3(0.05f, 1.1f, 0.3f)), false, grey);
    test_cube(t, test_transform(v3(0, 1.05f, 0), v3(1.1f, 0.05f, 1.1f)), false, grey);
    test_cube(t, test_transform(v3(0, -1.05f, 0), v3(1.1f, 0.05f, 1.1f)), false, grey);
}

// A camera in the middle that looks down.
static inline void test_look_down(struct test_scene *t) {
    t->scene.camera = (struct camera){
        .to_world = mat4_scale(v3(1, 1, -1)), .tan_x = 1.0f, .tan_y = 1.0f, .far_clip = INFINITY};
    t->scene.film =
        (struct scene_film){.width = 64, .height = 64, .crop_width = 64, .crop_height = 64};
}

// A whole scene: a closed cube of +-1 that emits a radiance of 1 and reflects `albedo` diffusely,
// so that radiance is 1 / (1 - albedo) everywhere.
static inline void test_furnace(struct test_scene *t, float albedo) {
    test_scene_init(t);
    const uint32_t shape =
        test_cube(t, mat4_identity(), true, test_diffuse(t, albedo, albedo, albedo));
    test_area_light(t, shape, rgb_grey(1.0f));
    test_scene_finish(t);
}

#endif
