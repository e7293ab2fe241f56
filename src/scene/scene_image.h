// SPDX-License-Identifier: Apache-2.0
// Images of textures and environments, in memory.
#ifndef SCENE_IMAGE_H
#define SCENE_IMAGE_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// An image of linear texels with 1 or 3 channels, owned by the scene's arena, row by row from the
// top: floats, or bytes, each of which stands for one of 256 values.
struct image {
    int width, height, channels;
    const float *texel;   // NULL if bytes
    const uint8_t *byte;  // NULL if floats
    const float *byte_value;
    float side;  // square root of the number of texels
};
static inline struct image scene_image_make(int width, int height, int channels,
                                            const float *texel) {
    return (struct image){.width = width,
                          .height = height,
                          .channels = channels,
                          .texel = texel,
                          .side = sqrtf((float)width * (float)height)};
}
// Value i of width * height * channels.
static inline float scene_image_value(const struct image *image, size_t i) {
    return image->byte ? image->byte_value[image->byte[i]] : image->texel[i];
}
// The memory of the texels [bytes].
static inline double scene_image_bytes(const struct image *image) {
    const double values = (double)image->width * image->height * image->channels;
    return image->byte ? values : values * sizeof *image->texel;
}

// An image that was read from a file, with smaller copies for lookups over a footprint.
struct image_file {
    const char *path;
    struct image *image, *level;  // level: copies of half the size, a quarter, ...; NULL if raw
    int levels, channel;          // channel: the only one that was read, or -1
    bool raw;
};

// The memory of the images that were read from files.
struct scene_images {
    bool module;          // whether some were read by OpenImageIO
    bool missing;         // whether some were not read, as they do not fit into the limit
    double bytes, asked;  // as they are, and about as they would be without a limit
    double needed;        // with which all can be read, beside the process
};

#endif
