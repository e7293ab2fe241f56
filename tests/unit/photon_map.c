// SPDX-License-Identifier: Apache-2.0
// The kd-tree against a full search, with fewer rows than asked for and with queries that are not
// finite; packed directions; the map's order.
#include "test_scene.h"

#include <math.h>
#include <stdlib.h>

#include "base/sampling.h"
#include "photon/photon_map.h"

enum { ROWS = 500, QUERIES = 200, K = 12 };

static float distance2_to(const float *a, const float *b, int columns) {
    float d2 = 0.0f;
    for (int i = 0; i < columns; i++) d2 += sqrf(a[i] - b[i]);
    return d2;
}

// How many rows are nearer to q than d2.
static int nearer(const float *data, int rows, int columns, const float *q, float d2) {
    int n = 0;
    for (int i = 0; i < rows; i++) n += distance2_to(data + i * columns, q, columns) < d2;
    return n;
}

static void search_is_exact(void **state) {
    (void)state;
    static float data[ROWS * 6], query[QUERIES * 6], distance2[QUERIES * K];
    static int row[QUERIES * K], all[ROWS];
    static float all_distance2[ROWS];
    struct parallel *pool = parallel_new(1);
    for (int columns = 3; columns <= 6; columns += 3) {
        struct rng rng = rng_make(1, RNG_TEST, (uint64_t)columns);
        for (int i = 0; i < ROWS * columns; i++) data[i] = rng_float(&rng);
        for (int i = 0; i < QUERIES * columns; i++) query[i] = rng_float(&rng) * 1.2f - 0.1f;
        struct photon_index *index = photon_index_new(data, ROWS, columns, NULL, pool);
        assert_non_null(index);
        photon_index_nearest(index, query, QUERIES, K, INFINITY, row, distance2);
        for (int i = 0; i < QUERIES; i++) {
            float most = 0.0f;
            const float *q = query + i * columns;
            for (int j = 0; j < K; j++) {
                int r = row[i * K + j];
                assert_in_range(r, 0, ROWS - 1);
                float d2 = distance2_to(data + r * columns, q, columns);
                assert_true(fabsf(d2 - distance2[i * K + j]) < 1e-5f);
                most = fmaxf(most, distance2[i * K + j]);
            }
            assert_true(nearer(data, ROWS, columns, q, most * 0.9999f) < K);
            assert_true(nearer(data, ROWS, columns, q, most * 1.0001f) >= K);
            // Within that distance there are as many, of which the nearest are found if they are
            // too many.
            const float r2 = most * 1.00001f;
            const int within = nearer(data, ROWS, columns, q, r2);
            assert_int_equal(photon_index_within(index, q, ROWS, r2, all, all_distance2), within);
            for (int j = 0; j < within; j++) assert_true(all_distance2[j] < r2);
            assert_int_equal(photon_index_within(index, q, K / 2, r2, all, all_distance2), K / 2);
            float far2 = 0.0f;
            for (int j = 0; j < K / 2; j++) far2 = fmaxf(far2, all_distance2[j]);
            assert_true(nearer(data, ROWS, columns, q, far2 * 0.9999f) < K / 2);
        }
        photon_index_free(index);
    }
    parallel_free(pool);
}

// Each row is twice as far from the origin as the one before on its axis, so the tree separates
// them one by one and is deeper than a search has memory for.
static void search_of_deep_tree_is_exact(void **state) {
    (void)state;
    enum { DEEP = 360, NEAREST = 2 };
    static float data[DEEP * 3], distance2[DEEP * NEAREST];
    static int row[DEEP * NEAREST];
    for (int i = 0; i < DEEP; i++) data[3 * i + i % 3] = ldexpf(1.0f, i / 3 - DEEP / 6);
    struct parallel *pool = parallel_new(1);
    struct photon_index *index = photon_index_new(data, DEEP, 3, NULL, pool);
    assert_non_null(index);
    for (int k = 1; k <= NEAREST; k++) {
        photon_index_nearest(index, data, DEEP, k, INFINITY, row, distance2);
        for (int i = 0; i < DEEP; i++) {
            float most = 0.0f;
            for (int j = 0; j < k; j++) most = fmaxf(most, distance2[i * k + j]);
            assert_true(nearer(data, DEEP, 3, data + 3 * i, most) < k);
            assert_true(nearer(data, DEEP, 3, data + 3 * i, fmaxf(most * 1.0001f, 1e-37f)) >= k);
        }
    }
    photon_index_free(index);
    parallel_free(pool);
}

static void few_rows_and_extreme_queries_are_harmless(void **state) {
    (void)state;
    const float data[9] = {0, 0, 0, 1, 0, 0, 0, 2, 0};
    const float query[9] = {0.1f, 0, 0, NAN, 0, 0, 0, 2, INFINITY};
    struct parallel *pool = parallel_new(1);
    struct photon_index *index = photon_index_new(data, 3, 3, NULL, pool);
    int row[15];
    float distance2[15];
    photon_index_nearest(index, query, 3, 5, INFINITY, row, distance2);
    int found = 0;
    for (int i = 0; i < 15; i++) {
        assert_true((row[i] < 0) == isinf(distance2[i]));
        found += row[i] >= 0;
        if (row[i] >= 0) assert_in_range(i, 0, 4);
    }
    assert_int_equal(found, 3);
    photon_index_nearest(index, query, 3, 1, INFINITY, row, distance2);
    assert_int_equal(row[0], 0);
    assert_int_equal(row[1], -1);
    assert_int_equal(row[2], -1);
    photon_index_free(index);
    photon_index_free(NULL);
    parallel_free(pool);
}

// There are 16 bits for each of two coordinates, so the error is at most 7e-5 rad.
static void packing_is_precise(void **state) {
    (void)state;
    for (uint32_t i = 0; i < 100000; i++) {
        vec2 u = sample_sobol2(i, 1);
        vec3 w = sample_uniform_sphere(u.x, u.y), back = photon_unpack(photon_pack(w));
        assert_true(v3_len(v3_sub(w, back)) < 7e-5f);
        assert_true(fabsf(v3_len(back) - 1.0f) < 1e-6f);
    }
    for (int axis = 0; axis < 6; axis++) {
        float s = axis & 1 ? -1.0f : 1.0f;
        vec3 w = v3(axis / 2 == 0 ? s : 0.0f, axis / 2 == 1 ? s : 0.0f, axis / 2 == 2 ? s : 0.0f);
        assert_true(v3_len(v3_sub(w, photon_unpack(photon_pack(w)))) == 0.0f);
    }
}

// All photons are there once, and neighbours in memory are neighbours in space.
static void map_keeps_all_in_order(void **state) {
    (void)state;
    enum { N = 4096 };
    struct test_scene t;
    test_scene_init(&t);
    test_cube(&t, mat4_identity(), true, test_diffuse(&t, 0.5f, 0.5f, 0.5f));
    test_scene_finish(&t);
    struct photon_hit *hit = calloc(N, sizeof *hit);
    double sum = 0.0, found = 0.0, step = 0.0;
    for (uint32_t i = 0; i < N; i++) {
        vec2 u = sample_sobol2(i, 1);
        hit[i].p = v3(2 * u.x - 1, 2 * u.y - 1, -1);
        hit[i].power = rgb_grey((float)i);
        sum += (double)i * (double)hit[i].p.x;
    }
    struct photon_map map;
    struct log quiet = {0};
    struct parallel *pool = parallel_new(1);
    assert_int_equal(photon_map_build(&t.scene, hit, N, pool, quiet, &map), SATIN_OK);
    parallel_free(pool);
    for (size_t i = 0; i < N; i++) {
        found += (double)map.photon[i].power.r * (double)photon_position(&map, i).x;
        if (i) step += sqrt(v3_dist2(photon_position(&map, i), photon_position(&map, i - 1))) / N;
    }
    assert_true(fabs(sum - found) < 1e-6 * N * N);
    assert_true(step < 3.0 * 2.0 / 64.0);  // the spacing is 2 / 64
    assert_true(photon_map_bytes(&map) > N * 32);
    photon_map_free(&map);
    free(hit);
    test_scene_free(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(search_is_exact),
        cmocka_unit_test(search_of_deep_tree_is_exact),
        cmocka_unit_test(few_rows_and_extreme_queries_are_harmless),
        cmocka_unit_test(packing_is_precise),
        cmocka_unit_test(map_keeps_all_in_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
