// SPDX-License-Identifier: Apache-2.0
// Sorting in Morton order on any number of threads, and the kd-tree that is built of cells
// of that order: it finds the same points as a single tree, for any number of threads.
#include "test_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/sampling.h"
#include "photon/photon_index.h"
#include "photon/photon_morton.h"

enum { COUNT = 30000, QUERIES = 500, K = 20, LAYOUTS = 3 };

static const int THREADS[] = {1, 2, 3, 8};
static const struct photon_morton MORTON = {{0.0f, 0.0f, 0.0f}, 1024.0f};

// Makes points in the unit cube: spread uniformly, most of them in a few small spots, or all in a
// few points, one of which has half of them.
static vec3 point_of(int layout, struct rng *rng) {
    const float u = rng_float(rng);
    vec3 p = v3(rng_float(rng), rng_float(rng), rng_float(rng));
    if (layout == 1 && u < 0.9f) {
        const float spot = floorf(10.0f * u) / 10.0f;
        p = v3(spot + 1e-3f * p.x, 0.5f + 1e-4f * p.y, spot + 1e-5f * p.z);
    }
    if (layout == 2)
        p = u < 0.5f ? v3(0.3f, 0.3f, 0.3f) : v3(floorf(4.0f * p.x) / 4.0f, 0.5f, 1.0f);
    return p;
}

// Makes rows in Morton order: `columns` floats each, of which those after the third are +-0.01.
static float *sorted_rows(int layout, int columns, struct parallel *pool) {
    struct photon_keyed *key = calloc(2 * COUNT, sizeof *key);
    vec3 *p = calloc(COUNT, sizeof *p);
    float *row = calloc((size_t)(COUNT * columns), sizeof *row);
    struct rng rng = rng_make(1, RNG_TEST, (uint64_t)layout);
    for (uint32_t i = 0; i < COUNT; i++) {
        p[i] = point_of(layout, &rng);
        key[i] = (struct photon_keyed){photon_morton_key(&MORTON, p[i]), i};
    }
    const struct photon_keyed *order = photon_morton_sort(key, key + COUNT, COUNT, pool);
    assert_non_null(order);
    for (int i = 0; i < COUNT; i++) {
        const vec3 q = p[order[i].item];
        float *out = row + i * columns;
        if (i > 0) {  // stable
            assert_true(order[i - 1].key <= order[i].key);
            assert_true(order[i - 1].key < order[i].key || order[i - 1].item < order[i].item);
        }
        out[0] = q.x;
        out[1] = q.y;
        out[2] = q.z;
        for (int k = 3; k < columns; k++) out[k] = rng_float(&rng) < 0.5f ? -0.01f : 0.01f;
    }
    free(key);
    free(p);
    return row;
}

static void threads_do_not_change_the_order(void **state) {
    (void)state;
    for (int layout = 0; layout < LAYOUTS; layout++) {
        float *first = NULL;
        for (size_t t = 0; t < sizeof THREADS / sizeof *THREADS; t++) {
            struct parallel *pool = parallel_new(THREADS[t]);
            float *row = sorted_rows(layout, 3, pool);
            if (first) assert_memory_equal(row, first, 3 * COUNT * sizeof *row);
            if (first)
                free(row);
            else
                first = row;
            parallel_free(pool);
        }
        free(first);
    }
}

static void cells_cover_all_points(void **state) {
    (void)state;
    enum { MOST = 700 };
    struct parallel *pool = parallel_new(2);
    float *row = sorted_rows(1, 6, pool);
    struct photon_morton_tree tree;
    assert_true(photon_morton_split(&MORTON, row, 6, COUNT, MOST, &tree));
    size_t next = 0, cells = 0;
    for (size_t i = 0; i < tree.count; i++) {
        const struct photon_morton_node *node = &tree.node[i];
        if (node->column >= 0) {  // a plane keeps the children apart
            const size_t middle = tree.node[node->second].begin;
            float most = -INFINITY, least = INFINITY;
            for (size_t k = node->begin; k < middle; k++)
                most = fmaxf(most, row[6 * k + (size_t)node->column]);
            for (size_t k = middle; k < node->end; k++)
                least = fminf(least, row[6 * k + (size_t)node->column]);
            assert_true(most <= least);
            continue;
        }
        assert_int_equal(node->begin, next);
        assert_true(node->end > node->begin);
        next = node->end;
        cells++;
    }
    assert_int_equal(next, COUNT);
    assert_int_equal(cells, tree.cells);
    assert_true(cells > COUNT / MOST / 2);
    free(tree.node);
    free(row);
    parallel_free(pool);
}

static void search(const float *row, int columns, const struct photon_morton *morton, int threads,
                   const float *query, int k, int *found, float *distance2) {
    struct parallel *pool = parallel_new(threads);
    struct photon_index *index = photon_index_new(row, COUNT, columns, morton, pool);
    assert_non_null(index);
    parallel_free(pool);
    photon_index_nearest(index, query, QUERIES, k, INFINITY, found, distance2);
    photon_index_free(index);
}

static int compare_floats(const void *a, const void *b) {
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

// Both give equal distances; rows are at the distances that are reported, and no row is reported
// twice, so that only rows at the largest distance can differ.
static void assert_same_neighbours(const float *row, int columns, const float *query, int k,
                                   const int *found, float *distance2, float *expected) {
    for (int j = 0; j < k; j++) {
        float d2 = 0.0f;
        for (int c = 0; c < columns; c++) d2 += sqrf(query[c] - row[found[j] * columns + c]);
        assert_true(d2 == distance2[j]);
        for (int i = 0; i < j; i++) assert_int_not_equal(found[i], found[j]);
    }
    qsort(distance2, (size_t)k, sizeof *distance2, compare_floats);
    qsort(expected, (size_t)k, sizeof *expected, compare_floats);
    assert_memory_equal(distance2, expected, (size_t)k * sizeof *distance2);
}

static void cells_find_what_one_tree_finds(void **state) {
    (void)state;
    static float query[6 * QUERIES], distance2[QUERIES * K], whole2[QUERIES * K];
    static int found[QUERIES * K], first[QUERIES * K], whole[QUERIES * K];
    for (int run = 0; run < 4 * LAYOUTS; run++) {
        const int layout = run / 4, columns = run & 1 ? 3 : 6, k = run & 2 ? 1 : K;
        struct parallel *pool = parallel_new(1);
        float *row = sorted_rows(layout, columns, pool);
        parallel_free(pool);
        struct rng rng = rng_make(2, RNG_TEST, (uint64_t)run);
        for (int i = 0; i < QUERIES * columns; i++) {
            // The queries are near rows, and anywhere.
            query[i] = 1.2f * rng_float(&rng) - 0.1f;
            if (i / columns % 2) query[i] = row[i * 37 / columns * columns % (COUNT * columns)];
        }
        search(row, columns, NULL, 1, query, k, whole, whole2);
        for (size_t t = 0; t < sizeof THREADS / sizeof *THREADS; t++) {
            search(row, columns, &MORTON, THREADS[t], query, k, found, distance2);
            if (t == 0) memcpy(first, found, sizeof found);
            assert_memory_equal(found, first, (size_t)(QUERIES * k) * sizeof *found);
        }
        for (int i = 0; i < QUERIES; i++)
            assert_same_neighbours(row, columns, query + i * columns, k, found + i * k,
                                   distance2 + i * k, whole2 + i * k);
        free(row);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_do_not_change_the_order),
        cmocka_unit_test(cells_cover_all_points),
        cmocka_unit_test(cells_find_what_one_tree_finds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
