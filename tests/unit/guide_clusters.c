// SPDX-License-Identifier: Apache-2.0
// Photon clusters: found where photons arrive densely, visible from points with a free line to
// them, and not found where light is uniform.
#include "test_scene.h"

#include <math.h>

#include "base/sampling.h"
#include "guide/guide_clusters.h"

enum { SPREAD = 12000, DENSE = 8000, PHOTONS = SPREAD + DENSE };

static const vec3 SPOT = {0.3f, 1.0f, -0.2f};  // on the ceiling
static const float SPOT_RADIUS = 0.04f;

// A position on wall i of the six of the box.
static vec3 on_wall(size_t i, vec2 u, vec3 *n) {
    const float x = 2.0f * u.x - 1.0f, y = 2.0f * u.y - 1.0f, side = i & 1 ? 1.0f : -1.0f;
    const int axis = (int)(i / 2);
    *n = axis == 0 ? v3(-side, 0, 0) : axis == 1 ? v3(0, -side, 0) : v3(0, 0, -side);
    return axis == 0 ? v3(side, x, y) : axis == 1 ? v3(x, side, y) : v3(x, y, side);
}

// Photons of power 1 / PHOTONS, spread over the walls of a box, and a fraction in a spot on its
// ceiling.
static void shower(struct guide_photon *photon, size_t spread) {
    for (size_t i = 0; i < PHOTONS; i++) {
        vec2 u = sample_sobol2((uint32_t)i / 6, 7 + (uint32_t)i % 6);
        vec3 n, p = on_wall(i % 6, u, &n);
        if (i >= spread) {
            vec2 d = sample_disk(u.x, u.y);
            p = v3_add(SPOT, v3(SPOT_RADIUS * d.x, 0.0f, SPOT_RADIUS * d.y));
            n = v3(0, -1, 0);
        }
        photon[i] = (struct guide_photon){.p = p, .n = n, .power = 1.0f / PHOTONS};
    }
}

// A box, and if `shaded` a board below the spot.
static void box(struct test_scene *t, bool shaded) {
    test_scene_init(t);
    uint32_t grey = test_diffuse(t, 0.5f, 0.5f, 0.5f);
    test_cube(t, mat4_identity(), true, grey);
    if (shaded)
        test_cube(t, test_transform(v3(0.3f, 0.8f, -0.2f), v3(0.3f, 0.01f, 0.3f)), false, grey);
    test_scene_finish(t);
}

static struct guide_clusters *build_of(const struct test_scene *t,
                                       const struct guide_photon *photon, int threads) {
    struct guide_clusters *clusters = NULL;
    struct parallel *pool = parallel_new(threads);
    assert_int_equal(
        guide_clusters_build(&t->scene, photon, PHOTONS, pool, (struct log){0}, &clusters),
        SATIN_OK);
    parallel_free(pool);
    return clusters;
}

static struct guide_clusters *test_guide_clusters_build(const struct test_scene *t, size_t spread) {
    static struct guide_photon photon[PHOTONS];
    shower(photon, spread);
    return build_of(t, photon, 2);
}

static int guide_clusters_look(const struct test_scene *t, struct guide_clusters *clusters, vec3 p,
                               vec3 n, struct guide_cone *cone) {
    float expected = 0.0f;
    int count =
        guide_cones_from(clusters, &t->scene, &(struct guide_point){p, n, n}, cone, &expected);
    if (count > 0) assert_true(expected > 0.0f);
    return count;
}

// The cones hold the spot and little more, and predict the light that comes from it.
static void a_spot_is_visible(void **state) {
    (void)state;
    struct test_scene t;
    box(&t, false);
    struct guide_clusters *clusters = test_guide_clusters_build(&t, SPREAD);
    assert_non_null(clusters);
    assert_true(guide_clusters_bytes(clusters) > 0);
    for (int i = 0; i < 8; i++) {
        const vec3 p = v3(-0.9f + 0.2f * (float)i, -1.0f, 0.1f * (float)i), n = v3(0, 1, 0);
        struct guide_cone cone[GUIDE_CONES];
        int count = guide_clusters_look(&t, clusters, p, n, cone);
        assert_true(count > 0);
        float solid_angle = 0.0f, E = 0.0f;
        for (int c = 0; c < count; c++) {
            E += cone[c].E;
            if (!(cone[c].E > 1e-3f)) continue;  // positions a little brighter than the walls
            solid_angle += 2.0f * PI_F * cone[c].versine;
            assert_true(cone[c].filled > 0.1f);
        }
        const vec3 d = v3_sub(SPOT, p);
        const float height = 2.0f / v3_len(d), r2 = v3_len2(d);
        assert_true(solid_angle < 8.0f * PI_F * sqrf(SPOT_RADIUS) / r2);
        const float wanted = (float)DENSE / PHOTONS * sqrf(height) / (PI_F * r2);
        assert_true(fabsf(E / wanted - 1.0f) < 0.05f);
        for (int k = 0; k < 16; k++) {
            vec3 at = v3_add(SPOT, v3(0.9f * SPOT_RADIUS * cosf((float)k), 0.0f,
                                      0.9f * SPOT_RADIUS * sinf((float)k)));
            vec3 w = v3_unit(v3_sub(at, p));
            int held = 0;
            for (int c = 0; c < count; c++)
                held += v3_dist2(w, cone[c].axis) <= 2.0f * cone[c].versine;
            assert_true(held > 0);
        }
    }
    guide_clusters_free(clusters);
    test_scene_free(&t);
}

static void what_is_hidden_is_not_visible(void **state) {
    (void)state;
    struct test_scene t;
    box(&t, true);
    struct guide_clusters *clusters = test_guide_clusters_build(&t, SPREAD);
    struct guide_cone cone[GUIDE_CONES];
    int others = guide_clusters_look(&t, clusters, v3(0.3f, -1.0f, -0.2f), v3(0, 1, 0), cone);
    for (int c = 0; c < others; c++) assert_true(cone[c].E < 1e-3f);
    // These points are beside the board, and on a wall; the last one faces away.
    assert_true(guide_clusters_look(&t, clusters, v3(-0.9f, 0.7f, -0.2f), v3(1, 0, 0), cone) > 0);
    others = guide_clusters_look(&t, clusters, v3(-0.9f, 0.7f, -0.2f), v3(0, -1, 0), cone);
    for (int c = 0; c < others; c++) assert_true(cone[c].centre.y < 0.9f && cone[c].E < 1e-3f);
    guide_clusters_free(clusters);
    test_scene_free(&t);
}

// Light on the outside of the walls, as that of a sky, has most of the power and is hidden from
// inside. A spot of little power, along which a ray is far brighter, gets a cone all the same.
static void outer_light_does_not_hide_a_spot(void **state) {
    (void)state;
    static const float OUTSIDE = 3.0f;
    static const size_t OUTER = PHOTONS - PHOTONS / 200;
    static struct guide_photon photon[PHOTONS];
    struct test_scene t;
    box(&t, false);
    shower(photon, OUTER);
    for (size_t i = 0; i < OUTER; i++) {
        photon[i].p = v3_mul(photon[i].p, OUTSIDE);
        photon[i].n = v3_neg(photon[i].n);
    }
    struct guide_clusters *clusters = build_of(&t, photon, 2);
    const vec3 p = v3(-0.5f, -1.0f, 0.1f), n = v3(0, 1, 0), d = v3_sub(SPOT, p);
    struct guide_cone cone[GUIDE_CONES];
    float expected = 1e-4f;  // that on the outer walls is .005
    const int count =
        guide_cones_from(clusters, &t.scene, &(struct guide_point){p, n, n}, cone, &expected);
    float versine = 1.0f;  // of the narrowest cone that holds the spot
    for (int c = 0; c < count; c++)
        if (guide_cone_holds(&cone[c], v3_unit(d))) versine = fminf(versine, cone[c].versine);
    assert_true(versine < 4.0f * sqrf(SPOT_RADIUS) / v3_len2(d));
    guide_clusters_free(clusters);
    test_scene_free(&t);
}

static void uniform_light_has_no_clusters(void **state) {
    (void)state;
    struct test_scene t;
    box(&t, false);
    struct guide_clusters *clusters = test_guide_clusters_build(&t, PHOTONS), *none = NULL;
    struct guide_cone cone[GUIDE_CONES];
    assert_int_equal(guide_clusters_look(&t, clusters, v3(0.1f, -1, 0.2f), v3(0, 1, 0), cone), 0);
    assert_int_equal(guide_clusters_look(&t, NULL, v3(0.1f, -1, 0.2f), v3(0, 1, 0), cone), 0);
    assert_int_equal(guide_clusters_build(&t.scene, NULL, 0, NULL, (struct log){0}, &none),
                     SATIN_OK);
    assert_null(none);
    guide_clusters_free(clusters);
    test_scene_free(&t);
}

// The photons lie in one point, or in a line, and so have no area at all.
static void photons_without_area_are_harmless(void **state) {
    (void)state;
    static struct guide_photon photon[PHOTONS];
    for (int line = 0; line < 2; line++) {
        shower(photon, SPREAD);
        for (size_t i = SPREAD; i < PHOTONS; i++)
            photon[i].p = v3_add(SPOT, v3(line ? 1e-6f * (float)i : 0.0f, 0.0f, 0.0f));
        struct test_scene t;
        box(&t, false);
        struct guide_clusters *clusters = build_of(&t, photon, 2);
        struct guide_cone cone[GUIDE_CONES];
        int count = guide_clusters_look(&t, clusters, v3(0, -1, 0), v3(0, 1, 0), cone);
        for (int c = 0; c < count; c++)
            assert_true(cone[c].versine > 0.0f && isfinite(cone[c].E) && isfinite(cone[c].filled));
        guide_clusters_free(clusters);
        test_scene_free(&t);
    }
}

// Asks for cancellation once it has been called `*left` times.
static bool cancel_later(void *user, double done) {
    int *left = user;
    (void)done;
    return (*left)-- <= 0;
}

// Building stops at any call, with nothing left in memory (the sanitizers see that).
static void building_can_be_cancelled_anywhere(void **state) {
    (void)state;
    static struct guide_photon photon[PHOTONS];
    struct test_scene t;
    box(&t, false);
    shower(photon, SPREAD);
    struct parallel *pool = parallel_new(1);
    int calls = 0;
    for (bool cancelled = true; cancelled; calls++) {
        int left = calls;
        struct guide_clusters *clusters = NULL;
        parallel_set_progress(pool, cancel_later, &left);
        const satin_status status =
            guide_clusters_build(&t.scene, photon, PHOTONS, pool, (struct log){0}, &clusters);
        cancelled = status == SATIN_CANCELLED;
        assert_true(cancelled ? !clusters : status == SATIN_OK && clusters);
        guide_clusters_free(clusters);
    }
    assert_true(calls > 10);
    parallel_free(pool);
    test_scene_free(&t);
}

// The tree is well-formed, has every photon once, and is the same on any number of threads.
static void threads_do_not_change_the_clusters(void **state) {
    (void)state;
    static struct guide_photon photon[PHOTONS];
    static const int THREADS[] = {1, 2, 3, 8};
    struct test_scene t;
    box(&t, false);
    shower(photon, SPREAD);
    struct guide_clusters *first = build_of(&t, photon, 1);
    const size_t nodes = first->node_count;
    double power = 0.0;
    size_t points = 0;
    assert_int_equal(first->node->count, PHOTONS);
    for (size_t i = 0; i < nodes; i++) {
        const struct guide_cluster *node = &first->node[i], *right = &first->node[node->right];
        if (node->right) {
            assert_true(i + 1 < (size_t)node->right && (size_t)node->right < nodes);
            assert_int_equal(node[1].first, node->first);
            assert_int_equal(right->first, node->first + node[1].count);
            assert_int_equal(node->count, node[1].count + right->count);
        } else {
            power += (double)node->power;
            points += node->count;
            for (size_t k = 0; k < node->count; k++)
                assert_true(v3_dist2(first->position[node->first + k], node->centre) <=
                            1.001f * node->radius * node->radius);
        }
    }
    assert_int_equal(points, PHOTONS);
    assert_true(fabs(power - 1.0) < 1e-4);
    for (size_t k = 0; k < sizeof THREADS / sizeof *THREADS; k++) {
        struct guide_clusters *other = build_of(&t, photon, THREADS[k]);
        assert_int_equal(other->node_count, nodes);
        for (size_t i = 0; i < nodes; i++) {
            const struct guide_cluster *a = &first->node[i], *b = &other->node[i];
            assert_memory_equal(&a->centre, &b->centre, sizeof a->centre);
            assert_memory_equal(&a->normal, &b->normal, sizeof a->normal);
            assert_true(a->radius == b->radius && a->power == b->power && a->area == b->area);
            assert_true(a->dense == b->dense && a->common == b->common && a->right == b->right);
            assert_true(a->first == b->first && a->count == b->count);
        }
        assert_memory_equal(first->position, other->position, PHOTONS * sizeof *first->position);
        guide_clusters_free(other);
    }
    guide_clusters_free(first);
    test_scene_free(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_spot_is_visible),
        cmocka_unit_test(what_is_hidden_is_not_visible),
        cmocka_unit_test(outer_light_does_not_hide_a_spot),
        cmocka_unit_test(uniform_light_has_no_clusters),
        cmocka_unit_test(photons_without_area_are_harmless),
        cmocka_unit_test(building_can_be_cancelled_anywhere),
        cmocka_unit_test(threads_do_not_change_the_clusters),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
