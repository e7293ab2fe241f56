// SPDX-License-Identifier: Apache-2.0
// The number of rays of a new record: a constant, or a number that depends on the variance measured
// at the records around it [K05 7.2.1]. It must not depend on the record's own rays, because that
// would bias their mean.
#include "fill/fill_record.h"

// The index of the plain number of rays; others are up to four times larger or smaller.
enum { PLAIN = FILL_LAYOUTS / 2 };

// The fraction of the rays of a record that are stratified, if the others are drawn by glossy
// lobes (gather_lobe_rays.c).
static const double STRATIFIED = 0.5;

// Replaces a set of layouts by those of `rays` rays and, if the options ask for a noise, of
// fewer and more. SATIN_ERROR_MEMORY: then it stays as it is.
static satin_status replace_layouts(struct gather_layout **layout, const struct cache_store *store,
                                    double rays) {
    const struct cache_options *o = &store->options;
    struct gather_layout *made[FILL_LAYOUTS] = {NULL};
    satin_status status = SATIN_OK;
    for (int i = 0; i < FILL_LAYOUTS && status == SATIN_OK; i++) {
        if (!(o->noise > 0.0f) && i != PLAIN) continue;
        const double wanted = fmax(4.0, fmin(ldexp(rays, i - PLAIN), FILL_RAYS_MAX));
        made[i] = gather_layout_new((int)wanted, o->basis, store->order);
        if (!made[i]) status = SATIN_ERROR_MEMORY;
    }
    for (int i = 0; i < FILL_LAYOUTS; i++) {
        gather_layout_free(status == SATIN_OK ? layout[i] : made[i]);
        if (status == SATIN_OK) layout[i] = made[i];
    }
    return status;
}

satin_status fill_rays_prepare(struct fill *fill, enum cache_kind kind, float fraction) {
    const struct cache_store *store = &fill->cache->store[kind];
    struct fill_side *side = &fill->side[kind];
    const double rays = (double)fraction * store->options.rays;
    const satin_status status = replace_layouts(side->layout, store, rays);
    if (status != SATIN_OK || !side->draws_glossy) return status;
    return replace_layouts(side->glossy, store, STRATIFIED * rays);
}

satin_status fill_limit_rays(struct fill *fill, float fraction) {
    if (fraction == fill->rays_fraction) return SATIN_OK;
    satin_status status = SATIN_OK;
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS && status == SATIN_OK; k++)
        if (fill->cache->store[k].filled) status = fill_rays_prepare(fill, k, fraction);
    if (status == SATIN_OK) fill->rays_fraction = fraction;
    return status;
}

// The relative variance of one ray, as measured by a record: its squared deviation over its squared
// value, times its number of rays.
typedef float variance_fn(const struct cache *cache, uint32_t record);

static float irradiance_variance(const struct cache *cache, uint32_t record) {
    const struct cache_irradiance_record *r = &cache->store[CACHE_IRRADIANCE].irradiance[record];
    return r->deviation * r->deviation * (float)r->value.rays;
}

static float radiance_variance(const struct cache *cache, uint32_t record) {
    const struct cache_radiance_record *r = &cache->store[CACHE_RADIANCE].radiance[record];
    float noise2 = 0.0f, size2 = 0.0f;
    const int order = cache->store[CACHE_RADIANCE].order;
    for (int k = 0; k < order * order; k++) {
        const float *value = r->value + k * CACHE_LANES;
        noise2 += sqrf(value[3]);
        size2 += sqrf(rgb_luminance(rgb_make(value[0], value[1], value[2])));
    }
    return size2 > 0.0f ? noise2 / size2 * (float)r->rays : 0.0f;
}

static variance_fn *const variance_of[CACHE_KINDS] = {
    [CACHE_IRRADIANCE] = irradiance_variance,
    [CACHE_RADIANCE] = radiance_variance,
};

bool fill_rays_glossy(const struct fill *fill, enum cache_kind kind, const struct fill_site *site) {
    return fill->side[kind].draws_glossy && site->glossy.table;
}

const struct gather_layout *fill_rays_layout(const struct fill *fill, enum cache_kind kind,
                                             const struct fill_site *site, float a) {
    const struct cache_store *store = &fill->cache->store[kind];
    const struct fill_side *side = &fill->side[kind];
    const bool glossy = fill_rays_glossy(fill, kind, site);
    struct gather_layout *const *layout = glossy ? side->glossy : side->layout;
    const float noise = store->options.noise;
    if (!(noise > 0.0f)) return layout[PLAIN];
    struct cache_near near[CACHE_NEAR_MAX];
    const int count = cache_find(fill->cache, kind, site->p, site->frame.n, a, near);
    float variance = 0.0f;
    for (int i = 0; i < count; i++) variance += variance_of[kind](fill->cache, near[i].record);
    if (!(variance > 0.0f)) return layout[PLAIN];
    const float wanted = variance / ((float)count * noise * noise);
    const float plain = (float)gather_layout_rays(side->layout[PLAIN]);
    const float times = wanted / plain;
    const int step = (int)lroundf(log2f(clampf(times, 0x1p-10f, 0x1p10f)));
    return layout[step < -PLAIN ? 0 : step > PLAIN ? FILL_LAYOUTS - 1 : PLAIN + step];
}
