// SPDX-License-Identifier: Apache-2.0
// Spheres, disks and cylinders: ray intersection, and the surface at a hit. scene_trace.c calls
// this during Embree's traversal. Everything is in double: the roots of a quadratic lose half their
// digits, but of 53 bits enough are left to be finer than a float position, so a ray whose origin
// was moved off the surface by some float ulp never hits it again. The parameterisation is Mitsuba
// 3's.
#include "scene/scene_quadric.h"

#include <float.h>
#include <string.h>

struct quadric_point {
    double x, y, z;
};

static struct quadric_point apply(const double m[3][4], struct quadric_point p, double w) {
    return (struct quadric_point){m[0][0] * p.x + m[0][1] * p.y + m[0][2] * p.z + m[0][3] * w,
                                  m[1][0] * p.x + m[1][1] * p.y + m[1][2] * p.z + m[1][3] * w,
                                  m[2][0] * p.x + m[2][1] * p.y + m[2][2] * p.z + m[2][3] * w};
}

static struct quadric_point to_double(vec3 v) { return (struct quadric_point){v.x, v.y, v.z}; }
static vec3 to_float(struct quadric_point p) { return v3((float)p.x, (float)p.y, (float)p.z); }

static struct quadric_point point_at_distance(struct quadric_point o, double t,
                                              struct quadric_point d) {
    return (struct quadric_point){o.x + t * d.x, o.y + t * d.y, o.z + t * d.z};
}

static double dot(struct quadric_point a, struct quadric_point b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

// The inverse of an affine map by cofactors. False if it has none.
static bool invert(const double m[3][4], double out[3][4]) {
    double c[3][3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            c[i][j] = m[i1][j1] * m[i2][j2] - m[i1][j2] * m[i2][j1];
        }
    double det = m[0][0] * c[0][0] + m[0][1] * c[0][1] + m[0][2] * c[0][2];
    if (!(fabs(det) > 0.0) || !isfinite(det)) return false;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) out[i][j] = c[j][i] / det;
        out[i][3] = -(out[i][0] * m[0][3] + out[i][1] * m[1][3] + out[i][2] * m[2][3]);
        for (int j = 0; j < 4; j++)
            if (!isfinite(out[i][j])) return false;
    }
    return true;
}

bool scene_quadric_make(const struct shape *shape, uint32_t index, struct quadric *out) {
    struct quadric q = {.kind = shape->kind, .shape = index, .flip = shape->flip_normals};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) q.to_world[i][j] = shape->to_world.m[i][j];
    if (!invert(q.to_world, q.to_object)) return false;
    if (shape->kind == SHAPE_SPHERE) {
        q.centre[0] = shape->centre.x;
        q.centre[1] = shape->centre.y;
        q.centre[2] = shape->centre.z;
        q.radius = shape->radius;
        if (!(q.radius > 0.0 && isfinite(q.radius) && v3_finite(shape->centre))) return false;
    }
    *out = q;
    return true;
}

void scene_quadric_bounds(const struct quadric *q, vec3 *lo, vec3 *hi) {
    float from[3], to[3];
    for (int i = 0; i < 3; i++) {
        const double *m = q->to_world[i];
        double middle = m[3], half = sqrt(m[0] * m[0] + m[1] * m[1]);
        if (q->kind == SHAPE_SPHERE) {
            middle = q->centre[i];
            half = q->radius;
        }
        double low = middle - half, high = middle + half;
        if (q->kind == SHAPE_CYLINDER) {
            low += fmin(m[2], 0.0);
            high += fmax(m[2], 0.0);
        }
        from[i] = nextafterf((float)low, -FLT_MAX);
        to[i] = nextafterf((float)high, FLT_MAX);
    }
    *lo = v3(from[0], from[1], from[2]);
    *hi = v3(to[0], to[1], to[2]);
}

// The real roots of a t^2 + 2 b t + c, ascending, computed around the vertex of the parabola. False
// if there are none. `rest` is c - b^2 / a, which the caller computes without cancellation.
static bool roots(double a, double b, double c, double rest, double t[2]) {
    if (!(a > 0.0) || !(rest <= 0.0)) return false;
    double s = sqrt(-rest * a), q = b < 0.0 ? -b + s : -b - s;
    t[0] = q / a;
    t[1] = q != 0.0 ? c / q : t[0];
    if (t[0] > t[1]) {
        double swap = t[0];
        t[0] = t[1];
        t[1] = swap;
    }
    return true;
}

static int crossings(const struct quadric *q, struct quadric_point o, struct quadric_point d,
                     double t[2]) {
    if (q->kind == SHAPE_SPHERE) {
        struct quadric_point m = {o.x - q->centre[0], o.y - q->centre[1], o.z - q->centre[2]};
        double a = dot(d, d), b = dot(m, d), r2 = q->radius * q->radius;
        struct quadric_point nearest = point_at_distance(m, -b / a, d);
        return roots(a, b, dot(m, m) - r2, dot(nearest, nearest) - r2, t) ? 2 : 0;
    }
    o = apply(q->to_object, o, 1.0);
    d = apply(q->to_object, d, 0.0);
    if (q->kind == SHAPE_DISK) {
        t[0] = -o.z / d.z;
        struct quadric_point p = point_at_distance(o, t[0], d);
        return p.x * p.x + p.y * p.y <= 1.0 ? 1 : 0;  // false for a ray in the plane, where p is
                                                      // NaN
    }
    double a = d.x * d.x + d.y * d.y, b = o.x * d.x + o.y * d.y;
    double x = o.x - b / a * d.x, y = o.y - b / a * d.y, both[2];
    if (!roots(a, b, o.x * o.x + o.y * o.y - 1.0, x * x + y * y - 1.0, both)) return 0;
    int n = 0;
    for (int i = 0; i < 2; i++) {
        double z = o.z + both[i] * d.z;
        if (z >= 0.0 && z <= 1.0) t[n++] = both[i];
    }
    return n;
}

bool scene_quadric_intersect(const struct quadric *q, vec3 o, vec3 d, float tnear, float tfar,
                             float *t) {
    double at[2];
    int n = crossings(q, to_double(o), to_double(d), at);
    for (int i = 0; i < n; i++)
        if (at[i] > tnear && at[i] < tfar) {
            *t = (float)at[i];
            return true;
        }
    return false;
}

static struct quadric_point scaled(struct quadric_point p, double s) {
    return (struct quadric_point){p.x * s, p.y * s, p.z * s};
}

// Transforms n by the transposed inverse and normalises it.
static struct quadric_point normal_to_world(const struct quadric *q, struct quadric_point n) {
    const double(*m)[4] = q->to_object;
    struct quadric_point w = {m[0][0] * n.x + m[1][0] * n.y + m[2][0] * n.z,
                              m[0][1] * n.x + m[1][1] * n.y + m[2][1] * n.z,
                              m[0][2] * n.x + m[1][2] * n.y + m[2][2] * n.z};
    return scaled(w, 1.0 / sqrt(dot(w, w)));
}

// Position, normal (on the front side: outwards or +z), uv, dp/du and dp/dv in world space.
struct quadric_surface {
    struct quadric_point p, n, du, dv;
    vec2 uv;
};

static struct quadric_surface sphere_surface(const struct quadric *q, struct quadric_point p) {
    struct quadric_point m = {p.x - q->centre[0], p.y - q->centre[1], p.z - q->centre[2]};
    struct quadric_surface s;
    s.n = scaled(m, 1.0 / sqrt(dot(m, m)));
    s.p = point_at_distance((struct quadric_point){q->centre[0], q->centre[1], q->centre[2]},
                            q->radius, s.n);
    struct quadric_point l = apply(q->to_object, s.p, 1.0);
    double r = hypot(l.x, l.y), c = r > 0.0 ? l.x / r : 1.0, d = r > 0.0 ? l.y / r : 0.0;
    s.du =
        apply(q->to_world, (struct quadric_point){-2.0 * M_PI * l.y, 2.0 * M_PI * l.x, 0.0}, 0.0);
    s.dv =
        apply(q->to_world, (struct quadric_point){M_PI * l.z * c, M_PI * l.z * d, -M_PI * r}, 0.0);
    s.uv.x = azimuth_fraction_wide(l.y, l.x);
    s.uv.y = (float)(atan2(r, l.z) / M_PI);
    return s;
}

static struct quadric_surface disk_surface(const struct quadric *q, struct quadric_point p) {
    struct quadric_point l = apply(q->to_object, p, 1.0);
    l.z = 0.0;
    double r = hypot(l.x, l.y);
    struct quadric_point axis =
        r > 0.0 ? (struct quadric_point){l.x / r, l.y / r, 0.0} : (struct quadric_point){1, 0, 0};
    struct quadric_surface s = {.p = apply(q->to_world, l, 1.0),
                                .n = normal_to_world(q, (struct quadric_point){0.0, 0.0, 1.0}),
                                .du = apply(q->to_world, axis, 0.0)};
    s.dv =
        apply(q->to_world, (struct quadric_point){-2.0 * M_PI * l.y, 2.0 * M_PI * l.x, 0.0}, 0.0);
    s.uv = (vec2){(float)r, azimuth_fraction_wide(l.y, l.x)};
    return s;
}

static struct quadric_surface cylinder_surface(const struct quadric *q, struct quadric_point p) {
    struct quadric_point l = apply(q->to_object, p, 1.0);
    double r = hypot(l.x, l.y);
    l = (struct quadric_point){l.x / r, l.y / r, fmin(fmax(l.z, 0.0), 1.0)};
    struct quadric_surface s = {
        .p = apply(q->to_world, l, 1.0),
        .n = normal_to_world(q, (struct quadric_point){l.x, l.y, 0.0}),
        .dv = apply(q->to_world, (struct quadric_point){0.0, 0.0, 1.0}, 0.0)};
    s.du =
        apply(q->to_world, (struct quadric_point){-2.0 * M_PI * l.y, 2.0 * M_PI * l.x, 0.0}, 0.0);
    s.uv = (vec2){azimuth_fraction_wide(l.y, l.x), (float)l.z};
    return s;
}

void scene_quadric_interaction(const struct quadric *q, const struct ray *ray, float t,
                               bool tangent, struct interaction *out) {
    struct quadric_point p = point_at_distance(to_double(ray->o), t, to_double(ray->d));
    struct quadric_surface s = q->kind == SHAPE_SPHERE ? sphere_surface(q, p)
                               : q->kind == SHAPE_DISK ? disk_surface(q, p)
                                                       : cylinder_surface(q, p);
    out->p = to_float(s.p);
    out->ng = to_float(q->flip ? scaled(s.n, -1.0) : s.n);
    out->uv = s.uv;
    out->frame = tangent ? frame_from_tangent(out->ng, to_float(s.du)) : frame_from_normal(out->ng);
    out->dp_du = to_float(s.du);
    out->dp_dv = to_float(s.dv);
}
