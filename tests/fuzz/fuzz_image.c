// SPDX-License-Identifier: Apache-2.0
// Any bytes given as an image, through OpenImageIO: finite texels of at least 0, or one logged
// error; no crash of ours, bounded memory.
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

#include "scene/scene_build.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void count(void *user, satin_log_level level, const char *text) {
    (void)text;
    if (level == SATIN_LOG_ERROR) ++*(int *)user;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    int file = memfd_create("image", MFD_CLOEXEC), lines = 0;
    if (file < 0 || write(file, data, size) != (ssize_t)size) abort();
    char path[64];
    sprintf(path, "/proc/self/fd/%d", file);
    struct arena arena = {0};
    struct scene_source source = {{count, &lines}, {"fuzz.xml", 1, 1}, &arena, path, NULL};
    const struct image *image = NULL;
    satin_status status = scene_image_load(&source, size & 1, &image);
    if (lines != (status != SATIN_OK) || (status == SATIN_OK) != (image != NULL)) abort();
    size_t texels = image ? (size_t)image->width * (size_t)image->height : 0;
    for (size_t i = 0; i < texels * (size_t)(image ? image->channels : 0); i++)
        if (!(image->texel[i] >= 0.0f) || !isfinite(image->texel[i])) abort();
    arena_free(&arena);
    close(file);
    return 0;
}
