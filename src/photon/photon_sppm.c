// SPDX-License-Identifier: Apache-2.0
// Progressive photon mapping: the mean over passes with new photons each, whose density estimates
// have smaller radii from pass to pass. Noise and bias both vanish [Hachisuka, Ogaki and Jensen
// 2008]. Passes have nothing in common but the initial radius of a point, so that a pass depends
// on its number alone [Knaus and Zwicker 2011].
//
// The initial radius of a point is that of the k photons around it in a map that serves for
// nothing else, so that it does not depend on the photons of an estimate; in caustics it is
// narrower where light is curved (photon_bandwidth.c).
//
// Where few indirect photons lie, their discs would be so wide that hardly any number of passes
// narrows them: they shrink with the sixth root of it. There a path continues instead, and reads
// caustics and direct light where it hits.
#include <math.h>
#include <stdlib.h>

#include "base/array.h"
#include "photon/photon_map.h"

enum {
    MAP_INDIRECT = 0,
    MAP_CAUSTIC,  // aimed at specular surfaces
    PROGRESSIVE_MAPS
};
enum {
    OPEN_CHUNK = 256,     // photons of a chunk
    SPPM_POINTS = 8,      // along each direction of a disc, where gaps of its surface are found
    INITIAL_NEAREST = 16  // photons among which one on the surface of a point is looked for
};

// Between passes the squared radius falls by (i + ALPHA) / (i + 1). With 2/3 the squared bias falls
// as fast as the variance [Knaus and Zwicker 2011, sec. 4.3].
static const double ALPHA = 2.0 / 3.0;

// Indirect light is from photons, except in directions that a glossy lobe draws with a larger
// density [sr^-1]: few photons come from there, so paths continue. With a third or a tenth of it
// the error of 16 passes is 1.2 to 2.6 times as large in rooms with glossy walls.
static const float SHARP_PDF = 3.0f;

// Indirect light is from photons if their initial disc is no wider than this fraction of the path
// from the eye. With half of it `caustic` has twice the variance, with a fifth `indirect-room` has
// ten times as much; at the foot of the gold in `ring`, whose discs are three times as wide as the
// ring, photons alone are 7 % too dark (docs/experiments/caustics.md).
static const float DISC_WIDEST = 0.1f;

struct photon_sppm {
    const struct satin_scene *scene;
    const satin_options *options;
    struct photon_paths paths;
    struct guide_allocation allocation;
    const struct guide_emission *emission;      // NULL: there are no caustics
    struct photon_map first[PROGRESSIVE_MAPS];  // with radii
    struct photon_map map[PROGRESSIVE_MAPS];    // of the present pass
    uint64_t passes;                            // number of passes, the map of radii not counted
    float shrink2;  // squared radius in the present pass over that in the first one
};

// Traces the photons of a pass and builds a map from them.
static satin_status trace_map(const struct photon_sppm *p, int kind, uint64_t pass,
                              struct parallel *pool, struct log log, struct stats *stats,
                              struct photon_map *out) {
    const bool caustic = kind == MAP_CAUSTIC;
    const struct photon_tracing tracing = {
        .scene = p->scene,
        .seed = rng_mix(p->options->seed + RNG_GOLDEN * pass),
        .consumer = {{.paths = caustic ? p->paths.caustic : p->paths.global,
                      .classes = 1u << (caustic ? PHOTON_CAUSTIC : PHOTON_INDIRECT),
                      .allocation = caustic ? NULL : &p->allocation}},
        .bounces = photon_bounces_left(p->options, 1),
        .emission = caustic ? p->emission : NULL,
        .repeated = pass > 0,
        .passing = pass > 0};
    struct photon_trace trace[PHOTON_CONSUMERS] = {0};
    return photon_map_trace(&tracing, pool, log, stats, out, trace);
}

// Traces the photons of a pass for all maps.
static satin_status trace_pass(const struct photon_sppm *p, uint64_t pass, struct parallel *pool,
                               struct log log, struct stats *stats,
                               struct photon_map map[PROGRESSIVE_MAPS]) {
    satin_status status = trace_map(p, MAP_INDIRECT, pass, pool, log, stats, &map[MAP_INDIRECT]);
    if (status != SATIN_OK || !p->emission) return status;
    return trace_map(p, MAP_CAUSTIC, pass, pool, log, stats, &map[MAP_CAUSTIC]);
}

// The least radius of a disc that is known to be whole, over that in the first pass: 250,000 passes
// end there.
#define SHRUNK_MOST 0.125f

struct open_loop {
    const struct satin_scene *scene;
    struct photon_map *map;
};

static void find_open(void *ctx, size_t begin, size_t end, int worker) {
    const struct open_loop *loop = ctx;
    const struct photon_map *map = loop->map;
    (void)worker;
    for (size_t i = begin; i < end; i++)
        map->whole_disc[i] =
            photon_area_clear(loop->scene, photon_position(map, i), photon_unpack(map->photon[i].n),
                              sqrtf(map->radius2[i]), SHRUNK_MOST);
}

// Finds the radii of a map's photons, and which of their discs no edge or wall cuts.
static satin_status find_discs(const struct photon_sppm *p, int kind, struct photon_map *map,
                               struct parallel *pool) {
    const satin_options *o = p->options;
    const int k = photon_clamp_k(kind == MAP_CAUSTIC ? o->caustic_k : o->photon_k);
    if (!map->count) return SATIN_OK;
    map->stride = 1;
    map->whole_disc = array_new_unset(map->count, sizeof *map->whole_disc);
    if (!map->whole_disc) return SATIN_ERROR_MEMORY;
    satin_status status = photon_map_find_radii(map, k, pool);
    if (status == SATIN_OK && kind == MAP_CAUSTIC) status = photon_map_narrow_radii(map, k, pool);
    if (status != SATIN_OK) return status;
    struct open_loop loop = {p->scene, map};
    return parallel_for(pool, map->count, OPEN_CHUNK, find_open, &loop) ? SATIN_OK
                                                                        : SATIN_CANCELLED;
}

satin_status photon_sppm_new(const struct photon_request *request, struct parallel *pool,
                             struct log log, struct stats *stats, struct photon_sppm **out) {
    struct photon_sppm *p = calloc(1, sizeof *p);
    if (!p) return log_fail(log, SATIN_ERROR_MEMORY, "not enough memory for the photon maps");
    p->scene = request->scene;
    p->options = request->options;
    p->paths = request->paths;
    p->emission = request->emission;
    p->shrink2 = 1.0f;
    parallel_begin_part(pool, "seen");
    guide_allocation_make(p->scene, p->options->seed, p->paths.seen, pool, &p->allocation);
    satin_status status = trace_pass(p, 0, pool, log, stats, p->first);
    parallel_begin_part(pool, "estimate");
    const double start = stats_wall();
    for (int i = 0; i < PROGRESSIVE_MAPS && status == SATIN_OK; i++)
        status = find_discs(p, i, &p->first[i], pool);
    stats_add(stats, "photons.radii_s", stats_wall() - start);
    if (status == SATIN_OK)
        *out = p;
    else
        photon_sppm_free(p);
    return status;
}

static void free_pass(struct photon_map map[PROGRESSIVE_MAPS]) {
    for (int i = 0; i < PROGRESSIVE_MAPS; i++) photon_map_free(&map[i]);
}

void photon_sppm_free(struct photon_sppm *p) {
    if (!p) return;
    free_pass(p->first);
    free_pass(p->map);
    free(p);
}

// Shrinks the discs from those of the last pass to those of the next one.
static void begin_pass(struct photon_sppm *p) {
    if (p->passes) p->shrink2 *= (float)(((double)p->passes + ALPHA) / ((double)p->passes + 1.0));
    p->passes++;
}

void photon_sppm_skip(struct photon_sppm *p, uint32_t passes) {
    for (uint32_t i = 0; i < passes; i++) begin_pass(p);
}

satin_status photon_sppm_next(struct photon_sppm *p, struct parallel *pool, struct log log,
                              struct stats *stats) {
    struct photon_map map[PROGRESSIVE_MAPS] = {{0}};
    satin_status status = trace_pass(p, p->passes + 1, pool, log, stats, map);
    if (status != SATIN_OK) {
        free_pass(map);
        return status;
    }
    free_pass(p->map);
    for (int i = 0; i < PROGRESSIVE_MAPS; i++) p->map[i] = map[i];
    begin_pass(p);
    return SATIN_OK;
}

// The disc around a point in the first pass.
struct initial_disc {
    bool found;
    bool whole;  // whether no edge or wall cuts it
    float r2;    // INFINITY: there are no photons
};

// The row of the nearest of k photons that is on the surface of a point, or of those that are not;
// -1: there is none.
static int nearest_photon(const struct photon_map *first, vec3 p, vec3 n, int k, bool on_surface,
                          float *r2) {
    const float q[3] = {p.x, p.y, p.z};
    int row[INITIAL_NEAREST], nearest = -1;
    float distance2[INITIAL_NEAREST], least = INFINITY;
    photon_index_nearest(first->index, q, 1, k, INFINITY, row, distance2);
    for (int i = 0; i < k; i++) {
        if (row[i] < 0 || !(distance2[i] < least)) continue;
        const float own2 = fmaxf(first->radius2[row[i]], distance2[i]),
                    height = v3_dot(v3_sub(photon_position(first, (size_t)row[i]), p), n);
        const vec3 m = photon_unpack(first->photon[row[i]].n);
        if (on_surface && !photon_is_on_surface(n, m, height, own2)) continue;
        nearest = row[i];
        least = distance2[i];
        *r2 = own2;
    }
    return nearest;
}

// The disc of a point is at least that of the photon nearest to it on its surface, and contains
// that photon. If none of those nearest to it is there, it is that of the nearest one.
static struct initial_disc find_initial(const struct photon_map *first, vec3 p, vec3 n) {
    struct initial_disc disc = {.r2 = INFINITY};
    if (!first->count) return disc;
    int nearest = nearest_photon(first, p, n, 1, true, &disc.r2);
    if (nearest < 0) nearest = nearest_photon(first, p, n, INITIAL_NEAREST, true, &disc.r2);
    disc.whole = nearest >= 0 && first->whole_disc[nearest];
    disc.found = nearest >= 0 || nearest_photon(first, p, n, 1, false, &disc.r2) >= 0;
    return disc;
}

// The radiance that a point reflects of the photons of a map in the present pass.
static rgb map_radiance(const struct photon_sppm *sppm, int kind, struct initial_disc initial,
                        const struct shading_point *point, const struct photon_reflection *at) {
    const struct photon_map *map = &sppm->map[kind];
    if (!initial.found || !map->count) return rgb_grey(0.0f);
    int row[PHOTON_K_MAX];
    float distance2[PHOTON_K_MAX];
    const vec3 p = point->interaction.p;
    const float q[3] = {p.x, p.y, p.z};
    struct photon_disc disc = {.map = map,
                               .p = p,
                               .n = point->ng,
                               .kernel = KERNEL_PARABOLA,
                               .row = row,
                               .distance2 = distance2,
                               .r2 = sppm->shrink2 * initial.r2,
                               .points = SPPM_POINTS};
    disc.count = photon_index_within(map->index, q, PHOTON_K_MAX, disc.r2, row, distance2);
    if (disc.count == PHOTON_K_MAX) disc.r2 = photon_radius2(map, row, distance2, disc.count);
    if (disc.count == 0) return rgb_grey(0.0f);
    disc.r = sqrtf(disc.r2);
    photon_disc_scale(&disc, initial.whole ? NULL : sppm->scene);
    photon_disc_drop_hidden(sppm->scene, row, distance2, &disc);
    return photon_disc_radiance(&disc, at);
}

rgb photon_sppm_radiance(const struct photon_sppm *p, const struct shading_point *point, int depth,
                         float length, bool *indirect) {
    struct photon_reflection at =
        photon_reflection_make(&point->frame, &point->brdf, point->wo_l, BRDF_REFLECT);
    at.pdf_most = SHARP_PDF;
    if (p->options->max_depth >= 0) at.bounces = p->options->max_depth - depth - 1;
    rgb L = rgb_grey(0.0f);
    for (int i = 0; i < PROGRESSIVE_MAPS; i++) {
        const struct initial_disc initial =
            find_initial(&p->first[i], point->interaction.p, point->ng);
        const bool narrow = initial.r2 < sqrf(DISC_WIDEST * length);
        if (i == MAP_INDIRECT) *indirect = narrow;
        if (i == MAP_CAUSTIC || narrow) L = rgb_add(L, map_radiance(p, i, initial, point, &at));
    }
    return L;
}

rgb photon_sppm_rest(const struct shading_point *point, const struct brdf_sample *sample) {
    const struct brdf *b = &point->brdf;
    if (!(sample->pdf_w > 0.0f) || !(point->wo_l.z * sample->wi.z > 0.0f)) return sample->weight;
    if (!brdf_is_sharp(b, point->wo_l, sample->wi, SHARP_PDF)) return rgb_grey(0.0f);
    const rgb f = brdf_eval(b, point->wo_l, sample->wi, BRDF_GLOSSY);
    return rgb_scale(f, fabsf(sample->wi.z) / sample->pdf_w);
}
