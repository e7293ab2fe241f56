// SPDX-License-Identifier: Apache-2.0
// Private to load/: the interface of image readers, which are libpng (load_image_png.c),
// libjpeg (load_image_jpeg.c), OpenEXR (load_image_exr.c) and the module on OpenImageIO.
// load_image.c opens the module on first use: if OpenImageIO were linked, every start would take
// 138 ms and 120 MB more.
#ifndef LOAD_IMAGE_READER_H
#define LOAD_IMAGE_READER_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

// An image file. For the module `data` may be NULL, as it reads the file itself.
struct image_data {
    const char *path;
    const char *data;
    size_t size;  // of data [bytes]
    int alpha;    // whether alpha is read, if there is any
};

struct opened_image {
    void *input;  // of the reader
    int width, height;
    int channels;  // 1 or 3, and one more with alpha; further channels are not read
    int bytes;     // whether values are bytes, which stand for 0 to 1; else floats
    int srgb;      // whether values are encoded by the transfer function of sRGB, or probably are
};

enum reader_result { READER_DONE, READER_FAILED, READER_NO_MEMORY };

// An image reader. Messages go to `error`, as one line cut at `error_size`. No function throws
// exceptions.
struct image_reader {
    // Opens an image and reads its header, or fails with a message.
    enum reader_result (*open)(const struct image_data *file, struct opened_image *out, char *error,
                               size_t error_size);
    // Reads width * height * channels bytes or floats, with integers scaled to [0, 1], or fails
    // with a message.
    enum reader_result (*read)(struct opened_image *image, void *values, char *error,
                               size_t error_size);
    void (*close)(struct opened_image *image);
};

// The reader of PNG files, which uses the bytes of the file until it is closed; and whether a file
// is a PNG by its first bytes.
extern const struct image_reader load_image_png;
int load_image_is_png(const struct image_data *file);
// Likewise for JPEG files of one or three components.
extern const struct image_reader load_image_jpeg;
int load_image_is_jpeg(const struct image_data *file);
// Likewise for OpenEXR files of the usual channels and methods of compression.
extern const struct image_reader load_image_exr;
int load_image_is_exr(const struct image_data *file);

// The only symbol of the module, an image_reader.
#define OIIO_MODULE_SYMBOL "satin_oiio_module"

#ifdef __cplusplus
}
#endif
#endif
