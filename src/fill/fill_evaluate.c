// SPDX-License-Identifier: Apache-2.0
// The criterion of adaptive caching [K05 6.3.1, 6.4]: whether the light of the records at a point
// differs perceptibly, by Weber's law on direct and indirect light and by more than their noise,
// and which of the records are to be shrunk.
#include "fill/fill_adaptive_cache.h"

// The relative difference that is perceptible by Weber's law, as is widely used in computer
// graphics [K05 6.4].
static const float VISIBLE = 0.02f;

// A difference of up to this many standard deviations may be noise. In the thesis it is one, which
// is often exceeded by chance among all points and pairs of records; and the noise grows as records
// shrink.
static const float VISIBLE_DEVIATIONS = 2.5f;

void fill_update_point(const struct fill_adaptation *c, const struct fill_site *s,
                       struct fill_point *p) {
    int kept = 0;
    for (int i = 0; i < p->count; i++) {
        struct fill_contribution x = p->with[i];
        if (x.change != c->change[x.record]) {
            const struct cache_head *h = &c->tree->head[x.record];
            x.error = cache_tree_error(h, s->p, s->frame.n);
            x.change = c->change[x.record];
            if (x.error >= c->read_a * h->scale) continue;
        }
        p->with[kept++] = x;
    }
    p->count = (uint8_t)kept;
    p->bare = true;
    for (int i = 0; i < kept; i++)
        if (p->with[i].error < c->sites->a * c->tree->head[p->with[i].record].scale)
            p->bare = false;
}

// The lobes that records light at a site, with the harmonics of its glossy lobes if these are
// within `order`.
static void find_surface(const struct fill_site *s, int order, struct cache_surface *out) {
    const struct fill_glossy *v = &s->glossy;
    out->specular = s->specular;
    out->diffuse = s->diffuse;
    out->lobe = (struct cache_lobe){.C = out->coefficients};
    if (order == 0 || !v->table) return;
    out->lobe.order = brdf_range_lookup(v->table, &v->brdf, v->wo, out->coefficients);
    out->lobe.channels = v->channels;
    out->lobe.number = v->lobe_number;
    out->lobe.mirror = cache_mirror(&s->frame, v->wo);
}

static cache_reflected_fn *const reflected[CACHE_KINDS] = {
    [CACHE_IRRADIANCE] = cache_irradiance_reflected,
    [CACHE_RADIANCE] = cache_radiance_reflected,
};

// Computes the luminances that are not known yet.
static void find_luminances(const struct fill_adaptation *c, const struct fill_site *s,
                            struct fill_point *p) {
    const struct cache_lookup at = {s->shading_p, s->frame.n, s->frame, 0.0f};
    struct cache_surface surface;
    find_surface(s, c->cache->store[c->kind].order, &surface);
    for (int i = 0; i < p->count; i++) {
        struct fill_contribution *x = &p->with[i];
        if (x->Y < 0.0f)
            x->Y = at_least(
                reflected[c->kind](c->cache, x->record, &at, c->read_a, &surface, &x->noise), 0.0f);
    }
}

// The mean luminance of the contributions in `mask`, weighted by 1 / error.
static float mean_luminance(const struct fill_point *p, unsigned mask) {
    float sum = 0.0f, weights = 0.0f;
    for (int i = 0; i < p->count; i++) {
        if (!(mask >> i & 1u)) continue;
        float w = 1.0f / fmaxf(p->with[i].error, 1e-6f);
        sum += w * p->with[i].Y;
        weights += w;
    }
    return sum / weights;
}

// The difference that noise alone may cause. The estimate by one record is too noisy, so that of
// all records of the point is used.
static float noise_of(const struct fill_point *p) {
    float square = 0.0f;
    for (int i = 0; i < p->count; i++) square += p->with[i].noise * p->with[i].noise;
    return VISIBLE_DEVIATIONS * sqrtf(square / (float)p->count);
}

// Whether a record may end before this point: it must not become smaller than the least radius.
static bool may_shrink(const struct fill_adaptation *c, const struct fill_site *s,
                       uint32_t record) {
    const struct cache_options *o = &c->cache->store[c->kind].options;
    const float least = o->a * fill_least_radius(c->fill, c->kind, s->pixel);
    return v3_dist2(c->tree->head[record].p, s->p) > least * least;
}

// Whether a difference in luminance is perceptible, given the luminance `all` by the records plus
// direct light [K05 6.4].
static bool perceptible(const struct fill_site *s, float difference, float all, float noise) {
    return difference > VISIBLE * (all + s->direct) + noise;
}

// Whether the mean of the contributions in `mask` differs perceptibly from that without one of
// them.
static bool disagree(const struct fill_site *s, const struct fill_point *p, unsigned mask) {
    const float all = mean_luminance(p, mask), noise = noise_of(p);
    for (int i = 0; i < p->count; i++) {
        if (!(mask >> i & 1u)) continue;
        float rest = mean_luminance(p, mask & ~(1u << i));
        if (perceptible(s, fabsf(all - rest), all, noise)) return true;
    }
    return false;
}

// The contributions that may have caused the difference between `worst` and the rest: errors grow
// with the square of the distance, so records that are hardly nearer have almost the same error.
static unsigned similar_errors(const struct fill_site *s, const struct fill_point *p, unsigned rest,
                               int worst) {
    const float all = mean_luminance(p, rest), noise = noise_of(p);
    const float difference = fabsf(p->with[worst].Y - all);
    const float far2 = p->with[worst].error * p->with[worst].error;
    unsigned similar = 1u << worst;
    for (int i = 0; i < p->count; i++) {
        float near2 = p->with[i].error * p->with[i].error;
        if (rest >> i & 1u && perceptible(s, difference * near2 / (near2 + far2), all, noise))
            similar |= 1u << i;
    }
    return similar;
}

// While contributions disagree, the one of least weight is to be shrunk [K05 figure 6.2].
// Deviation: so are those with a similar error; otherwise a point whose records all have similar
// errors would keep the nearest one.
void fill_evaluate_point(const struct fill_adaptation *c, const struct fill_site *s,
                         struct fill_point *p) {
    p->shrinking = 0;
    if (p->count < 2) return;
    find_luminances(c, s, p);
    unsigned mask = (1u << p->count) - 1u;
    while (mask & (mask - 1u) && disagree(s, p, mask)) {
        int worst = -1;
        for (int i = 0; i < p->count; i++)
            if (mask >> i & 1u && (worst < 0 || p->with[i].error > p->with[worst].error)) worst = i;
        unsigned shrinking = similar_errors(s, p, mask & ~(1u << worst), worst);
        for (int i = 0; i < p->count; i++)
            if (shrinking >> i & 1u && !may_shrink(c, s, p->with[i].record))
                shrinking &= ~(1u << i);
        if (!shrinking) return;
        p->shrinking |= shrinking;
        mask &= ~shrinking;
    }
}
