// SPDX-License-Identifier: Apache-2.0
// The position of the sun by the formulas of Blanco-Muriel et al. (Computing the solar vector,
// 2001), which Mitsuba 0.6 uses. They are accurate to half a minute of arc from 1999 to 2015.
#include "light/light_sun.h"

static const double RADIANS = 3.14159265358979323846 / 180.0;
static const double EARTH_RADIUS = 6371.01, SUN_DISTANCE = 149597890.0;  // km

// Days since noon of 1 January 2000, where `hours` are those of the day in universal time.
static double days_since_2000(const struct sun_time *t, double hours) {
    const long shift = (t->month - 14) / 12;
    const long day = 1461L * (t->year + 4800 + shift) / 4 +
                     367L * (t->month - 2 - 12 * shift) / 12 -
                     3 * ((t->year + 4900 + shift) / 100) / 4 + t->day - 32075;
    return (double)day - 0.5 + hours / 24.0 - 2451545.0;
}

vec3 light_sun_toward(const struct sun_time *t) {
    const double hours =
        (double)t->hour - t->timezone + ((double)t->minute + t->second / 60.0) / 60.0;
    const double n = days_since_2000(t, hours);
    // Ecliptic coordinates.
    const double omega = 2.1429 - 0.0010394594 * n, mean = 4.8950630 + 0.017202791698 * n,
                 anomaly = 6.2400600 + 0.0172019699 * n;
    const double longitude = mean + 0.03341607 * sin(anomaly) + 0.00034894 * sin(2.0 * anomaly) -
                             0.0001134 - 0.0000203 * sin(omega);
    const double obliquity = 0.4090928 - 6.2140e-9 * n + 0.0000396 * cos(omega);
    // Celestial coordinates.
    const double ascension = atan2(cos(obliquity) * sin(longitude), cos(longitude)),
                 declination = asin(sin(obliquity) * sin(longitude));
    // Horizontal coordinates.
    const double greenwich = 6.6974243242 + 0.0657098283 * n + hours;
    const double angle = (greenwich * 15.0 + t->longitude) * RADIANS - ascension;
    const double latitude = t->latitude * RADIANS;
    double zenith =
        acos(cos(latitude) * cos(angle) * cos(declination) + sin(declination) * sin(latitude));
    const double azimuth =
        atan2(-sin(angle), tan(declination) * cos(latitude) - sin(latitude) * cos(angle));
    zenith += EARTH_RADIUS / SUN_DISTANCE * sin(zenith);
    return v3((float)(sin(azimuth) * sin(zenith)), (float)cos(zenith),
              (float)(-cos(azimuth) * sin(zenith)));
}
