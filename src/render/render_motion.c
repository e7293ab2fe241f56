// SPDX-License-Identifier: Apache-2.0
// Frames in which objects or lights have moved. Each is a render of its own, of a scene of its own,
// with photons of its own; but it begins with those records of the scene at rest whose light has
// not changed. To know which, a few rays, the probes of a record, are traced from it in both
// scenes, with the same random numbers: where they hit, and what light they bring. So it does not
// matter what has moved, and how the light of a record depends on it. What is kept in a frame
// depends on the scene at rest and on that frame, not on other frames.
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "base/sampling.h"
#include "render/render_state.h"

enum { PROBE_SIDE = 8, PROBE_RAYS = PROBE_SIDE * PROBE_SIDE };  // strata of a hemisphere
// The largest change of a record that is kept, as a fraction of its light (docs/animation.md).
static const float CHANGE_MOST = 0.02f;
// Distances that differ by less, as a fraction, are of one surface.
static const float SAME_DISTANCE = 1e-3f;

// What the rays of a record meet. Distances are INFINITY where that is nothing.
struct record_probe {
    float foot;                          // the surface below a point just above the record
    float r[PROBE_RAYS], L[PROBE_RAYS];  // distances, and luminances of the light they bring
};
struct render_probes {
    struct record_probe *of[CACHE_KINDS];  // of the records, in their order
};

// ---- Probes -------------------------------------------------------------------------------------

struct probe_job {
    const struct render *r;     // in whose scene the rays are traced
    const struct cache *cache;  // whose records they are of
    enum cache_kind kind;
    struct record_probe *out;
    struct gather_worker *worker;
};

static void probe_record(const struct probe_job *job, size_t i, struct gather_scratch *scratch,
                         struct record_probe *out) {
    const struct render *r = job->r;
    const struct cache_head *head = &job->cache->store[job->kind].tree.head[i];
    const struct frame frame = frame_from_normal(head->n);
    struct rng rng = rng_make(r->options.seed, RNG_PROBE, 2 * (uint64_t)i + job->kind);
    struct gather_ray ray[PROBE_RAYS];
    // A record is on a surface if that is met from this height.
    const float height = fmaxf(0.01f * head->R, 8.0f * r->scene.epsilon);
    const vec3 above = v3_mad(head->p, height, head->n);
    out->foot =
        scene_distance(&r->scene, &(struct ray){above, 0.0f, v3_neg(head->n), 2.0f * height});
    for (int k = 0; k < PROBE_RAYS; k++) {
        const float u = sample_stratum(k / PROBE_SIDE, rng_float(&rng), PROBE_SIDE),
                    v = sample_stratum(k % PROBE_SIDE, rng_float(&rng), PROBE_SIDE);
        const vec3 d = frame_to_world(&frame, sample_cosine_hemisphere(u, v));
        ray[k] = (struct gather_ray){.ray = scene_spawn(&r->scene, head->p, head->n, d),
                                     .item = (uint32_t)k};
    }
    gather_rays(&r->second_pass.gather, scratch, ray, PROBE_RAYS,
                rng_mix(2 * (uint64_t)i + job->kind));
    for (int k = 0; k < PROBE_RAYS; k++) {
        out->r[k] = ray[k].first.r;
        out->L[k] = rgb_luminance(ray[k].L);
    }
}

static void probe_records(void *ctx, size_t begin, size_t end, int worker) {
    const struct probe_job *job = ctx;
    for (size_t i = begin; i < end; i++)
        probe_record(job, i, job->worker[worker].scratch, &job->out[i]);
}

// Probes the records of a kind, of which `cache` has at least one, in the scene of r.
static satin_status probe_all(const struct render *r, const struct cache *cache,
                              enum cache_kind kind, struct record_probe **out) {
    const size_t count = cache_count(cache, kind);
    struct probe_job job = {r, cache, kind, array_new(count, sizeof *job.out),
                            gather_workers_new(r->pool, PROBE_RAYS)};
    const struct parallel_results results = {.slot[0] = {job.out, sizeof *job.out}};
    satin_status status = job.out && job.worker ? SATIN_OK : SATIN_ERROR_MEMORY;
    if (status == SATIN_OK &&
        !parallel_for_results(r->pool, count, 16, probe_records, &job, &results))
        status = SATIN_CANCELLED;
    gather_workers_free(job.worker, parallel_threads(r->pool));
    if (status == SATIN_OK)
        *out = job.out;
    else
        free(job.out);
    return status;
}

satin_status render_probes_make(struct render *r) {
    const struct cache *cache = r->second_pass.cache;
    satin_status status = SATIN_OK;
    if (!render_has_stage(r, STAGE_RECORDS)) return SATIN_OK;
    struct render_probes *probes = calloc(1, sizeof *probes);
    if (!probes) return SATIN_ERROR_MEMORY;
    r->motion.probes = probes;
    parallel_begin_part(r->pool, "probes");
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS && status == SATIN_OK; k++)
        if (cache_count(cache, k)) status = probe_all(r, cache, k, &probes->of[k]);
    return status;
}

void render_probes_free(struct render_probes *probes) {
    if (!probes) return;
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS; k++) free(probes->of[k]);
    free(probes);
}

// ---- Which records are kept ---------------------------------------------------------------------

static bool same_distance(float a, float b) {
    return a == b || fabsf(a - b) < SAME_DISTANCE * fminf(a, b);
}

// The fraction of a record's light that has changed: all light of rays that meet something else,
// and the sum of the changes of the others, whose noise cancels.
static float changed_fraction(const struct record_probe *before, const struct record_probe *now) {
    float met = 0.0f, change = 0.0f, all = 0.0f;
    for (int k = 0; k < PROBE_RAYS; k++) {
        const float most = fmaxf(before->L[k], now->L[k]);
        if (same_distance(before->r[k], now->r[k]))
            change += now->L[k] - before->L[k];
        else
            met += most;
        all += most;
    }
    return all > 0.0f ? (met + fabsf(change)) / all : 0.0f;
}

static bool is_kept(const struct record_probe *before, const struct record_probe *now) {
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
    const char *part = parallel_begin_part(r->pool, "probes");
    r->scene.view = NULL;  // records are made for the view of the frame alone
    const double start = stats_wall();
    satin_status status = SATIN_OK;
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS && status == SATIN_OK; k++) {
        const struct record_probe *before = at_rest->motion.probes->of[k];
        struct record_probe *now = NULL;
        if (!before || from->store[k].order != to->store[k].order) continue;
        status = probe_all(r, from, k, &now);
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
    stats_set(&r->stats, "frame.probes_s", stats_wall() - start);
    parallel_begin_part(r->pool, part);
    return status;
}

// ---- The render of a frame ----------------------------------------------------------------------

struct render *render_frame_new(const struct render *at_rest) {
    const struct render_frames *frames = &at_rest->frames;
    satin_callbacks callbacks = at_rest->callbacks;
    callbacks.animation = NULL;
    callbacks.load_cache = callbacks.save_cache = NULL;
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
