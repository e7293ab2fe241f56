// SPDX-License-Identifier: Apache-2.0
// Any bytes given as an image, through OpenImageIO: finite texels of at least 0, or one logged
// error; so are those of smaller copies and of the image that a limit of memory leaves; no crash in
// satin, bounded memory.
#include "fuzz_case.h"
#include "load/load_build.h"

static void check_texels(const struct image *image) {
    const size_t texels = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < texels * (size_t)image->channels; i++)
        if (!(scene_image_value(image, i) >= 0.0f) || !isfinite(scene_image_value(image, i)))
            abort();
}

// Makes the image coarser as often as it can be.
static void check_coarser(struct load_images *images, struct image *image, bool raw) {
    struct image *level = NULL;
    struct scene_images what;
    int levels = 0;
    images->memory = 1.0;
    if ((!raw && !load_image_levels(images->arena, image, &level, &levels)) ||
        !load_images_keep(images, image, level, levels, raw && image->height % 2 == 0))
        abort();
    load_images_end(images, (struct log){0}, &what);
    if (image->width >= 6 && image->height >= 6) abort();
    check_texels(image);
    for (int i = 0; i < levels; i++) check_texels(&level[i]);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    char path[FUZZ_PATH];
    int file = fuzz_file(data, size, path), lines = 0;
    struct arena arena = {0};
    struct load_source source = {{fuzz_count, &lines}, {"fuzz.xml", 1, 1}, &arena, path, NULL};
    struct load_images images = {.arena = &arena};
    struct image *image = NULL;
    const bool raw = size & 1;
    satin_status status = size & 2
                              ? load_image_texture(&source, &images, raw, LOAD_IMAGE_ALPHA, &image)
                              : load_image(&source, &images, raw, &image);
    if (lines != (status != SATIN_OK) || (status == SATIN_OK) != (image != NULL)) abort();
    if (image) {
        check_texels(image);
        check_coarser(&images, image, raw);
    }
    arena_free(&arena);
    close(file);
    return 0;
}
