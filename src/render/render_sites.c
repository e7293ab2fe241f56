// SPDX-License-Identifier: Apache-2.0
// The shading points of the image at which records may be needed: grids of pixels, and the points
// that are seen there.
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "render/render_state.h"

enum { SITES_PER_PIXEL = 4 };  // largest number

struct site_search {
    const struct render *r;
    struct shade shade;  // that of the image pass, with the camera of the search
    uint32_t view;       // index of this camera
    const uint32_t *pixel;
    bool adaptive;
    struct fill_site *found;  // SITES_PER_PIXEL for each pixel of a block
    uint8_t *count;           // number of sites of each pixel
    struct fill_site *site;   // the sites of the block are appended here
    size_t *first;            // index of the first site of each pixel
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
        struct fill_site *found = &s->found[i * SITES_PER_PIXEL];
        s->count[i] = (uint8_t)shade_sites(&s->shade, x, y, s->adaptive, found, SITES_PER_PIXEL);
        // Otherwise the records of a pixel would have the same noise in all views.
        for (int k = 0; k < s->count[i] && s->view > 0; k++)
            found[k].stream = rng_mix(found[k].stream + s->view);
    }
}

static void copy_sites(void *ctx, size_t begin, size_t end, int worker) {
    const struct site_search *s = ctx;
    (void)worker;
    for (size_t i = begin; i < end; i++)
        memcpy(s->site + s->first[i], s->found + i * SITES_PER_PIXEL,
               s->count[i] * sizeof *s->found);
}

// Appends the sites of a block of `pixels`, in order.
static satin_status append_sites(struct site_search *s, size_t pixels, struct render_sites *out) {
    size_t more = 0;
    for (size_t i = 0; i < pixels; i++) {
        s->first[i] = more;
        more += s->count[i];
    }
    if (more == 0) return SATIN_OK;
    if (!array_reserve((void **)&out->site, &out->capacity, out->count + more, sizeof *out->site))
        return SATIN_ERROR_MEMORY;
    s->site = out->site + out->count;
    out->count += more;
    return parallel_for(s->r->pool, pixels, 64, copy_sites, s) ? SATIN_OK : SATIN_CANCELLED;
}

satin_status render_find_sites(struct render *r, uint32_t view, const uint32_t *pixel,
                               size_t *count, size_t most, bool adaptive,
                               struct render_sites *sites) {
    const char *part = parallel_begin_part(r->pool, "sites");
    const size_t block = *count < RENDER_TRACED_PIXELS ? *count : RENDER_TRACED_PIXELS;
    struct site_search s = {
        .r = r, .shade = r->second_pass.shade, .view = view, .adaptive = adaptive};
    s.shade.camera = scene_camera_at(&r->scene, view);
    s.found = array_new_unset(block * SITES_PER_PIXEL, sizeof *s.found);
    s.count = array_new(block, 1);
    s.first = array_new(block, sizeof *s.first);
    satin_status status = s.found && s.count && s.first ? SATIN_OK : SATIN_ERROR_MEMORY;
    sites->count = 0;
    size_t done = 0;
    while (done < *count && sites->count < most && status == SATIN_OK) {
        const size_t pixels = *count - done < block ? *count - done : block;
        s.pixel = pixel + done;
        done += pixels;
        if (!parallel_for(r->pool, pixels, 64, find_pixel_sites, &s))
            status = SATIN_CANCELLED;
        else
            status = append_sites(&s, pixels, sites);
    }
    *count = done;
    free(s.found);
    free(s.count);
    free(s.first);
    parallel_begin_part(r->pool, part);
    return status;
}

void render_sites_free(struct render_sites *sites) {
    free(sites->site);
    *sites = (struct render_sites){0};
}
