// SPDX-License-Identifier: Apache-2.0
// Importance sampling of the film's filter: the offset of a sample from the pixel's centre is drawn
// from the filter, so that every sample belongs to one pixel and has the same weight. A filter with
// negative lobes is sampled by its absolute value, and samples in the lobes have negative weight;
// the mean weight is 1.
#include "base/sampling.h"
#include "scene/scene.h"

// ---- Filters that are nowhere negative ----------------------------------------------------------

// The filter's integral from -radius to x, and below its value, both up to the same factor.
static double filter_integral(const struct scene_film *film, double x) {
    double r = (double)film->radius, sigma = (double)film->stddev;
    switch (film->filter) {
        case FILTER_TENT:
            return x < 0.0 ? 0.5 * (r + x) * (r + x) : r * r - 0.5 * (r - x) * (r - x);
        case FILTER_GAUSSIAN:
            // The Gaussian minus its value at the radius.
            return sigma * sqrt(0.5 * 3.14159265358979323846) *
                       (erf(x / (sigma * sqrt(2.0))) + erf(r / (sigma * sqrt(2.0)))) -
                   (x + r) * exp(-0.5 * r * r / (sigma * sigma));
        default:
            return x + r;
    }
}

static double filter_value(const struct scene_film *film, double x) {
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

// Keeps rounding from moving the position out of [lo, hi).
static float clamp_offset(float centre, float lo, float hi, float offset) {
    if (centre + offset >= hi) offset = nextafterf(hi, -INFINITY) - centre;
    return centre + offset < lo ? lo - centre : offset;
}

float scene_film_filter_sample(const struct scene_film *film, float centre, float lo, float hi,
                               float u) {
    double r = (double)film->radius;
    double a = fmax(-r, (double)lo - (double)centre), b = fmin(r, (double)hi - (double)centre);
    if (!(a < b)) return 0.0f;
    double from = filter_integral(film, a), to = filter_integral(film, b);
    double wanted = from + (double)u * (to - from);
    // Newton's method, with bisection where it leaves the bracket. The integral is monotonic, so
    // the bracket shrinks to a point.
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
    return clamp_offset(centre, lo, hi, (float)x);
}

// ---- Filters with negative lobes ----------------------------------------------------------------

bool scene_film_filter_has_lobes(const struct scene_film *film) {
    return film->filter == FILTER_CUBIC || film->filter == FILTER_LANCZOS;
}

// The two-parameter cubic of [Mitchell and Netravali 1988, (8)].
static double cubic(double b, double c, double x) {
    if (x >= 2.0) return 0.0;
    if (x >= 1.0)
        return ((((-b - 6.0 * c) * x + 6.0 * b + 30.0 * c) * x - 12.0 * b - 48.0 * c) * x +
                8.0 * b + 24.0 * c) /
               6.0;
    return (((12.0 - 9.0 * b - 6.0 * c) * x - 18.0 + 12.0 * b + 6.0 * c) * x * x + 6.0 - 2.0 * b) /
           6.0;
}

static double sinc(double x) { return x == 0.0 ? 1.0 : sin(M_PI * x) / (M_PI * x); }

static double lobes_value(const struct scene_film *film, double x) {
    x = fabs(x);
    if (film->filter == FILTER_CUBIC) return cubic((double)film->b, (double)film->c, x);
    return x < (double)film->radius ? sinc(x) * sinc(x / (double)film->radius) : 0.0;
}

// Tabulates the integrals of the filter and of its absolute value.
static void make_lobes(struct scene_film_filter *filter) {
    enum { FINE = 8 };  // points per step
    const double r = (double)filter->film->radius, step = 2.0 * r / FILM_FILTER_STEPS;
    double sum = 0.0, size = 0.0;
    filter->sum[0] = filter->size[0] = 0.0f;
    for (int i = 0; i < FILM_FILTER_STEPS; i++) {
        for (int k = 0; k < FINE; k++) {
            double f = lobes_value(filter->film, -r + step * (i + (k + 0.5) / FINE)) / FINE;
            sum += step * f;
            size += step * fabs(f);
        }
        filter->sum[i + 1] = (float)sum;
        filter->size[i + 1] = (float)size;
    }
}

static float table_at(const float table[FILM_FILTER_STEPS + 1], float at) {
    int i = (int)clampf(at, 0.0f, (float)(FILM_FILTER_STEPS - 1));
    return lerpf(table[i], table[i + 1], at - (float)i);
}

// The position in an ascending table at which it has a value, in steps.
static float table_find(const float table[FILM_FILTER_STEPS + 1], float value) {
    int low = 0, high = FILM_FILTER_STEPS;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (table[middle] <= value)
            low = middle;
        else
            high = middle;
    }
    float rise = table[high] - table[low];
    return (float)low + (rise > 0.0f ? clampf((value - table[low]) / rise, 0.0f, 1.0f) : 0.5f);
}

static struct scene_film_offset draw_lobes(const struct scene_film_filter *filter, float centre,
                                           float lo, float hi, float u) {
    const float r = filter->film->radius, scale = FILM_FILTER_STEPS / (2.0f * r);
    float a = clampf((lo - centre + r) * scale, 0.0f, (float)FILM_FILTER_STEPS);
    float b = clampf((hi - centre + r) * scale, 0.0f, (float)FILM_FILTER_STEPS);
    float from = table_at(filter->size, a), size = table_at(filter->size, b) - from;
    float sum = table_at(filter->sum, b) - table_at(filter->sum, a);
    if (!(sum > 0.0f)) return (struct scene_film_offset){0.0f, 1.0f};
    float offset = table_find(filter->size, from + u * size) / scale - r;
    float weight = lobes_value(filter->film, (double)offset) < 0.0 ? -size / sum : size / sum;
    return (struct scene_film_offset){clamp_offset(centre, lo, hi, offset), weight};
}

// ---- Any filter ---------------------------------------------------------------------------------

void scene_film_filter_make(const struct scene_film *film, struct scene_film_filter *out) {
    out->film = film;
    out->wide = false;
    if (scene_film_filter_has_lobes(film)) {
        make_lobes(out);
        return;
    }
    for (int i = 0; i <= FILM_FILTER_STEPS; i++)
        out->inverse[i] = scene_film_filter_sample(film, 0.0f, -INFINITY, INFINITY,
                                                   (float)i / (float)FILM_FILTER_STEPS);
    out->inverse[FILM_FILTER_STEPS + 1] = out->inverse[FILM_FILTER_STEPS];
}

void scene_film_filter_widen(struct scene_film_filter *filter) {
    const enum filter_kind kind = filter->film->filter;
    filter->wide = kind == FILTER_TENT || kind == FILTER_GAUSSIAN;
}

// Moves a uniform number towards the nearer end of [0, 1]. Its weight is the derivative.
static float draw_wide(float *u) {
    const float v = *u, end = minf(v, 1.0f - v), near = end * (0.5f + end);
    *u = v < 0.5f ? near : 1.0f - near;
    return 0.5f + 2.0f * end;
}

struct scene_film_offset scene_film_filter_offset(const struct scene_film_filter *filter,
                                                  float centre, float lo, float hi, float u) {
    if (scene_film_filter_has_lobes(filter->film)) return draw_lobes(filter, centre, lo, hi, u);
    const float r = filter->film->radius, weight = filter->wide ? draw_wide(&u) : 1.0f;
    if (centre - r < lo || centre + r >= hi)
        return (struct scene_film_offset){scene_film_filter_sample(filter->film, centre, lo, hi, u),
                                          weight};
    float at = u * (float)FILM_FILTER_STEPS;
    int i = (int)at;
    return (struct scene_film_offset){
        lerpf(filter->inverse[i], filter->inverse[i + 1], at - (float)i), weight};
}
