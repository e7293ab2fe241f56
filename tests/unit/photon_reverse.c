// SPDX-License-Identifier: Apache-2.0
// First pass `reverse`: in a closed furnace, whose irradiance is known, its mean and how its noise
// falls with the batches; the same sums as by one map of all photons; light paths of limited
// length; and the same bits for any number of threads, from a journal too.
#include "photon_case.h"
#include "test_scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "photon/photon_map.h"

enum { BATCH = 20000 };

// A box that emits 1 and reflects half: the irradiance is 2 pi, of which pi is direct light.
static void closed_furnace(struct test_scene *t) {
    test_scene_init(t);
    const uint32_t grey = test_diffuse(t, 0.5f, 0.5f, 0.5f);
    test_area_light(t, test_cube(t, mat4_identity(), true, grey), rgb_grey(1.0f));
    test_scene_finish(t);
}

static satin_options reverse_options(int batches, int max_depth) {
    satin_options o = satin_options_default;
    o.first_pass = SATIN_FIRST_REVERSE;
    o.photons = (int64_t)batches * BATCH;
    o.photon_batch = BATCH;
    o.caustic_photons = 0;
    o.gather_direct = false;
    o.max_depth = max_depth;
    return o;
}

static struct photon_maps *build(const struct test_scene *t, const satin_options *o, int threads,
                                 struct stats *stats) {
    struct parallel *pool = parallel_new(threads);
    struct photon_maps *maps = NULL;
    assert_int_equal(photon_case_build(&t->scene, o, pool, stats, &maps), SATIN_OK);
    parallel_free(pool);
    return maps;
}

// Means over the entries far from edges, in units of the exact irradiance; `late` is the mean
// square of the differences from it, without the first batch.
struct furnace_result {
    double mean, late;
};

static struct furnace_result read_furnace(const struct photon_maps *one,
                                          const struct photon_maps *maps, int batches) {
    const struct photon_irradiance *first = &one->irradiance, *r = &maps->irradiance;
    struct furnace_result result = {0};
    size_t count = 0;
    assert_int_equal(first->count, r->count);
    for (size_t i = 0; i < r->count; i++) {
        const vec3 p = photon_entry_position(&r->position, i);
        const float x = fabsf(p.x), y = fabsf(p.y), z = fabsf(p.z), most = 1.0f - r->radius[i];
        if ((x > most) + (y > most) + (z > most) != 1) continue;
        assert_true(first->radius[i] == r->radius[i]);
        const double all = (double)r->E[i].g, E = (double)first->E[i].g,
                     late = (all * batches - E) / (batches > 1 ? batches - 1 : 1);
        result.mean += all / (2.0 * M_PI);
        result.late += pow(late / (2.0 * M_PI) - 1.0, 2.0);
        count++;
    }
    assert_true(count > 2000);
    result.mean /= (double)count;
    result.late /= (double)count;
    return result;
}

// After the first batch, a disc of the radius of 50 photons has 49 of a batch on average: the
// variance of one is 1 / 49, and of 8 an eighth of that. There are 3,600 entries, of which about
// one in six has photons of its own, so the variance is known within some 6 %. The mean has the
// first batch, whose estimates at photons are too bright by 1 / 49 (photon_irradiance.c).
static void noise_falls_with_the_batches(void **state) {
    (void)state;
    struct test_scene t;
    closed_furnace(&t);
    struct photon_maps *maps[3];
    struct furnace_result result[3];
    static const int batches[3] = {1, 2, 9};
    for (int i = 0; i < 3; i++) {
        const satin_options o = reverse_options(batches[i], -1);
        struct stats stats = {0};
        maps[i] = build(&t, &o, 2, &stats);
        assert_true(stats_get(&stats, "photons.emitted") == (double)o.photons);
        assert_true(stats_get(&stats, "photons.stored_direct") == (double)o.photons);
        assert_true(stats_get(&stats, "photons.batches") == (double)batches[i]);
        assert_true(fabs(stats_get(&stats, "photons.power_emitted") / (24.0 * M_PI) - 1.0) < 1e-4);
        result[i] = read_furnace(maps[0], maps[i], batches[i]);
        printf("%d batches: mean %.4f, variance of those after the first %.5f\n", batches[i],
               result[i].mean, result[i].late);
        const double bright = 1.0 / 49.0 / batches[i];
        assert_true(fabs(result[i].mean - 1.0 - bright) < 0.006);
    }
    assert_true(fabs(49.0 * result[1].late - 1.0) < 0.25);
    assert_true(fabs(8.0 * result[2].late / result[1].late - 1.0) < 0.25);
    for (int i = 0; i < 3; i++) photon_maps_free(maps[i]);
    test_scene_free(&t);
}

// Builds a map of the photons of all batches of these options. *out is the number of photons.
static void build_one_map(const struct test_scene *t, const satin_options *o, int batches,
                          struct parallel *pool, struct photon_map *map, size_t *out) {
    struct guide_allocation allocation;
    guide_allocation_make(&t->scene, o->seed, render_budget_paths(o, 0.0).seen, pool, &allocation);
    struct photon_hit *hit = NULL;
    size_t count = 0;
    for (int b = 0; b < batches; b++) {
        const struct photon_tracing tracing = {
            .scene = &t->scene,
            .seed = b ? rng_mix(o->seed + RNG_GOLDEN * (uint64_t)b) : o->seed,
            .consumer = {{.paths = BATCH, .classes = 7, .allocation = &allocation}},
            .bounces = -1};
        struct photon_trace trace[PHOTON_CONSUMERS];
        assert_int_equal(photon_trace_run(&tracing, pool, (struct log){0}, trace), SATIN_OK);
        hit = realloc(hit, (count + trace->count) * sizeof *hit);
        assert_non_null(hit);
        memcpy(hit + count, trace->hit, trace->count * sizeof *hit);
        count += trace->count;
        photon_trace_free(trace);
    }
    assert_int_equal(photon_map_build(&t->scene, hit, count, pool, (struct log){0}, map), SATIN_OK);
    free(hit);
    *out = count;
}

// The photons of all batches in one map, searched in the discs of the entries, give the same sums;
// edges and corners included.
static void the_sums_are_those_of_one_map(void **state) {
    (void)state;
    enum { BATCHES = 3 };
    struct test_scene t;
    closed_furnace(&t);
    satin_options o = reverse_options(BATCHES, -1);
    o.guide_clusters = false;
    struct stats stats = {0};
    struct photon_maps *maps = build(&t, &o, 2, &stats);
    struct parallel *pool = parallel_new(2);
    struct photon_map map;
    size_t count;
    build_one_map(&t, &o, BATCHES, pool, &map, &count);
    const struct photon_irradiance *r = &maps->irradiance;
    int *row = malloc(count * sizeof *row);
    float *distance2 = malloc(count * sizeof *distance2);
    double sum = 0.0, sum_of_batches = 0.0;
    int corrected = 0;
    for (size_t i = 0; i < r->count; i += 7) {
        const float *at = r->position.row + 6 * i;
        struct photon_disc disc = {
            .map = &map,
            .p = v3(at[0], at[1], at[2]),
            .n = v3_unit(v3(at[3], at[4], at[5])),
            .kernel = KERNEL_FLAT,
            .row = row,
            .distance2 = distance2,
            .r = r->radius[i],
            .r2 = sqrf(r->radius[i]),
        };
        disc.count = photon_index_within(map.index, at, (int)count, disc.r2, row, distance2);
        photon_disc_scale(&disc, &t.scene);
        const double E = (double)photon_disc_irradiance(&disc).g / BATCHES;
        // Whether the outermost photon of the first batch counts is a matter of rounding here.
        const double power = 24.0 * M_PI / BATCH, most = power * (double)disc.scale / BATCHES;
        assert_true(fabs(E - (double)r->E[i].g) < 1.01 * most);
        sum += E;
        sum_of_batches += (double)r->E[i].g;
        corrected += disc.corrected;
    }
    printf("one map %.5f, batches %.5f\n", sum, sum_of_batches);
    assert_true(fabs(sum / sum_of_batches - 1.0) < 0.007 && corrected > 50);
    free(row);
    free(distance2);
    photon_map_free(&map);
    photon_maps_free(maps);
    parallel_free(pool);
    test_scene_free(&t);
}

// Paths of two segments after the eye's carry direct light alone, which is half of all light, and
// the part of the last bounce is all of it.
static void lengths_of_paths_are_limited(void **state) {
    (void)state;
    struct test_scene t;
    closed_furnace(&t);
    satin_options o = reverse_options(4, 3);
    struct stats stats = {0};
    struct photon_maps *maps = build(&t, &o, 2, &stats);
    const struct photon_irradiance *r = &maps->irradiance;
    double sum = 0.0;
    for (size_t i = 0; i < r->count; i++) {
        assert_true(fabsf(r->last[i].g - r->E[i].g) <= 1e-5f * r->E[i].g);
        sum += (double)r->E[i].g / (M_PI * (double)r->count);
    }
    assert_true(fabs(sum - 1.0) < 0.02);
    photon_maps_free(maps);
    test_scene_free(&t);
}

// The results of loops, as a checkpoint has them.
struct loops {
    struct bytes *loop;
    int count, read;
};

static bool read_known_loop(void *user, struct parallel_entry *entry, struct bytes *out) {
    struct loops *loops = user;
    // Passing results of short loops are not written.
    if (entry->passing || loops->read == loops->count) return false;
    entry->last = true;
    const struct bytes *loop = &loops->loop[loops->read++];
    bytes_put(out, loop->data, loop->count);
    return true;
}

static void write_known_loop(void *user, struct parallel_entry entry, const struct bytes *results) {
    struct loops *loops = user;
    assert_true(entry.last);
    loops->loop = realloc(loops->loop, (size_t)(loops->count + 1) * sizeof *loops->loop);
    assert_non_null(loops->loop);
    loops->loop[loops->count] = (struct bytes){0};
    bytes_put(&loops->loop[loops->count], results->data, results->count);
    loops->read = ++loops->count;
}

static bool equal_irradiance(const struct photon_maps *a, const struct photon_maps *b) {
    const struct photon_irradiance *x = &a->irradiance, *y = &b->irradiance;
    return x->count == y->count && memcmp(x->E, y->E, x->count * sizeof *x->E) == 0 &&
           memcmp(x->last, y->last, x->count * sizeof *x->last) == 0 &&
           memcmp(x->radius, y->radius, x->count * sizeof *x->radius) == 0;
}

// A process that ends after any loop leaves those before it in the journal. The photons of batches
// are not in it, and are not traced again if their sums are.
static void bits_are_equal(void **state) {
    (void)state;
    struct test_scene t;
    closed_furnace(&t);
    satin_options o = reverse_options(3, 8);
    struct stats stats = {0};
    struct photon_maps *one = build(&t, &o, 1, &stats), *three = build(&t, &o, 3, &stats);
    assert_true(equal_irradiance(one, three));
    photon_maps_free(three);
    struct loops loops = {0};
    const struct parallel_journal journal = {&loops, read_known_loop, write_known_loop, NULL};
    int all = 0;
    for (int left = 0; left <= all; left++) {
        for (int i = left; i < loops.count; i++) bytes_free(&loops.loop[i]);
        if (left < loops.count) loops.count = left;
        loops.read = 0;
        struct parallel *pool = parallel_new(2);
        struct photon_maps *maps = NULL;
        stats = (struct stats){0};
        parallel_set_journal(pool, &journal, PARALLEL_ALL_LOOPS);
        assert_int_equal(photon_case_build(&t.scene, &o, pool, &stats, &maps), SATIN_OK);
        assert_true(equal_irradiance(one, maps));
        assert_true(stats_get(&stats, "photons.emitted") == 3.0 * BATCH);
        assert_true(fabs(stats_get(&stats, "photons.power_emitted") / (24.0 * M_PI) - 1.0) < 1e-4);
        photon_maps_free(maps);
        parallel_free(pool);
        all = loops.count;
    }
    assert_true(all >= 4);
    for (int i = 0; i < all; i++) bytes_free(&loops.loop[i]);
    free(loops.loop);
    photon_maps_free(one);
    test_scene_free(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(noise_falls_with_the_batches),
        cmocka_unit_test(the_sums_are_those_of_one_map),
        cmocka_unit_test(lengths_of_paths_are_limited),
        cmocka_unit_test(bits_are_equal),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
