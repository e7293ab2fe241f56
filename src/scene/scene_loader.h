// SPDX-License-Identifier: Apache-2.0
// Private to scene/: the state of one run of satin_scene_load, and the builders that fill it, one
// file per kind of element.
#ifndef SCENE_LOADER_H
#define SCENE_LOADER_H

#include "scene/scene.h"
#include "scene/scene_build.h"
#include "scene/scene_params.h"

struct scene_loader {
    struct log log;
    const char *path;  // of the main file
    bool lenient;      // what is missing or unknown is left out, with a warning
    struct log each;   // for those warnings, which are not counted but told one by one
    struct scene_xml xml;
    struct satin_scene *scene;  // what is built; its arrays are these, until the end
    struct shape *shape;
    struct material *material;
    struct light *light;
    struct image_file *image;
    struct shape_group *group;
    const char **attribute;  // names that textures ask for, each once
    size_t shape_count, material_count, light_count, image_count, group_count, attribute_count;
    size_t shape_capacity, material_capacity, light_capacity, image_capacity, group_capacity,
        attribute_capacity;
    size_t shape_elements;  // looked at, counting references
    uint32_t open_group;    // 1 + index of the <shape type="shapegroup"> that is being read, or 0
    int shape_depth;        // of shapes within shapes
    uint32_t plain[2];      // 1 + index of the materials of shapes without one: [emits]
    int bsdf_depth;         // of nested <bsdf>s being built
    int texture_depth;      // of nested <texture>s being built
    struct attribute_names wanted;  // by the textures of the shape that is being built
};

// Logs lack of memory and returns its status.
satin_status scene_no_memory(struct scene_loader *loader);
// Copies text into the scene's arena; NULL without memory.
const char *scene_keep_text(struct scene_loader *loader, const char *text);
// params_read for the plugin that the element names.
satin_status scene_params(struct scene_loader *loader, struct xml_node *node, struct params *out);
// The source of a file that a parameter names: beside the file with the parameter, or else beside
// the main file. The caller frees source->path.
satin_status scene_file_source(struct scene_loader *loader, const struct param_value *name,
                               struct scene_source *out);

// Whether the type of an element is unknown, or the file that it names is missing, and the loader
// is lenient: logs that, and what is done `instead`.
bool scene_left_out(struct scene_loader *loader, const struct xml_node *node, const char *instead);
bool scene_file_missing(struct scene_loader *loader, const struct params *p, const char *instead);

// The texture of a textured parameter, built on its first use (scene_plugins_texture.c).
satin_status scene_texture_of(struct scene_loader *loader, struct xml_node *node,
                              const struct texture **out);
// A texture that is `inner` times a factor (scene_plugins_texture.c).
void scene_texture_scale(const struct texture *inner, rgb by, struct texture *out);
// Builds one side of a surface from the parameters of a <bsdf> that wraps no other
// (scene_plugins_bsdf.c).
satin_status scene_side_build(struct scene_loader *loader, const struct params *p,
                              struct material_side *side);
// Builds a material, without adding it to the scene (scene_plugins_material.c).
satin_status scene_material_build(struct scene_loader *loader, struct xml_node *node,
                                  struct material *out);
// The index of the material of a <bsdf>, added on its first use; NULL: the default of a shape that
// emits or not.
satin_status scene_material_of(struct scene_loader *loader, struct xml_node *node, bool emits,
                               uint32_t *index);
// Adds a shape, with its material and light, or the shapes that it is made of
// (scene_plugins_shape.c).
satin_status scene_shape_add(struct scene_loader *loader, struct xml_node *node);
// Room for one more shape. Logs its failures.
satin_status scene_shape_reserve(struct scene_loader *loader, const struct params *p);
// Adds a shape made of others: merge, shapegroup, instance (scene_plugins_group.c).
satin_status scene_group_add(struct scene_loader *loader, const struct params *p);
// Adds an <emitter> of shape `shape`, or one without a shape if that is negative; *index is its
// number, or -1 if it is black (scene_plugins_light.c).
satin_status scene_emitter_add(struct scene_loader *loader, struct xml_node *node, int64_t shape,
                               int32_t *index);
// An environment of daylight; `sun` is in world space, the aperture in degrees
// (scene_plugins_light.c).
struct scene_daylight {
    float turbidity;
    vec3 sun;
    float sky_scale, sun_scale, sun_aperture;
};
satin_status scene_daylight_build(struct scene_loader *loader, const struct params *p,
                                  const struct scene_daylight *daylight, struct light *light);
// Camera, film and samples per pixel of the scene (scene_plugins_sensor.c).
satin_status scene_sensor_read(struct scene_loader *loader, struct xml_node *node);
// Half extents at unit distance of what the parameters fov, fov_axis and focal_length ask for, of
// width / height `aspect`; and the choices of fov_axis.
satin_status scene_view_read(struct scene_loader *loader, const struct params *p, double aspect,
                             float tan[2]);
extern const char *const scene_fov_axes[];
// The `name:type` pairs of an `aov` integrator (scene_aov.c).
satin_status scene_aovs_read(struct scene_loader *loader, const struct param_value *text,
                             struct scene_aovs *out);
// What `moment` makes of the integrator `inner` in it, whose channels are those from `first` on.
satin_status scene_aovs_moment(struct scene_loader *loader, const struct xml_node *inner, int first,
                               struct scene_aovs *out);
// What the <integrator> asks for (scene_plugins_integrator.c).
satin_status scene_integrator_read(struct scene_loader *loader, struct xml_node *node);

#endif
