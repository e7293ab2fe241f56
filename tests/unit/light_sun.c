// SPDX-License-Identifier: Apache-2.0
// The direction of the sun, against simple astronomical facts.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "light/light_sun.h"

static vec3 at(float latitude, int month, int day, float hour) {
    return light_sun_toward(&(struct sun_time){2010, month, day, hour, 0, 0, latitude, 0, 0});
}

// At noon the sun is in the south, at the height of the latitude's complement and the declination.
static void the_sun_is_high_at_noon(void **state) {
    (void)state;
    static const struct {
        float latitude;
        int month, day;
        float elevation;
    } known[] = {{50, 3, 20, 40}, {50, 6, 21, 63.44f}, {50, 12, 21, 16.56f}, {10, 12, 21, 56.56f}};
    for (int i = 0; i < 4; i++) {
        const vec3 sun = at(known[i].latitude, known[i].month, known[i].day, 12.0f);
        assert_float_equal(v3_len2(sun), 1.0f, 1e-5f);
        // These are the declination of the day and the equation of time, which is a few minutes.
        assert_float_equal(asinf(sun.y) * 180.0f / PI_F, known[i].elevation, 0.2f);
        assert_true(sun.z > 0.0f && fabsf(sun.x) < 0.05f);
    }
}

static void the_sun_rises_in_the_east(void **state) {
    (void)state;
    const vec3 morning = at(50, 3, 20, 7.0f), evening = at(50, 3, 20, 17.0f);
    assert_true(morning.x > 0.9f && morning.y > 0.05f && evening.x < -0.9f && evening.y > 0.05f);
    assert_true(at(50, 3, 20, 0.0f).y < -0.5f);
    // South of the equator the sun is in the north; an hour east of Greenwich, it is there an hour
    // earlier.
    assert_true(at(-50, 3, 20, 12.0f).z < -0.5f);
    struct sun_time east = {2010, 3, 20, 13, 0, 0, 50, 15, 1};
    const vec3 a = light_sun_toward(&east), b = at(50, 3, 20, 13.0f);
    assert_true(v3_dist2(a, b) < 1e-5f);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_sun_is_high_at_noon),
                                       cmocka_unit_test(the_sun_rises_in_the_east)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
