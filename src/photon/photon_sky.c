// SPDX-License-Identifier: Apache-2.0
// Where the environment is seen from. Through a window it is a small part of all directions, and
// samples that are drawn by its radiance alone mostly end at walls. Points on paths from the eye,
// and on their bounces, are parted into cells of equal numbers; rays from the points of a cell tell
// in which bins of directions the environment is seen there, and direct light is drawn from these.
#include <stdlib.h>

#include "base/array.h"
#include "base/sampling.h"
#include "photon/photon_map.h"

enum {
    PATHS = 4 * PHOTON_VIEW_PATHS,
    BOUNCES = 2,  // of a path: gather rays sample direct light behind the first one
    POINTS = PATHS * (1 + BOUNCES),
    DEPTH = 10,  // of the tree at most
    LEAST = 8,   // points of a cell
    RAYS = 8,    // per bin at most,
    PER = 30000  // and one for each so many photons: who wants few has little time
};

// A bin beside one where the environment is seen gets this part of its weight: rays are few.
#define BESIDE 0.1f
// Share of samples that bins get: a constant sky has nothing to draw by, and an image draws well
// where all of it is seen.
#define SHARE_CONSTANT 0.9f
#define SHARE_IMAGE 0.75f

struct point {
    vec3 p, ng, n;
    bool both;  // lit from behind as well
    float key;
    uint32_t id;
};

struct cell {
    const struct point *point;
    size_t count;
};

struct photon_sky {
    int depth;
    struct {
        int axis;
        float at;
    } split[1 << DEPTH];  // of node i, whose children are 2 i + 1 and 2 i + 2
    struct cell cell[1 << DEPTH];
    struct light_window window[1 << DEPTH];
    float cdf[1 << DEPTH][LIGHT_WINDOW_BINS + 1];
};

// ---- Points -----------------------------------------------------------------------------------

static size_t add_path(const struct satin_scene *scene, uint64_t seed, uint32_t i,
                       struct point *out) {
    struct rng rng = rng_make(seed, RNG_SKY, i);
    struct surfel s;
    vec3 n;
    size_t count = 0;
    bool found = photon_view_eye(scene, i, &rng, &s, &n);
    while (found) {
        out[count] = (struct point){s.p,  s.ng,
                                    n,    material_transmits(&scene->material[s.material]),
                                    0.0f, (uint32_t)(i * (1 + BOUNCES) + count)};
        if (count++ == BOUNCES) break;
        const struct frame frame = frame_from_normal(n);
        const float u = rng_float(&rng), v = rng_float(&rng);
        struct ray ray =
            scene_spawn(scene, s.p, s.ng, frame_to_world(&frame, sample_cosine_hemisphere(u, v)));
        found = photon_view_follow(scene, &ray, &rng, &s, &n);
    }
    return count;
}

// ---- Cells ------------------------------------------------------------------------------------

static int by_key(const void *a, const void *b) {
    const struct point *x = a, *y = b;
    if (x->key != y->key) return x->key < y->key ? -1 : 1;
    return (x->id > y->id) - (x->id < y->id);
}

static int longest_axis(const struct point *point, size_t count) {
    vec3 lo = point[0].p, hi = lo;
    for (size_t i = 1; i < count; i++) {
        lo = v3_min(lo, point[i].p);
        hi = v3_max(hi, point[i].p);
    }
    const vec3 d = v3_sub(hi, lo);
    return d.x >= d.y && d.x >= d.z ? 0 : d.y >= d.z ? 1 : 2;
}

// Cuts the points of a node in halves, down to its cells.
static void cut(struct photon_sky *sky, struct point *point, size_t count, size_t node, int level) {
    if (level == sky->depth) {
        sky->cell[node - (((size_t)1 << sky->depth) - 1)] = (struct cell){point, count};
        return;
    }
    const int axis = longest_axis(point, count);
    for (size_t i = 0; i < count; i++) point[i].key = v3_along(point[i].p, axis);
    qsort(point, count, sizeof *point, by_key);
    const size_t half = count / 2;
    sky->split[node].axis = axis;
    sky->split[node].at = point[half].key;
    cut(sky, point, half, 2 * node + 1, level + 1);
    cut(sky, point + half, count - half, 2 * node + 2, level + 1);
}

// ---- Windows ----------------------------------------------------------------------------------

struct learning {
    const struct satin_scene *scene;
    uint64_t seed;
    int rays;  // per bin
    struct photon_sky *sky;
};

// What rays from a cell find of the environment: the square root of its luminance, as the peaks are
// the own sampling's.
struct tally {
    float weight[LIGHT_WINDOW_BINS];  // mean of a bin
    float seen, facing;               // sums: what is seen, and were without walls
};

static void ask(const struct learning *l, const struct cell *cell, int bin, struct rng *rng,
                struct tally *tally) {
    const size_t first = rng_u32(rng) % cell->count;
    float sum = 0.0f;
    int asked = 0;
    for (size_t k = 0; k < cell->count && asked < l->rays; k++) {
        const struct point *p = &cell->point[(first + k) % cell->count];
        const float u = rng_float(rng), v = rng_float(rng);
        const vec3 w = light_window_direction(bin, u, v);
        if (!p->both && !(v3_dot(w, p->n) > 0.0f)) continue;
        asked++;
        const float L = sqrtf(rgb_luminance(light_environment(l->scene, w)));
        if (!(L > 0.0f)) continue;
        tally->facing += L;
        struct ray ray = scene_spawn(l->scene, p->p, p->ng, w);
        if (!scene_occluded(l->scene, &ray)) sum += L;
    }
    tally->seen += sum;
    tally->weight[bin] = asked ? sum / (float)asked : 0.0f;
}

// Rows end at the poles, columns meet.
static float brightest_beside(const struct tally *tally, int bin) {
    const int row = bin / LIGHT_WINDOW_SIDE, column = bin % LIGHT_WINDOW_SIDE;
    float most = 0.0f;
    for (int y = row - 1; y <= row + 1; y++) {
        if (y < 0 || y >= LIGHT_WINDOW_SIDE) continue;
        for (int x = column - 1; x <= column + 1; x++) {
            const int beside = (x + LIGHT_WINDOW_SIDE) % LIGHT_WINDOW_SIDE;
            most = fmaxf(most, tally->weight[y * LIGHT_WINDOW_SIDE + beside]);
        }
    }
    return most;
}

static void learn(void *ctx, size_t begin, size_t end, int worker) {
    const struct learning *l = ctx;
    (void)worker;
    const struct light *light = &l->scene->light[l->scene->environment];
    for (size_t i = begin; i < end; i++) {
        struct rng rng = rng_make(l->seed, RNG_SKY, PATHS + i);
        struct tally tally = {.seen = 0.0f};
        float weight[LIGHT_WINDOW_BINS];
        for (int bin = 0; bin < LIGHT_WINDOW_BINS; bin++)
            ask(l, &l->sky->cell[i], bin, &rng, &tally);
        if (!(tally.seen > 0.0f)) continue;  // its share stays 0
        for (int bin = 0; bin < LIGHT_WINDOW_BINS; bin++)
            weight[bin] = fmaxf(tally.weight[bin], BESIDE * brightest_beside(&tally, bin));
        sample_cdf_build(weight, LIGHT_WINDOW_BINS, l->sky->cdf[i]);
        l->sky->window[i] = (struct light_window){
            light->kind == LIGHT_CONSTANT ? SHARE_CONSTANT
                                          : SHARE_IMAGE * (1.0f - tally.seen / tally.facing),
            l->sky->cdf[i]};
    }
}

// ---- The whole --------------------------------------------------------------------------------

static int rays_per_bin(int64_t photons) {
    return photons < 2 * PER ? 1 : photons > RAYS * PER ? RAYS : (int)(photons / PER);
}

satin_status photon_sky_build(const struct satin_scene *scene, const satin_options *options,
                              struct parallel *pool, struct photon_sky **out) {
    *out = NULL;
    if (scene->environment < 0) return SATIN_OK;
    struct photon_sky *sky = calloc(1, sizeof *sky);
    struct point *point = array_new(POINTS, sizeof *point);
    satin_status status = SATIN_ERROR_MEMORY;
    if (sky && point) {
        size_t count = 0;
        for (uint32_t i = 0; i < PATHS; i++)
            count += add_path(scene, options->seed, i, point + count);
        while (sky->depth < DEPTH && count >> (sky->depth + 1) >= LEAST) sky->depth++;
        struct learning learning = {scene, options->seed, rays_per_bin(options->photons), sky};
        status = SATIN_OK;
        if (count >= LEAST) {
            cut(sky, point, count, 0, 0);
            if (!parallel_for(pool, (size_t)1 << sky->depth, 1, learn, &learning))
                status = SATIN_CANCELLED;
        }
    }
    free(point);
    if (status == SATIN_OK)
        *out = sky;
    else
        free(sky);
    return status;
}

const struct light_window *photon_sky_window(const struct photon_maps *maps, vec3 p) {
    const struct photon_sky *sky = maps ? maps->sky : NULL;
    if (!sky) return NULL;
    size_t node = 0;
    for (int level = 0; level < sky->depth; level++)
        node = 2 * node + (v3_along(p, sky->split[node].axis) < sky->split[node].at ? 1 : 2);
    const struct light_window *window = &sky->window[node - (((size_t)1 << sky->depth) - 1)];
    return window->share > 0.0f ? window : NULL;
}

void photon_sky_free(struct photon_sky *sky) { free(sky); }
