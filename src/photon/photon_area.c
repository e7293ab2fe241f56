// SPDX-License-Identifier: Apache-2.0
// The area of the surface inside the disc of a density estimate. An estimate divides the photons in
// a disc by its area, but the disc may extend beyond an edge or into a wall. Here the disc is cut
// to the surface of the same orientation that is visible from just above its centre. In each of
// several directions, a ray along the surface finds a wall, and a ray downwards finds the end of
// the surface. Extents are interpolated in their inverse, which is exact for a straight wall. A
// photon counts only inside the cut disc, so the area and the photons agree even if the outline is
// approximate, and photons behind a thin wall do not leak.
#include "base/sampling.h"
#include "photon/photon_map.h"

// In units of the disc's radius r.
#define DEPTH 0.35f           // how far the surface may curve below the tangent plane
#define EXTENT_MIN .02f       // limits 1 / extent
#define CLEARING 2.5f         // radius of a clearing
#define CLEARING_LEAST 0.15f  // the least disc in a clearing, as a fraction of its radius
#define CLEARING_FACING 0.9f  // least cosine between the normals of its discs and its own
#define SECTOR (2.0f * PI_F / AREA_SECTORS)
enum { BISECTIONS = 5, AREA_STEPS = 4 };

struct raised_disc {
    const struct satin_scene *scene;
    vec3 origin, n;  // origin is above the centre
    float height, r;
};

static float clear_distance(const struct satin_scene *scene, vec3 o, vec3 d, float most) {
    struct ray ray = {o, 0.0f, d, most};
    return fminf(scene_distance(scene, &ray), most);
}

// Whether the surface below the point `t` along w continues that at the centre, with the same
// orientation and without an edge higher than `most`. The chord of a surface of constant curvature
// has half the slope of its end.
static bool surface_continues(const struct raised_disc *disc, vec3 w, float t, float most) {
    vec3 p, ng;
    const vec3 above = v3_mad(disc->origin, t, w);
    if (!photon_surface_below(disc->scene, above, disc->n, disc->height + DEPTH * disc->r, &p, &ng))
        return false;
    const float facing = v3_dot(ng, disc->n);
    if (!(facing > PHOTON_FACING)) return false;
    const float height = v3_dot(v3_sub(p, disc->origin), disc->n) + disc->height,
                curved = -0.5f * t * v3_dot(ng, w) / facing;
    return fabsf(height - curved) <= most;
}

// How far the surface extends along w, in units of r; beyond 1 it is the distance to a wall. It is
// looked for at so many points, of which gaps that lie between two are not found.
static float extent(const struct raised_disc *disc, vec3 w, int points) {
    float wall = clear_distance(disc->scene, disc->origin, w, 1.5f * disc->r);
    // A little before the wall or the disc's boundary, so that the ray downwards does not hit the
    // wall itself.
    float hi = 0.98f * fminf(wall, disc->r), lo = 0.0f;
    int gap = 1;
    while (gap <= points && surface_continues(disc, w, hi * (float)gap / (float)points, INFINITY))
        gap++;
    if (gap > points) return wall / disc->r;
    lo = hi * (float)(gap - 1) / (float)points;
    hi *= (float)gap / (float)points;
    for (int i = 0; i < BISECTIONS; i++) {
        float middle = 0.5f * (lo + hi);
        if (surface_continues(disc, w, middle, INFINITY))
            lo = middle;
        else
            hi = middle;
    }
    return 0.5f * (lo + hi) / disc->r;
}

static struct raised_disc raised_disc_make(const struct satin_scene *scene, vec3 p, vec3 n,
                                           float r) {
    struct ray up = scene_spawn(scene, p, n, n);
    // In a gap lower than that, rays are at half its height.
    float height = PHOTON_SURFACE_HEIGHT * r,
          clearance = clear_distance(scene, up.o, n, 2.0f * height);
    if (clearance < 2.0f * height) height = 0.5f * clearance;
    return (struct raised_disc){scene, v3_mad(up.o, height, n), n, height, r};
}

float photon_area_rotation(vec3 p) {
    union {
        float f[3];
        uint32_t u[3];
    } bits = {{p.x, p.y, p.z}};
    const uint64_t key = rng_mix(bits.u[0] ^ rng_mix((uint64_t)bits.u[1] << 32 | bits.u[2]));
    return (float)(rng_mix(key) >> 40) * 0x1p-24f * SECTOR;
}

void photon_area_make(const struct satin_scene *scene, vec3 p, vec3 n, float r, int points,
                      struct photon_area *out) {
    out->frame = frame_from_normal(n);
    out->rotation = photon_area_rotation(p);
    out->whole_disc = true;
    struct raised_disc disc = raised_disc_make(scene, p, n, r);
    out->height = disc.height;
    for (int i = 0; i < AREA_SECTORS; i++) {
        float phi = out->rotation + (float)i * SECTOR;
        vec3 w = frame_to_world(&out->frame, v3(cosf(phi), sinf(phi), 0.0f));
        float e = extent(&disc, w, points);
        out->inverse[i] = 1.0f / fmaxf(e, EXTENT_MIN);
        if (e < 1.0f) out->whole_disc = false;
    }
}

bool photon_area_hides(const struct satin_scene *scene, const struct photon_area *area, vec3 p,
                       vec3 q) {
    const vec3 n = area->frame.n, d = v3_sub(q, p), along = v3_mad(d, -v3_dot(d, n), n);
    const float length = v3_len(along);
    if (!(length > 0.0f)) return false;
    struct ray ray = scene_spawn(scene, p, n, n);
    ray.o = v3_mad(ray.o, area->height, n);
    ray.d = v3_mul(along, 1.0f / length);
    ray.tfar = length;
    return scene_occluded(scene, &ray);
}

bool photon_area_clear(const struct satin_scene *scene, vec3 p, vec3 n, float r, float smallest) {
    struct frame frame = frame_from_normal(n);
    struct raised_disc disc = raised_disc_make(scene, p, n, r);
    for (int i = 0; i < AREA_SECTORS; i++) {
        // Directions far apart first, so that an edge is found soon.
        float phi = (float)(i * 7 % AREA_SECTORS) * SECTOR;
        vec3 w = frame_to_world(&frame, v3(cosf(phi), sinf(phi), 0.0f));
        if (clear_distance(scene, disc.origin, w, r) < r ||
            !surface_continues(&disc, w, 0.98f * r, smallest * DEPTH * r))
            return false;
    }
    return true;
}

struct photon_clearing photon_clearing_find(const struct satin_scene *scene, vec3 p, vec3 n,
                                            float r) {
    const float radius = CLEARING * r;
    const bool clear = radius > 0.0f && photon_area_clear(scene, p, n, radius, CLEARING_LEAST);
    return (struct photon_clearing){p, n, clear ? radius : 0.0f, CLEARING_LEAST * radius};
}

bool photon_clearing_has(const struct photon_clearing *clearing, vec3 p, vec3 n, float r) {
    return r >= clearing->smallest && r <= clearing->radius - sqrtf(v3_dist2(p, clearing->p)) &&
           v3_dot(n, clearing->n) > CLEARING_FACING;
}

bool photon_surface_below(const struct satin_scene *scene, vec3 above, vec3 n, float depth, vec3 *p,
                          vec3 *ng) {
    const struct ray down = {above, 0.0f, v3_neg(n), depth};
    if (!scene_surface(scene, &down, p, ng)) return false;
    if (v3_dot(*ng, n) < 0.0f) *ng = v3_neg(*ng);
    return true;
}

// 1 / extent at a real number `sector` in [0, AREA_SECTORS].
static float inverse_extent(const struct photon_area *area, float sector) {
    int i = (int)sector;
    float f = sector - (float)i;
    return lerpf(area->inverse[i % AREA_SECTORS], area->inverse[(i + 1) % AREA_SECTORS], f);
}

float photon_area_sector(float x, float y, float rotation) {
    float sector = (atan2f(y, x) - rotation) * (1.0f / SECTOR);
    if (sector < 0.0f) sector += AREA_SECTORS;
    if (sector < 0.0f) sector += AREA_SECTORS;
    return fminf(sector, (float)AREA_SECTORS);
}

bool photon_area_has(const struct photon_area *area, vec3 d, float r) {
    float x = v3_dot(d, area->frame.u), y = v3_dot(d, area->frame.v);
    float inverse = inverse_extent(area, photon_area_sector(x, y, area->rotation));
    return (x * x + y * y) * inverse * inverse <= r * r;
}

float photon_area_inverse(const struct photon_area *area) {
    float inverse = 1.0f;
    for (int i = 0; i < AREA_SECTORS; i++) inverse = fmaxf(inverse, area->inverse[i]);
    return inverse;
}

// The extent at the middle of step i of AREA_SECTORS * AREA_STEPS, at most 1.
static float extent_at_step(const struct photon_area *area, int i) {
    return fminf(1.0f / inverse_extent(area, ((float)i + 0.5f) / AREA_STEPS), 1.0f);
}

vec2 photon_area_centroid(const struct photon_area *area) {
    float x = 0.0f, y = 0.0f, sum = 0.0f;
    for (int i = 0; i < AREA_SECTORS * AREA_STEPS; i++) {
        const float e = extent_at_step(area, i);
        const float phi = area->rotation + ((float)i + 0.5f) / AREA_STEPS * SECTOR;
        // Twice the integrals of t^2 and t from 0 to e.
        x += cosf(phi) * (2.0f / 3.0f) * e * e * e;
        y += sinf(phi) * (2.0f / 3.0f) * e * e * e;
        sum += e * e;
    }
    return (vec2){x / sum, y / sum};
}

float photon_area_fraction(const struct photon_area *area, enum photon_kernel kernel) {
    if (area->whole_disc) return 1.0f;
    float sum = 0.0f;
    for (int i = 0; i < AREA_SECTORS * AREA_STEPS; i++) {
        const float e = extent_at_step(area, i), q = e * e;
        // The integral of weight(t^2) 2 t from 0 to e.
        sum += kernel == KERNEL_FLAT ? q : q * (2.0f - q);
    }
    return sum / (AREA_SECTORS * AREA_STEPS);
}
