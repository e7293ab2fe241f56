// SPDX-License-Identifier: Apache-2.0
// <emitter>: daylight of version 0.6: `sunsky`, `sky` and `sun`. The direction of the sun follows
// from a date, a time, a longitude and a latitude. Deviation: version 0.6 has another model of the
// sky; here it is that of `preethamsky`, in the same units.
#include "load/load_state.h"

#define NUMBER(id, text, value, in, about) \
    static const struct param_spec id = {text, PARAM_FLOAT, value, in, 0, NULL, about}
#define WHOLE(id, text, value, about) \
    static const struct param_spec id = {text, PARAM_INTEGER, value, RANGE_POSITIVE, 0, NULL, about}

NUMBER(haze, "turbidity", "3", RANGE_POSITIVE,
       "The turbidity of the air: 2 is very clear, 10 hazy.");
static const struct param_spec daylight_direction = {
    "sun_direction",
    PARAM_POINT,
    NULL,
    0,
    0,
    NULL,
    "The direction to the sun, instead of date, time and position."};
NUMBER(latitude, "latitude", "35.6894", 0, "The latitude in degrees, positive to the north.");
NUMBER(longitude, "longitude", "139.6917", 0, "The longitude in degrees, positive to the east.");
NUMBER(timezone, "timezone", "9", 0, "The hours that local time is ahead of UTC.");
WHOLE(year, "year", "2010", "The year of the date.");
WHOLE(month, "month", "7", "The month, 1 to 12.");
WHOLE(day, "day", "10", "The day, 1 to 31.");
NUMBER(hour, "hour", "15", RANGE_NOT_NEGATIVE, "The hour of local time.");
NUMBER(minute, "minute", "0", RANGE_NOT_NEGATIVE, "The minute of local time, 0 to 60.");
NUMBER(second, "second", "0", RANGE_NOT_NEGATIVE, "The second of local time, 0 to 60.");
NUMBER(scale, "scale", "1", RANGE_NOT_NEGATIVE, "A factor of the sky and the sun.");
NUMBER(sky_scale, "sky_scale", "1", RANGE_NOT_NEGATIVE, "A factor of the sky.");
NUMBER(sun_scale, "sun_scale", "1", RANGE_NOT_NEGATIVE, "A factor of the sun.");
NUMBER(sun_radius, "sun_radius_scale", "1", RANGE_POSITIVE,
       "A factor of the sun's radius. Its power does not depend on it.");
static const struct param_spec sun_to_world = {"to_world",
                                               PARAM_TRANSFORM,
                                               "1",
                                               0,
                                               0,
                                               NULL,
                                               "The transform of the sky, before which y is up."};

static const struct param_spec *const daylight[] = {&haze,       &daylight_direction,
                                                    &latitude,   &longitude,
                                                    &timezone,   &year,
                                                    &month,      &day,
                                                    &hour,       &minute,
                                                    &second,     &scale,
                                                    &sky_scale,  &sun_scale,
                                                    &sun_radius, &sun_to_world,
                                                    NULL};

static vec3 sun_toward_of(const struct params *p) {
    const struct sun_time time = {.year = param(p, "year")->i,
                                  .month = param(p, "month")->i,
                                  .day = param(p, "day")->i,
                                  .hour = param(p, "hour")->f,
                                  .minute = param(p, "minute")->f,
                                  .second = param(p, "second")->f,
                                  .latitude = param(p, "latitude")->f,
                                  .longitude = param(p, "longitude")->f,
                                  .timezone = param(p, "timezone")->f};
    return mat4_vector(&param(p, "to_world")->m, sun_toward(&time));
}

static satin_status build_daylight(struct load_state *loader, const struct params *p,
                                   struct light *light, float sky, float sun) {
    const float all = param(p, "scale")->f;
    const struct param_value *given = param(p, "sun_direction");
    const struct load_daylight request = {
        .turbidity = clampf(param(p, "turbidity")->f, SKY_TURBIDITY_MIN, SKY_TURBIDITY_MAX),
        .sun = given->given ? given->v : sun_toward_of(p),
        .sky_scale = all * sky * param(p, "sky_scale")->f,
        .sun_scale = all * sun * param(p, "sun_scale")->f,
        .sun_aperture = SKY_SUN_APERTURE * param(p, "sun_radius_scale")->f};
    log_warning_at(loader->log, p->node->place,
                   "emitter '%s' is read as 'preethamsky', a model that looks a little different",
                   p->plugin->name);
    return load_daylight_build(loader, p, &request, light);
}

static satin_status build_sunsky(struct load_state *loader, const struct params *p, void *object) {
    return build_daylight(loader, p, object, 1.0f, 1.0f);
}

static satin_status build_sky_alone(struct load_state *loader, const struct params *p,
                                    void *object) {
    return build_daylight(loader, p, object, 1.0f, 0.0f);
}

static satin_status build_sun(struct load_state *loader, const struct params *p, void *object) {
    return build_daylight(loader, p, object, 0.0f, 1.0f);
}

const struct plugin_spec load_sun_plugins[] = {
    {XML_EMITTER, "sunsky", "in files of version 0.6, daylight by date and position", daylight, 0,
     build_sunsky, false},
    {XML_EMITTER, "sky", "in files of version 0.6, the sky of `sunsky` alone", daylight, 0,
     build_sky_alone, false},
    {XML_EMITTER, "sun", "in files of version 0.6, the sun of `sunsky` alone", daylight, 0,
     build_sun, false},
    {0}};
