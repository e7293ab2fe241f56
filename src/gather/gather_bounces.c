// SPDX-License-Identifier: Apache-2.0
// The path from the hit y of a gather ray on: the last row of the path table, E S* x S* y ... L.
// The illumination integral at each of its surfaces [K05 (2.1)] is divided by light and by lobe.
// The path adds the direct light there and reads the other light that is known: records of the next
// indirect bounce (first pass `recursive`), or the irradiance of the first-pass estimate (photons).
// It continues by those lobes whose light is not known:
// - by the diffuse lobe where the estimate is not reliable: nearer to the start of the segment
//   than the photon lookup can resolve, or where photons are so few that the lookup would blur a
//   large part of the visible scene;
// - by the glossy lobe always, except at the end of long paths.
// So a path ends where all light is known, which for most gather rays is y itself.
//
// If it continues by both lobes, the path splits in two. They are followed to their ends one after
// the other, with the surface at which they split kept on a stack, and light is summed from the
// ends back to y. After y, the probabilities of both together are no larger than that of the
// likelier one alone, so paths do not multiply.
#include "gather/gather_bounces.h"

#include <assert.h>

#include "gather/gather_scratch.h"
#include "gather/gather_segment.h"

enum {
    GLOSSY_BOUNCES_MAX = 6,  // glossy bounces after y; the rest of the lobe is treated as diffuse
    THROUGH_MAX = 32,  // glossy bounces inside rough glass, where photons do not describe the rest
    DIFFUSE_MAX = 64,  // bounces where there are no photons; further light is lost
    VERTICES = DIFFUSE_MAX + SATIN_RECURSIVE_BOUNCES_MAX + 1
};

// Lobes that are followed by a segment separate from that of the diffuse lobe.
static const unsigned GLOSSY = BRDF_GLOSSY | BRDF_THROUGH;

// The lobes by which a path continues from a surface, and the probability that it does.
struct path_branch {
    unsigned lobes;  // 0: none
    float probability;
    float ratio;  // number of its directions per light sample for the lobes, see gather_mis
};

// A surface of the path.
struct path_vertex {
    const struct gather *g;  // whose records may be read here
    const struct shading_point *y;
    struct shading_point point;  // the surface point, except of the first vertex
    int segments;                // number of segments from y to this surface, as g counts them
    int depth;                   // of those from the eye, with ideal specular surfaces between
    rgb T, Le;  // of the segment that ends here: its transmittance, and the emitted light on it
    rgb L;      // radiance reflected here, as far as it is known
    float E;    // luminance of the first-pass irradiance here
    struct path_branch branch[2];  // by which the path continues: diffuse, then glossy
    int followed;                  // number of branches that are done
};

struct path {
    struct sampler sampler;            // for all decisions, in the order in which they are made
    const struct gather_cones *cones;  // to which diffuse bounces are guided; NULL: to none
    bool strict;                       // whether its lookups are
    struct path_vertex vertex[VERTICES];
};

static bool has_records(const struct gather *g) {
    return g->options->first_pass == SATIN_FIRST_RECURSIVE;
}

// The probability that glossy lobes of this albedo are followed. Faint ones, such as that of a
// coat, are followed sometimes; on long paths the probability is the albedo.
static float glossy_probability(rgb albedo, int segments) {
    if (segments >= GLOSSY_BOUNCES_MAX) return clampf(rgb_max(albedo), 0.1f, 0.95f);
    return clampf(4.0f * rgb_max(albedo), 0.1f, 1.0f);
}

// The probability that the diffuse lobe is followed where the estimate is not reliable: 1 at the
// gather ray's hit, the albedo after it.
static float diffuse_probability(const struct shading_point *y, int segments) {
    if (segments == 0) return 1.0f;
    if (segments >= DIFFUSE_MAX) return 0.0f;
    return clampf(rgb_max(brdf_albedo(&y->brdf, y->wo_l, BRDF_DIFFUSE)), 0.1f, 0.95f);
}

// The number of bounces over which glossy lobes are followed; where E describes it, the rest is
// treated as diffuse.
static int glossy_bounces(const struct gather *g, unsigned glossy, bool reliable) {
    if (!reliable && !has_records(g)) return DIFFUSE_MAX;
    return glossy & BRDF_THROUGH || has_records(g) ? THROUGH_MAX : GLOSSY_BOUNCES_MAX;
}

// Scales the probabilities of two branches so that their sum is the larger of them.
static void limit_splits(struct path_branch *a, struct path_branch *b) {
    const float sum = a->probability + b->probability;
    const float factor = fmaxf(a->probability, b->probability) / fmaxf(sum, 1e-20f);
    a->probability *= factor;
    b->probability *= factor;
}

// The radiance of a diffuse lobe of this albedo under the irradiance E.
static rgb diffuse_radiance(rgb albedo, rgb E) {
    return rgb_scale(rgb_mul(albedo, E), 1.0f / PI_F);
}

// Direct light at a vertex by `count` light samples. If they are several, they form a sequence of
// their own.
static rgb sample_direct(const struct path *path, const struct path_vertex *v,
                         struct gather_mis mis, int count) {
    struct gather_light_samples light_samples = {count, path->sampler.index};
    struct sampler sampler = path->sampler;
    if (count > 1) {
        sampler.seed = (uint32_t)rng_mix((uint64_t)sampler.seed << 32 | sampler.index);
        light_samples.first = 0;
    }
    return gather_sample_lights(v->g, v->y, mis, light_samples, sampler, NULL);
}

// Direct light reflected by the glossy lobes alone, sampled with the probability with which they
// are followed.
static rgb sample_glossy_direct(struct path *path, const struct path_vertex *v,
                                struct path_branch branch) {
    const struct gather_mis mis = {v->depth, {{branch.lobes, branch.ratio}}};
    if (!branch.lobes || !(sampler_1d(&path->sampler) < branch.probability)) return rgb_grey(0.0f);
    return rgb_scale(sample_direct(path, v, mis, 1), 1.0f / branch.probability);
}

// Whether an estimate includes the direct light of the diffuse lobe: light through as many panes as
// that of y may pass.
static bool includes_direct(const struct path_vertex *v, struct gather_estimate estimate) {
    return estimate.reliable && estimate.direct &&
           (v->depth == photon_hit_depth(v->g->options) || v->g->options->max_depth < 0);
}

// Irradiance by caustic photons at a vertex, beside the light that was added there.
static rgb caustic_irradiance(const struct path *path, const struct path_vertex *v, rgb albedo) {
    struct sampler apart = path->sampler;
    apart.dimension += 32;  // beyond those that the branches use
    const float reflected = rgb_luminance(v->L) / fmaxf(rgb_max(albedo), 1e-6f);
    const struct photon_other_light other = {reflected + v->E / PI_F, sampler_1d(&apart)};
    return photon_caustic_irradiance(v->g->maps, v->g->scene, v->y->interaction.p, v->y->ng,
                                     photon_bounces_left(v->g->options, v->depth), other);
}

// Light that ideal specular surfaces throw on the vertex and its glossy lobes of this albedo
// reflect, but for the directions in which these are sharp: by caustic photons.
static rgb glossy_caustic(const struct path *path, const struct path_vertex *v,
                          struct path_branch branch, rgb albedo) {
    struct sampler apart = path->sampler;
    apart.dimension += 33;  // beyond that of caustic_irradiance
    const float u = sampler_1d(&apart) / branch.probability;
    if (!(u < 1.0f && v->y->wo_l.z > 0.0f)) return rgb_grey(0.0f);
    const struct photon_other_light other = {rgb_luminance(v->L) / fmaxf(rgb_max(albedo), 1e-6f),
                                             u};
    const struct photon_caustic_limits limits = {branch.lobes & BRDF_GLOSSY,
                                                 GATHER_CAUSTIC_PDF_MOST,
                                                 photon_bounces_left(v->g->options, v->depth)};
    return rgb_scale(photon_caustic_at_hit(v->g->maps, v->g->scene, v->y, &limits, other),
                     1.0f / branch.probability);
}

// Adds the light that is known at a vertex, and decides by which lobes the path continues.
static void add_vertex_light(struct path *path, struct path_vertex *v,
                             struct gather_estimate estimate) {
    const struct gather *g = v->g;
    const struct shading_point *y = v->y;
    v->L = rgb_grey(0.0f);
    v->E = rgb_luminance(estimate.E);
    v->followed = 0;
    const unsigned known = g->next.gather ? cache_add_reflected(g->next.reader, y, &v->L) : 0;
    const unsigned diffuse = y->lobes & BRDF_DIFFUSE & ~known, glossy = y->lobes & GLOSSY & ~known;
    const rgb albedo = glossy ? brdf_albedo(&y->brdf, y->wo_l, GLOSSY) : rgb_grey(0.0f);
    struct path_branch by_diffuse = {0}, by_glossy = {0};
    if (diffuse && !estimate.reliable)
        by_diffuse = (struct path_branch){diffuse, diffuse_probability(y, v->segments), 0.0f};
    if (glossy)
        by_glossy = (struct path_branch){glossy, glossy_probability(albedo, v->segments), 0.0f};
    if (v->segments > 0) limit_splits(&by_diffuse, &by_glossy);
    // Where direct light is known, light is sampled for the glossy lobe as often as it is followed.
    const bool includes = includes_direct(v, estimate);
    by_diffuse.ratio = by_diffuse.probability / (float)estimate.light_samples;
    by_glossy.ratio = includes ? 1.0f : by_glossy.probability / (float)estimate.light_samples;

    // Direct light. That of the diffuse lobe may be known separately, or be part of a reliable
    // estimate from all photons.
    rgb E = estimate.E;  // irradiance for the diffuse lobe
    if (includes) {
        E = rgb_add(E, *estimate.direct);
        v->L = rgb_add(v->L, sample_glossy_direct(path, v, by_glossy));
    } else {
        const bool shadow = !estimate.reliable || g->options->gather_direct;
        const struct gather_mis mis = {
            v->depth,
            {{shadow ? diffuse : 0u, by_diffuse.ratio}, {glossy, by_glossy.ratio}, {known, 0.0f}}};
        v->L = rgb_add(v->L, sample_direct(path, v, mis, estimate.light_samples));
    }
    path->sampler.dimension += 2;

    const struct photon_caustic_limits caustic = {known, INFINITY,
                                                  photon_bounces_left(g->options, v->depth)};
    if (known) v->L = rgb_add(v->L, photon_caustic(g->maps, g->scene, y, &caustic, PHOTON_ALONE));
    if (diffuse) {
        const rgb white = brdf_albedo(&y->brdf, y->wo_l, BRDF_DIFFUSE);
        if (!estimate.reliable) E = caustic_irradiance(path, v, white);
        v->L = rgb_add(v->L, diffuse_radiance(white, E));
    }
    if (glossy && v->segments >= glossy_bounces(g, glossy, estimate.reliable)) {
        v->L = rgb_add(v->L, diffuse_radiance(albedo, estimate.E));
        by_glossy.lobes = 0;
    }
    if (by_glossy.lobes) v->L = rgb_add(v->L, glossy_caustic(path, v, by_glossy, albedo));
    v->branch[0] = by_diffuse;
    v->branch[1] = by_glossy;
}

// Draws the direction of a segment that leaves v by a branch. False if the path ends.
static bool draw_direction(struct path *path, const struct path_vertex *v,
                           struct path_branch branch, struct brdf_sample *out) {
    const struct shading_point *y = v->y;
    float u_lobe = sampler_1d(&path->sampler);
    const vec2 u = sampler_2d(&path->sampler);
    if (u_lobe >= branch.probability) return false;
    u_lobe /= branch.probability;
    if (path->cones && gather_aims_bounce(y->lobes, branch.lobes))
        return gather_near_bounce(path->cones, y, branch.lobes, v->E, u_lobe, u, out);
    return brdf_sample_wi(&y->brdf, y->wo_l, u_lobe, u, branch.lobes, BRDF_RADIANCE, out);
}

// Reads the estimate at the end z of a segment. First pass `recursive` has records instead.
static struct gather_estimate estimate_at(const struct path_vertex *z, bool strict) {
    const struct gather *g = z->g;
    const struct gather_estimate none = {rgb_grey(0.0f), false, NULL, 1};
    if (has_records(g) || !gather_looks_up(g)) return none;
    float radius;
    int entry;
    rgb E;
    const int more = z->depth - photon_hit_depth(g->options);
    const struct photon_lookups one = {
        1, &z->y->interaction.p, &z->y->ng, &more, &E, &radius, &entry, strict};
    photon_irradiance_many(g->maps, g->scene, &one);
    const bool near = gather_is_near(g, z->y->interaction.t, radius, GATHER_NEAR_DISCS);
    return (struct gather_estimate){gather_reads_photons(g, z->depth) ? E : none.E,
                                    gather_is_reliable(g, z->y, radius, near),
                                    gather_direct_known(g, z->y, entry), 1};
}

// Follows a branch from v by one segment. True if it ends at a surface, which becomes the vertex
// after v. Emitted light on the way is weighted against the light samples of v. After specular
// surfaces it counts only where the caustic photons of v leave it out.
static bool follow_branch(struct path *path, struct path_vertex *v, struct path_branch branch) {
    struct path_vertex *z = v + 1;
    struct brdf_sample next;
    if (!draw_direction(path, v, branch, &next)) return false;
    assert(z < path->vertex + VERTICES);
    const struct interaction *s = &v->y->interaction;
    const struct light_receiver at = gather_receiver(v->y);
    const struct gather_segment_start start = {
        .ray = scene_spawn(v->g->scene, s->p, s->ng, frame_to_world(&v->y->frame, next.wi)),
        .lit = &at,
        .depth = v->depth};
    struct gather_segment segment;
    const bool found = gather_segment_trace(v->g, &start, &path->sampler, &segment, &z->point);
    const rgb weight = rgb_scale(next.weight, 1.0f / branch.probability);
    z->T = rgb_mul(weight, segment.T);
    z->Le = rgb_grey(0.0f);
    if (segment.light_pdf > 0.0f)
        z->Le = rgb_scale(rgb_mul(weight, segment.Le),
                          mis_power(branch.ratio * next.pdf_w, segment.light_pdf));
    if (branch.lobes != BRDF_DIFFUSE && !gather_has_caustic_photons(v->y, next.wi))
        z->Le = rgb_fma(z->Le, weight, segment.Le_specular);
    const int depth = v->depth + segment.specular + 1;
    if (!found || !gather_within_depth(v->g, depth, 1)) {
        v->L = rgb_add(v->L, z->Le);
        return false;
    }
    // The records of the next indirect bounce are gathered with a max_depth that is less by one, so
    // that z is as many segments after y as v is, as their gather counts.
    const struct gather *next_bounce = v->g->next.gather;
    z->g = next_bounce ? next_bounce : v->g;
    z->segments = next_bounce ? v->segments : v->segments + 1;
    z->depth = next_bounce ? depth - 1 : depth;
    z->y = &z->point;
    add_vertex_light(path, z, estimate_at(z, path->strict));
    return true;
}

rgb gather_bounces(const struct gather *g, const struct shading_point *y, int depth,
                   struct gather_estimate estimate, const struct gather_near *near,
                   struct sampler sampler) {
    struct path path;  // not initialised as a whole, as few of its vertices are used
    path.sampler = sampler;
    path.cones = near ? &near->cones : NULL;
    path.strict = gather_near_of_record(near);
    struct path_vertex *v = path.vertex;
    v->g = g;
    v->y = y;
    v->segments = 0;
    v->depth = depth;
    add_vertex_light(&path, v, estimate);
    for (;;) {
        if (v->followed < 2) {
            const struct path_branch branch = v->branch[v->followed++];
            if (branch.lobes && follow_branch(&path, v, branch)) v++;
        } else if (v > path.vertex) {
            v--;
            v->L = rgb_add(v->L, rgb_fma(v[1].Le, v[1].T, v[1].L));
        } else {
            return v->L;
        }
    }
}
