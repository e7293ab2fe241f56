// SPDX-License-Identifier: Apache-2.0
// Private to scene/: what the loader calls to make meshes and images. Everything made lives in the
// arena.
#ifndef SCENE_BUILD_H
#define SCENE_BUILD_H

#include "scene/scene.h"

// Bounds that keep a short hostile file from asking for all memory.
enum {
    SCENE_FILE_MAX = 2000000000,  // bytes of a mesh file
    SCENE_XML_MAX = 256 << 20,    // bytes of one XML file
    SCENE_IMAGE_PIXELS_MAX = 1 << 28
};

// Where a mesh or image comes from. `place` is the scene file's line that asks for it: errors that
// concern the file as a whole name it; errors inside a text file name the file and its line, inside
// a binary file the file.
struct scene_source {
    struct log log;
    struct log_place place;
    struct arena *arena;
    const char *path;
    uint64_t *hash;  // continued over the file's bytes
};

// Reads the whole file of at most `max_bytes` and continues the hash over it; the caller frees
// *data, which ends with a 0 after its `size` bytes.
satin_status scene_source_read(const struct scene_source *source, size_t max_bytes, char **data,
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
satin_status scene_mesh_obj(const struct scene_source *source, const struct mesh_request *request,
                            struct mesh *out);
satin_status scene_mesh_ply(const struct scene_source *source, const struct mesh_request *request,
                            struct mesh *out);
satin_status scene_mesh_serialized(const struct scene_source *source,
                                   const struct mesh_request *request, struct mesh *out);
// The unit rectangle [-1, 1]^2 at z = 0 facing +z and the cube [-1, 1]^3, transformed.
satin_status scene_mesh_rectangle(struct arena *arena, const struct mesh_request *request,
                                  struct mesh *out);
satin_status scene_mesh_cube(struct arena *arena, const struct mesh_request *request,
                             struct mesh *out);

// Places a sphere, disk or cylinder by the transform of its object space (a sphere's or cylinder's
// centre, radius and ends included): sets to_world, to_object, center and radius. A mirrored sphere
// turns its front side, as in Mitsuba: flip_normals, set before, is toggled. False if the transform
// has no inverse.
bool scene_shape_place(struct shape *shape, const struct mat4 *to_world);
// World-space area of a shape.
float scene_shape_area(const struct shape *shape);

// Reads an image through OpenImageIO, to linear floats with 1 or 3 channels (alpha is dropped).
// `raw`: values are taken as they are; else sRGB or untagged 8- and 16-bit data are linearised.
satin_status scene_image_load(const struct scene_source *source, bool raw,
                              const struct image **out);
// Makes all smaller copies of an image, down to one texel; false without memory.
bool scene_image_levels(struct arena *arena, const struct image *image, const struct image **level,
                        int *levels);
// Undoes the encoding of sRGB.
static inline float srgb_to_linear(float x) {
    return x <= 0.04045f ? x / 12.92f : powf((x + 0.055f) / 1.055f, 2.4f);
}

// What is wrong with a PNG file that was read whole, in words; NULL: nothing, or it is no PNG.
// scene_image_no_memory: it is not known.
extern const char scene_image_no_memory[];
const char *scene_image_png_problem(const char *data, size_t size);

// What is in it once its factors are taken off; NULL of NULL.
static inline const struct texture *texture_unscaled(const struct texture *texture) {
    while (texture && texture->kind == TEXTURE_SCALED) texture = texture->check[0];
    return texture;
}
// The part of the plane that the lines of a grid cover.
static inline float texture_lines(const struct texture *grid) {
    const float between = fmaxf(1.0f - 2.0f * grid->scale, 0.0f);
    return 1.0f - between * between;
}

#endif
