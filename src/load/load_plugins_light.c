// SPDX-License-Identifier: Apache-2.0
// <emitter>: area lights of shapes, point, spot and directional lights, environments. Units and
// defaults are Mitsuba 3's. Black lights are left out.
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "load/load_state.h"

static const struct param_spec surface_radiance = {"radiance",
                                                   PARAM_LIGHT,
                                                   "1",
                                                   RANGE_NOT_NEGATIVE,
                                                   PARAM_TEXTURE,
                                                   NULL,
                                                   "The radiance [W m^-2 sr^-1]."};
static const struct param_spec radiance = {
    "radiance", PARAM_LIGHT, "1", RANGE_NOT_NEGATIVE, 0, NULL, "The radiance [W m^-2 sr^-1]."};
static const struct param_spec intensity = {
    "intensity", PARAM_LIGHT, "1", RANGE_NOT_NEGATIVE, 0, NULL, "The radiant intensity [W sr^-1]."};
static const struct param_spec irradiance = {
    "irradiance",
    PARAM_LIGHT,
    "1",
    RANGE_NOT_NEGATIVE,
    0,
    NULL,
    "The irradiance of a surface that faces the light [W m^-2]."};
static const struct param_spec light_position = {
    "position",
    PARAM_POINT,
    NULL,
    0,
    0,
    NULL,
    "The position in world space, instead of `to_world`."};
static const struct param_spec light_direction = {
    "direction",
    PARAM_POINT,
    NULL,
    0,
    0,
    NULL,
    "The direction in which the light travels, instead of `to_world`."};
static const struct param_spec light_to_world = {
    "to_world",
    PARAM_TRANSFORM,
    "1",
    0,
    0,
    NULL,
    "The transform from light space to world space. The light faces +z."};
static const struct param_spec sky_to_world = {
    "to_world",
    PARAM_TRANSFORM,
    "1",
    0,
    0,
    NULL,
    "The transform from the image's space, where y is up, to world space."};
static const struct param_spec cutoff_angle = {"cutoff_angle",
                                               PARAM_FLOAT,
                                               "20",
                                               RANGE_POSITIVE,
                                               0,
                                               NULL,
                                               "The half angle of the cone, in degrees."};
static const struct param_spec beam_width = {
    "beam_width",
    PARAM_FLOAT,
    NULL,
    RANGE_NOT_NEGATIVE,
    0,
    NULL,
    "The half angle of the inner cone of full intensity, in degrees. If it is not given, it is 3/4 "
    "of `cutoff_angle`."};
static const struct param_spec envmap_file = {"filename",
                                              PARAM_STRING,
                                              NULL,
                                              0,
                                              PARAM_REQUIRED,
                                              NULL,
                                              "The image, in latitude and longitude."};
static const struct param_spec envmap_scale = {
    "scale", PARAM_FLOAT, "1", RANGE_NOT_NEGATIVE, 0, NULL, "A factor of the image."};
static const struct param_spec compensation = {"mis_compensation",
                                               PARAM_BOOLEAN,
                                               "false",
                                               0,
                                               0,
                                               NULL,
                                               "It has no effect: Mitsuba uses it for sampling."};
static const struct param_spec sampling_weight = {"sampling_weight",
                                                  PARAM_FLOAT,
                                                  "1",
                                                  RANGE_NOT_NEGATIVE,
                                                  0,
                                                  NULL,
                                                  "It has no effect: lights are chosen by power."};

static const struct param_spec spot_texture = {
    "texture",
    PARAM_LIGHT,
    "1",
    RANGE_NOT_NEGATIVE,
    PARAM_TEXTURE,
    NULL,
    "A factor of the intensity, as an image on the square around the cone."};
static const struct param_spec slide_image = {
    "irradiance",
    PARAM_LIGHT,
    "1",
    RANGE_NOT_NEGATIVE,
    PARAM_TEXTURE,
    NULL,
    "The irradiance of a plane at unit distance, over pi."};
static const struct param_spec slide_scale = {
    "scale", PARAM_FLOAT, "1", RANGE_NOT_NEGATIVE, 0, NULL, "A factor of the irradiance."};
static const struct param_spec slide_fov = {"fov",
                                            PARAM_FLOAT,
                                            NULL,
                                            RANGE_POSITIVE,
                                            0,
                                            NULL,
                                            "The angle that the slide subtends, in degrees."};
static const struct param_spec slide_fov_axis = {"fov_axis",
                                                 PARAM_CHOICE,
                                                 "x",
                                                 0,
                                                 0,
                                                 load_fov_axes,
                                                 "The side of the slide to which `fov` refers."};
static const struct param_spec slide_focal_length = {
    "focal_length",
    PARAM_STRING,
    "50mm",
    0,
    0,
    NULL,
    "The focal length for 35 mm film, in millimetres, instead of `fov`."};

typedef const struct param_spec *const param_list[];
static param_list area_params = {&surface_radiance, &sampling_weight, NULL};
static param_list point_params = {&intensity, &light_position, &light_to_world, &sampling_weight,
                                  NULL};
static param_list spot_params = {&intensity,      &cutoff_angle,    &beam_width, &spot_texture,
                                 &light_to_world, &sampling_weight, NULL};
static param_list projector_params = {
    &slide_image,        &slide_scale,    &slide_fov,       &slide_fov_axis,
    &slide_focal_length, &light_to_world, &sampling_weight, NULL};
static param_list directional_params = {&irradiance, &light_direction, &light_to_world,
                                        &sampling_weight, NULL};
static param_list constant_params = {&radiance, &sampling_weight, NULL};
static param_list envmap_params = {&envmap_file,  &envmap_scale,    &sky_to_world,
                                   &compensation, &sampling_weight, NULL};

// Reads to_world, and sets position, direction and inverse.
static satin_status set_light_position(struct load_state *loader, const struct params *p,
                                       struct light *light) {
    light->to_world = load_param(p, "to_world")->m;
    if (!mat4_inverse(&light->to_world, &light->to_local))
        return load_refuse(loader, p, "to_world is singular");
    light->position = mat4_point(&light->to_world, v3(0, 0, 0));
    light->direction = v3_unit(mat4_vector(&light->to_world, v3(0, 0, 1)));
    if (v3_finite(light->position) && fabsf(v3_len2(light->direction) - 1.0f) < 1e-3f)
        return SATIN_OK;
    return load_refuse(loader, p, "to_world is too small or too large");
}

static satin_status build_area(struct load_state *loader, const struct params *p, void *object) {
    struct light *light = object;
    const struct param_value *value = load_param(p, "radiance");
    light->kind = LIGHT_AREA;
    light->value = value->color;
    if (!value->texture) return SATIN_OK;
    satin_status status = load_texture_of(loader, value->texture, &light->texture);
    if (status == SATIN_OK) light->value = light->texture->mean;
    return status;
}

static satin_status build_beam(struct load_state *loader, const struct params *p, void *object) {
    satin_status status = build_area(loader, p, object);
    ((struct light *)object)->kind = LIGHT_BEAM;
    return status;
}

static satin_status build_point(struct load_state *loader, const struct params *p, void *object) {
    struct light *light = object;
    const struct param_value *at = load_param(p, "position");
    light->kind = LIGHT_POINT;
    light->value = load_param(p, "intensity")->color;
    if (at->given && load_param(p, "to_world")->given)
        return load_refuse(loader, p, "it has both a position and a to_world");
    satin_status status = set_light_position(loader, p, light);
    if (at->given) light->position = at->v;
    return status;
}

// Sets a textured factor of light->value.
static satin_status set_texture(struct load_state *loader, const struct param_value *value,
                                struct light *light) {
    if (value->texture) return load_texture_of(loader, value->texture, &light->texture);
    if (value->given) light->value = rgb_mul(light->value, value->color);
    return SATIN_OK;
}

static satin_status build_projector(struct load_state *loader, const struct params *p,
                                    void *object) {
    struct light *light = object;
    light->kind = LIGHT_PROJECTOR;
    light->value = rgb_grey(load_param(p, "scale")->f);
    satin_status status = set_texture(loader, load_param(p, "irradiance"), light);
    if (status == SATIN_OK) status = set_light_position(loader, p, light);
    if (status != SATIN_OK) return status;
    // The aspect ratio of the slide is that of its image.
    const struct texture *shown = scene_texture_unscaled(light->texture);
    const struct image *image = shown ? shown->image : NULL;
    double aspect = image ? (double)image->width / image->height : 1.0;
    float tan[2];
    status = load_field_of_view(loader, p, aspect, tan);
    if (status != SATIN_OK) return status;
    light->tan_x = tan[0];
    light->tan_y = tan[1];
    return SATIN_OK;
}

static satin_status build_spot(struct load_state *loader, const struct params *p, void *object) {
    struct light *light = object;
    float cutoff = load_param(p, "cutoff_angle")->f, beam = 0.75f * cutoff;
    if (load_param(p, "beam_width")->given) beam = load_param(p, "beam_width")->f;
    if (cutoff > 180.0f) return load_refuse(loader, p, "its cutoff_angle is over 180 degrees");
    if (beam > cutoff) {
        log_warning_at(loader->log, p->node->place,
                       "its beam_width is larger than its cutoff_angle, where its light ends");
        beam = cutoff;
    }
    light->kind = LIGHT_SPOT;
    light->value = load_param(p, "intensity")->color;
    satin_status status = set_texture(loader, load_param(p, "texture"), light);
    if (status != SATIN_OK) return status;
    if (light->texture && cutoff >= 90.0f)
        return load_refuse(loader, p, "its texture needs a cutoff_angle below 90 degrees");
    light->cos_cutoff = cosf(cutoff * (PI_F / 180.0f));
    light->cos_beam = cosf(beam * (PI_F / 180.0f));
    return set_light_position(loader, p, light);
}

static satin_status build_directional(struct load_state *loader, const struct params *p,
                                      void *object) {
    struct light *light = object;
    const struct param_value *towards = load_param(p, "direction");
    light->kind = LIGHT_DIRECTIONAL;
    light->value = load_param(p, "irradiance")->color;
    if (towards->given && load_param(p, "to_world")->given)
        return load_refuse(loader, p, "it has both a direction and a to_world");
    satin_status status = set_light_position(loader, p, light);
    if (status != SATIN_OK || !towards->given) return status;
    light->direction = v3_unit(towards->v);
    if (fabsf(v3_len2(light->direction) - 1.0f) < 1e-3f) return SATIN_OK;
    return load_refuse(loader, p, "its direction is too small or too large");
}

static satin_status build_constant_light(struct load_state *loader, const struct params *p,
                                         void *object) {
    (void)loader;
    struct light *light = object;
    light->kind = LIGHT_CONSTANT;
    light->value = load_param(p, "radiance")->color;
    light->to_world = light->to_local = mat4_identity();
    return SATIN_OK;
}

satin_status load_light_orient(struct load_state *loader, const struct params *p,
                               struct mat4 to_world, struct light *light) {
    light->to_world = to_world;
    if (mat4_inverse(&to_world, &light->to_local) && !load_transform_similar(&to_world)) {
        log_warning_at(loader->log, p->node->place,
                       "emitter '%s': to_world stretches or shears it; only its rotation is used",
                       p->plugin->name);
        light->to_world = load_transform_unstretched(&to_world);
    }
    if (mat4_inverse(&light->to_world, &light->to_local)) return SATIN_OK;
    return load_refuse(loader, p, "to_world is singular");
}

// Mitsuba needs three rows: it repeats the last of two.
static satin_status repeat_row(struct load_state *loader, struct image *image) {
    if (image->height != 2) return SATIN_OK;
    const size_t row = (size_t)image->width * (size_t)image->channels;
    float *texel = arena_array_alone(&loader->scene->arena, 3 * row, sizeof *texel);
    if (!texel) return load_no_memory(loader);
    memcpy(texel, image->texel, 2 * row * sizeof *texel);
    memcpy(texel + 2 * row, image->texel + row, row * sizeof *texel);
    arena_drop(&loader->scene->arena, image->texel);
    *image = scene_image_make(image->width, 3, image->channels, texel);
    return SATIN_OK;
}

static satin_status build_envmap(struct load_state *loader, const struct params *p, void *object) {
    struct light *light = object;
    light->kind = LIGHT_ENVMAP;
    light->value = rgb_grey(load_param(p, "scale")->f);
    satin_status status = load_light_orient(loader, p, load_param(p, "to_world")->m, light);
    if (status != SATIN_OK) return status;
    struct load_source source;
    status = load_file_source(loader, load_param(p, "filename"), &source);
    if (status != SATIN_OK) return status;
    struct image *image;
    status = load_image(&source, &loader->images, false, &image);
    free((char *)source.path);
    if (status == SATIN_OK) status = repeat_row(loader, image);
    if (status != SATIN_OK) return status;
    light->image = image;
    return load_images_keep(&loader->images, image, NULL, 0, true) ? SATIN_OK
                                                                   : load_no_memory(loader);
}

const struct plugin_spec load_emitter_plugins[] = {
    {XML_EMITTER, "area", "light from the surface of a shape", area_params, 0, build_area, false},
    {XML_EMITTER, "directionalarea", "parallel light from a rectangle or disk", area_params, 0,
     build_beam, false},
    {XML_EMITTER, "point", "light from a point in all directions", point_params, 0, build_point,
     false},
    {XML_EMITTER, "spot", "light from a point into a cone", spot_params, 0, build_spot, false},
    {XML_EMITTER, "projector", "light from a point that projects an image", projector_params, 0,
     build_projector, false},
    {XML_EMITTER, "directional", "parallel light", directional_params, 0, build_directional, false},
    {XML_EMITTER, "constant", "the same light from all directions", constant_params, 0,
     build_constant_light, false},
    {XML_EMITTER, "envmap", "light from an image of the environment", envmap_params, 0,
     build_envmap, false},
    {0}};

static bool is_environment(const struct light *light) {
    return light->kind == LIGHT_CONSTANT || light->kind == LIGHT_ENVMAP;
}

// Checks that only area lights are in shapes, and that there is only one environment.
static satin_status check_parent(struct load_state *loader, const struct params *p,
                                 const struct light *light, bool in_shape) {
    bool area = light->kind == LIGHT_AREA || light->kind == LIGHT_BEAM;
    if (in_shape && !area)
        return load_refuse(loader, p, "it cannot be part of a shape; area lights are");
    if (is_environment(light) && loader->scene->environment >= 0)
        return load_refuse(loader, p, "the scene has another environment");
    return SATIN_OK;
}

satin_status load_emitter_add(struct load_state *loader, struct xml_node *node,
                              const struct xml_node *parent, int32_t *index) {
    struct params p;
    struct light light = {.shape = parent ? (uint32_t)loader->shape_count : 0};
    *index = -1;
    if (load_left_out(loader, node, "the light is left out")) return SATIN_OK;
    satin_status status = load_params(loader, node, &p);
    if (status != SATIN_OK) return status;
    struct load_spared spared;
    load_spare_file(loader, &p, "the light is left out", &spared);
    status = p.plugin->build(loader, &p, &light);
    if (load_spare_end(loader, &spared, &status)) return SATIN_OK;
    if (status == SATIN_OK) status = check_parent(loader, &p, &light, parent);
    if (status == SATIN_OK) status = load_pose_dim(loader, node, &light);
    if (status == SATIN_OK && parent) status = load_pose_dim(loader, parent, &light);
    if (status != SATIN_OK || (!parent && load_pose_gone(loader, node))) return status;
    // An area light outside of a shape is only defined for references.
    bool waits = !parent && (light.kind == LIGHT_AREA || light.kind == LIGHT_BEAM);
    if (waits && !load_xml_get(node, "id"))
        return load_refuse(loader, &p, "it must be part of a shape");
    if (waits || (rgb_black(light.value) && rgb_black(light.sun_value))) return SATIN_OK;
    void *items = loader->light;
    if (!array_reserve(&items, &loader->light_capacity, loader->light_count + 1, sizeof light))
        return load_no_memory(loader);
    loader->light = items;
    *index = (int32_t)loader->light_count;
    if (is_environment(&light)) loader->scene->environment = *index;
    loader->light[loader->light_count++] = light;
    return SATIN_OK;
}
