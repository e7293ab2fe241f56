// SPDX-License-Identifier: Apache-2.0
// One new record: computes irradiance or radiance from a gathered hemisphere, with its extent, and
// inserts it. What differs between the kinds is in the functions of a table.
#include "fill/fill_member.h"

#include <math.h>

// If a few of its rays make up most of an irradiance record, as when one of them has hit a small
// bright surface, it is gathered again with all the rays of the options, and both results are
// averaged by their numbers of rays. This is the deviation above which that is done: other records
// have less than .1 to .2 at 50 rays.
static const float UNSURE = 0.4f;

static rgb mix(rgb a, rgb b, float t) { return rgb_add(rgb_scale(a, 1.0f - t), rgb_scale(b, t)); }

// The mean of two values of one site, by their numbers of rays.
static struct cache_irradiance_value average_values(const struct cache_irradiance_value *a,
                                                    const struct cache_irradiance_value *b) {
    struct cache_irradiance_value mean = {.rays = a->rays + b->rays};
    const float t = (float)b->rays / (float)mean.rays;
    mean.E = mix(a->E, b->E, t);
    for (int k = 0; k < 3; k++) {
        mean.grad_t[k] = v3_mad(v3_mul(a->grad_t[k], 1.0f - t), t, b->grad_t[k]);
        mean.grad_r[k] = v3_mad(v3_mul(a->grad_r[k], 1.0f - t), t, b->grad_r[k]);
    }
    return mean;
}

// The relative standard deviation of that mean, by those of both.
static float average_deviation(const struct cache_irradiance_value *a, float deviation_a,
                               const struct cache_irradiance_value *b, float deviation_b) {
    const float E_a = (float)a->rays * rgb_luminance(a->E);
    const float E_b = (float)b->rays * rgb_luminance(b->E);
    if (!(E_a + E_b > 0.0f)) return 0.0f;
    return hypotf(deviation_a * E_a, deviation_b * E_b) / (E_a + E_b);
}

static void find_surroundings(const struct fill_making *m, struct fill_member *member,
                              const struct gather_hemisphere *hemisphere) {
    const struct cache_options *o = &m->store->options;
    gather_surroundings_make(hemisphere, o->gradients, o->radius == SATIN_RADIUS_HESSIAN,
                             &member->found.around);
}

// The light that the site reflects to the eye and that the harmonics leave out.
static struct cache_residual find_residual(const struct fill_making *m,
                                           const struct fill_member *member,
                                           const struct gather_hemisphere *hemisphere) {
    const struct fill_site *s = member->site;
    if (!s->glossy.table || !s->glossy.lobe_number)
        return (struct cache_residual){.lobe_number = 0};
    const rgb whole =
        gather_hemisphere_reflected(hemisphere, &s->glossy.brdf, s->glossy.wo, BRDF_GLOSSY);
    return fill_residual(&member->radiance, m->store->order, &s->frame, &s->glossy, whole);
}

static void find_irradiance(const struct fill_making *m, struct fill_member *member,
                            const struct gather_hemisphere *hemisphere) {
    find_surroundings(m, member, hemisphere);
    gather_hemisphere_irradiance(hemisphere, m->store->options.gradients,
                                 &member->found.irradiance);
}

static bool make_irradiance(const struct fill_making *m, struct fill_member *member) {
    if (!fill_valid_irradiance(&member->found.irradiance, &member->found.around)) return false;
    member->found.extent = fill_extent_irradiance(m->fill, member->site, &member->found.around,
                                                  &member->found.irradiance);
    return true;
}

// Copies coefficients to the layout of cache_radiance_record.
static void interleave(const struct gather_radiance *from, int n2, float *value) {
    const float *array[3] = {from->lambda, from->dx, from->dy};
    for (int k = 0; k < n2; k++)
        for (int i = 0; i < 3; i++)
            for (int c = 0; c < 3; c++) value[k * CACHE_LANES + 4 * i + c] = array[i][c * n2 + k];
    for (int k = 0; k < n2; k++) value[k * CACHE_LANES + 3] = from->noise[k];
}

// The limit of R by the curvature of the light that the site reflects to the eye.
static float curvature_limit(const struct fill_making *m, const struct fill_member *member,
                             const struct gather_hemisphere *hemisphere) {
    const struct fill_site *s = member->site;
    const struct cache_options *o = &m->store->options;
    if (!s->glossy.table || !o->curvature_clamp) return INFINITY;
    const float most = fminf(m->cache->scene->radius, o->max_pixels * s->pixel / o->a);
    return fill_curvature_clamp_radius(hemisphere, &s->glossy, o->a,
                                       fminf(member->found.around.harmonic, most),
                                       fill_least_radius(m->fill, m->kind, s->pixel));
}

static void find_radiance(const struct fill_making *m, struct fill_member *member,
                          const struct gather_hemisphere *hemisphere) {
    find_surroundings(m, member, hemisphere);
    gather_hemisphere_radiance(hemisphere, m->store->options.gradients, &member->radiance);
    member->found.radiance_rays = member->radiance.rays;
    member->found.residual = find_residual(m, member, hemisphere);
    member->found.most = curvature_limit(m, member, hemisphere);
}

static bool make_radiance(const struct fill_making *m, struct fill_member *member) {
    if (!fill_valid_radiance(&member->radiance, m->store->order, &member->found.around) ||
        !rgb_finite(member->found.residual.L))
        return false;
    member->found.extent = fill_extent_radiance(m->fill, member->site, &member->found.around,
                                                member->found.most, &member->radiance);
    interleave(&member->radiance, m->store->order * m->store->order, member->value);
    return true;
}

// If a few of its rays make up most of an irradiance record, gathers it again, by all the rays of
// the options, and averages both values.
static void add_irradiance_rays(const struct fill_making *m, struct fill_member *member,
                                const struct gather_site *site, const struct gather_worker *w) {
    if (!(member->found.around.deviation > UNSURE)) return;
    const struct cache_irradiance_value first = member->found.irradiance;
    const float deviation = member->found.around.deviation,
                of_gradient = member->found.around.gradient_deviation;
    struct gather_site again = *site;
    again.stream = rng_mix(site->stream ^ RNG_GOLDEN);
    gather_hemisphere_trace(m->fill->g, m->fill->side[m->kind].whole, &again, w->scratch,
                            w->hemisphere);
    find_irradiance(m, member, w->hemisphere);
    struct cache_irradiance_value *second = &member->found.irradiance;
    struct gather_surroundings *around = &member->found.around;
    around->deviation = average_deviation(&first, deviation, second, around->deviation);
    around->gradient_deviation =
        average_deviation(&first, of_gradient, second, around->gradient_deviation);
    *second = average_values(&first, second);
}

// Radiance records have enough rays.
static void keep_rays(const struct fill_making *m, struct fill_member *member,
                      const struct gather_site *site, const struct gather_worker *w) {
    (void)m, (void)member, (void)site, (void)w;
}

// The scale of a new record among adapted ones: 1.4 times that of the nearest one [K05 6.3.2].
static float first_scale(const struct cache_tree *tree, const struct fill_site *s, float radius) {
    static const float GROWTH = 1.4f;
    int64_t nearest = cache_tree_nearest(tree, s->p, s->frame.n, radius);
    return nearest < 0 ? 1.0f : fminf(1.0f, GROWTH * tree->head[nearest].scale);
}

// Limits a new record and its neighbours by each other, if the options include that.
static void clamp_extent(const struct fill_making *m, const struct fill_site *s,
                         struct fill_extent *x) {
    if (!m->store->options.neighbour_clamp) return;
    x->R = fill_neighbour_clamp(&m->store->tree, s->p, s->frame.n, x->R);
    x->R = fmaxf(x->R, fill_least_radius(m->fill, m->kind, s->pixel));
    x->across = fminf(x->across, x->R);
}

// The head of a new record.
static struct cache_head make_head(const struct fill_making *m, const struct fill_member *member,
                                   const struct fill_extent *x) {
    const struct fill_site *s = member->site;
    const float radius = m->store->options.a * m->sites->factor_max * x->R;
    float ratio = x->R / x->across;
    const float least = m->store->options.a * fill_least_radius(m->fill, m->kind, s->pixel);
    struct cache_head head = {
        .p = s->p,
        .R = x->R,
        .n = s->frame.n,
        .search_radius = radius,
        .anisotropy = v3_mul(x->axis, sqrtf(fmaxf(ratio * ratio - 1.0f, 0.0f))),
        .scale = m->sites->adapted ? first_scale(&m->store->tree, s, radius) : 1.0f,
        .u = s->frame.u,
    };
    head.clear = fill_find_sectors(&member->found.around, radius, least, head.sector);
    return head;
}

static bool insert_irradiance(const struct fill_making *m, struct fill_member *member) {
    struct fill_extent x = member->found.extent;
    clamp_extent(m, member->site, &x);
    const struct cache_head head = make_head(m, member, &x);
    const struct cache_irradiance_record record = {
        member->found.irradiance, member->found.around.deviation,
        member->found.around.gradient_deviation, x.radius_ratio};
    return cache_insert_irradiance(m->cache, &head, &record);
}

static bool insert_radiance(const struct fill_making *m, struct fill_member *member) {
    struct fill_extent x = member->found.extent;
    clamp_extent(m, member->site, &x);
    const struct cache_head head = make_head(m, member, &x);
    const struct cache_radiance_record record = {member->site->frame, member->value, x.radius_ratio,
                                                 member->found.radiance_rays,
                                                 member->found.residual};
    return cache_insert_radiance(m->cache, &head, &record);
}

const struct fill_functions fill_functions_of[CACHE_KINDS] = {
    [CACHE_IRRADIANCE] = {add_irradiance_rays, find_irradiance, make_irradiance, insert_irradiance},
    [CACHE_RADIANCE] = {keep_rays, find_radiance, make_radiance, insert_radiance},
};
