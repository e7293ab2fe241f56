// SPDX-License-Identifier: Apache-2.0
// Part of light.h: the direction to the sun at a time and a point of the earth.
#ifndef LIGHT_SUN_H
#define LIGHT_SUN_H

#include "base/vec.h"

struct sun_time {
    int year, month, day;
    float hour, minute, second;           // local time
    float latitude, longitude, timezone;  // degrees, positive to the north and east; hours
};

// The unit vector to the sun as in Mitsuba 0.6: y is up, z to the south and x to the east.
vec3 light_sun_toward(const struct sun_time *time);

#endif
