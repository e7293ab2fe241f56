// SPDX-License-Identifier: Apache-2.0
// Surfaces with holes: the fraction of rays that pass, by every query, through meshes and quadrics.
#include "test_scene.h"

enum { RAYS = 20000 };

// Makes a material of a blend of two sides, with the given weight.
static struct material_side scene_opacity_join(const struct material_side *a,
                                               const struct material_side *b, float weight,
                                               const struct texture *texture) {
    return (struct material_side){
        .component = {a, b}, .weight = weight, .blend = texture, .holes = a->holes || b->holes};
}

// A surface with holes (a rectangle, or a sphere, which rays cross twice) before a wall, z = 0.
static void scene_opacity_build(struct test_scene *t, bool sphere,
                                const struct material_side *side) {
    test_scene_init(t);
    uint32_t plain = test_diffuse(t, .5f, .5f, .5f), holes = test_diffuse(t, .5f, .5f, .5f);
    t->material[holes].front = t->material[holes].back = *side;
    test_rectangle(t, test_transform(v3(0, 0, 0), v3(10, 10, 1)), plain);
    if (sphere)
        test_quadric(t, SHAPE_SPHERE, test_transform(v3(0, 0, 5), v3(2, 2, 2)), false, holes);
    else
        test_rectangle(t, test_transform(v3(0, 0, 5), v3(2, 2, 1)), holes);
    test_scene_finish(t);
}

static struct ray ray_number(int i) {
    float x = (float)(i % 100) * .01f + .1f, y = (float)(i / 100) * .005f - .4f;
    return (struct ray){v3(x, y, 9), 0.0f, v3(0, 0, -1), INFINITY};
}

// Fractions of rays that arrive at the wall, by the queries of scene.h.
static void fraction_through(const struct satin_scene *scene, float fraction[2]) {
    int hits = 0, free_ways = 0;
    for (int i = 0; i < RAYS; i++) {
        struct ray ray = ray_number(i), shadow = ray;
        struct interaction s;
        assert_true(scene_intersect(scene, &ray, &s));
        bool wall = s.p.z == 0.0f;
        hits += wall;
        assert_true((scene_distance(scene, &ray) == 9.0f) == wall);
        shadow.tfar = 8.5f;
        bool clear = !scene_occluded(scene, &shadow);
        assert_true(clear == wall);  // the same ray finds the same
        free_ways += clear;
        vec3 p, n;
        assert_true(scene_surface(scene, &ray, &p, &n) && p.z > 0.0f);
        assert_true(fabsf(v3_len(n) - 1.0f) < 1e-6f);
    }
    fraction[0] = (float)hits / RAYS;
    fraction[1] = (float)free_ways / RAYS;
}

static const struct material_side hole = {.holes = true};
static const struct material_side whole;

static void a_mask_lets_its_fraction_pass(void **state) {
    (void)state;
    const struct material_side mask = scene_opacity_join(&hole, &whole, .3f, NULL),
                               inverted = scene_opacity_join(&whole, &hole, .3f, NULL),
                               blend = scene_opacity_join(&inverted, &whole, .4f, NULL),
                               both = scene_opacity_join(&mask, &inverted, .25f, NULL);
    const struct {
        struct material_side side;
        float pass;
    } holes[] = {
        {mask, .7f},   {inverted, .3f}, {scene_opacity_join(&hole, &mask, .5f, NULL), .85f},
        {blend, .18f}, {both, .6f},     {scene_opacity_join(&blend, &mask, .5f, NULL), .44f}};
    for (int k = 0; k < 12; k++) {
        struct test_scene t;
        scene_opacity_build(&t, k & 1, &holes[k / 2].side);
        float fraction[2], pass = holes[k / 2].pass;
        if (k & 1) pass *= pass;
        fraction_through(&t.scene, fraction);
        for (int i = 0; i < 2; i++)
            assert_true(fabsf(fraction[i] - pass) < 4.0f * sqrtf(pass * (1 - pass) / RAYS));
        test_scene_free(&t);
    }
}

// The texture says where the holes are; a checkerboard that gives a number begins with color1.
static void opacity_follows_its_texture(void **state) {
    (void)state;
    const struct texture white = {.value = {1, 1, 1}}, black = {0};
    const struct texture checks = {
        .kind = TEXTURE_CHECKERBOARD, .check = {&white, &black}, .to_uv = {1, 0, 0, 0, 1, 0}};
    struct test_scene t;
    struct material_side side = scene_opacity_join(&hole, &whole, 0.0f, &checks);
    scene_opacity_build(&t, false, &side);
    for (int i = 0; i < 4; i++) {
        float x = i & 1 ? 1.0f : -1.0f, y = i & 2 ? 1.0f : -1.0f;
        struct ray ray = {v3(x, y, 9), 0.0f, v3(0, 0, -1), INFINITY};
        struct interaction s;
        assert_true(scene_intersect(&t.scene, &ray, &s));
        assert_true((s.p.z > 0.0f) == (x != y));
    }
    test_scene_free(&t);
}

// A null surface does not exist for rays, unless it emits light.
static void a_null_material_is_nothing(void **state) {
    (void)state;
    struct test_scene t;
    test_scene_init(&t);
    uint32_t nothing = test_material(&t, "null", rgb_grey(0.0f), rgb_grey(0.0f));
    uint32_t shape = test_rectangle(&t, test_transform(v3(0, 0, 5), v3(2, 2, 1)), nothing);
    struct ray ray = {v3(0.5f, 0, 9), 0.0f, v3(0, 0, -1), INFINITY};
    struct interaction s;
    for (int emits = 0; emits < 2; emits++) {
        t.shape[shape].light = emits - 1;
        assert_int_equal(scene_trace_build(&t.scene, (struct log){0}), SATIN_OK);
        assert_int_equal(scene_intersect(&t.scene, &ray, &s), emits);
        scene_trace_free(t.scene.trace);
        t.scene.trace = NULL;
    }
    test_scene_free(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_mask_lets_its_fraction_pass),
        cmocka_unit_test(opacity_follows_its_texture),
        cmocka_unit_test(a_null_material_is_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
