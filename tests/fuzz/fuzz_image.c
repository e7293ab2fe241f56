// SPDX-License-Identifier: Apache-2.0
// Any bytes given as an image, through OpenImageIO: finite texels of at least 0, or one logged
// error; no crash in satin, bounded memory.
#include "fuzz_case.h"
#include "load/load_build.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    char path[FUZZ_PATH];
    int file = fuzz_file(data, size, path), lines = 0;
    struct arena arena = {0};
    struct load_source source = {{fuzz_count, &lines}, {"fuzz.xml", 1, 1}, &arena, path, NULL};
    const struct image *image = NULL;
    satin_status status = load_image(&source, size & 1, &image);
    if (lines != (status != SATIN_OK) || (status == SATIN_OK) != (image != NULL)) abort();
    size_t texels = image ? (size_t)image->width * (size_t)image->height : 0;
    for (size_t i = 0; i < texels * (size_t)(image ? image->channels : 0); i++)
        if (!(image->texel[i] >= 0.0f) || !isfinite(image->texel[i])) abort();
    arena_free(&arena);
    close(file);
    return 0;
}
