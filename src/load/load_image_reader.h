// SPDX-License-Identifier: Apache-2.0
// Private to load/: the interface of what reads images: libpng, and the module around OpenImageIO,
// which load_image.c opens on first use. Linking OpenImageIO instead would cost every start 138 ms
// and 120 MB.
#ifndef LOAD_IMAGE_READER_H
#define LOAD_IMAGE_READER_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

// An image file. The bytes may be gone if the reader is the module, which reads the file by itself.
struct image_data {
    const char *path;
    const char *data;
    size_t size;  // of data [bytes]
};

struct opened_image {
    void *input;  // of the reader
    int width, height;
    int channels;  // 1 or 3: what is read; alpha and further channels are not
    int srgb;      // values are encoded by the sRGB curve, or likely so
};

enum reader_result { READER_DONE, READER_FAILED, READER_NO_MEMORY };

// Messages go to `error`, one line cut at `error_size`. No function throws.
struct image_reader {
    // Opens an image and reads its header only; or fails with a message.
    enum reader_result (*open)(const struct image_data *file, struct opened_image *out, char *error,
                               size_t error_size);
    // Reads width * height * channels floats, integers scaled to [0, 1]; or fails with a message.
    enum reader_result (*read)(struct opened_image *image, float *texel, char *error,
                               size_t error_size);
    void (*close)(struct opened_image *image);
};

// The reader of PNG files, and whether a file is one by its first bytes. It uses the file's bytes
// until it is closed.
extern const struct image_reader load_image_png;
int load_image_is_png(const struct image_data *file);

// The one symbol of the module, an image_reader.
#define OIIO_MODULE_SYMBOL "satin_oiio_module"

#ifdef __cplusplus
}
#endif
#endif
