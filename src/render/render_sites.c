// SPDX-License-Identifier: Apache-2.0
// The shading points of the image where records may be needed: grids of pixels, and what the eye
// sees there.
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "render/render_state.h"

enum {
    SITES_PER_PIXEL = 4,  // at most
    ROUND_PIXELS = 8192   // that are traced at a time, in slots of 11 MB; 128 chunks
};

struct site_search {
    const struct render *r;
    const uint32_t *pixel;
    bool adaptive;
    struct cache_site *slot;  // SITES_PER_PIXEL for each pixel of a round
    uint8_t *count;           // of them that are filled
};

uint32_t *render_grid(const struct render *r, int stride, bool finer, size_t *count) {
    int width = r->options.width, height = r->options.height;
    size_t columns = (size_t)(width + stride - 1) / (size_t)stride;
    size_t rows = (size_t)(height + stride - 1) / (size_t)stride, n = 0;
    uint32_t *pixel = array_new(columns * rows, sizeof *pixel);
    *count = 0;
    if (!pixel) return NULL;
    for (int y = 0; y < height; y += stride)
        for (int x = 0; x < width; x += stride)
            if (!finer || x % (2 * stride) || y % (2 * stride))
                pixel[n++] = (uint32_t)y * (uint32_t)width + (uint32_t)x;
    struct rng rng = rng_make(r->options.seed, RNG_SITE, (uint64_t)stride);
    for (size_t i = n; i > 1; i--) {
        size_t j = (size_t)(((uint64_t)rng_u32(&rng) * i) >> 32);
        uint32_t t = pixel[i - 1];
        pixel[i - 1] = pixel[j];
        pixel[j] = t;
    }
    *count = n;
    return pixel;
}

static void find_pixel_sites(void *ctx, size_t begin, size_t end, int worker) {
    struct site_search *s = ctx;
    (void)worker;
    const uint32_t width = (uint32_t)s->r->options.width;
    for (size_t i = begin; i < end; i++) {
        const int x = (int)(s->pixel[i] % width), y = (int)(s->pixel[i] / width);
        s->count[i] = (uint8_t)shade_sites(&s->r->second_pass.shade, x, y, s->adaptive,
                                           &s->slot[i * SITES_PER_PIXEL], SITES_PER_PIXEL);
    }
}

// Appends the sites of a round of `pixels`, in order.
static bool append_sites(const struct site_search *s, size_t pixels, struct render_sites *out) {
    size_t more = 0;
    for (size_t i = 0; i < pixels; i++) more += s->count[i];
    if (more == 0) return true;
    if (!array_reserve((void **)&out->site, &out->capacity, out->count + more, sizeof *out->site))
        return false;
    for (size_t i = 0; i < pixels; i++) {
        memcpy(out->site + out->count, s->slot + i * SITES_PER_PIXEL,
               s->count[i] * sizeof *s->slot);
        out->count += s->count[i];
    }
    return true;
}

satin_status render_find_sites(struct render *r, const uint32_t *pixel, size_t count, bool adaptive,
                               struct render_sites *sites) {
    const char *part = parallel_begin_part(r->pool, "sites");
    const size_t most = count < ROUND_PIXELS ? count : ROUND_PIXELS;
    struct site_search s = {.r = r, .adaptive = adaptive};
    s.slot = array_new(most * SITES_PER_PIXEL, sizeof *s.slot);
    s.count = array_new(most, 1);
    satin_status status = s.slot && s.count ? SATIN_OK : SATIN_ERROR_MEMORY;
    sites->count = 0;
    for (size_t i = 0; i < count && status == SATIN_OK; i += ROUND_PIXELS) {
        const size_t pixels = count - i < ROUND_PIXELS ? count - i : ROUND_PIXELS;
        s.pixel = pixel + i;
        if (!parallel_for(r->pool, pixels, 64, find_pixel_sites, &s))
            status = SATIN_CANCELLED;
        else if (!append_sites(&s, pixels, sites))
            status = SATIN_ERROR_MEMORY;
    }
    free(s.slot);
    free(s.count);
    parallel_begin_part(r->pool, part);
    return status;
}

void render_sites_free(struct render_sites *sites) {
    free(sites->site);
    *sites = (struct render_sites){0};
}
