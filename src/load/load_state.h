// SPDX-License-Identifier: Apache-2.0
// Private to load/: the state of one call of satin_scene_load, and the functions that build
// objects, one file per kind of element.
#ifndef LOAD_STATE_H
#define LOAD_STATE_H

#include "light/light.h"
#include "load/load_build.h"
#include "load/load_params.h"
#include "scene/scene.h"

// The most textures within textures, so that visiting all in a checkerboard takes 2^8 steps.
enum { TEXTURE_NESTING_MAX = 8 };

// The materials of shapes without a <bsdf>.
enum plain_material {
    PLAIN_GREY,
    PLAIN_BLACK,  // of shapes that emit
    PLAIN_NULL    // of those of version 0.6 that contain a medium: they are not visible
};

struct load_state {
    struct log log;
    const char *path;    // of the main file
    const char *sensor;  // the id or the index of the sensor to use; NULL: the first one
    bool all_sensors;    // the cameras of all sensors are read, too
    bool no_sensor;      // the scene has none
    bool lenient;        // missing or unknown objects are left out, with a warning
    struct log each;     // log for those warnings, which are not counted but passed on at once
    struct load_xml xml;
    struct satin_scene *scene;  // the scene that is built; the arrays below become its arrays at
                                // the end
    struct shape *shape;
    struct material *material;
    struct light *light;
    struct image_file *image;
    struct load_images images;
    const struct brdf_glossy *tables;  // of the BRDFs so far, see brdf_prepare
    struct shape_group *group;
    const char **attribute;  // names of attributes to which textures refer, each once
    size_t shape_count, material_count, light_count, image_count, group_count, attribute_count;
    size_t shape_capacity, material_capacity, light_capacity, image_capacity, group_capacity,
        attribute_capacity;
    size_t shape_elements;   // number of shape elements, with references counted
    uint32_t open_group;     // 1 + index of the <shape type="shapegroup"> that is being read, or 0
    int shape_depth;         // depth of shapes within shapes
    uint32_t plain[3];       // 1 + index of the default materials of shapes: enum plain_material
    int bsdf_depth;          // depth of nested <bsdf>s
    int texture_depth;       // depth of nested <texture>s
    struct load_pose *pose;  // where objects and lights are in this frame; owned
    size_t pose_count;
    struct attribute_names wanted;  // attributes for the textures of the current shape
};

// Logs lack of memory and returns its status.
satin_status load_no_memory(struct load_state *loader);
// Logs why a plugin is refused, at the place of its element.
satin_status load_refuse(struct load_state *loader, const struct params *p, const char *why);
// Copies text into the scene's arena; NULL without memory.
const char *load_keep_text(struct load_state *loader, const char *text);
// Reads the parameters of the plugin that the element names (load_params_read).
satin_status load_params(struct load_state *loader, struct xml_node *node, struct params *out);

// ---- load_pose.c: poses of shapes and emitters, by their ids
satin_status load_poses_begin(struct load_state *loader, const satin_scene_request *request);
// Continues the hash over all poses that change the scene.
uint64_t load_poses_hash(const struct load_state *loader, uint64_t hash);
// Moves the object of these parameters, if it has a pose.
satin_status load_pose_apply(struct load_state *loader, struct params *p);
// Whether the element's pose has the scale 0: it is left out.
bool load_pose_gone(const struct load_state *loader, const struct xml_node *node);
// Scales the intensity of a light by the pose of the element, its emitter or its shape.
satin_status load_pose_dim(struct load_state *loader, const struct xml_node *node,
                           struct light *light);
// Logs a pose whose id the scene does not have: SATIN_ERROR_INPUT.
satin_status load_poses_check(struct load_state *loader);

// The source of a file that a parameter names: relative to the file with the parameter, else to the
// main file. The caller frees source->path.
satin_status load_file_source(struct load_state *loader, const struct param_value *name,
                              struct load_source *out);

// ---- load_spare.c: things without which the image can be made
// Whether the loader is lenient and the element has an unknown type. If so, logs that, and what is
// done `instead`.
bool load_left_out(struct load_state *loader, const struct xml_node *node, const char *instead);

// Whether the loader is lenient and a <ref> in the element leads nowhere.
bool load_ref_missing(const struct load_state *loader, const struct xml_node *node);

// While such a thing is read, its errors are logged as warnings.
struct load_spared {
    bool used;  // else nothing is changed
    struct log_spared log;
};
// Begins to read what the scene does not use.
void load_spare_unused(struct load_state *loader, struct load_spared *spared);
// Begins to read what an element with these parameters describes, if it has a file and the loader
// is lenient. `instead` is what is done without it.
void load_spare_file(struct load_state *loader, const struct params *p, const char *instead,
                     struct load_spared *spared);
// Ends either. Returns whether the thing is to be left out because of an error in the input, of
// which *status then becomes SATIN_OK.
bool load_spare_end(struct load_state *loader, const struct load_spared *spared,
                    satin_status *status);

// The texture of a textured parameter, built on its first use (load_plugins_texture.c).
satin_status load_texture_of(struct load_state *loader, struct xml_node *node,
                             const struct texture **out);
// The only texture in a `scale` texture, whose parameters are given. Logs if there is no such one.
satin_status load_texture_nested(struct load_state *loader, const struct params *p,
                                 struct xml_node **out);
// Makes a texture that is `inner` times a factor (load_plugins_texture.c).
void load_texture_scale(const struct texture *inner, rgb by, struct texture *out);
// Builds one side of a surface from the parameters of a <bsdf> that contains no other
// (load_plugins_bsdf.c).
satin_status load_side_build(struct load_state *loader, const struct params *p,
                             struct material_side *side);
// Builds a material, without adding it to the scene (load_plugins_material.c).
satin_status load_material_build(struct load_state *loader, struct xml_node *node,
                                 struct material *out);
// Sets *index to that of the material of a <bsdf>, which is added at the first reference. If `node`
// is NULL, it is `plain`.
satin_status load_material_of(struct load_state *loader, struct xml_node *node,
                              enum plain_material plain, uint32_t *index);
// Adds a shape with its material and light, or the shapes of which it consists (load_shape.c).
satin_status load_shape_add(struct load_state *loader, struct xml_node *node);
// The name of the last shape element that was begun: its id or, so that no two have one name, that
// of its plugin and its number among all shapes. NULL if there is no memory.
const char *load_shape_name(struct load_state *loader, const struct xml_node *node,
                            const char *plugin);
// Allocates one more shape. Logs failures.
satin_status load_shape_reserve(struct load_state *loader, const struct params *p);
// Adds a shape of shapes: merge, shapegroup, instance (load_plugins_group.c).
satin_status load_group_add(struct load_state *loader, const struct params *p);
// Adds an <emitter> of the shape that is added next, whose element is `parent`, or one without a
// shape if that is NULL. *index is its index, or -1 if it is black (load_plugins_light.c).
satin_status load_emitter_add(struct load_state *loader, struct xml_node *node,
                              const struct xml_node *parent, int32_t *index);
// Sets the transform of an image of the environment and its inverse. One that stretches or shears
// is replaced by its rotation, with a warning (load_plugins_light.c).
satin_status load_light_orient(struct load_state *loader, const struct params *p,
                               struct mat4 to_world, struct light *light);
// Reads the camera, the film and the samples per pixel of the scene (load_plugins_sensor.c).
satin_status load_sensor(struct load_state *loader, struct xml_node *node);
// Adds a camera to a scene without a sensor, as Mitsuba does: one of 45 degrees that looks along +z
// from where it sees the front of the bounds, which are known. Refuses a scene without an extent.
satin_status load_sensor_default(struct load_state *loader);
// Adds daylight to a scene of version 0.6 that has no <emitter>, as Mitsuba 0.6 does
// (load_plugins_daylight.c).
satin_status load_daylight_default(struct load_state *loader);
// Computes the half extents at unit distance from the parameters fov, fov_axis and focal_length,
// for an aspect ratio width / height. Below are the choices of fov_axis.
satin_status load_field_of_view(struct load_state *loader, const struct params *p, double aspect,
                                float tan[2]);
extern const char *const load_fov_axes[];
// Reads the `name:type` pairs of an `aov` integrator (load_aov.c).
satin_status load_aovs(struct load_state *loader, const struct param_value *text,
                       struct scene_aovs *out);
// Adds the channels of `moment` for the integrator `inner` in it, whose own channels begin at
// `first`.
satin_status load_aovs_moment(struct load_state *loader, const struct xml_node *inner, int first,
                              struct scene_aovs *out);
// Reads the <integrator> (load_plugins_integrator.c).
satin_status load_integrator(struct load_state *loader, struct xml_node *node);

#endif
