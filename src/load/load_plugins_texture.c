// SPDX-License-Identifier: Apache-2.0
// <texture>: bitmap, checkerboard, attributes of meshes and, from version 0.6, scale and
// gridtexture. A texture is built once and an image is read once, however often they are used. A
// texture within textures is counted at every reference.
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "load/load_state.h"

static const char *const filters[] = {"bilinear", "nearest", NULL};
static const char *const wraps[] = {"repeat", "mirror", "clamp", "zero", "one", NULL};
static const char *const bitmap_channels[] = {"r", "g", "b", "a", "x", "y", "z", NULL};
static const char *const formats[] = {"auto", "variant", "fp16", NULL};

static const struct param_spec bitmap_file = {"filename", PARAM_STRING,     NULL, 0, PARAM_REQUIRED,
                                              NULL,       "The image file."};
static const struct param_spec filter_type = {
    "filter_type", PARAM_CHOICE, "bilinear", 0, 0, filters, "The interpolation between texels."};
static const struct param_spec wrap_mode = {
    "wrap_mode",
    PARAM_CHOICE,
    "repeat",
    0,
    0,
    wraps,
    "How the texture continues where u or v is outside [0, 1]: `zero` and `one` are these values."};
static const struct param_spec wrap_mode_u = {
    "wrap_mode_u",
    PARAM_CHOICE,
    NULL,
    0,
    0,
    wraps,
    "As `wrap_mode`, for u alone; it overrides `wrap_mode`."};
static const struct param_spec wrap_mode_v = {
    "wrap_mode_v",
    PARAM_CHOICE,
    NULL,
    0,
    0,
    wraps,
    "As `wrap_mode`, for v alone; it overrides `wrap_mode`."};
static const struct param_spec single_channel = {
    "channel",
    PARAM_CHOICE,
    NULL,
    0,
    0,
    bitmap_channels,
    "The only channel that is used, such as alpha for an opacity; x, y and z are r, g and b."};
static const struct param_spec raw = {
    "raw",
    PARAM_BOOLEAN,
    "false",
    0,
    0,
    NULL,
    "If true, texels are plain numbers, which are not decoded from sRGB."};
static const struct param_spec to_uv = {
    "to_uv",
    PARAM_TRANSFORM,
    "1",
    0,
    0,
    NULL,
    "A transform of the texture coordinates before the lookup."};
static const struct param_spec format = {"format",
                                         PARAM_CHOICE,
                                         "auto",
                                         0,
                                         0,
                                         formats,
                                         "It has no effect: Mitsuba uses it for storage."};
static const struct param_spec bitmap_accel = {
    "accel",
    PARAM_BOOLEAN,
    "true",
    0,
    0,
    NULL,
    "It has no effect: Mitsuba uses it for hardware acceleration."};
static const struct param_spec color0 = {
    "color0",
    PARAM_COLOR,
    ".4",
    RANGE_TEXEL,
    PARAM_TEXTURE,
    NULL,
    "The colour of the squares at (0, 0) and diagonally from it."};
static const struct param_spec color1 = {"color1",
                                         PARAM_COLOR,
                                         ".2",
                                         RANGE_TEXEL,
                                         PARAM_TEXTURE,
                                         NULL,
                                         "The colour of the other squares."};

static const struct param_spec grid_color0 = {
    "color0", PARAM_COLOR, ".2", RANGE_TEXEL, PARAM_TEXTURE, NULL, "The colour between the lines."};
static const struct param_spec grid_color1 = {
    "color1", PARAM_COLOR, ".4", RANGE_TEXEL, PARAM_TEXTURE, NULL, "The colour of the lines."};
static const struct param_spec line_width = {"line_width",
                                             PARAM_FLOAT,
                                             ".01",
                                             RANGE_NOT_NEGATIVE,
                                             0,
                                             NULL,
                                             "Half the width of a line, in texture coordinates."};
static const struct param_spec scaling = {
    "scale", PARAM_COLOR, "1", RANGE_MODEST, 0, NULL, "The factor, a number or a colour."};

static const struct param_spec attribute = {
    "name",
    PARAM_STRING,
    NULL,
    0,
    PARAM_REQUIRED,
    NULL,
    "The name of the attribute, which begins with `vertex_` or `face_`."};
static const struct param_spec factor = {
    "scale", PARAM_FLOAT, "1", RANGE_NOT_NEGATIVE, 0, NULL, "A factor of the values."};

static const struct param_spec *const bitmap_params[] = {
    &bitmap_file,    &filter_type, &wrap_mode, &wrap_mode_u,  &wrap_mode_v, &raw,
    &single_channel, &to_uv,       &format,    &bitmap_accel, NULL};
static const struct param_spec *const checkerboard_params[] = {&color0, &color1, &to_uv, NULL};
static const struct param_spec *const grid_params[] = {&grid_color0, &grid_color1, &line_width,
                                                       &to_uv, NULL};
static const struct param_spec *const scale_params[] = {&scaling, NULL};
static const struct param_spec *const attribute_params[] = {&attribute, &factor, NULL};

static void set_to_uv(struct texture *texture, const struct mat4 *m) {
    const float row[6] = {m->m[0][0], m->m[0][1], m->m[0][3], m->m[1][0], m->m[1][1], m->m[1][3]};
    memcpy(texture->to_uv, row, sizeof row);
}

static rgb image_mean(const struct image *image) {
    size_t count = (size_t)image->width * (size_t)image->height;
    double sum[3] = {0.0, 0.0, 0.0};
    for (size_t i = 0; i < count; i++)
        for (int c = 0; c < 3; c++)
            sum[c] += (double)scene_image_value(
                image, i * (size_t)image->channels + (size_t)(image->channels == 3 ? c : 0));
    double scale = 1.0 / (double)count;
    return rgb_make((float)(sum[0] * scale), (float)(sum[1] * scale), (float)(sum[2] * scale));
}

static satin_status image_of(struct load_state *loader, const struct params *p,
                             const struct image_file **out) {
    const bool as_is = load_param(p, "raw")->b;
    const struct param_value *only = load_param(p, "channel"), *name = load_param(p, "filename");
    const int alpha = LOAD_IMAGE_ALPHA;
    const int channel = !only->given      ? LOAD_IMAGE_ALL
                        : only->i > alpha ? only->i - alpha - 1
                                          : only->i;
    struct load_source source;
    satin_status status = load_file_source(loader, name, &source);
    if (status != SATIN_OK) return status;
    for (size_t i = 0; i < loader->image_count; i++) {
        const struct image_file *image = &loader->image[i];
        if (image->raw != as_is || image->channel != channel ||
            strcmp(image->path, source.path) != 0)
            continue;
        *out = image;
        free((char *)source.path);
        return SATIN_OK;
    }
    struct image_file image = {
        .path = load_keep_text(loader, source.path), .raw = as_is, .channel = channel};
    void *items = loader->image;
    if (image.path && array_reserve(&items, &loader->image_capacity, loader->image_count + 1,
                                    sizeof *loader->image)) {
        loader->image = items;
        status = load_image_texture(&source, &loader->images, as_is, channel, &image.image);
        // Numbers and normals are not averaged.
        if (status == SATIN_OK &&
            ((!as_is &&
              !load_image_levels(source.arena, image.image, &image.level, &image.levels)) ||
             !load_images_keep(&loader->images, image.image, image.level, image.levels, false)))
            status = load_no_memory(loader);
    } else {
        status = load_no_memory(loader);
    }
    free((char *)source.path);
    if (status != SATIN_OK) return status;
    loader->image[loader->image_count] = image;
    *out = &loader->image[loader->image_count++];
    return SATIN_OK;
}

static satin_status build_bitmap(struct load_state *loader, const struct params *p, void *object) {
    struct texture *texture = object;
    texture->kind = TEXTURE_BITMAP;
    texture->nearest = load_param(p, "filter_type")->i == 1;
    const struct param_value *u = load_param(p, "wrap_mode_u"), *v = load_param(p, "wrap_mode_v");
    texture->wrap = (enum texture_wrap)(u->given ? u : load_param(p, "wrap_mode"))->i;
    texture->wrap_v = (enum texture_wrap)(v->given ? v : load_param(p, "wrap_mode"))->i;
    set_to_uv(texture, &load_param(p, "to_uv")->m);
    const struct image_file *loaded;
    satin_status status = image_of(loader, p, &loaded);
    if (status != SATIN_OK) return status;
    texture->image = loaded->image;
    const float *m = texture->to_uv;
    texture->level = loaded->level;
    texture->levels = texture->nearest ? 0 : loaded->levels;
    texture->filtered = texture->levels > 0;
    texture->unit = sqrtf(fabsf(m[0] * m[4] - m[1] * m[3]));
    texture->mean = image_mean(texture->image);
    return SATIN_OK;
}

static satin_status make_check(struct load_state *loader, const struct param_value *value,
                               const struct texture **out) {
    if (value->texture) return load_texture_of(loader, value->texture, out);
    struct texture *constant = arena_alloc(&loader->scene->arena, sizeof *constant);
    if (!constant) return load_no_memory(loader);
    *constant = (struct texture){.value = value->color, .mean = value->color};
    *out = constant;
    return SATIN_OK;
}

// Builds the textures of color0 and color1; `second` is the fraction of the area with color1.
static satin_status make_checks(struct load_state *loader, const struct params *p, float second,
                                struct texture *texture) {
    for (int i = 0; i < 2; i++) {
        satin_status status =
            make_check(loader, load_param(p, i ? "color1" : "color0"), &texture->check[i]);
        if (status != SATIN_OK) return status;
        const struct texture *check = texture->check[i];
        texture->mean = rgb_mad(texture->mean, check->mean, i ? second : 1.0f - second);
        texture->filtered = texture->filtered || check->filtered;
        if (check->nesting >= texture->nesting) texture->nesting = check->nesting + 1;
    }
    set_to_uv(texture, &load_param(p, "to_uv")->m);
    return SATIN_OK;
}

static satin_status build_checkerboard(struct load_state *loader, const struct params *p,
                                       void *object) {
    ((struct texture *)object)->kind = TEXTURE_CHECKERBOARD;
    return make_checks(loader, p, 0.5f, object);
}

static satin_status build_grid(struct load_state *loader, const struct params *p, void *object) {
    struct texture *texture = object;
    texture->kind = TEXTURE_GRID;
    texture->scale = load_param(p, "line_width")->f;
    return make_checks(loader, p, scene_texture_lines(texture), texture);
}

void load_texture_scale(const struct texture *inner, rgb by, struct texture *out) {
    *out = (struct texture){.kind = TEXTURE_SCALED,
                            .value = by,
                            .check = {inner, NULL},
                            .nesting = inner->nesting + 1,
                            .filtered = inner->filtered,
                            .mean = rgb_mul(inner->mean, by)};
}

satin_status load_texture_nested(struct load_state *loader, const struct params *p,
                                 struct xml_node **out) {
    struct xml_node *at = NULL, *node = load_params_child(&loader->xml, p->node, XML_TEXTURE, &at);
    if (!node || load_params_child(&loader->xml, p->node, XML_TEXTURE, &at)) {
        log_error_at(loader->log, p->node->place, "texture 'scale' takes one <texture>");
        return SATIN_ERROR_INPUT;
    }
    *out = node;
    return SATIN_OK;
}

static satin_status build_scale(struct load_state *loader, const struct params *p, void *object) {
    struct xml_node *node;
    const struct texture *inner;
    satin_status status = load_texture_nested(loader, p, &node);
    if (status == SATIN_OK) status = load_texture_of(loader, node, &inner);
    if (status == SATIN_OK) load_texture_scale(inner, load_param(p, "scale")->color, object);
    return status;
}

// The only copy of a name, so that equal names have equal pointers. NULL if there is no memory.
static const char *attribute_name(struct load_state *loader, const char *text) {
    for (size_t i = 0; i < loader->attribute_count; i++)
        if (strcmp(loader->attribute[i], text) == 0) return loader->attribute[i];
    void *items = loader->attribute;
    const char *name = load_keep_text(loader, text);
    if (!name || !array_reserve(&items, &loader->attribute_capacity, loader->attribute_count + 1,
                                sizeof *loader->attribute))
        return NULL;
    loader->attribute = items;
    return loader->attribute[loader->attribute_count++] = name;
}

static satin_status build_attribute(struct load_state *loader, const struct params *p,
                                    void *object) {
    struct texture *texture = object;
    const struct param_value *name = load_param(p, "name");
    texture->kind = TEXTURE_ATTRIBUTE;
    texture->scale = load_param(p, "scale")->f;
    texture->mean = rgb_grey(texture->scale);
    if (strncmp(name->s, "vertex_", 7) != 0 && strncmp(name->s, "face_", 5) != 0) {
        log_error_at(loader->log, name->place,
                     "the name of a mesh attribute begins with vertex_ or face_, not '%s'",
                     name->s);
        return SATIN_ERROR_INPUT;
    }
    texture->attribute = attribute_name(loader, name->s);
    return texture->attribute ? SATIN_OK : load_no_memory(loader);
}

// The colours of a mesh's vertices as in Mitsuba 0.6.
static satin_status build_vertex_colors(struct load_state *loader, const struct params *p,
                                        void *object) {
    struct texture *texture = object;
    (void)p;
    texture->kind = TEXTURE_ATTRIBUTE;
    texture->scale = 1.0f;
    texture->mean = rgb_grey(1.0f);
    texture->attribute = attribute_name(loader, LOAD_VERTEX_COLORS);
    return texture->attribute ? SATIN_OK : load_no_memory(loader);
}

static const struct param_spec raw_value = {"value",
                                            PARAM_COLOR,
                                            NULL,
                                            RANGE_MODEST,
                                            PARAM_REQUIRED,
                                            NULL,
                                            "The value, one number or three."};
static const struct param_spec *const rawconstant_params[] = {&raw_value, NULL};

static satin_status build_constant_texture(struct load_state *loader, const struct params *p,
                                           void *object) {
    (void)loader;
    const rgb value = load_param(p, "value")->color;
    *(struct texture *)object = (struct texture){.value = value, .mean = value};
    return SATIN_OK;
}

const struct plugin_spec load_texture_plugins[] = {
    {XML_TEXTURE, "bitmap", "an image", bitmap_params, 0, build_bitmap, false},
    {XML_TEXTURE, "scale", "a texture times a factor, as in Mitsuba 0.6", scale_params,
     1u << XML_TEXTURE, build_scale, false},
    {XML_TEXTURE, "gridtexture", "lines around squares of one unit, as in Mitsuba 0.6", grid_params,
     0, build_grid, false},
    {XML_TEXTURE, "checkerboard", "two colours or textures in squares of half a unit",
     checkerboard_params, 0, build_checkerboard, false},
    {XML_TEXTURE, "mesh_attribute", "numbers or colours at a mesh's vertices or faces",
     attribute_params, 0, build_attribute, false},
    {XML_TEXTURE, "vertexcolors",
     "the colours at the vertices of a PLY or serialized mesh, as in Mitsuba 0.6", NULL, 0,
     build_vertex_colors, false},
    {XML_TEXTURE, "rawconstant", "the same value everywhere", rawconstant_params, 0,
     build_constant_texture, false},
    {0}};

// Builds the texture that the element describes. If it cannot be read and the loader is lenient,
// a grey texture is built instead.
static satin_status build_texture(struct load_state *loader, struct xml_node *node,
                                  struct texture *texture) {
    static const char grey[] = "the texture is grey";
    struct params p;
    bool left_out = load_left_out(loader, node, grey);
    satin_status status = left_out ? SATIN_OK : load_params(loader, node, &p);
    if (status != SATIN_OK) return status;
    if (!left_out) {
        struct load_spared spared;
        load_spare_file(loader, &p, grey, &spared);
        status = p.plugin->build(loader, &p, texture);
        left_out = load_spare_end(loader, &spared, &status);
    }
    if (left_out) *texture = (struct texture){.value = rgb_grey(0.5f), .mean = rgb_grey(0.5f)};
    return status;
}

satin_status load_texture_of(struct load_state *loader, struct xml_node *node,
                             const struct texture **out) {
    if (loader->texture_depth + (node->texture ? node->texture->nesting : 0) >
        TEXTURE_NESTING_MAX) {
        log_error_at(loader->log, node->place,
                     "textures are nested too deep, or contain themselves");
        return SATIN_ERROR_INPUT;
    }
    if (!node->texture) {
        struct texture *texture = arena_alloc(&loader->scene->arena, sizeof *texture);
        if (!texture) return load_no_memory(loader);
        loader->texture_depth++;
        satin_status status = build_texture(loader, node, texture);
        loader->texture_depth--;
        if (status != SATIN_OK) return status;
        node->texture = texture;
        loader->scene->texture_count++;
    }
    *out = node->texture;
    return SATIN_OK;
}
