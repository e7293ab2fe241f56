// SPDX-License-Identifier: Apache-2.0
// <shape>s of Mitsuba 0.6 that version 3 does not have: heightfield, hair.
#include <stdlib.h>
#include <string.h>

#include "load/load_attribute.h"
#include "load/load_plugins_shape.h"
#include "load/load_state.h"

static const struct param_spec heights_file = {
    "filename",
    PARAM_STRING,
    NULL,
    0,
    0,
    NULL,
    "The image of the heights, whose first row is at y = -1. Colours count by their luminance; "
    "values in sRGB are decoded."};
static const struct param_spec heights_scale = {
    "scale", PARAM_FLOAT, "1", RANGE_ANY, 0, NULL, "A factor of the heights."};
static const struct param_spec shading_normals = {
    "shading_normals",
    PARAM_BOOLEAN,
    "true",
    0,
    0,
    NULL,
    "If false, the surface has facets: it has no vertex normals."};
static const struct param_spec heights_width = {
    "width",
    PARAM_INTEGER,
    "32",
    RANGE_POSITIVE,
    0,
    NULL,
    "The number of heights along x, if a <texture> gives them that is no image."};
static const struct param_spec heights_height = {
    "height", PARAM_INTEGER, "32", RANGE_POSITIVE, 0, NULL, "As `width`, along y."};

static const struct param_spec *const heightfield_params[] = {
    &heights_file,   &heights_scale,       &shading_normals,         &heights_width,
    &heights_height, &load_shape_to_world, &load_shape_flip_normals, NULL};

static const struct param_spec hair_file = {
    "filename",
    PARAM_STRING,
    NULL,
    0,
    PARAM_REQUIRED,
    NULL,
    "The file of strands. Each line `x y z` is a point, and blank lines separate strands; or the "
    "binary form BINARY_HAIR."};
static const struct param_spec hair_radius = {
    "radius",
    PARAM_FLOAT,
    ".025",
    RANGE_POSITIVE,
    0,
    NULL,
    "The radius of all strands in object space. to_world scales it as it scales the z axis."};
static const struct param_spec angle_threshold = {
    "angle_threshold",
    PARAM_FLOAT,
    "1",
    RANGE_NOT_NEGATIVE,
    0,
    NULL,
    "The angle in degrees, at most 90, between segments that follow one another, below which they "
    "become one."};
static const struct param_spec hair_reduction = {
    "reduction",
    PARAM_FLOAT,
    "0",
    RANGE_UNIT,
    0,
    NULL,
    "The fraction of strands that are left out at random, less than 1. The radius of the others "
    "grows so that they cover as much."};
static const struct param_spec *const hair_params[] = {&hair_file,
                                                       &hair_radius,
                                                       &angle_threshold,
                                                       &hair_reduction,
                                                       &load_shape_to_world,
                                                       &load_shape_flip_normals,
                                                       NULL};

// ---- Heights ------------------------------------------------------------------------------------

static satin_status heights_of_file(struct load_state *loader, const struct param_value *name,
                                    bool raw, struct heights *out) {
    struct load_source source;
    struct image *image;
    satin_status status = load_file_source(loader, name, &source);
    if (status != SATIN_OK) return status;
    status = load_image_heights(&source, raw, &loader->images.module, &image);
    free((char *)source.path);
    if (status != SATIN_OK) return status;
    out->width = image->width;
    out->height = image->height;
    out->channels = image->channels;
    out->value = image->texel;
    return SATIN_OK;
}

// Evaluates a texture at the corners of width - 1 by height - 1 cells.
static satin_status heights_of_samples(struct load_state *loader, const struct params *p,
                                       struct xml_node *node, struct heights *out) {
    const struct param_value *width = load_param(p, "width"), *height = load_param(p, "height");
    const struct texture *texture;
    if ((int64_t)width->i * height->i > HEIGHTS_MAX)
        return load_refuse(loader, p, "it has more than 2^26 heights");
    satin_status status = load_texture_of(loader, node, &texture);
    if (status != SATIN_OK) return status;
    if (scene_attribute_used(texture))
        return load_refuse(loader, p, "its heights cannot be an attribute of a mesh");
    const size_t columns = (size_t)width->i, rows = (size_t)height->i;
    float *value = arena_array_alone(&loader->scene->arena, 3 * columns * rows, sizeof *value);
    if (!value) return load_no_memory(loader);
    *out = (struct heights){width->i, height->i, 3, value, out->factor};
    for (size_t y = 0; y < rows; y++)
        for (size_t x = 0; x < columns; x++, value += 3) {
            const vec2 uv = {columns > 1 ? (float)((double)x / (double)(columns - 1)) : 0.0f,
                             rows > 1 ? (float)((double)y / (double)(rows - 1)) : 0.0f};
            const struct texture_lookup at = scene_texture_at(uv);
            const rgb color = scene_texture_eval(texture, &at);
            value[0] = color.r;
            value[1] = color.g;
            value[2] = color.b;
        }
    return SATIN_OK;
}

// The heights that a texture gives: of an image, also inside of `scale` textures, its texels,
// whatever its other parameters are; of any other texture, samples.
static satin_status heights_of_texture(struct load_state *loader, const struct params *p,
                                       struct xml_node *node, struct heights *out) {
    static const char flat[] = "the surface is flat";
    struct params t;
    bool left_out = load_left_out(loader, node, flat);
    satin_status status = left_out ? SATIN_OK : load_params(loader, node, &t);
    if (status != SATIN_OK) return status;
    const bool file = !left_out && strcmp(t.plugin->name, "bitmap") == 0;
    if (file) {
        struct load_spared spared;
        load_spare_file(loader, &t, flat, &spared);
        status = heights_of_file(loader, load_param(&t, "filename"), load_param(&t, "raw")->b, out);
        left_out = load_spare_end(loader, &spared, &status);
    }
    if (left_out) {
        float *zero = arena_array_alone(&loader->scene->arena, 1, sizeof *zero);
        *out = (struct heights){1, 1, 1, zero, out->factor};
        return zero ? SATIN_OK : load_no_memory(loader);
    }
    if (file) return status;
    if (strcmp(t.plugin->name, "scale") != 0) return heights_of_samples(loader, p, node, out);
    struct xml_node *inner;
    status = load_texture_nested(loader, &t, &inner);
    if (status != SATIN_OK) return status;
    if (loader->texture_depth == TEXTURE_NESTING_MAX) {
        log_error_at(loader->log, node->place,
                     "textures are nested too deep, or contain themselves");
        return SATIN_ERROR_INPUT;
    }
    out->factor = rgb_mul(out->factor, load_param(&t, "scale")->color);
    loader->texture_depth++;
    status = heights_of_texture(loader, p, inner, out);
    loader->texture_depth--;
    return status;
}

static satin_status read_heights(struct load_state *loader, const struct params *p,
                                 struct heights *out) {
    const struct param_value *name = load_param(p, "filename");
    struct xml_node *at = NULL, *node = load_params_child(&loader->xml, p->node, XML_TEXTURE, &at);
    if (node && load_params_child(&loader->xml, p->node, XML_TEXTURE, &at))
        return load_refuse(loader, p, "it takes one <texture>");
    at = NULL;
    if (load_params_child(&loader->xml, p->node, XML_RFILTER, &at))
        log_warning_at(loader->log, at->place,
                       "the filter has no effect: heights are used as they are");
    if (!node == !name->given)
        return load_refuse(loader, p, "it takes either a filename or a <texture>");
    return node ? heights_of_texture(loader, p, node, out)
                : heights_of_file(loader, name, false, out);
}

static satin_status build_heightfield(struct load_state *loader, const struct params *p,
                                      void *object) {
    struct shape *shape = object;
    struct arena *arena = &loader->scene->arena;
    struct heights heights = {.factor = rgb_grey(load_param(p, "scale")->f)};
    const struct mesh_request request = {.to_world = load_param(p, "to_world")->m,
                                         .flip_normals = load_param(p, "flip_normals")->b,
                                         .face_normals = !load_param(p, "shading_normals")->b};
    satin_status status = read_heights(loader, p, &heights);
    if (status != SATIN_OK) return status;
    if ((int64_t)heights.width * heights.height > HEIGHTS_MAX)
        return load_refuse(loader, p, "it has more than 2^26 heights");
    shape->face_normals = request.face_normals;
    status = load_mesh_heightfield(arena, &request, &heights, &shape->mesh);
    arena_drop(arena, heights.value);
    if (status == SATIN_ERROR_INPUT)
        return load_refuse(loader, p, "its heights, scale or to_world make it too large");
    return status == SATIN_ERROR_MEMORY ? load_no_memory(loader) : status;
}

// ---- Strands ------------------------------------------------------------------------------------

static satin_status build_hair(struct load_state *loader, const struct params *p, void *object) {
    struct shape *shape = object;
    const struct mat4 *m = &load_param(p, "to_world")->m;
    const float reduction = load_param(p, "reduction")->f;
    const float scale = v3_len(mat4_vector(m, v3(0, 0, 1)));
    if (!(reduction < 1.0f)) return load_refuse(loader, p, "its reduction must be less than 1");
    const struct hair_request request = {
        .to_world = *m,
        .radius = load_param(p, "radius")->f * scale / (1.0f - reduction),
        .angle_threshold = load_param(p, "angle_threshold")->f,
        .reduction = reduction};
    if (request.angle_threshold > 90.0f)
        return load_refuse(loader, p, "its angle_threshold must be at most 90 degrees");
    if (!(request.radius > 0.0f && request.radius < 1e15f))
        return load_refuse(loader, p, "to_world makes its radius 0 or too large");
    struct load_source source;
    satin_status status = load_file_source(loader, load_param(p, "filename"), &source);
    if (status != SATIN_OK) return status;
    shape->kind = SHAPE_CURVES;
    status = load_hair(&source, &request, &shape->curves);
    free((char *)source.path);
    if (status == SATIN_OK) scene_curves_bound(&shape->curves, &shape->lo, &shape->hi);
    return status;
}

const struct plugin_spec load_shape06_plugins[] = {
    {XML_SHAPE, "heightfield",
     "a surface over [-1, 1]^2 in the xy plane, whose heights along z an image or a <texture> "
     "gives, as in Mitsuba 0.6",
     heightfield_params, SHAPE_CHILDREN | 1u << XML_TEXTURE | 1u << XML_RFILTER, build_heightfield,
     false},
    {XML_SHAPE, "hair", "strands of straight round tubes, as in Mitsuba 0.6", hair_params,
     SHAPE_CHILDREN, build_hair, false},
    {0}};
