// SPDX-License-Identifier: Apache-2.0
// Emission that was found by chance. The first rays may miss a small lamp or its reflection. Pixels
// with emission that are connected are one highlight, which is found as a whole as soon as one of
// them is: from there, pixels around those where rays find light get rays, too. If a ray finds it
// with the probability p in a pixel that has n samples and first rays, that of the highlight is
// P = 1 - e^-H, H being the sum of -n ln(1 - p) over its pixels. With the sums X of those samples
// and first rays and Y of the rays at rims, of the weights w and v, (X + Y) / (w + P v) is right in
// the mean, since X and Y are 0 in the images that miss it. p is measured by the rays that are
// summed in Y; where they happen to find much, P is as much larger. Where enough small lamps are
// near each other, as where one is seen through a pierced shade, all pixels around get many rays,
// and P is 1.
#include "render/render_rims.h"

// Pixels around which fewer hits are expected were found by chance. The probability that others are
// missed is below e^-3.
static const float HITS_LEAST = 3.0f;
// They are near each other up to this many pixels away.
enum { NEAR_PIXELS = 8 };

// Whether fewer hits are expected in a box than all but certainly find something.
static bool found_by_chance(const struct rims *rims, struct image_box box) {
    float hits = 0.0f;
    for (int y = box.y0; y < box.y1; y++)
        for (int x = box.x0; x < box.x1; x++)
            hits += rims->hits[(size_t)y * (size_t)rims->r->image->width + (size_t)x];
    return hits < HITS_LEAST;
}

// Visits the pixels with light that are connected with this one, and those around them, and sets
// their probability. Notes which were found by chance, and returns how many.
static size_t visit_highlight(struct rims *rims, uint32_t pixel) {
    const size_t width = (size_t)rims->r->image->width;
    size_t count = 1, by_chance = 0;
    float hits = 0.0f;
    bool near = false;
    rims->known[pixel] |= RIM_VISITED;
    rims->highlight[0] = pixel;
    for (size_t i = 0; i < count; i++) {
        const uint32_t from = rims->highlight[i];
        const struct image_box box = render_rims_around(rims, from);
        const bool chance = found_by_chance(rims, box);
        if (chance) rims->known[from] |= RIM_BY_CHANCE;
        by_chance += chance;
        if (rims->emission[from] == 0.0f) continue;
        hits += rims->hits[from];
        near = near || rims->known[from] & RIM_NEAR;
        for (int y = box.y0; y < box.y1; y++)
            for (int x = box.x0; x < box.x1; x++) {
                const size_t at = (size_t)y * width + (size_t)x;
                if (!rims->known[at] || rims->known[at] & RIM_VISITED) continue;
                rims->known[at] |= RIM_VISITED;
                rims->highlight[count++] = (uint32_t)at;
            }
    }
    const float probability = near ? 1.0f : -expm1f(-hits);
    for (size_t i = 0; i < count; i++) rims->probability[rims->highlight[i]] = probability;
    return by_chance;
}

size_t render_highlights_find(struct rims *rims) {
    const float certain = -expm1f(-HITS_LEAST);
    size_t by_chance = 0, most = 0;
    for (size_t i = 0; i < rims->list.count; i++)
        rims->known[rims->list.pixel[i]] &= (uint8_t)~RIM_VISITED;
    for (size_t i = 0; i < rims->list.count; i++) {
        const uint32_t pixel = rims->list.pixel[i];
        if (rims->known[pixel] & RIM_VISITED || rims->emission[pixel] == 0.0f) continue;
        const size_t chance = visit_highlight(rims, pixel);
        by_chance += chance;
        if (rims->probability[pixel] < certain && chance > most) most = chance;
    }
    return by_chance - most;
}

static bool enough_near(const struct rims *rims, size_t pixel) {
    const struct image_box box = render_rims_within(rims, pixel, NEAR_PIXELS);
    float hits = 0.0f;
    for (int y = box.y0; y < box.y1; y++)
        for (int x = box.x0; x < box.x1; x++) {
            const size_t at = (size_t)y * (size_t)rims->r->image->width + (size_t)x;
            if (rims->known[at] & RIM_BY_CHANCE) hits += rims->hits[at];
        }
    return hits >= HITS_LEAST;
}

void render_highlights_append_near(struct rims *rims) {
    const size_t found = rims->list.count;
    for (size_t i = 0; i < found; i++) {
        const uint32_t pixel = rims->list.pixel[i];
        if (rims->known[pixel] & RIM_BY_CHANCE && enough_near(rims, pixel))
            render_rims_append(rims, pixel, NEAR_PIXELS, RIM_NEAR);
    }
}
