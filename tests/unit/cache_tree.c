// SPDX-License-Identifier: Apache-2.0
// The octree of records against a search of all of them.
#include "cache/cache_tree.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/rng.h"
#include "base/sampling.h"

enum { RECORDS = 2000, QUERIES = 4000 };

static vec3 cache_tree_random_point(struct rng *rng) {
    return v3(rng_float(rng), 2.0f * rng_float(rng), 0.2f * rng_float(rng));
}

static struct cache_head random_head(struct rng *rng, float a) {
    struct cache_head head = {.p = cache_tree_random_point(rng), .scale = 1.0f};
    head.n = sample_uniform_cone(rng_float(rng), rng_float(rng), 0.01f);
    head.R = 0.001f + 0.6f * rng_float(rng) * rng_float(rng);
    head.search_radius = a * head.R;
    return head;
}

// The definition of S, without the tree.
static float error_at(const struct cache_head *h, vec3 p, vec3 n) {
    return sqrtf(v3_dist2(p, h->p)) / h->R + safe_sqrtf(1.0f - v3_dot(n, h->n));
}

static void queries_find_exactly_the_set_S(void **state) {
    (void)state;
    const float a = 0.4f;
    struct cache_tree tree;
    cache_tree_init(&tree, v3(0, 0, 0), v3(1, 2, 0.2f));
    struct rng rng = rng_make(7, RNG_TEST, 0);
    for (int i = 0; i < RECORDS; i++) {
        struct cache_head head = random_head(&rng, a);
        assert_true(cache_tree_insert(&tree, &head));
    }
    size_t found = 0;
    for (int q = 0; q < QUERIES; q++) {
        vec3 p = cache_tree_random_point(&rng),
             n = sample_uniform_cone(rng_float(&rng), rng_float(&rng), 0.01f);
        struct cache_near near[CACHE_NEAR_MAX];
        int count = cache_tree_find(&tree, p, n, a, near);
        assert_true(count < CACHE_NEAR_MAX);
        assert_int_equal(cache_tree_covered(&tree, p, n, a), count > 0);
        bool in[RECORDS] = {false};
        for (int i = 0; i < count; i++) {
            assert_true(near[i].weight > 0.0f);
            assert_false(in[near[i].record]);
            in[near[i].record] = true;
        }
        for (int i = 0; i < RECORDS; i++) {
            const struct cache_head *h = &tree.head[i];
            float error = error_at(h, p, n);
            if (in[i]) assert_true(error < a * 1.00001f);
            // A record that is near enough is left out only if the point lies in front of it or far
            // from its tangent plane.
            if (fabsf(v3_dot(v3_sub(p, h->p), h->n)) > 0.39f * a * h->R) continue;
            bool behind = v3_dot(v3_sub(p, h->p), v3_add(n, h->n)) >= 0.0f;
            if (error < a * 0.99999f && behind) assert_true(in[i]);
        }
        found += (size_t)count;
    }
    assert_true(found > QUERIES / 2);  // the test has something to find
    cache_tree_free(&tree);
}

static void records_in_front_of_a_point_are_rejected(void **state) {
    (void)state;
    struct cache_tree tree;
    cache_tree_init(&tree, v3(-1, -1, -1), v3(1, 1, 1));
    struct cache_head head = {
        .p = v3(0, 0, 0), .R = 1.0f, .n = v3(0, 0, 1), .search_radius = 0.5f, .scale = 1.0f};
    assert_true(cache_tree_insert(&tree, &head));
    assert_true(cache_tree_covered(&tree, v3(0.1f, 0, 0), v3(0, 0, 1), 0.5f));
    assert_true(cache_tree_covered(&tree, v3(0.1f, 0, 0.2f), v3(0, 0, 1), 0.5f));
    assert_false(cache_tree_covered(&tree, v3(0.1f, 0, -0.2f), v3(0, 0, 1), 0.5f));
    cache_tree_free(&tree);
}

// At a larger accuracy than it was made for, a record's weight still falls to 0 at the search
// radius.
static void weights_end_at_the_search_radius(void **state) {
    (void)state;
    struct cache_tree tree;
    cache_tree_init(&tree, v3(-1, -1, -1), v3(1, 1, 1));
    const struct cache_head head = {
        .p = v3(0, 0, 0), .R = 1.0f, .n = v3(0, 0, 1), .search_radius = 0.5f, .scale = 1.0f};
    assert_true(cache_tree_insert(&tree, &head));
    struct cache_near near[CACHE_NEAR_MAX];
    assert_int_equal(cache_tree_find(&tree, v3(0.3f, 0, 0), v3(0, 0, 1), 0.4f, near), 1);
    assert_float_equal(near[0].weight, 0.25f, 1e-5f);
    assert_int_equal(cache_tree_find(&tree, v3(0.49f, 0, 0), v3(0, 0, 1), 0.8f, near), 1);
    assert_float_equal(near[0].weight, 0.02f, 1e-5f);
    assert_false(cache_tree_covered(&tree, v3(0.51f, 0, 0), v3(0, 0, 1), 0.8f));
    cache_tree_free(&tree);
}

// Limits lower the search radii, the distances that sectors serve stay, and nothing changes in
// queries at smaller accuracies.
static void limits_change_no_query_below_them(void **state) {
    (void)state;
    struct cache_tree whole, limited;
    cache_tree_init(&whole, v3(0, 0, 0), v3(1, 2, 0.2f));
    cache_tree_init(&limited, v3(0, 0, 0), v3(1, 2, 0.2f));
    struct rng rng = rng_make(9, RNG_TEST, 0);
    for (int i = 0; i < RECORDS; i++) {
        struct cache_head head = random_head(&rng, 0.8f);
        head.sector[0] = 50;
        head.sector[1] = 127;
        head.sector[2] = UINT8_MAX;
        assert_true(cache_tree_insert(&whole, &head) && cache_tree_insert(&limited, &head));
    }
    assert_true(cache_tree_limit(&limited, 0.4f));
    assert_int_equal(limited.head_count, RECORDS);
    assert_true(limited.ref_count > 0 && limited.node_count > 0);
    for (int i = 0; i < RECORDS; i++) {
        const struct cache_head *head = &limited.head[i];
        assert_float_equal(head->search_radius, 0.4f * head->R, 1e-6f);
        assert_in_range(head->sector[0], 99, 100);
        assert_in_range(head->sector[1], 253, 254);
        assert_int_equal(head->sector[2], UINT8_MAX);
    }
    size_t sum = 0;
    for (int i = 0; i < QUERIES; i++) {
        const vec3 p = cache_tree_random_point(&rng), n = v3(0, 0, 1);
        struct cache_near of_whole[CACHE_NEAR_MAX], of_limited[CACHE_NEAR_MAX];
        const int count = cache_tree_find(&whole, p, n, 0.3f, of_whole);
        assert_int_equal(cache_tree_find(&limited, p, n, 0.3f, of_limited), count);
        if (count == CACHE_NEAR_MAX) continue;
        double weight = 0.0;
        for (int k = 0; k < count; k++)
            weight += (double)of_whole[k].weight - (double)of_limited[k].weight;
        assert_true(fabs(weight) < 1e-5);
        sum += (size_t)count;
    }
    assert_true(sum > QUERIES);
    cache_tree_free(&whole);
    cache_tree_free(&limited);
}

struct visited {
    bool in[RECORDS];
};

static void test_cache_tree_visit(void *ctx, uint32_t record) {
    ((struct visited *)ctx)->in[record] = true;
}

static void every_sphere_that_intersects_the_ball_is_visited(void **state) {
    (void)state;
    struct cache_tree tree;
    cache_tree_init(&tree, v3(0, 0, 0), v3(1, 2, 0.2f));
    struct rng rng = rng_make(8, RNG_TEST, 0);
    for (int i = 0; i < RECORDS; i++) {
        struct cache_head head = random_head(&rng, 0.4f);
        assert_true(cache_tree_insert(&tree, &head));
    }
    for (int q = 0; q < 200; q++) {
        vec3 p = cache_tree_random_point(&rng);
        float radius = 0.2f * rng_float(&rng);
        struct visited visited = {{false}};
        cache_tree_visit(&tree, p, radius, test_cache_tree_visit, &visited);
        for (int i = 0; i < RECORDS; i++)
            if (v3_dist2(tree.head[i].p, p) < radius * radius) assert_true(visited.in[i]);
    }
    cache_tree_free(&tree);
}

static void an_empty_tree_covers_nothing(void **state) {
    (void)state;
    struct cache_tree tree;
    cache_tree_init(&tree, v3(0, 0, 0), v3(0, 0, 0));
    struct cache_near near[CACHE_NEAR_MAX];
    assert_int_equal(cache_tree_find(&tree, v3(0, 0, 0), v3(0, 0, 1), 1.0f, near), 0);
    assert_false(cache_tree_covered(&tree, v3(0, 0, 0), v3(0, 0, 1), 1.0f));
    cache_tree_free(&tree);
}

// An elliptic record has the radius R along, and less across; its scale lowers both.
static void an_ellipse_and_a_scale_shorten_the_radius(void **state) {
    (void)state;
    struct cache_tree tree;
    cache_tree_init(&tree, v3(-1, -1, -1), v3(1, 1, 1));
    const vec3 up = v3(0, 0, 1);
    // Along x, half of the distance is left: sqrt(2^2 - 1).
    struct cache_head head = {.R = 1.0f, .n = up, .search_radius = 0.5f, .scale = 1.0f};
    head.anisotropy = v3(sqrtf(3.0f), 0, 0);
    assert_true(cache_tree_insert(&tree, &head));
    assert_true(cache_tree_covered(&tree, v3(0, 0.49f, 0), up, 0.5f));
    assert_true(cache_tree_covered(&tree, v3(0.24f, 0, 0), up, 0.5f));
    assert_false(cache_tree_covered(&tree, v3(0.26f, 0, 0), up, 0.5f));
    tree.head[0].scale = 0.5f;
    assert_true(cache_tree_covered(&tree, v3(0, 0.24f, 0), up, 0.5f));
    assert_false(cache_tree_covered(&tree, v3(0, 0.26f, 0), up, 0.5f));
    assert_false(cache_tree_covered(&tree, v3(0.13f, 0, 0), up, 0.5f));
    cache_tree_free(&tree);
}

// A record whose radius is larger than the scene is found everywhere in it.
static void a_radius_beyond_the_scene_is_found(void **state) {
    (void)state;
    struct cache_tree tree;
    cache_tree_init(&tree, v3(-1, -1, -1), v3(1, 1, 1));
    const vec3 up = v3(0, 0, 1);
    struct cache_head head = {.R = 2e9f, .n = up, .search_radius = 1e9f, .scale = 1.0f};
    assert_true(cache_tree_insert(&tree, &head));
    assert_true(cache_tree_covered(&tree, v3(0.9f, -0.9f, 0), up, 0.5f));
    assert_true(cache_tree_covered(&tree, v3(-0.2f, 0.9f, 0), up, 0.5f));
    cache_tree_free(&tree);
}

static void the_nearest_record_is_on_the_same_side_and_layer(void **state) {
    (void)state;
    struct cache_tree tree;
    cache_tree_init(&tree, v3(-4, -4, -4), v3(4, 4, 4));
    const vec3 up = v3(0, 0, 1);
    const struct cache_head head[] = {
        {.p = v3(1, 0, 0), .R = 0.1f, .n = up, .search_radius = 0.1f},     // on the plane, far
        {.p = v3(0, 0.5f, 0), .R = 0.1f, .n = up, .search_radius = 0.1f},  // on the plane, near
        {.p = v3(0, 0.1f, 0),
         .R = 0.1f,
         .n = v3(1, 0, 0),
         .search_radius = 0.1f},                                             // faces elsewhere
        {.p = v3(0, 0, -0.45f), .R = 0.1f, .n = up, .search_radius = 0.1f},  // a layer below
    };
    assert_int_equal(cache_tree_nearest(&tree, v3(0, 0, 0), up, 1.0f), -1);
    for (int i = 0; i < 4; i++) assert_true(cache_tree_insert(&tree, &head[i]));
    assert_int_equal(cache_tree_nearest(&tree, v3(0, 0, 0), up, 1.0f), 1);
    assert_int_equal(cache_tree_nearest(&tree, v3(0, 0, 0), up, 0.4f), -1);
    assert_int_equal(cache_tree_nearest(&tree, v3(0.9f, 0, 0), up, 0.4f), 0);
    cache_tree_free(&tree);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_ellipse_and_a_scale_shorten_the_radius),
        cmocka_unit_test(a_radius_beyond_the_scene_is_found),
        cmocka_unit_test(the_nearest_record_is_on_the_same_side_and_layer),
        cmocka_unit_test(queries_find_exactly_the_set_S),
        cmocka_unit_test(records_in_front_of_a_point_are_rejected),
        cmocka_unit_test(weights_end_at_the_search_radius),
        cmocka_unit_test(limits_change_no_query_below_them),
        cmocka_unit_test(every_sphere_that_intersects_the_ball_is_visited),
        cmocka_unit_test(an_empty_tree_covers_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
