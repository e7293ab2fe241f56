// SPDX-License-Identifier: Apache-2.0
// Private to load/: what the loader calls to make meshes and images. Everything made lives in the
// arena.
#ifndef LOAD_BUILD_H
#define LOAD_BUILD_H

#include "scene/scene.h"

// Bounds that keep a short hostile file from asking for all memory.
enum {
    LOAD_FILE_MAX = 2000000000,  // bytes of a mesh file
    LOAD_XML_MAX = 256 << 20,    // bytes of one XML file
    LOAD_IMAGE_PIXELS_MAX = 1 << 28
};

// Where a mesh or image comes from. `place` is the scene file's line that asks for it: errors that
// concern the file as a whole name it; errors inside a text file name the file and its line, inside
// a binary file the file.
struct load_source {
    struct log log;
    struct log_place place;
    struct arena *arena;
    const char *path;
    uint64_t *hash;  // continued over the file's bytes
};

// Reads the whole file of at most `max_bytes` and continues the hash over it; the caller frees
// *data, which ends with a 0 after its `size` bytes.
satin_status load_source_read(const struct load_source *source, size_t max_bytes, char **data,
                              size_t *size);

// Names of attributes that a mesh is asked for.
enum { ATTRIBUTES_MAX = 8 };
struct attribute_names {
    int count;
    const char *name[ATTRIBUTES_MAX];
};

struct mesh_request {
    struct mat4 to_world;
    bool flip_normals;
    bool face_normals;     // drop the file's vertex normals
    float smooth_angle;    // make them anew over edges flatter than this [degrees]; 0: keep them
    bool flip_tex_coords;  // v -> 1 - v
    int shape_index;       // serialized: which mesh of the file
    struct attribute_names attributes;  // to be kept if the file has them
};

// Reads a mesh into world space. Normals absent in the file are made smooth as Mitsuba 3 makes
// them, unless face_normals. Mirroring transforms keep the front side as Mitsuba does. Positions
// must be finite and indices in range, else SATIN_ERROR_INPUT.
satin_status load_mesh_obj(const struct load_source *source, const struct mesh_request *request,
                           struct mesh *out);
satin_status load_mesh_ply(const struct load_source *source, const struct mesh_request *request,
                           struct mesh *out);
satin_status load_mesh_serialized(const struct load_source *source,
                                  const struct mesh_request *request, struct mesh *out);
// The unit rectangle [-1, 1]^2 at z = 0 facing +z and the cube [-1, 1]^3, transformed.
satin_status load_mesh_rectangle(struct arena *arena, const struct mesh_request *request,
                                 struct mesh *out);
satin_status load_mesh_cube(struct arena *arena, const struct mesh_request *request,
                            struct mesh *out);

// Reads lines `x y z radius`, one control point each; blank lines separate curves. Points go to
// world space, radii stay as they are, as in Mitsuba. `linear`: segments between neighbours, two
// points or more to a curve; else cubic B-splines, four points or more.
satin_status load_curves(const struct load_source *source, const struct mat4 *to_world, bool linear,
                         struct curves *out);

// Reads an image through libpng or OpenImageIO, to linear floats with 1 or 3 channels (alpha is
// dropped). `raw`: values are taken as they are; else sRGB or untagged 8- and 16-bit data are
// linearised.
satin_status load_image(const struct load_source *source, bool raw, const struct image **out);
// Makes all smaller copies of an image, down to one texel; false without memory.
bool load_image_levels(struct arena *arena, const struct image *image, const struct image **level,
                       int *levels);
// Undoes the encoding of sRGB.
static inline float srgb_to_linear(float x) {
    return x <= 0.04045f ? x / 12.92f : powf((x + 0.055f) / 1.055f, 2.4f);
}

#endif
