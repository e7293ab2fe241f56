// SPDX-License-Identifier: Apache-2.0
// Adaptive caching over the image [K05 6.3], at the shading points where records must agree.
#include <stdlib.h>

#include "render/render_state.h"

// Adapts the records to what camera number `view` sees in these pixels.
static satin_status adapt_view(struct render *r, uint32_t view, const uint32_t *pixel,
                               size_t pixels) {
    struct render_sites sites = {0};
    satin_status status =
        render_find_sites(r, view, pixel, &pixels, render_memory_adapted(r), true, &sites);
    for (enum cache_kind k = CACHE_IRRADIANCE; k < CACHE_KINDS && status == SATIN_OK; k++) {
        const struct cache_options *o = &r->second_pass.cache->store[k].options;
        const struct fill_sites wanted = {.site = sites.site,
                                          .count = sites.count,
                                          .a = o->a,
                                          .factor_max = render_budget_largest_factor(&r->options),
                                          .spacing = 1.5f};
        status = fill_adapt(r->second_pass.fill, k, &wanted, o->a * o->widen);
    }
    render_sites_free(&sites);
    return status;
}

satin_status render_adaptive_cache(struct render *r) {
    const int stride = render_budget_adaptive_stride(r->options.width, r->options.height);
    size_t pixels;
    uint32_t *pixel = render_grid(r, stride, false, &pixels);
    satin_status status = pixel ? SATIN_OK : SATIN_ERROR_MEMORY;
    for (uint32_t i = 0; i < scene_camera_count(&r->scene) && status == SATIN_OK; i++) {
        const size_t before = cache_count_all(r->second_pass.cache);
        status = adapt_view(r, i, pixel, pixels);
        if (r->frames.view)
            r->frames.records[i] += (double)(cache_count_all(r->second_pass.cache) - before);
    }
    free(pixel);
    return status;
}
