// SPDX-License-Identifier: Apache-2.0
// Private to load/: functions that make meshes and images. Everything that they make is in the
// arena.
#ifndef LOAD_BUILD_H
#define LOAD_BUILD_H

#include "scene/scene.h"

// Limits, so that a short hostile file cannot allocate all memory.
enum {
    LOAD_FILE_MAX = 2000000000,  // bytes of a mesh file
    LOAD_XML_MAX = 256 << 20,    // bytes of one XML file
    LOAD_IMAGE_PIXELS_MAX = 1 << 28
};

// The file of a mesh or image. Errors in the file as a whole are reported at `place`, the line of
// the scene file that refers to it. Errors inside a text file are reported with its name and line,
// errors inside a binary file with its name.
struct load_source {
    struct log log;
    struct log_place place;
    struct arena *arena;
    const char *path;
    uint64_t *hash;  // continued over the bytes of the file
};

// Where images are kept, and what they may take.
struct load_images {
    struct arena *arena;
    double memory;  // a render's limit [bytes], of which images may take half of what the process
                    // leaves; 0: there is none
    struct load_held *held;  // all of them; owned
    size_t count, capacity;
    double asked;   // bytes of all that were asked for, with copies
    double needed;  // bytes beside the process with which all could have been read
    bool module;    // whether some were read by OpenImageIO
    bool missing;   // whether some were not read, as they do not fit
};

// Reads the whole file, of at most `max_bytes`, and continues the hash over it. The caller frees
// *data, which has a 0 after its `size` bytes.
satin_status load_source_read(const struct load_source *source, size_t max_bytes, char **data,
                              size_t *size);

// Names of the attributes that a mesh must keep.
enum { ATTRIBUTES_MAX = 8 };
struct attribute_names {
    int count;
    const char *name[ATTRIBUTES_MAX];
};
// The name of the colours of vertices as Mitsuba 0.6 reads them: integers are fractions, and all
// are sRGB unless the shape says otherwise.
#define LOAD_VERTEX_COLORS "vertexcolors"

struct mesh_request {
    struct mat4 to_world;
    bool flip_normals;
    bool face_normals;     // ignore the vertex normals of the file
    float smooth_angle;    // compute normals that are smooth across edges with angles below this
                           // [degrees]; 0: keep the file's
    bool flip_tex_coords;  // v -> 1 - v
    int shape_index;       // serialized: index of the mesh in the file
    bool linear_colors;    // PLY: LOAD_VERTEX_COLORS are linear, not sRGB
    struct attribute_names attributes;  // to be kept if the file has them
    const char *const *material;        // OBJ: names of materials, each once; their faces are
    size_t material_count;              // meshes of their own
    bool others;                        // whether faces of other materials are expected
};

// Reads a mesh and transforms it to world space. If the file has no normals, smooth ones are
// computed as in Mitsuba 3, unless face_normals. Mirroring transforms keep the front side, as in
// Mitsuba. Positions must be finite and indices in range, else SATIN_ERROR_INPUT.
// An OBJ is one mesh for each material of the request, without triangles if no face has it, and a
// last one for all other faces: `out` is an array.
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

// A grid of heights: row by row, the first row at y = -1. A row or a column alone counts twice.
struct heights {
    int width, height;   // columns and rows, of both 1 at least and 2^26 together at most
    int channels;        // 1 or 3
    const float *value;  // finite
    rgb factor;          // of the values, whose luminance is the height
};
enum { HEIGHTS_MAX = 1 << 26 };  // as many triangles as the largest mesh file has

// Makes a surface over [-1, 1]^2 with its vertices at the heights: two triangles per cell, whose
// common edge goes from (x, y) to (x + 1, y + 1), texture coordinates from (0, 0) at (-1, -1) to
// (1, 1), and vertex normals as in Mitsuba 0.6 unless request->face_normals. SATIN_ERROR_INPUT,
// without a message, if a position is not finite or too far away.
satin_status load_mesh_heightfield(struct arena *arena, const struct mesh_request *request,
                                   const struct heights *heights, struct mesh *out);

// Reads lines `x y z radius`, one control point each; blank lines separate curves. Points are
// transformed to world space, but radii are not, as in Mitsuba. If `linear`, a curve is straight
// segments between two or more points; else it is a cubic B-spline of four or more.
satin_status load_curves(const struct load_source *source, const struct mat4 *to_world, bool linear,
                         struct curves *out);

// How the strands of a file become curves.
struct hair_request {
    struct mat4 to_world;
    float radius;           // world space, > 0
    float angle_threshold;  // [degrees], 0 to 90
    float reduction;        // the fraction of strands that are left out, in [0, 1)
};

// Reads the strands of Mitsuba 0.6 as straight segments: lines `x y z`, where a blank line or one
// that begins with # separates strands, or the binary form that load_hair.c describes. The radius
// is the same everywhere. Points that repeat the one before are dropped; a point replaces the one
// before if the direction to it differs by less than the threshold. Strands without a segment count
// for nothing, but a file without any is SATIN_ERROR_INPUT, as is one that is damaged.
satin_status load_hair(const struct load_source *source, const struct hair_request *request,
                       struct curves *out);

// Reads an image to linear floats with 1 or 3 channels, without alpha. Unless `raw`, 8- and 16-bit
// data that is sRGB or untagged is converted to linear.
// One that does not fit into the limit is not read but replaced by a small one.
satin_status load_image(const struct load_source *source, struct load_images *images, bool raw,
                        struct image **out);
// Likewise, but one of 8 bits stays as bytes; and if `channel` is not LOAD_IMAGE_ALL, reads a
// single channel: 0 to 2 of the colours, of which a grey image has one, or LOAD_IMAGE_ALPHA, which
// is never converted. SATIN_ERROR_INPUT if the file has no alpha.
enum { LOAD_IMAGE_ALL = -1, LOAD_IMAGE_ALPHA = 3 };
satin_status load_image_texture(const struct load_source *source, struct load_images *images,
                                bool raw, int channel, struct image **out);
// Reads an image of heights as load_image does. All values must be finite, but may be negative, and
// the size is that of the file. The texels are an array alone in the arena. *module is set to true
// if OpenImageIO read it.
satin_status load_image_heights(const struct load_source *source, bool raw, bool *module,
                                struct image **out);
// Makes all smaller copies of an image, down to one texel. False if there is no memory.
bool load_image_levels(struct arena *arena, const struct image *image, struct image **level,
                       int *levels);
// Sets *out, whose texels are a copy alone in the arena, to one of half the size. False if there is
// no memory.
bool load_image_coarser(struct arena *arena, const struct image *from, bool environment,
                        struct image *out);

// ---- load_image_limit.c: images that become coarser where memory is limited

// Finds whether an image of so many values of `size` bytes can be read, which before it becomes
// coarser is in memory at its full size, with so many bytes beside it while it is read. If not,
// that is noted, and no render can begin. False if there is no memory.
bool load_images_admit(struct load_images *images, double values, size_t size, double beside,
                       bool *admitted);
// Keeps an image with its levels, which stay where they are while it becomes coarser: the largest
// images are replaced by their copies until all fit. False if there is no memory.
bool load_images_keep(struct load_images *images, struct image *image, struct image *level,
                      int levels, bool environment);
// Warns if images are coarser, unless some are missing, and frees the list.
void load_images_end(struct load_images *images, struct log log, struct scene_images *out);
// Converts an sRGB value to linear.
static inline float load_srgb_to_linear(float x) {
    return x <= 0.04045f ? x / 12.92f : powf((x + 0.055f) / 1.055f, 2.4f);
}

#endif
