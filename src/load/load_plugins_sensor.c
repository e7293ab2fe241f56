// SPDX-License-Identifier: Apache-2.0
// <sensor>: the camera. Names, defaults and the meaning of fov are Mitsuba 3's.
#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "load/load_state.h"

enum sensor_axis { AXIS_X = 0, AXIS_Y, AXIS_DIAGONAL, AXIS_SMALLER, AXIS_LARGER };
const char *const load_fov_axes[] = {"x", "y", "diagonal", "smaller", "larger", NULL};

static const struct param_spec sensor_to_world = {
    "to_world",
    PARAM_TRANSFORM,
    "1",
    0,
    0,
    NULL,
    "The transform from camera space to world space. The camera faces +z."};
static const struct param_spec fov = {
    "fov", PARAM_FLOAT, NULL, RANGE_POSITIVE, 0, NULL, "The field of view, in degrees."};
static const struct param_spec fov_axis = {"fov_axis",
                                           PARAM_CHOICE,
                                           "x",
                                           0,
                                           0,
                                           load_fov_axes,
                                           "The side of the film to which `fov` refers."};
static const struct param_spec focal_length = {
    "focal_length",
    PARAM_STRING,
    "50mm",
    0,
    0,
    NULL,
    "The focal length for 35 mm film, in millimetres, instead of `fov`."};
static const struct param_spec near_clip = {
    "near_clip",
    PARAM_FLOAT,
    ".01",
    RANGE_POSITIVE,
    0,
    NULL,
    "The distance of the near plane along the optical axis: nothing nearer is seen."};
static const struct param_spec far_clip = {
    "far_clip",
    PARAM_FLOAT,
    "10000",
    RANGE_POSITIVE,
    0,
    NULL,
    "The distance of the far plane along the optical axis: nothing farther is seen."};
static const struct param_spec shift_x = {
    "principal_point_offset_x",
    PARAM_FLOAT,
    "0",
    0,
    0,
    NULL,
    "The horizontal offset of the principal point, in film widths."};
static const struct param_spec shift_y = {
    "principal_point_offset_y",
    PARAM_FLOAT,
    "0",
    0,
    0,
    NULL,
    "The vertical offset of the principal point, in film heights."};
static const struct param_spec aperture_radius = {"aperture_radius",
                                                  PARAM_FLOAT,
                                                  NULL,
                                                  RANGE_NOT_NEGATIVE,
                                                  PARAM_REQUIRED,
                                                  NULL,
                                                  "The radius of the lens, in scene units."};
static const struct param_spec focus_distance = {
    "focus_distance",
    PARAM_FLOAT,
    NULL,
    RANGE_POSITIVE,
    0,
    NULL,
    "The distance of the plane in focus. If it is not given, it is `far_clip`."};
static const struct param_spec telecentric_radius = {"aperture_radius",
                                                     PARAM_FLOAT,
                                                     "0",
                                                     RANGE_NOT_NEGATIVE,
                                                     0,
                                                     NULL,
                                                     "The radius of the lens, in scene units."};
static const struct param_spec idle_focus_distance = {"focus_distance",
                                                      PARAM_FLOAT,
                                                      NULL,
                                                      RANGE_POSITIVE,
                                                      0,
                                                      NULL,
                                                      "It has no effect: everything is in focus."};
static const struct param_spec shutter_open = {
    "shutter_open", PARAM_FLOAT, "0", 0, 0, NULL, "It has no effect: nothing moves."};
static const struct param_spec shutter_close = {
    "shutter_close", PARAM_FLOAT, "0", 0, 0, NULL, "It has no effect: nothing moves."};

typedef const struct param_spec *const param_list[];
static param_list perspective_params = {&sensor_to_world, &fov,           &fov_axis,
                                        &focal_length,    &near_clip,     &far_clip,
                                        &shift_x,         &shift_y,       &idle_focus_distance,
                                        &shutter_open,    &shutter_close, NULL};
static param_list thinlens_params = {
    &sensor_to_world, &fov,          &fov_axis,      &focal_length,    &near_clip, &far_clip,
    &focus_distance,  &shutter_open, &shutter_close, &aperture_radius, NULL};

static param_list orthographic_params = {
    &sensor_to_world, &near_clip,           &far_clip, &shutter_open,
    &shutter_close,   &idle_focus_distance, NULL};

static param_list telecentric_params = {
    &sensor_to_world, &near_clip,          &far_clip,       &shutter_open,
    &shutter_close,   &telecentric_radius, &focus_distance, NULL};

static param_list spherical_params = {&sensor_to_world, &shutter_open, &shutter_close, NULL};

// Half the diagonal of 35 mm film, 36 x 24 mm.
#define HALF_DIAGONAL_35MM 21.633307652783937

// The tangent of half the angle that fov or focal_length gives, and the axis to which it refers.
static satin_status read_field_of_view(struct load_state *loader, const struct params *p,
                                       double *tangent, enum sensor_axis *axis) {
    const struct param_value *angle = load_param(p, "fov"), *focal = load_param(p, "focal_length");
    if (angle->given && focal->given)
        return load_refuse(loader, p, "it has both fov and focal_length");
    if (angle->given) {
        if (angle->f >= 180.0f || angle->f < SCENE_FOV_MIN) {
            log_error_at(loader->log, angle->place, "fov is %g, but must be in [%g, 180)",
                         (double)angle->f, (double)SCENE_FOV_MIN);
            return SATIN_ERROR_INPUT;
        }
        *tangent = tan((double)angle->f * (3.14159265358979323846 / 360.0));
        *axis = (enum sensor_axis)load_param(p, "fov_axis")->i;
        return SATIN_OK;
    }
    char text[32] = "";
    size_t n = strlen(focal->s);
    if (n > 2 && strcmp(focal->s + n - 2, "mm") == 0) n -= 2;
    while (n && focal->s[n - 1] == ' ') n--;
    if (n < sizeof text) memcpy(text, focal->s, n);
    double length;
    if (!text_double(text, &length) || !(length > 1e-3 && length < 1e9)) {
        log_error_at(loader->log, focal->place, "focal_length is '%.40s', but must be like 50mm",
                     focal->s);
        return SATIN_ERROR_INPUT;
    }
    *tangent = HALF_DIAGONAL_35MM / length;
    *axis = AXIS_DIAGONAL;
    return SATIN_OK;
}

satin_status load_field_of_view(struct load_state *loader, const struct params *p, double aspect,
                                float tan[2]) {
    double tangent = 0.0;
    enum sensor_axis axis = AXIS_X;
    satin_status status = read_field_of_view(loader, p, &tangent, &axis);
    if (status != SATIN_OK) return status;
    if (axis == AXIS_SMALLER) axis = aspect > 1.0 ? AXIS_Y : AXIS_X;
    if (axis == AXIS_LARGER) axis = aspect > 1.0 ? AXIS_X : AXIS_Y;
    if (axis == AXIS_Y) tangent *= aspect;
    if (axis == AXIS_DIAGONAL) tangent /= sqrt(1.0 + 1.0 / (aspect * aspect));
    tan[0] = (float)tangent;
    tan[1] = (float)(tangent / aspect);
    if (tan[0] > 0.0f && tan[0] < 1e6f && tan[1] > 0.0f) return SATIN_OK;
    return load_refuse(loader, p, "its angle of view must be over 0 and at most 179.9998 degrees");
}

static satin_status set_field_of_view(struct load_state *loader, const struct params *p,
                                      struct camera *camera) {
    const struct scene_film *film = &loader->scene->film;
    float tan[2];
    satin_status status =
        load_field_of_view(loader, p, (double)film->width / (double)film->height, tan);
    if (status != SATIN_OK) return status;
    camera->tan_x = tan[0];
    camera->tan_y = tan[1];
    return SATIN_OK;
}

// The transform may rotate and mirror but not scale; the tolerance is Mitsuba's.
static satin_status set_sensor_transform(struct load_state *loader, const struct params *p,
                                         struct camera *camera) {
    const struct mat4 *m = &load_param(p, "to_world")->m;
    struct mat4 inverse;
    camera->to_world = *m;
    for (int j = 0; j < 3; j++) {
        float l2 = v3_len2(v3(m->m[0][j], m->m[1][j], m->m[2][j]));
        if (!(fabsf(l2 - 1.0f) <= 1e-3f)) return load_refuse(loader, p, "to_world has a scale");
    }
    for (int j = 0; j < 4; j++)
        if (m->m[3][j] != (j == 3 ? 1.0f : 0.0f))
            return load_refuse(loader, p, "to_world is not affine");
    return mat4_inverse(m, &inverse) ? SATIN_OK : load_refuse(loader, p, "to_world is singular");
}

static satin_status set_clip(struct load_state *loader, const struct params *p,
                             struct camera *camera) {
    camera->near_clip = load_param(p, "near_clip")->f;
    camera->far_clip = load_param(p, "far_clip")->f;
    camera->focus_distance = camera->far_clip;
    if (camera->near_clip < camera->far_clip) return SATIN_OK;
    return load_refuse(loader, p, "near_clip must be smaller than far_clip");
}

static satin_status build_camera(struct load_state *loader, const struct params *p, void *object) {
    struct camera *camera = object;
    satin_status status = set_clip(loader, p, camera);
    if (status == SATIN_OK) status = set_sensor_transform(loader, p, camera);
    return status == SATIN_OK ? set_field_of_view(loader, p, camera) : status;
}

// The film is 2 wide and has the height of its aspect ratio; to_world scales it.
static satin_status build_orthographic(struct load_state *loader, const struct params *p,
                                       void *object) {
    struct camera *camera = object;
    const struct scene_film *film = &loader->scene->film;
    struct mat4 inverse;
    camera->orthographic = true;
    camera->to_world = load_param(p, "to_world")->m;
    camera->tan_x = 1.0f;
    camera->tan_y = (float)((double)film->height / (double)film->width);
    if (!mat4_inverse(&camera->to_world, &inverse))
        return load_refuse(loader, p, "to_world is singular");
    float depth = v3_len2(mat4_vector(&camera->to_world, v3(0, 0, 1)));
    if (!(depth > 1e-30f && depth < 1e30f))
        return load_refuse(loader, p, "to_world is too small or too large");
    return set_clip(loader, p, camera);
}

// Lengths are in world space in the file, where to_world may scale, and in camera space here.
static satin_status build_telecentric(struct load_state *loader, const struct params *p,
                                      void *object) {
    struct camera *camera = object;
    satin_status status = build_orthographic(loader, p, object);
    if (status != SATIN_OK) return status;
    const float across = v3_len(mat4_vector(&camera->to_world, v3(1, 0, 0)));
    const float depth = v3_len(mat4_vector(&camera->to_world, v3(0, 0, 1)));
    const float focus = load_param(p, "focus_distance")->given ? load_param(p, "focus_distance")->f
                                                               : camera->far_clip;
    const float length = camera->far_clip - camera->near_clip;
    camera->aperture = load_param(p, "aperture_radius")->f / across;
    camera->focus_distance = focus / depth;
    camera->near_clip /= depth;
    // Without a lens, rays begin at the near plane, and their length is in world space.
    camera->far_clip =
        camera->aperture > 0.0f ? camera->far_clip / depth : camera->near_clip + length;
    if (!(camera->aperture < 1e15f && camera->focus_distance > 1e-15f))
        return load_refuse(loader, p, "its lens is too large, or its focus too near");
    if (camera->near_clip < camera->far_clip && isfinite(camera->far_clip)) return SATIN_OK;
    return load_refuse(loader, p, "to_world makes its clip planes too near or too far");
}

static satin_status build_spherical(struct load_state *loader, const struct params *p,
                                    void *object) {
    struct camera *camera = object;
    camera->spherical = true;
    camera->tan_x = 2.0f;
    camera->tan_y = 1.0f;
    camera->far_clip = INFINITY;
    return set_sensor_transform(loader, p, camera);
}

static satin_status build_perspective(struct load_state *loader, const struct params *p,
                                      void *object) {
    struct camera *camera = object;
    camera->shift.x = load_param(p, "principal_point_offset_x")->f;
    camera->shift.y = load_param(p, "principal_point_offset_y")->f;
    if (fabsf(camera->shift.x) > 1e4f || fabsf(camera->shift.y) > 1e4f)
        return load_refuse(loader, p, "its principal point is too far off");
    return build_camera(loader, p, camera);
}

static satin_status build_thinlens(struct load_state *loader, const struct params *p,
                                   void *object) {
    struct camera *camera = object;
    satin_status status = build_camera(loader, p, camera);
    camera->aperture = load_param(p, "aperture_radius")->f;
    if (load_param(p, "focus_distance")->given)
        camera->focus_distance = load_param(p, "focus_distance")->f;
    return status;
}

#define SENSOR_CHILDREN (1u << XML_FILM | 1u << XML_SAMPLER)

const struct plugin_spec load_sensor_plugins[] = {
    {XML_SENSOR, "perspective", "a pinhole camera", perspective_params, SENSOR_CHILDREN,
     build_perspective, false},
    {XML_SENSOR, "thinlens", "a camera with depth of field", thinlens_params, SENSOR_CHILDREN,
     build_thinlens, false},
    {XML_SENSOR, "orthographic", "parallel rays; the film is 2 wide before to_world scales it",
     orthographic_params, SENSOR_CHILDREN, build_orthographic, false},
    {XML_SENSOR, "telecentric",
     "parallel rays with depth of field, as in Mitsuba 0.6; the film is 2 wide before to_world "
     "scales it",
     telecentric_params, SENSOR_CHILDREN, build_telecentric, false},
    {XML_SENSOR, "spherical",
     "all directions by longitude and latitude, as in Mitsuba 0.6: an image for `envmap`, if it is "
     "twice as wide as high",
     spherical_params, SENSOR_CHILDREN, build_spherical, false},
    {0}};

// Reads the only child of a tag, if there is one, to `object`.
static satin_status read_only_child(struct load_state *loader, const struct params *parent,
                                    enum xml_tag tag, void *object, struct params *out) {
    struct xml_node *at = NULL, *node = load_params_child(&loader->xml, parent->node, tag, &at);
    out->node = NULL;
    if (!node) return SATIN_OK;
    if (load_params_child(&loader->xml, parent->node, tag, &at))
        return load_refuse(loader, parent, "it has two parts of the same kind");
    satin_status status = load_params(loader, node, out);
    return status == SATIN_OK ? out->plugin->build(loader, out, object) : status;
}

static const struct scene_film default_film = {.width = 768,
                                               .height = 576,
                                               .crop_width = 768,
                                               .crop_height = 576,
                                               .filter = FILTER_GAUSSIAN,
                                               .radius = 2.0f,
                                               .stddev = 0.5f};

satin_status load_sensor(struct load_state *loader, struct xml_node *node) {
    struct params sensor, child, filter;
    struct camera camera = {0};
    struct scene_film film = default_film;
    if (load_left_out(loader, node, "it is a perspective camera")) node->type = "perspective";
    satin_status status = load_params(loader, node, &sensor);
    if (status == SATIN_OK) status = read_only_child(loader, &sensor, XML_SAMPLER, NULL, &child);
    if (status == SATIN_OK) status = read_only_child(loader, &sensor, XML_FILM, &film, &child);
    if (status == SATIN_OK && child.node)
        status = read_only_child(loader, &child, XML_RFILTER, &film, &filter);
    if (status != SATIN_OK) return status;
    loader->scene->film = film;
    status = sensor.plugin->build(loader, &sensor, &camera);
    if (status == SATIN_OK) loader->scene->camera = camera;
    return status;
}

satin_status load_sensor_default(struct load_state *loader) {
    struct satin_scene *scene = loader->scene;
    const struct log_place place = loader->xml.root->place;
    const vec3 size = v3_sub(scene->bounds_hi, scene->bounds_lo),
               center = v3_add(scene->bounds_lo, v3_mul(size, 0.5f));
    const float across = maxf(size.x, size.y);
    if (!(across > 0.0f)) {
        log_error_at(loader->log, place, "the scene has no <sensor>");
        return SATIN_ERROR_INPUT;
    }
    log_warning_at(loader->log, place,
                   "the scene has no <sensor>: a camera in front of it looks along +z");
    const float tangent = tanf(22.5f * (PI_F / 180.0f)), distance = 0.5f * across / tangent;
    const vec3 from = v3(center.x, center.y, scene->bounds_lo.z - distance);
    scene->film = default_film;
    scene->camera = (struct camera){.to_world = mat4_translate(from),
                                    .tan_x = tangent,
                                    .tan_y = tangent * 0.75f,
                                    .near_clip = 0.01f * distance,
                                    .far_clip = distance + 5.0f * maxf(across, size.z)};
    scene->camera.focus_distance = scene->camera.far_clip;
    scene->sensor = &scene->camera;
    scene->sensor_count = 1;
    return SATIN_OK;
}
