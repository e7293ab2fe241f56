// SPDX-License-Identifier: Apache-2.0
// <emitter>: daylight: `sunsky`, and `sky` and `sun` of version 0.6. The direction of the sun is
// given, or follows from a date, a time, a longitude and a latitude. Before to_world, y is up in
// version 0.6 and z in version 3. Deviation: in version 0.6 the sun is that of Preetham, Shirley
// and Smits; here both versions have the same.
#include "load/load_build.h"
#include "load/load_state.h"

#define DAYLIGHT_NUMBER(id, text, value, in, about) \
    static const struct param_spec id = {text, PARAM_FLOAT, value, in, 0, NULL, about}
#define WHOLE(id, text, value, about) \
    static const struct param_spec id = {text, PARAM_INTEGER, value, RANGE_POSITIVE, 0, NULL, about}

// Ground of version 0.6, where none is given.
#define MITSUBA06_ALBEDO 0.15f

DAYLIGHT_NUMBER(turbidity, "turbidity", "3", RANGE_POSITIVE,
                "The turbidity of the air, 1 to 10: 2 is very clear, 10 hazy.");
static const struct param_spec ground = {
    "albedo",
    PARAM_COLOR,
    ".3",
    RANGE_UNIT,
    0,
    NULL,
    "The albedo of the ground, which lights the sky. Its default is .15 in files of version 0.6."};
static const struct param_spec sunsky_direction = {
    "sun_direction",
    PARAM_POINT,
    NULL,
    0,
    0,
    NULL,
    "The direction to the sun in world space, instead of date, time and position."};
DAYLIGHT_NUMBER(latitude, "latitude", "35.6894", 0,
                "The latitude in degrees, positive to the north, -90 to 90.");
DAYLIGHT_NUMBER(longitude, "longitude", "139.6917", 0,
                "The longitude in degrees, positive to the east, -360 to 360.");
DAYLIGHT_NUMBER(timezone, "timezone", "9", 0,
                "The hours that local time is ahead of UTC, -24 to 24.");
WHOLE(year, "year", "2010", "The year of the date.");
WHOLE(month, "month", "7", "The month, 1 to 12.");
WHOLE(day, "day", "10", "The day, 1 to 31.");
DAYLIGHT_NUMBER(hour, "hour", "15", RANGE_NOT_NEGATIVE, "The hour of local time, 0 to 24.");
DAYLIGHT_NUMBER(minute, "minute", "0", RANGE_NOT_NEGATIVE, "The minute of local time, 0 to 60.");
DAYLIGHT_NUMBER(second, "second", "0", RANGE_NOT_NEGATIVE, "The second of local time, 0 to 60.");
DAYLIGHT_NUMBER(scale, "scale", "1", RANGE_NOT_NEGATIVE, "A factor of the sky and the sun.");
DAYLIGHT_NUMBER(sky_scale, "sky_scale", "1", RANGE_NOT_NEGATIVE, "A factor of the sky.");
DAYLIGHT_NUMBER(sun_scale, "sun_scale", "1", RANGE_NOT_NEGATIVE, "A factor of the sun.");
DAYLIGHT_NUMBER(sun_aperture, "sun_aperture", "0.5358", RANGE_POSITIVE,
                "The angle that the sun subtends, in degrees. Its power does not depend on it.");
DAYLIGHT_NUMBER(sun_radius, "sun_radius_scale", "1", RANGE_POSITIVE,
                "A factor of the sun's radius, as in version 0.6.");
static const struct param_spec complex_sun = {
    "complex_sun",
    PARAM_BOOLEAN,
    "false",
    0,
    0,
    NULL,
    "It has no effect: the sun's disc has the same radiance everywhere."};
static const struct param_spec to_world = {
    "to_world",
    PARAM_TRANSFORM,
    "1",
    0,
    0,
    NULL,
    "The transform of the sky. Before it, z is up; in files of version 0.6, y."};
DAYLIGHT_NUMBER(sampling_weight, "sampling_weight", "1", RANGE_NOT_NEGATIVE,
                "It has no effect: lights are chosen by power.");

static const struct param_spec *const daylight[] = {
    &turbidity,    &ground,          &sunsky_direction,
    &latitude,     &longitude,       &timezone,
    &year,         &month,           &day,
    &hour,         &minute,          &second,
    &scale,        &sky_scale,       &sun_scale,
    &sun_aperture, &sun_radius,      &complex_sun,
    &to_world,     &sampling_weight, NULL};

// Parameters of date, time and position, which a sun_direction replaces, and their ranges.
static const struct {
    const char *name;
    bool whole;
    float least, most;
} sun_ranges[] = {{"month", true, 1.0f, 12.0f},          {"day", true, 1.0f, 31.0f},
                  {"hour", false, 0.0f, 24.0f},          {"minute", false, 0.0f, 60.0f},
                  {"second", false, 0.0f, 60.0f},        {"latitude", false, -90.0f, 90.0f},
                  {"longitude", false, -360.0f, 360.0f}, {"timezone", false, -24.0f, 24.0f}};

static satin_status check_sun_time(struct load_state *loader, const struct params *p) {
    const bool replaced = load_param(p, "sun_direction")->given;
    for (size_t i = 0; i < sizeof sun_ranges / sizeof *sun_ranges; i++) {
        const char *name = sun_ranges[i].name;
        const struct param_value *value = load_param(p, name);
        const float x = sun_ranges[i].whole ? (float)value->i : value->f;
        if (value->given && replaced)
            log_warning_at(loader->log, value->place,
                           "'%s' has no effect, as sun_direction is given", name);
        else if (!(x >= sun_ranges[i].least && x <= sun_ranges[i].most)) {
            log_error_at(loader->log, value->place, "%s is %g, but must be %g to %g", name,
                         (double)x, (double)sun_ranges[i].least, (double)sun_ranges[i].most);
            return SATIN_ERROR_INPUT;
        }
    }
    return SATIN_OK;
}

// The direction to the sun before to_world. `z_up`: in the axes of Mitsuba 3, whose x points to the
// south and whose y to the west.
static vec3 sun_of_date(const struct params *p, bool z_up) {
    const struct sun_time time = {.year = load_param(p, "year")->i,
                                  .month = load_param(p, "month")->i,
                                  .day = load_param(p, "day")->i,
                                  .hour = load_param(p, "hour")->f,
                                  .minute = load_param(p, "minute")->f,
                                  .second = load_param(p, "second")->f,
                                  .latitude = load_param(p, "latitude")->f,
                                  .longitude = load_param(p, "longitude")->f,
                                  .timezone = load_param(p, "timezone")->f};
    const vec3 w = light_sun_toward(&time);
    return z_up ? v3(w.z, -w.x, w.y) : w;
}

// Sets the light's transform, under which y is up as in the image of the sky.
static satin_status set_transform(struct load_state *loader, const struct params *p, bool z_up,
                                  struct light *light) {
    const struct mat4 stand = z_up ? mat4_rotate(v3(1.0f, 0.0f, 0.0f), 90.0f) : mat4_identity();
    return load_light_orient(loader, p, mat4_mul(&load_param(p, "to_world")->m, &stand), light);
}

// Sets direction, size and radiance of the sun.
static satin_status set_sun(struct load_state *loader, const struct params *p,
                            const struct sky *sky, float factor, struct light *light) {
    const float degrees = load_param(p, "sun_aperture")->f * load_param(p, "sun_radius_scale")->f,
                aperture = degrees * (PI_F / 180.0f);
    if (!(aperture < 0.5f * PI_F))
        return load_refuse(loader, p, "its sun_aperture is not below 90 degrees");
    // The power of the sun does not depend on its size.
    const float natural = SKY_SUN_APERTURE * (PI_F / 180.0f);
    light->sun_chord = 2.0f * sinf(0.25f * aperture);
    const float shrink = sqrf(2.0f * sinf(0.25f * natural) / light->sun_chord);
    light->sun_value = rgb_scale(light_sky_sun(sky), factor * shrink);
    return SATIN_OK;
}

// Makes the light black, as Mitsuba does when the sun has set. The model knows no twilight.
static satin_status set_night(struct load_state *loader, const struct params *p,
                              struct light *light) {
    log_warning_at(loader->log, p->node->place,
                   "emitter '%s': its sun is below the horizon, so it gives no light",
                   p->plugin->name);
    light->value = rgb_grey(0.0f);
    return SATIN_OK;
}

// `has_sky` and `has_sun` are 0 or 1.
static satin_status build_daylight(struct load_state *loader, const struct params *p,
                                   struct light *light, float has_sky, float has_sun) {
    const bool z_up = !p->node->mitsuba06;
    const float all = load_param(p, "scale")->f;
    const struct param_value *given = load_param(p, "sun_direction"),
                             *albedo = load_param(p, "albedo");
    light->kind = LIGHT_ENVMAP;
    light->value = rgb_grey(all * has_sky * load_param(p, "sky_scale")->f);
    satin_status status = check_sun_time(loader, p);
    if (status == SATIN_OK) status = set_transform(loader, p, z_up, light);
    if (status != SATIN_OK) return status;
    const vec3 sun =
        given->given ? given->v : mat4_vector(&load_param(p, "to_world")->m, sun_of_date(p, z_up));
    light->sun = v3_unit(sun);
    const struct sky sky = {
        .turbidity = load_param(p, "turbidity")->f,
        .albedo = albedo->given || z_up ? albedo->color : rgb_grey(MITSUBA06_ALBEDO),
        .sun = v3_unit(mat4_vector(&light->to_local, light->sun))};
    if (!(sky.turbidity >= SKY_TURBIDITY_MIN && sky.turbidity <= SKY_TURBIDITY_MAX))
        return load_refuse(loader, p, "its turbidity is not in [1, 10]");
    if (!(v3_len2(sky.sun) > 0.5f))
        return load_refuse(loader, p, "its sun_direction is zero, too small or too large");
    if (sky.sun.y < 0.0f) return set_night(loader, p, light);
    status = set_sun(loader, p, &sky, all * has_sun * load_param(p, "sun_scale")->f, light);
    if (status != SATIN_OK) return status;
    struct image *image = arena_alloc(&loader->scene->arena, sizeof *image);
    if (!image || !light_sky_image(&loader->scene->arena, &sky, image))
        return load_no_memory(loader);
    light->image = image;
    light->lit_rows = SKY_HORIZON;
    return SATIN_OK;
}

static satin_status build_sunsky(struct load_state *loader, const struct params *p, void *object) {
    return build_daylight(loader, p, object, 1.0f, 1.0f);
}

static satin_status build_sky(struct load_state *loader, const struct params *p, void *object) {
    return build_daylight(loader, p, object, 1.0f, 0.0f);
}

static satin_status build_sun(struct load_state *loader, const struct params *p, void *object) {
    return build_daylight(loader, p, object, 0.0f, 1.0f);
}

static bool has_emitter(const struct xml_node *node) {
    if (node->tag == XML_EMITTER) return true;
    for (const struct xml_node *child = node->child; child; child = child->next)
        if (has_emitter(child)) return true;
    return false;
}

satin_status load_daylight_default(struct load_state *loader) {
    static const char *const attribute[] = {"type", "sunsky", NULL};
    const struct xml_node *root = loader->xml.root;
    if (!root->mitsuba06 || has_emitter(root)) return SATIN_OK;
    log_warning_at(
        loader->log, root->place,
        "the scene has no <emitter>: it has the daylight of `sunsky`, as in version 0.6");
    struct xml_node *node = arena_alloc(&loader->xml.arena, sizeof *node);
    if (!node) return load_no_memory(loader);
    int32_t light;
    *node = (struct xml_node){.tag = XML_EMITTER,
                              .place = root->place,
                              .type = "sunsky",
                              .attribute = attribute,
                              .mitsuba06 = true};
    return load_emitter_add(loader, node, NULL, &light);
}

const struct plugin_spec load_daylight_plugins[] = {
    {XML_EMITTER, "sunsky", "daylight: a clear sky and the sun", daylight, 0, build_sunsky, false},
    {XML_EMITTER, "sky", "the sky of `sunsky` alone, as in version 0.6", daylight, 0, build_sky,
     false},
    {XML_EMITTER, "sun", "the sun of `sunsky` alone, as in version 0.6", daylight, 0, build_sun,
     false},
    {0}};
