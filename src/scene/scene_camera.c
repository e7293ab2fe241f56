// SPDX-License-Identifier: Apache-2.0
// Eye rays, and film positions drawn from the pixel filter.
#include "base/sampling.h"
#include "scene/scene.h"

// Parallel rays from the near plane. Their width is the same everywhere, so that per distance it is
// right in the middle of the scene.
static struct ray parallel_ray(const struct satin_scene *scene, vec3 plane, float *spread) {
    const struct camera *camera = &scene->camera;
    vec3 o = mat4_point(&camera->to_world, v3(plane.x, plane.y, camera->near_clip));
    vec3 d = v3_unit(mat4_vector(&camera->to_world, v3(0, 0, 1)));
    vec3 middle = v3_mul(v3_add(scene->bounds_lo, scene->bounds_hi), 0.5f);
    vec3 x = mat4_vector(&camera->to_world, v3(2.0f * camera->tan_x, 0, 0));
    float distance = fmaxf(v3_dot(v3_sub(middle, o), d), 0.1f * scene->radius);
    if (spread) *spread = v3_len(x) / (float)scene->film.width / distance;
    return (struct ray){o, 0.0f, d, camera->far_clip - camera->near_clip};
}

struct ray camera_ray(const struct satin_scene *scene, float x, float y, float u, float v,
                      float *spread) {
    const struct camera *camera = &scene->camera;
    const struct film_spec *film = &scene->film;
    // Where the film position lies on the plane z = 1; x goes to the left there, y up.
    float s = x / (float)film->width + camera->shift.x;
    float t = y / (float)film->height + camera->shift.y;
    vec3 plane = v3(camera->tan_x * (1.0f - 2.0f * s), camera->tan_y * (1.0f - 2.0f * t), 1.0f);
    if (camera->orthographic) return parallel_ray(scene, plane, spread);
    vec3 origin = v3(0, 0, 0), d = v3_unit(plane);
    // A pixel's width on that plane, seen from the eye: the root of its solid angle, w^2 cos^3.
    float width = 2.0f * camera->tan_x / (float)film->width;
    if (spread) *spread = width * d.z * sqrtf(d.z);
    if (camera->aperture > 0.0f) {
        vec2 lens = sample_disk(u, v);
        origin = v3(camera->aperture * lens.x, camera->aperture * lens.y, 0.0f);
        d = v3_unit(v3_mad(plane, -1.0f / camera->focus_distance, origin));
    }
    return (struct ray){mat4_point(&camera->to_world, origin), camera->near_clip / d.z,
                        v3_unit(mat4_vector(&camera->to_world, d)), camera->far_clip / d.z};
}

// ---- Filter -------------------------------------------------------------------------------------

// The filter's integral from -radius to x, up to a factor; and its value, by the same factor.
static double filter_integral(const struct film_spec *film, double x) {
    double r = (double)film->radius, sigma = (double)film->stddev;
    switch (film->filter) {
        case FILTER_TENT:
            return x < 0.0 ? 0.5 * (r + x) * (r + x) : r * r - 0.5 * (r - x) * (r - x);
        case FILTER_GAUSSIAN:
            // Lowered to reach zero at the radius.
            return sigma * sqrt(0.5 * 3.14159265358979323846) *
                       (erf(x / (sigma * sqrt(2.0))) + erf(r / (sigma * sqrt(2.0)))) -
                   (x + r) * exp(-0.5 * r * r / (sigma * sigma));
        default:
            return x + r;
    }
}

static double filter_value(const struct film_spec *film, double x) {
    double r = (double)film->radius, sigma = (double)film->stddev;
    switch (film->filter) {
        case FILTER_TENT:
            return r - fabs(x);
        case FILTER_GAUSSIAN:
            return exp(-0.5 * x * x / (sigma * sigma)) - exp(-0.5 * r * r / (sigma * sigma));
        default:
            return 1.0;
    }
}

float film_filter_sample(const struct film_spec *film, float centre, float lo, float hi, float u) {
    double r = (double)film->radius;
    double a = fmax(-r, (double)lo - (double)centre), b = fmin(r, (double)hi - (double)centre);
    if (!(a < b)) return 0.0f;
    double from = filter_integral(film, a), to = filter_integral(film, b);
    double wanted = from + (double)u * (to - from);
    // Newton's method; where it leaves the bracket, halving. The integral only grows, so the
    // bracket closes.
    double left = a, right = b, x = 0.5 * (a + b);
    for (int i = 0; i < 40; i++) {
        double error = filter_integral(film, x) - wanted;
        if (error > 0.0)
            right = x;
        else
            left = x;
        double step = error / filter_value(film, x), next = x - step;
        if (!(next > left && next < right)) next = 0.5 * (left + right);
        if (fabs(next - x) < 1e-8 * r) break;
        x = next;
    }
    // Rounding must not move the position out of [lo, hi).
    float offset = (float)x;
    if (centre + offset >= hi) offset = nextafterf(hi, -INFINITY) - centre;
    return centre + offset < lo ? lo - centre : offset;
}

void film_filter_make(const struct film_spec *film, struct film_filter *out) {
    out->film = film;
    for (int i = 0; i <= FILM_FILTER_STEPS; i++)
        out->inverse[i] = film_filter_sample(film, 0.0f, -INFINITY, INFINITY,
                                             (float)i / (float)FILM_FILTER_STEPS);
    out->inverse[FILM_FILTER_STEPS + 1] = out->inverse[FILM_FILTER_STEPS];
}

float film_filter_offset(const struct film_filter *filter, float centre, float lo, float hi,
                         float u) {
    float r = filter->film->radius;
    if (centre - r < lo || centre + r >= hi)
        return film_filter_sample(filter->film, centre, lo, hi, u);
    float at = u * (float)FILM_FILTER_STEPS;
    int i = (int)at;
    return lerpf(filter->inverse[i], filter->inverse[i + 1], at - (float)i);
}
