// SPDX-License-Identifier: Apache-2.0
// Lists of the pixels of an image that something holds of, found by all threads.
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "render/render_image.h"

enum { SEARCH_ROWS = 8 };  // per chunk

// The context of the loop over rows.
struct pixel_search {
    const struct pixel_list *list;
    render_pixel_fn *holds;
    const void *ctx;
    size_t width;
};

bool render_pixels_make(struct pixel_list *list, const struct render_image *image) {
    *list = (struct pixel_list){
        .pixel = array_new_unset(render_pixel_count(image), sizeof *list->pixel),
        .found = array_new((size_t)image->height, sizeof *list->found)};
    return list->pixel && list->found;
}

void render_pixels_destroy(struct pixel_list *list) {
    free(list->pixel);
    free(list->found);
    *list = (struct pixel_list){0};
}

// Stores the pixels of each row from the index on at which the row begins.
static void search_rows(void *ctx, size_t begin, size_t end, int worker) {
    const struct pixel_search *search = ctx;
    const size_t width = search->width;
    (void)worker;
    for (size_t y = begin; y < end; y++)
        for (size_t at = y * width; at < (y + 1) * width; at++)
            if (search->holds(search->ctx, at))
                search->list->pixel[y * width + search->list->found[y]++] = (uint32_t)at;
}

void render_pixels_find(struct pixel_list *list, const struct render *r, render_pixel_fn *holds,
                        const void *ctx) {
    const size_t width = (size_t)r->image->width, height = (size_t)r->image->height;
    struct pixel_search search = {.list = list, .holds = holds, .ctx = ctx, .width = width};
    memset(list->found, 0, height * sizeof *list->found);
    list->count = 0;
    parallel_for_all(r->pool, height, SEARCH_ROWS, search_rows, &search);
    for (size_t y = 0; y < height; y++) {
        memmove(list->pixel + list->count, list->pixel + y * width,
                list->found[y] * sizeof *list->pixel);
        list->count += list->found[y];
    }
}
