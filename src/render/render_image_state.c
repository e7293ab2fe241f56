// SPDX-License-Identifier: Apache-2.0
// The state of an image as bytes, for checkpoints and other ranks.
#include "render/render_image.h"

// The arrays of an image with `size` bytes for each pixel; NULL where the image has none.
struct image_plane {
    void *items;
    size_t size;
};
enum { IMAGE_PLANES = 7 + CRYPTOMATTES };

static void list_planes(const struct render_image *image, struct image_plane out[IMAGE_PLANES]) {
    out[0] = (struct image_plane){image->pixel, sizeof *image->pixel};
    out[1] = (struct image_plane){image->adapt.pixel, sizeof *image->adapt.pixel};
    out[2] = (struct image_plane){image->aov, image->sums * sizeof *image->aov};
    out[3] = (struct image_plane){image->blocks, sizeof *image->blocks};
    out[4] = (struct image_plane){image->uncached, sizeof *image->uncached};
    out[5] = (struct image_plane){image->gathered, sizeof *image->gathered};
    out[6] = (struct image_plane){image->noisy_light, sizeof *image->noisy_light};
    for (int i = 0; i < CRYPTOMATTES; i++)
        out[7 + i] =
            (struct image_plane){image->cryptomatte.pixel[i], sizeof *image->cryptomatte.pixel[i]};
}

// Visits the rows of a box in all planes, in order.
static void visit_rows(const struct render_image *image, struct image_box box, void *ctx,
                       void (*visit)(void *ctx, void *row, size_t size)) {
    struct image_plane plane[IMAGE_PLANES];
    list_planes(image, plane);
    for (int i = 0; i < IMAGE_PLANES; i++)
        for (int y = box.y0; plane[i].items && y < box.y1; y++) {
            const size_t at = (size_t)y * (size_t)image->width + (size_t)box.x0;
            visit(ctx, (unsigned char *)plane[i].items + at * plane[i].size,
                  (size_t)(box.x1 - box.x0) * plane[i].size);
        }
}

static void put_row(void *out, void *row, size_t size) { bytes_put(out, row, size); }

static void get_row(void *in, void *row, size_t size) { bytes_get(in, row, size); }

void render_image_pack_box(const struct render_image *image, struct image_box box,
                           struct bytes *out) {
    visit_rows(image, box, out, put_row);
}

void render_image_unpack_box(struct render_image *image, struct image_box box,
                             struct bytes_reader *in) {
    visit_rows(image, box, in, get_row);
}

static struct image_box whole_box(const struct render_image *image) {
    return (struct image_box){0, 0, image->width, image->height};
}

void render_image_pack(const struct render_image *image, struct bytes *out) {
    bytes_put_u64(out, image->taken);
    bytes_put_u64(out, image->begun);
    bytes_put_u64(out, image->block);
    bytes_put_u64(out, image->rims_taken);
    bytes_put_u64(out, image->rare_emission);
    bytes_put_u64(out, image->has_features);
    bytes_put_u64(out, image->noisy.clean);
    bytes_put(out, &image->counts, sizeof image->counts);
    render_image_pack_box(image, whole_box(image), out);
}

bool render_image_unpack(struct render_image *image, const struct bytes *bytes) {
    struct bytes_reader in = {bytes->data, bytes->count, false};
    image->taken = bytes_get_u64(&in);
    image->begun = bytes_get_u64(&in);
    image->block = (uint32_t)bytes_get_u64(&in);
    image->rims_taken = bytes_get_u64(&in);
    image->rare_emission = bytes_get_u64(&in) != 0;
    image->has_features = bytes_get_u64(&in) != 0;
    image->noisy.clean = bytes_get_u64(&in) != 0;
    bytes_get(&in, &image->counts, sizeof image->counts);
    render_image_unpack_box(image, whole_box(image), &in);
    image->state = IMAGE_PAUSED;
    return !in.failed && in.left == 0 && image->block > 0;
}
