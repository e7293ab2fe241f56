// SPDX-License-Identifier: Apache-2.0
// Private to light/: samples along a line of light that are uniform in the angle that it subtends
// at a point [Kulla and Fajardo 2012, "Importance sampling techniques for path tracing in
// participating media", 4.1]. Uniform in length, most light of a long line near the point is in few
// of them.
#ifndef LIGHT_LINE_H
#define LIGHT_LINE_H

#include "base/vec.h"

// A line relative to a point. Lengths are in scene units.
struct light_line {
    float length;
    float foot, away;  // of the point: the distance along the line from its beginning, of any sign,
                       // and that from the line, above 0
    float angle;       // that the line subtends at the point, in (0, pi)
};

// False if the angle is too small for a float.
static inline bool light_line_make(float length, float foot, float away, struct light_line *line) {
    // The difference of two arctangents.
    const float angle = atan2f(length * away, away * away - foot * (length - foot));
    *line = (struct light_line){length, foot, away, angle};
    return angle > 0.0f;
}

// The distance from the beginning for v in [0, 1).
static inline float light_line_sample(const struct light_line *line, float v) {
    const float tangent = tanf(v * line->angle);
    const float along =
        (line->away * tangent - line->foot) / (1.0f + line->foot / line->away * tangent);
    return clampf(line->foot + along, 0.0f, line->length);
}

// The density over length of the point at distance `at` from the beginning.
static inline float light_line_density(const struct light_line *line, float at) {
    const float along = at - line->foot;
    return line->away / (line->angle * (line->away * line->away + along * along));
}

// The mean of the squared inverse distance, within 1e-4 of it: the angle over the product of length
// and distance, by its cosine and sine [Abramowitz and Stegun 1964, 4.4.45].
static inline float light_line_closeness(float length, float foot, float away) {
    const float x = away * away - foot * (length - foot), y = length * away;
    const float r = sqrtf(x * x + y * y), c = fabsf(x) / r;
    const float p = 1.5707288f + c * (-0.2121144f + c * (0.0742610f - 0.0187293f * c));
    const float acute = y / r / sqrtf(1.0f + c) * p;
    return (x < 0.0f ? PI_F - acute : acute) / y;
}

#endif
