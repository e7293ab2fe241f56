// SPDX-License-Identifier: Apache-2.0
// Gather rays: the path table's last row, E S* x S* y ... L. A ray goes through ideal specular
// surfaces to y and reads the rough solution there. Emitted light adds nothing: direct light and
// caustics at x carry it. Where the rough solution is not to be trusted, near y's own lookup
// radius, and for y's glossy lobe, the path goes on one more bounce. Where photons are so few that
// the lookup would blur over all that is seen, it goes on until it is absorbed: path tracing. In
// first pass `recursive` records are the rough solution; lobes that they do not tell of go on, and
// where that ray ends the records of the next level are.
#include <stdlib.h>

#include "base/array.h"
#include "gather/gather_near.h"

enum {
    DELTA_SURE = 32,   // ideal specular surfaces in a row, after which chance may end a gather ray
    BOUNCE_MAX = 6,    // glossy bounces behind y; the tail is taken as diffuse
    THROUGH_MAX = 32,  // the same inside rough glass, where no photon tells of the tail
    PATH_MAX = 64      // diffuse ones where there are no photons; the tail is lost
};

struct gather_scratch *gather_scratch_new(size_t capacity) {
    struct gather_scratch *s = calloc(1, sizeof *s);
    if (!s) return NULL;
    capacity += capacity / 2;
    s->capacity = capacity;
    s->rays = array_new(capacity, sizeof *s->rays);
    s->x = array_new(12 * capacity, sizeof *s->x);
    if (!s->rays || !s->x) {
        gather_scratch_free(s);
        return NULL;
    }
    s->y = s->x + capacity;
    s->z = s->y + capacity;
    s->r = s->z + capacity;
    s->g = s->r + capacity;
    s->b = s->g + capacity;
    s->wall = s->b + capacity;
    return s;
}

void gather_scratch_free(struct gather_scratch *scratch) {
    if (!scratch) return;
    free(scratch->rays);
    free(scratch->x);
    free(scratch);
}

struct gather_ray *gather_scratch_rays(struct gather_scratch *scratch) {
    return scratch->rays;
}

void gather_scratch_watch(struct gather_scratch *scratch, struct parallel *pool, int worker) {
    scratch->pool = pool;
    scratch->worker = worker;
}

// Chance of going on at each further ideal specular surface: light that is guided along a pane of
// glass meets some hundred.
static const float DELTA_SURVIVE = 0.98f;

// What is followed from y by one more ray.
static const unsigned GLOSSY = BRDF_GLOSSY | BRDF_THROUGH;

// Emitted light that a ray meets on its way to a smooth surface.
struct emitters {
    vec3 from;        // the surface point that the ray leaves,
    int depth;        // and the edges between it and the eye
    rgb Le;           // direct light: before any ideal specular surface, or through panes
    float light_pdf;  // density with which light samples at `from` draw it
    rgb Le_specular;  // all other
};

static void meet(const struct gather *g, const struct ray *ray, const struct interaction *hit,
                 rgb T, const struct light_chain *chain, struct emitters *e) {
    if (hit ? hit->light < 0 : g->scene->environment < 0) return;
    rgb Le = light_chain_emitted(chain, g->scene, hit, ray->d);
    if (rgb_black(Le)) return;
    if (!light_chain_straight(chain, ray->d)) {
        e->Le_specular = rgb_fma(e->Le_specular, T, Le);
    } else if (chain->crossed <= gather_panes(g, e->depth)) {
        e->Le = rgb_mul(T, Le);
        e->light_pdf = gather_light_pdf(g, e->from, chain, hit);
    }
}

// How likely a ray stops at a surface that has smooth and ideal specular lobes, by what they
// reflect.
static float stop_probability(const struct gather_point *p) {
    if (!(p->lobes & BRDF_DELTA)) return p->lobes & BRDF_SMOOTH ? 1.0f : 0.0f;
    if (!(p->lobes & BRDF_SMOOTH)) return 0.0f;
    float smooth = rgb_max(brdf_albedo(&p->brdf, p->wo_l, BRDF_SMOOTH));
    float delta = rgb_max(brdf_albedo(&p->brdf, p->wo_l, BRDF_DELTA));
    return smooth + delta > 0.0f ? smooth / (smooth + delta) : 1.0f;
}

// A ray and the width per distance of what it stands for.
struct cone {
    struct ray ray;
    float spread;
};

// Follows a ray through ideal specular surfaces to one with a smooth lobe. False if it meets none.
// *T gets what they leave of the light; emitters may be NULL.
static bool trace_to_smooth(const struct gather *g, struct cone cone, struct sampler *sampler,
                            rgb *T, struct gather_first *first, struct emitters *emitters,
                            struct gather_point *out) {
    struct ray ray = cone.ray;
    struct light_chain chain = light_chain_begin(ray.d);
    float distance = 0.0f;
    *T = rgb_grey(1.0f);
    *first = GATHER_NOTHING;
    for (int i = 0;; i++) {
        if (i >= DELTA_SURE) {
            if (!(sampler_1d(sampler) < DELTA_SURVIVE)) return false;
            *T = rgb_scale(*T, 1.0f / DELTA_SURVIVE);
        }
        struct interaction s;
        bool hit = scene_intersect(g->scene, &ray, &s);
        if (hit) light_chain_advance(&chain, s.t);
        if (emitters) meet(g, &ray, hit ? &s : NULL, *T, &chain, emitters);
        if (!hit) return false;
        if (i == 0) *first = (struct gather_first){s.t, s.ng};
        distance += s.t;
        s.footprint = cone.spread * distance;
        gather_point_make(g->scene, &s, ray.d, out);
        float stop = stop_probability(out), u = stop < 1.0f ? sampler_1d(sampler) : 0.0f;
        if (u < stop) {
            *T = rgb_scale(*T, 1.0f / stop);
            return true;
        }
        first->ng = GATHER_NOTHING.ng;
        struct brdf_sample next;
        float rest = stop > 0.0f ? (u - stop) / (1.0f - stop) : u;
        if (!out->lobes ||
            !brdf_sample(&out->brdf, out->wo_l, rest, 0.5f, 0.5f, BRDF_DELTA, BRDF_RADIANCE, &next))
            return false;
        *T = rgb_mul(*T, rgb_scale(next.weight, 1.0f / (1.0f - stop)));
        light_chain_pass(&chain, g->scene, &s, v3_neg(ray.d), out->wo_l, &next);
        ray = scene_spawn(g->scene, s.p, s.ng, frame_to_world(&out->frame, next.wi));
    }
}

bool gather_follow(const struct gather *g, struct ray ray, struct sampler *sampler,
                   struct gather_first *first, struct gather_point *out) {
    rgb T;
    return trace_to_smooth(g, (struct cone){ray, 0.0f}, sampler, &T, first, NULL, out);
}

// Reflected by y's diffuse lobe from the irradiance E of the rough solution.
static rgb diffuse_radiance(const struct gather_point *y, rgb E) {
    rgb albedo = brdf_albedo(&y->brdf, y->wo_l, BRDF_DIFFUSE);
    return rgb_scale(rgb_mul(albedo, E), 1.0f / PI_F);
}

// What decides along a path behind a gather ray.
struct choice {
    struct sampler sampler;
    const struct gather_near *near;  // bright places around, of a site near by
    float E;                         // luminance of the first-pass irradiance at its first surface
};

static rgb bounce(const struct gather *g, const struct gather_point *y, unsigned lobes,
                  float survive, int level, struct choice *choice);

// Probability that a glossy lobe is followed: faint ones, as of a coat, are followed now and then;
// on long paths all are by what they reflect.
static float follow(const struct gather_point *y, int level, rgb *albedo) {
    *albedo = brdf_albedo(&y->brdf, y->wo_l, GLOSSY);
    if (level >= BOUNCE_MAX) return clampf(rgb_max(*albedo), 0.1f, 0.95f);
    return clampf(4.0f * rgb_max(*albedo), 0.1f, 1.0f);
}

// The same for the diffuse lobe where E is not to be trusted: always behind a gather ray; on a
// path, whose surfaces have levels over 0, by what it reflects.
static float go_on(const struct gather_point *y, int level) {
    if (level == 0) return 1.0f;
    if (level >= PATH_MAX) return 0.0f;
    return clampf(rgb_max(brdf_albedo(&y->brdf, y->wo_l, BRDF_DIFFUSE)), 0.1f, 0.95f);
}

// On a path that goes on by either of two lobes it goes on no more often than by the likelier one
// alone: where each ray leads to more than one, they multiply.
static void share_path(float *a, float *b) {
    const float sum = *a + *b, share = fmaxf(*a, *b) / fmaxf(sum, 1e-20f);
    *a *= share;
    *b *= share;
}

// Whether light that reaches a surface of `level` after `more` edges is within the longest path:
// three edges lead from the eye over x and y to a light.
static bool within_depth(const struct gather *g, int level, int more) {
    return g->options->max_depth < 0 || 2 + level + more <= g->options->max_depth;
}

static bool recursive(const struct gather *g) {
    return g->options->first_pass == SATIN_FIRST_RECURSIVE;
}

// Bounces over which y's glossy lobes are followed: the tail is diffuse where E tells of it.
static int bounces_most(const struct gather *g, unsigned glossy, bool near) {
    if (near && !recursive(g)) return PATH_MAX;
    return glossy & BRDF_THROUGH || recursive(g) ? THROUGH_MAX : BOUNCE_MAX;
}

// Radiance that y reflects. Records tell of some of its lobes. Of the others, the diffuse one reads
// the irradiance E of the rough solution, or if `near`, where E is not to be trusted, follows one
// more ray; the glossy one always does.
static rgb reflected(const struct gather *g, const struct gather_point *y, rgb E, bool near,
                     int level, struct choice *choice) {
    rgb albedo = rgb_grey(0.0f), L = albedo;
    const unsigned known = g->rough.gather ? g->rough.read(g->rough.records, y, &L) : 0;
    const unsigned diffuse = y->lobes & BRDF_DIFFUSE & ~known, glossy = y->lobes & GLOSSY & ~known;
    const bool shadow = near || g->options->gather_shadow;
    float survive = glossy ? follow(y, level, &albedo) : 0.0f;
    float survive_diffuse = diffuse && near ? go_on(y, level) : 0.0f;
    if (level > 0) share_path(&survive, &survive_diffuse);
    const struct gather_mis mis = {
        2 + level, {{shadow ? diffuse : 0u, survive_diffuse}, {glossy, survive}, {known, 0.0f}}};
    L = rgb_add(L, gather_direct(g, y, mis, (struct gather_lights){1, choice->sampler.index},
                                 choice->sampler, NULL));
    choice->sampler.dimension += 2;
    // Photons do not know their edges: two at least are behind a caustic.
    const bool caustics = within_depth(g, level, 2);
    if (known && caustics)
        L = rgb_add(L, photon_caustic(g->maps, g->scene, y->interaction.p, y->ng, &y->frame,
                                      &y->brdf, y->wo_l, known, PHOTON_ALONE));
    if (diffuse && near) {
        if (caustics)
            L = rgb_add(L, diffuse_radiance(y, photon_caustic_irradiance(g->maps, g->scene,
                                                                         y->interaction.p, y->ng)));
        L = rgb_add(L, bounce(g, y, BRDF_DIFFUSE, survive_diffuse, level + 1, choice));
    } else if (diffuse) {
        L = rgb_add(L, diffuse_radiance(y, E));
    }
    if (!glossy) return L;
    if (level >= bounces_most(g, glossy, near))
        return rgb_add(L, rgb_scale(rgb_mul(albedo, E), 1.0f / PI_F));
    return rgb_add(L, bounce(g, y, glossy, survive, level + 1, choice));
}

// The same where no photon tells of E.
static rgb distant(const struct gather *g, const struct gather_point *y, int level,
                   struct choice *choice) {
    return reflected(g, y, rgb_grey(0.0f), true, level, choice);
}

// One more bounce from y by `lobes`, the diffuse or glossy ones, with probability `survive`:
// emitted light that the ray meets at once, weighted against y's light samples, and the rough
// solution where it ends. Emitted light behind specular surfaces counts for the glossy lobe; the
// diffuse one has caustic photons.
static rgb bounce(const struct gather *g, const struct gather_point *y, unsigned lobes,
                  float survive, int level, struct choice *choice) {
    struct brdf_sample next;
    struct sampler *sampler = &choice->sampler;
    float u_lobe = sampler_1d(sampler);
    vec2 u = sampler_2d(sampler);
    rgb L = rgb_grey(0.0f);
    if (u_lobe >= survive) return L;
    u_lobe /= survive;
    if (lobes == BRDF_DIFFUSE && choice->near) {
        if (!gather_near_bounce(choice->near, y, choice->E, u_lobe, u, &next)) return L;
    } else if (!brdf_sample(&y->brdf, y->wo_l, u_lobe, u.x, u.y, lobes, BRDF_RADIANCE, &next)) {
        return L;
    }
    choice->near = NULL;
    struct ray ray = scene_spawn(g->scene, y->interaction.p, y->interaction.ng,
                                 frame_to_world(&y->frame, next.wi));
    struct gather_point z;
    // `level` is the number of z: y has 1 + level edges to the eye.
    struct emitters e = {.from = y->interaction.p, .depth = 1 + level};
    const rgb start = rgb_scale(next.weight, 1.0f / survive);
    rgb T;
    struct gather_first first;
    bool found = trace_to_smooth(g, (struct cone){ray, 0.0f}, sampler, &T, &first, &e, &z);
    T = rgb_mul(start, T);
    if (e.light_pdf > 0.0f)
        L = rgb_scale(rgb_mul(start, e.Le), mis_power(survive * next.pdf_w, e.light_pdf));
    if (lobes != BRDF_DIFFUSE) L = rgb_fma(L, start, e.Le_specular);
    if (!found || !within_depth(g, level, 1)) return L;
    // Where there are records, z is to the next level's gather what y is to g.
    if (g->rough.gather) return rgb_fma(L, T, distant(g->rough.gather, &z, level - 1, choice));
    if (recursive(g)) return rgb_fma(L, T, distant(g, &z, level, choice));
    float radius;
    rgb E = photon_irradiance(g->maps, g->scene, z.interaction.p, z.ng, &radius);
    bool near = g->options->gather_bounce && radius > g->trust;
    if (!within_depth(g, level, 2)) E = rgb_grey(0.0f);
    return rgb_fma(L, T, reflected(g, &z, E, near, level, choice));
}

// Irradiance at y by the density estimate there: from what the diffuse lobe reflects. Without one,
// E is 0 and *radius is INFINITY.
static rgb estimate(const struct gather *g, const struct gather_point *y, float *radius) {
    *radius = INFINITY;
    if (!(y->lobes & BRDF_DIFFUSE)) return rgb_grey(0.0f);
    rgb L = photon_radiance(g->maps, g->scene, y->interaction.p, y->ng, &y->frame, &y->brdf,
                            y->wo_l, BRDF_DIFFUSE, radius);
    rgb a = brdf_albedo(&y->brdf, y->wo_l, BRDF_DIFFUSE);
    return rgb_make(a.r > 0.0f ? PI_F * L.r / a.r : 0.0f, a.g > 0.0f ? PI_F * L.g / a.g : 0.0f,
                    a.b > 0.0f ? PI_F * L.b / a.b : 0.0f);
}

// E and radius of the scratch's hits: all of a chunk look the map up together, or each has its own
// estimate.
static void look_up(const struct gather *g, struct gather_scratch *scratch, size_t count) {
    const bool precomputed = g->options->first_pass == SATIN_FIRST_PRECOMPUTED;
    for (size_t i = 0; i < count; i++) {
        scratch->p[i] = scratch->hit[i].point.interaction.p;
        scratch->n[i] = scratch->hit[i].point.ng;
        if (!precomputed) scratch->E[i] = estimate(g, &scratch->hit[i].point, &scratch->radius[i]);
    }
    if (precomputed)
        photon_irradiance_many(g->maps, g->scene, count, scratch->p, scratch->n, scratch->E,
                               scratch->radius);
}

// Rays that are traced together.
struct bundle {
    struct gather_ray *rays;
    bool guided;  // near their site, by the scratch's guide
    uint32_t seed;
};

// First passes `photons` and `photons-precomputed`.
static void shade_from_photons(const struct gather *g, struct gather_scratch *scratch, size_t count,
                               const struct bundle *bundle) {
    look_up(g, scratch, count);
    if (bundle->guided) gather_near_look(g, scratch, count);
    const struct gather_near *places = bundle->guided ? &scratch->guide.near : NULL;
    for (size_t i = 0; i < count; i++) {
        struct gather_hit *hit = &scratch->hit[i];
        struct gather_point *y = &hit->point;
        const float radius = scratch->radius[i];
        bool near = g->options->gather_bounce && (y->interaction.t < radius || radius > g->trust);
        struct choice choice = {hit->sampler, y->interaction.t < radius ? places : NULL,
                                rgb_luminance(scratch->E[i])};
        rgb L = reflected(g, y, scratch->E[i], near, 0, &choice);
        bundle->rays[hit->ray].L = rgb_mul(hit->T, L);
    }
}

static void trace_chunk(const struct gather *g, struct gather_scratch *scratch,
                        const struct bundle *bundle, size_t begin, size_t end) {
    struct gather_ray *rays = bundle->rays;
    const satin_first_pass first_pass = g->options->first_pass;
    const struct gather_mis lights_alone = {2, {{BRDF_SMOOTH, 0.0f}}};
    size_t hits = 0;
    for (size_t i = begin; i < end; i++) {
        struct gather_ray *ray = &rays[i];
        struct gather_hit *hit = &scratch->hit[hits];
        hit->sampler = (struct sampler){ray->item, bundle->seed, 0};
        struct sampler start = hit->sampler;
        struct emitters e = {.from = ray->lit ? *ray->lit : ray->ray.o, .depth = 1};
        bool found = false;
        hit->T = rgb_grey(1.0f);
        hit->ray = (uint32_t)i;
        if (first_pass != SATIN_FIRST_PATH || ray->lit)
            found = trace_to_smooth(g, (struct cone){ray->ray, ray->spread}, &hit->sampler, &hit->T,
                                    &ray->first, ray->lit ? &e : NULL, &hit->point);
        ray->Le = e.Le;
        ray->light_pdf = e.light_pdf;
        ray->Le_specular = e.Le_specular;
        ray->L = rgb_grey(0.0f);
        if (first_pass == SATIN_FIRST_PATH)
            ray->L = gather_path(g, ray->ray, &start, &ray->first);
        else if (found && first_pass == SATIN_FIRST_NONE)
            ray->L = rgb_mul(hit->T, gather_direct(g, &hit->point, lights_alone,
                                                   (struct gather_lights){1, hit->sampler.index},
                                                   hit->sampler, NULL));
        else if (found && first_pass == SATIN_FIRST_RECURSIVE)
            ray->L = rgb_mul(hit->T,
                             distant(g, &hit->point, 0, &(struct choice){.sampler = hit->sampler}));
        else if (found)
            hits++;
    }
    shade_from_photons(g, scratch, hits, bundle);
}

// Rays that are left off have found nothing.
static void forget(struct gather_ray *rays, size_t begin, size_t end) {
    for (size_t i = begin; i < end; i++) {
        rays[i].L = rays[i].Le = rays[i].Le_specular = rgb_grey(0.0f);
        rays[i].light_pdf = 0.0f;
        rays[i].first = GATHER_NOTHING;
    }
}

static void trace_rays(const struct gather *g, struct gather_scratch *scratch, struct bundle bundle,
                       size_t count, uint64_t stream) {
    bundle.seed = (uint32_t)rng_mix(stream ^ rng_mix(g->options->seed + RNG_GATHER_HIT));
    for (size_t begin = 0; begin < count; begin += GATHER_CHUNK) {
        size_t end = count - begin > GATHER_CHUNK ? begin + GATHER_CHUNK : count;
        // Of a million rays the rest would take seconds.
        if (begin > 0 && scratch->pool && parallel_cancelled(scratch->pool, scratch->worker))
            forget(bundle.rays, begin, end);
        else
            trace_chunk(g, scratch, &bundle, begin, end);
    }
}

void gather_rays_guided(const struct gather *g, struct gather_scratch *scratch,
                        struct gather_ray *rays, size_t count, uint64_t stream) {
    trace_rays(g, scratch, (struct bundle){.rays = rays, .guided = true}, count, stream);
}

void gather_rays(const struct gather *g, struct gather_scratch *scratch, struct gather_ray *rays,
                 size_t count, uint64_t stream) {
    trace_rays(g, scratch, (struct bundle){.rays = rays}, count, stream);
}
