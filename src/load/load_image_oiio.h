// SPDX-License-Identifier: Apache-2.0
// Private to load/: the C interface of the module around OpenImageIO, which load_image.c opens
// on first use. Linking OpenImageIO instead would cost every start 138 ms and 120 MB.
#ifndef LOAD_IMAGE_OIIO_H
#define LOAD_IMAGE_OIIO_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

struct oiio_image {
    void *input;  // of the module
    int width, height;
    int channels;  // 1 or 3: what is read; alpha and further channels are not
    int srgb;      // values are encoded by the sRGB curve, or likely so
};

enum oiio_result { OIIO_DONE, OIIO_FAILED, OIIO_NO_MEMORY };

// Messages go to `error`, one line cut at `error_size`. No function throws.
struct oiio_module {
    // Opens an image and reads its header only; or fails with a message.
    enum oiio_result (*open)(const char *path, struct oiio_image *out, char *error,
                             size_t error_size);
    // Reads width * height * channels floats, integers scaled to [0, 1]; or fails with a message.
    enum oiio_result (*read)(struct oiio_image *image, float *texel, char *error,
                             size_t error_size);
    void (*close)(struct oiio_image *image);
};

// The one symbol of the module.
#define OIIO_MODULE_SYMBOL "satin_oiio_module"

#ifdef __cplusplus
}
#endif
#endif
