// SPDX-License-Identifier: Apache-2.0
// Frames in which objects or lights have moved. Each is a render of its own, of a scene of its own,
// with photons of its own; but it begins with those records of the scene at rest whose light has
// not changed. To know which, a few rays, the test rays of a record, are traced from it in both
// scenes, with the same random numbers: where they hit, and what light they bring. So it does not
// matter what has moved, and how the light of a record depends on it. What is kept in a frame
// depends on the scene at rest and on that frame, not on other frames.
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "base/sampling.h"
#include "render/render_state.h"

enum { TEST_SIDE = 8, TEST_RAYS = TEST_SIDE * TEST_SIDE };  // strata of a hemisphere
// The largest change of a record that is kept, as a fraction of its light (docs/animation.md).
static const float CHANGE_MOST = 0.02f;
// Distances that differ by less, as a fraction, are of one surface.
static const float SAME_DISTANCE = 1e-3f;

// What the rays of a record meet. Distances are INFINITY where that is nothing.
struct record_test {
    float foot;                        // the surface below a point just above the record
    float r[TEST_RAYS], L[TEST_RAYS];  // distances, and luminances of the light they bring
};
struct render_tests {
    struct record_test *of[CACHE_KINDS];  // of the records, in their order
};

// ---- Test rays ----------------------------------------------------------------------------------

struct test_loop {
    const struct render *r;     // in whose scene the rays are traced
    const struct cache *cache;  // whose records they are of
    enum cache_kind kind;
    struct record_test *out;
    struct gather_worker *worker;
};

static void test_record(const struct test_loop *loop, size_t i, struct gather_scratch *scratch,
                        struct record_test *out) {
    const struct render *r = loop->r;
    const struct cache_head *head = &loop->cache->store[loop->kind].tree.head[i];
    const struct frame frame = frame_from_normal(head->n);
    struct rng rng = rng_make(r->options.seed, RNG_RECORD_TEST, 2 * (uint64_t)i + loop->kind);
    struct gather_ray ray[TEST_RAYS];
    // A record is on a surface if that is met from this height.
    const float height = fmaxf(0.01f * head->R, 8.0f * r->scene.epsilon);
    const vec3 above = v3_mad(head->p, height, head->n);
    out->foot =
        scene_distance(&r->scene, &(struct ray){above, 0.0f, v3_neg(head->n), 2.0f * height});
    for (int k = 0; k < TEST_RAYS; k++) {
        const float u = sample_stratum(k / TEST_SIDE, rng_float(&rng), TEST_SIDE),
                    v = sample_stratum(k % TEST_SIDE, rng_float(&rng), TEST_SIDE);
        const vec3 d = frame_to_world(&frame, sample_cosine_hemisphere(u, v));
        ray[k] = (struct gather_ray){.ray = scene_spawn(&r->scene, head->p, head->n, d),
                                     .item = (uint32_t)k};
    }
    gather_rays(&r->second_pass.gather, scratch, ray, TEST_RAYS,
                rng_mix(2 * (uint64_t)i + loop->kind));
    for (int k = 0; k < TEST_RAYS; k++) {
        out->r[k] = ray[k].first.r;
        out->L[k] = rgb_luminance(ray[k].L);
    }
}

static void test_records(void *ctx, size_t begin, size_t end, int worker) {
    const struct test_loop *loop = ctx;
    for (size_t i = begin; i < end; i++)
        test_record(loop, i, loop->worker[worker].scratch, &loop->out[i]);
}

// Tests the records of a kind, of which `cache` has at least one, in the scene of r.
static satin_status test_all(const struct render *r, const struct cache *cache,
                             enum cache_kind kind, struct record_test **out) {
    const size_t count = cache_count(cache, kind);
    struct test_loop loop = {r, cache, kind, array_new(count, sizeof *loop.out),
                             gather_workers_new(r->pool, TEST_RAYS)};
    const struct parallel_results results = {.slot[0] = {loop.out, sizeof *loop.out}};
    satin_status status = loop.out && loop.worker ? SATIN_OK : SATIN_ERROR_MEMORY;
    if (status == SATIN_OK &&
        !parallel_for_results(r->pool, count, 16, test_records, &loop, &results))
        status = SATIN_CANCELLED;
    gather_workers_free(loop.worker, parallel_threads(r->pool));
    if (status == SATIN_OK)
        *out = loop.out;
    else
        free(loop.out);
    return status;
}

satin_status render_tests_make(struct render *r) {
    const struct cache *cache = r->second_pass.cache;
    satin_status status = SATIN_OK;
    if (!render_has_stage(r, STAGE_RECORDS)) return SATIN_OK;
    struct render_tests *tests = calloc(1, sizeof *tests);
    if (!tests) return SATIN_ERROR_MEMORY;
    r->motion.tests = tests;
    parallel_begin_part(r->pool, "tests");
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS && status == SATIN_OK; k++)
        if (cache_count(cache, k)) status = test_all(r, cache, k, &tests->of[k]);
    return status;
}

void render_tests_free(struct render_tests *tests) {
    if (!tests) return;
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++) free(tests->of[k]);
    free(tests);
}

// ---- Which records are kept ---------------------------------------------------------------------

static bool same_distance(float a, float b) {
    return a == b || fabsf(a - b) < SAME_DISTANCE * fminf(a, b);
}

// The fraction of a record's light that has changed: all light of rays that meet something else,
// and the sum of the changes of the others, whose noise cancels.
static float changed_fraction(const struct record_test *before, const struct record_test *now) {
    float met = 0.0f, change = 0.0f, all = 0.0f;
    for (int k = 0; k < TEST_RAYS; k++) {
        const float most = fmaxf(before->L[k], now->L[k]);
        if (same_distance(before->r[k], now->r[k]))
            change += now->L[k] - before->L[k];
        else
            met += most;
        all += most;
    }
    return all > 0.0f ? (met + fabsf(change)) / all : 0.0f;
}

static bool is_kept(const struct record_test *before, const struct record_test *now) {
    return same_distance(before->foot, now->foot) && changed_fraction(before, now) < CHANGE_MOST;
}

// Whether a point is inside of the octree of a cache.
static bool is_inside(const struct cache_tree *tree, vec3 p) {
    const vec3 d = v3_sub(p, tree->lo);
    return fminf(fminf(d.x, d.y), d.z) >= 0.0f && v3_max_abs(d) <= tree->size;
}

satin_status render_keep_records(struct render *r) {
    const struct render *at_rest = r->motion.at_rest;
    const struct cache *from = at_rest->second_pass.cache;
    struct cache *to = r->second_pass.cache;
    const char *part = parallel_begin_part(r->pool, "tests");
    r->scene.view = NULL;  // records are made for the view of the frame alone
    const double start = stats_wall();
    satin_status status = SATIN_OK;
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS && status == SATIN_OK; k++) {
        const struct record_test *before = at_rest->motion.tests->of[k];
        struct record_test *now = NULL;
        if (!before || from->store[k].order != to->store[k].order) continue;
        status = test_all(r, from, k, &now);
        for (size_t i = 0; status == SATIN_OK && i < cache_count(from, k); i++) {
            const bool fits = is_inside(&to->store[k].tree, from->store[k].tree.head[i].p);
            if (fits && is_kept(&before[i], &now[i]) && !cache_insert_copy(to, from, k, i))
                status = SATIN_ERROR_MEMORY;
        }
        free(now);
    }
    stats_set(&r->stats, "frame.records_kept", (double)cache_count_all(to));
    stats_set(&r->stats, "frame.records_dropped",
              (double)(cache_count_all(from) - cache_count_all(to)));
    stats_set(&r->stats, "frame.tests_s", stats_wall() - start);
    parallel_begin_part(r->pool, part);
    return status;
}

// ---- The render of a frame ----------------------------------------------------------------------

struct render *render_frame_new(const struct render *at_rest) {
    const struct render_frames *frames = &at_rest->frames;
    satin_callbacks callbacks = at_rest->callbacks;
    callbacks.animation = NULL;
    callbacks.load_cache = callbacks.save_cache = callbacks.checkpoint = NULL;
    struct render *r = render_new(&callbacks);
    if (!r) return NULL;
    const int number = frames->next - 1;
    r->motion.at_rest = at_rest;
    r->motion.camera = &frames->view[number - at_rest->callbacks.animation->number];
    // What is reported of it is that of the whole render.
    r->progress.start = at_rest->progress.start;
    r->frames = *frames;
    r->frames.view = NULL;  // they are the other render's
    r->frames.records = NULL;
    r->frames.complete = NULL;
    stats_set(&r->stats, "frame.number", number);
    return r;
}
