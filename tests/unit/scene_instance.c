// SPDX-License-Identifier: Apache-2.0
// Rays hit instances as they hit the same shapes at the same positions, rays that leave an instance
// do not hit it again, and invalid groups are refused.
#include "scene/scene_instance.h"

#include "base/rng.h"
#include "base/sampling.h"
#include "scene_case.h"

#define SHAPES(step)                                                                   \
    "<shape type='cube'><transform name='to_world'><scale x='.5' y='.7' z='.9'/>" step \
    "</transform></shape><shape type='sphere'><float name='radius' value='.8'/>"       \
    "<transform name='to_world'><translate x='2'/>" step                               \
    "</transform>"                                                                     \
    "<bsdf type='roughconductor'><float name='alpha_u' value='.1'/>"                   \
    "<float name='alpha_v' value='.3'/></bsdf></shape>"                                \
    "<shape type='disk'><transform name='to_world'><translate y='2' z='1'/>" step      \
    "</transform></shape>"
#define MOVED                                                            \
    "<rotate y='1' z='.3' angle='50'/><scale value='3'/><scale x='-1'/>" \
    "<translate x='100' y='-40' z='7'/>"

static satin_scene *load_instances(void) {
    struct scene_case c;
    return scene_case_load(
        &c, SCENE_TEXT("<shape type='shapegroup' id='g'>" SHAPES(
                "") "</shape>"
                    "<shape type='instance'><ref id='g'/><transform name='to_world'>" MOVED
                    "</transform></shape><shape type='instance'><ref id='g'/></shape>"));
}

static vec3 scene_instance_random_point(const satin_scene *scene, uint64_t i) {
    vec3 size = v3_sub(scene->bounds_hi, scene->bounds_lo);
    struct rng rng = rng_make(5, RNG_TEST, i);
    float u[3];
    for (int k = 0; k < 3; k++) u[k] = 1.4f * rng_float(&rng) - 0.2f;
    return v3_add(scene->bounds_lo, v3(size.x * u[0], size.y * u[1], size.z * u[2]));
}

static void an_instance_shows_its_group(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *direct = scene_case_load(&c, SCENE_TEXT(SHAPES(MOVED) SHAPES("")));
    satin_scene *instances = load_instances();
    assert_true(direct && instances && instances->group_count == 1);
    // The bounds of rotated boxes are looser.
    assert_true(v3_dist2(direct->bounds_lo, instances->bounds_lo) < 64 &&
                v3_dist2(direct->bounds_hi, instances->bounds_hi) < 64);
    int hits = 0, misses = 0;
    for (uint64_t i = 0; i < 200000; i++) {
        vec3 from = scene_instance_random_point(direct, 2 * i),
             to = scene_instance_random_point(direct, 2 * i + 1);
        // Half of the rays are aimed at the shapes.
        if (i & 1) to = v3_add(i & 2 ? v3(1, 1, 0) : v3(98, -38, 7), v3_mul(v3_unit(to), 3));
        struct ray ray = {from, 0, v3_unit(v3_sub(to, from)), INFINITY};
        struct interaction a, b;
        bool hit = scene_intersect(direct, &ray, &a);
        if (hit != scene_intersect(instances, &ray, &b)) {
            misses++;
            continue;
        }
        assert_true(scene_occluded(instances, &ray) == scene_occluded(direct, &ray) || !hit);
        if (!hit) continue;
        hits++;
        if (fabsf(a.t - b.t) > 1e-2f) {  // past an edge
            misses++;
            continue;
        }
        // The hits agree to some ulp of 100 off the surface, and to more along it at a grazing ray.
        assert_true(fabsf(v3_dot(v3_sub(a.p, b.p), a.ng)) < 1e-4f && v3_dist2(a.p, b.p) < 1e-4f);
        // So do the origins of records, which are moved off edges.
        assert_true(v3_dist2(scene_origin_shift(direct, &a, 0.2f),
                             scene_origin_shift(instances, &b, 0.2f)) < 2e-4f);
        // A reflection puts the outside of a sphere inside, but not an instance of it; so it is in
        // Mitsuba.
        bool sphere = instances->shape[b.shape].kind == SHAPE_SPHERE;
        float side = sphere && v3_dot(a.ng, b.ng) < 0 ? -1 : 1;
        assert_true(side * v3_dot(a.ng, b.ng) > 0.9999f);
        assert_true(side * v3_dot(a.frame.n, b.frame.n) > 0.9999f);
        assert_true(instances->material[b.material].tangent ==
                    direct->material[a.material].tangent);
        if (instances->material[b.material].tangent)
            assert_true(v3_dot(a.frame.u, b.frame.u) > 0.999f);
        assert_true(fabsf(a.uv.x - b.uv.x) < 1e-3f || fabsf(a.uv.x - b.uv.x) > 0.99f);
    }
    assert_true(hits > 10000 && misses < 20);
    satin_scene_free(direct);
    satin_scene_free(instances);
}

// Rays from a convex surface to the outside do not hit it.
static void rays_leave_instances(void **state) {
    (void)state;
    satin_scene *scene = load_instances();
    int hits = 0;
    for (uint64_t i = 0; i < 200000; i++) {
        vec3 from = scene_instance_random_point(scene, 2 * i),
             to = i & 1 ? v3(106, -38, 3) : v3(0, 0, 0);
        struct ray ray = {from, 0, v3_unit(v3_sub(to, from)), INFINITY};
        struct interaction s, other;
        if (!scene_intersect(scene, &ray, &s) || s.shape > 1) continue;
        hits++;
        struct rng rng = rng_make(6, RNG_TEST, i);
        float u = rng_float(&rng), v = rng_float(&rng);
        vec3 d = sample_cosine_hemisphere(u, v);
        struct frame f = frame_from_normal(s.ng);
        struct ray next = scene_spawn(scene, s.p, s.ng, frame_to_world(&f, d));
        assert_false(scene_intersect(scene, &next, &other) && other.shape == s.shape &&
                     other.t < 1.0f);
    }
    assert_true(hits > 10000);
    satin_scene_free(scene);
}

// Rays do not hit a group without shapes anywhere, and the next group is not mistaken for it.
static void groups_may_be_empty(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *scene = scene_case_load(
        &c, SCENE_TEXT("<shape type='shapegroup' id='e'/><shape type='instance'><ref id='e'/>"
                       "</shape><shape type='shapegroup' id='g'><shape type='cube'/></shape>"
                       "<shape type='instance'><ref id='g'/></shape>"
                       "<shape type='instance'><ref id='e'/></shape>"));
    assert_non_null(scene);
    assert_true(scene->group_count == 1 && scene->group[0].count == 1 && scene->shape_count == 2);
    struct ray ray = {v3(0, 0, 5), 0, v3(0, 0, -1), INFINITY};
    struct interaction s;
    assert_true(scene_intersect(scene, &ray, &s) && fabsf(s.t - 4.0f) < 1e-5f);
    satin_scene_free(scene);
}

static void bad_instances_are_refused(void **state) {
    (void)state;
    static const char *const cases[][2] = {
        {"<shape type='instance'/>", "shape 'instance': it takes one shapegroup"},
        {"<shape type='instance'><shape type='cube'/></shape>",
         "shape 'instance': it takes one shapegroup"},
        {"<shape type='instance'><shape type='shapegroup'><shape type='cube'><emitter type='area'/>"
         "</shape></shape></shape>",
         "shape 'cube': it cannot emit in a shapegroup"},
        {"<shape type='shapegroup' id='g'><shape type='cube'/><shape type='instance'>"
         "<ref id='g'/></shape></shape><shape type='instance'><ref id='g'/></shape>",
         "shape 'instance': it cannot be part of a group"},
        {"<shape type='merge' id='m'><ref id='m'/></shape>",
         "shape 'merge': shapes are nested too deep, or contain themselves"},
        {"<shape type='merge' id='m'><ref id='m'/><ref id='m'/><shape type='cube'/></shape>",
         "shape 'merge': shapes are nested too deep, or contain themselves"},
        {"<shape type='instance'><shape type='shapegroup'><shape type='cube'/></shape>"
         "<transform name='to_world'><scale value='0'/></transform></shape>",
         "shape 'instance': to_world is singular"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct scene_case c;
        char text[512];
        snprintf(text, sizeof text, SCENE_TEXT("%s"), cases[i][0]);
        assert_null(scene_case_load(&c, text));
        assert_non_null(strstr(c.error, cases[i][1]));
    }
}

static void merged_shapes_are_shapes_of_the_scene(void **state) {
    (void)state;
    struct scene_case c;
    satin_scene *scene = scene_case_load(
        &c, SCENE_TEXT("<shape type='merge'>" SHAPES("") "<shape type='merge'>"
                                                         "<shape type='cube'/></shape></shape>"));
    assert_true(scene && scene->shape_count == 4 && scene->triangle_count == 24);
    satin_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_instance_shows_its_group), cmocka_unit_test(rays_leave_instances),
        cmocka_unit_test(groups_may_be_empty), cmocka_unit_test(bad_instances_are_refused),
        cmocka_unit_test(merged_shapes_are_shapes_of_the_scene)};
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
