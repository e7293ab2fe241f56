// SPDX-License-Identifier: Apache-2.0
// Adaptive caching over the image [K05 6.3]: the shading points at which records must agree.
#include <stdlib.h>

#include "base/array.h"
#include "render/render_state.h"

enum {
    POINTS_MOST = 1 << 18,  // pixels asked; a larger image is asked at every so many
    STRIDE_LEAST = 2,
    SITES_PER_PIXEL = 4
};

struct points {
    struct render *r;
    const uint32_t *pixel;
    struct cache_site *site;
    uint8_t *count;
};

static void find_sites(void *ctx, size_t begin, size_t end, int worker) {
    struct points *p = ctx;
    (void)worker;
    uint32_t width = (uint32_t)p->r->options.width;
    for (size_t i = begin; i < end; i++)
        p->count[i] = (uint8_t)shade_sites(&p->r->second_pass.shade, (int)(p->pixel[i] % width),
                                           (int)(p->pixel[i] / width), 0,
                                           &p->site[i * SITES_PER_PIXEL], SITES_PER_PIXEL);
}

static void surface(void *user, const struct cache_site *site, struct cache_place *at,
                    struct cache_surface *out) {
    struct render *r = user;
    shade_surface(&r->second_pass.shade, site, at, out);
}

static float direct(void *user, const struct cache_site *site) {
    struct render *r = user;
    return shade_surface_direct(&r->second_pass.shade, site);
}

static satin_status converge(struct points *p, size_t pixels, float widen, const float read[2]) {
    struct render *r = p->r;
    if (!parallel_for(r->pool, pixels, 64, find_sites, p)) return SATIN_CANCELLED;
    size_t n = 0;
    for (size_t i = 0; i < pixels; i++)
        for (int k = 0; k < p->count[i]; k++)
            p->site[n++] = p->site[i * SITES_PER_PIXEL + (size_t)k];
    struct cache_converge with = {
        .site = p->site,
        .count = n,
        .fill = {.a_irradiance = r->options.irradiance_a * widen,
                 .a_radiance = r->options.radiance_a * widen,
                 .widest = render_widest(r),
                 .spacing = 1.5f,
                 .go_on = r->options.time > 0.0 ? render_time_remains : NULL,
                 .view = render_view,
                 .user = r},
        .widen = {read[0] / widen, read[1] / widen},
        .surface = surface,
        .direct = direct,
        .user = r,
    };
    return cache_converge(r->second_pass.cache, &with);
}

satin_status render_converge(struct render *r, float widen, const float read[2]) {
    int stride = STRIDE_LEAST;
    while ((int64_t)r->options.width * r->options.height / stride / stride > POINTS_MOST) stride++;
    size_t pixels;
    uint32_t *pixel = render_grid(r, stride, false, &pixels);
    struct points p = {.r = r, .pixel = pixel};
    p.site = array_new(pixels * SITES_PER_PIXEL, sizeof *p.site);
    p.count = array_new(pixels, 1);
    satin_status status = SATIN_ERROR_MEMORY;
    if (pixel && p.site && p.count) status = converge(&p, pixels, widen, read);
    free(pixel);
    free(p.site);
    free(p.count);
    return status;
}
