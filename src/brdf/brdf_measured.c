// SPDX-License-Identifier: Apache-2.0
// Measured BRDFs: values in a grid, by half and difference angles as in the MERL database [Matusik
// et al. 2003], or by the angles of both directions, with linear interpolation.
//
// A grid is not separated into lobes. The part of it that is equal in all directions, the least
// value away from grazing directions, counts as diffuse, the rest as glossy. The glossy lobe is
// sampled by half vectors, whose distribution is tabulated from mirrored pairs, and by a fraction
// of cosine-distributed directions for the light that this misses.
#include <string.h>

#include "base/sampling.h"
#include "brdf/brdf_models.h"

enum { THETA = 64, PHI = 16, ALBEDO = 33, PAIRS = 5 };

#define COSINE_FRACTION 0.2f  // fraction of the samples

struct measured {
    struct brdf_grid grid;
    rgb least;           // least value of f [sr^-1]
    rgb albedo[ALBEDO];  // of the diffuse lobe, by the cosine
    float cdf[THETA * PHI + 1];
};

// ---- Values -------------------------------------------------------------------------------------

// The position x among n ascending nodes at equal distances, from `first` by `step`. It is periodic
// if `period` nodes are a full circle; otherwise it is clamped.
struct grid_position {
    int i[2];
    float f;
};

static struct grid_position position_even(float x, int n, bool wraps) {
    float i = floorf(x), f = x - i;
    int lo = (int)i;
    if (wraps) return (struct grid_position){{((lo % n) + n) % n, (((lo + 1) % n) + n) % n}, f};
    if (lo < 0) return (struct grid_position){{0, 0}, 0.0f};
    if (lo >= n - 1) return (struct grid_position){{n - 1, n - 1}, 0.0f};
    return (struct grid_position){{lo, lo + 1}, f};
}

// The position of x among nodes at[0 .. n - 1]; `period` may be 0.
static struct grid_position position_among(float x, const float *at, int n, float period) {
    if (n == 1) return (struct grid_position){{0, 0}, 0.0f};
    if (period > 0.0f) x = at[0] + (x - at[0]) - period * floorf((x - at[0]) / period);
    if (x >= at[n - 1]) {
        if (!(period > 0.0f)) return (struct grid_position){{n - 1, n - 1}, 0.0f};
        float gap = at[0] + period - at[n - 1];
        return (struct grid_position){{n - 1, 0}, gap > 0.0f ? (x - at[n - 1]) / gap : 0.0f};
    }
    int lo = 0, hi = n - 1;
    while (hi - lo > 1) {
        int mid = (lo + hi) / 2;
        if (at[mid] <= x)
            lo = mid;
        else
            hi = mid;
    }
    return (struct grid_position){{lo, hi}, clampf((x - at[lo]) / (at[hi] - at[lo]), 0.0f, 1.0f)};
}

static rgb grid_value(const struct brdf_grid *g, size_t i) {
    const float *v = g->value + i * (size_t)g->channels;
    return g->channels == 1 ? rgb_grey(v[0]) : rgb_make(v[0], v[1], v[2]);
}

// The interpolated value of a cell in `dimensions` coordinates, of which the last varies fastest.
static rgb blend(const struct brdf_grid *g, const struct grid_position *at, int dimensions) {
    rgb sum = rgb_grey(0.0f);
    for (int corner = 0; corner < 1 << dimensions; corner++) {
        float weight = 1.0f;
        size_t i = 0;
        for (int d = 0; d < dimensions; d++) {
            int end = corner >> d & 1;
            weight *= end ? at[d].f : 1.0f - at[d].f;
            i = i * (size_t)g->size[d] + (size_t)at[d].i[end];
        }
        if (weight > 0.0f) sum = rgb_mad(sum, grid_value(g, i), weight);
    }
    return sum;
}

static rgb value_half(const struct brdf_grid *g, vec3 wo, vec3 wi) {
    vec3 h = v3_unit(v3_add(wo, wi));
    float theta_h = acosf(minf(h.z, 1.0f)), theta_d = acosf(clampf(v3_dot(h, wo), 0.0f, 1.0f));
    // The azimuth of wi about h, from the plane of h and the normal; it is the same for wi and wo.
    float s = sqrtf(h.x * h.x + h.y * h.y), phi = 0.0f;
    if (s > 1e-6f) {
        float c = h.x / s, d = h.y / s;
        vec3 e = v3(c * h.z, d * h.z, -s), side = v3(-d, c, 0.0f);
        phi = atan2f(v3_dot(wi, side), v3_dot(wi, e));
        if (phi < 0.0f) phi += PI_F;
    }
    const float quarter = 0.5f * PI_F;
    const struct grid_position at[3] = {
        position_even(sqrtf(theta_h / quarter) * (float)g->size[0] - 0.5f, g->size[0], false),
        position_even(theta_d / quarter * (float)g->size[1] - 0.5f, g->size[1], false),
        position_even(phi / PI_F * (float)g->size[2] - 0.5f, g->size[2], true)};
    return blend(g, at, 3);
}

static rgb value_one_direction(const struct brdf_grid *g, vec3 wo, vec3 wi) {
    float theta_o = acosf(minf(wo.z, 1.0f)), theta_i = acosf(minf(wi.z, 1.0f));
    float phi_o = atan2f(wo.y, wo.x), phi = atan2f(wi.y, wi.x) - phi_o;
    const bool isotropic = g->size[1] == 1;
    if (isotropic) phi = fabsf(remainderf(phi, 2.0f * PI_F));
    const struct grid_position at[4] = {
        position_among(theta_o, g->at[0], g->size[0], 0.0f),
        position_among(phi_o, g->at[1], g->size[1], 2.0f * PI_F),
        position_among(theta_i, g->at[2], g->size[2], 0.0f),
        position_among(phi, g->at[3], g->size[3], isotropic ? 0.0f : 2.0f * PI_F)};
    return blend(g, at, 4);
}

// The mean of both directions of light, so that it is reciprocal for any data.
static rgb value(const struct measured *m, vec3 wo, vec3 wi) {
    if (m->grid.kind == BRDF_GRID_HALF) return value_half(&m->grid, wo, wi);
    return rgb_scale(
        rgb_add(value_one_direction(&m->grid, wo, wi), value_one_direction(&m->grid, wi, wo)),
        0.5f);
}

static rgb diffuse_component(const struct measured *m, rgb f) {
    return rgb_make(minf(f.r, m->least.r), minf(f.g, m->least.g), minf(f.b, m->least.b));
}

// ---- What is derived ----------------------------------------------------------------------------

static vec3 direction_of_angles(float theta, float phi) {
    return v3(sinf(theta) * cosf(phi), sinf(theta) * sinf(phi), cosf(theta));
}

// The least value where both angles are below 60 degrees.
static rgb find_least(const struct measured *m) {
    rgb least = rgb_grey(INFINITY);
    for (uint32_t i = 0; i < 4096; i++) {
        float u[4];
        sample_sobol4(i, 5, u);
        vec3 wo = sample_uniform_cone(u[0], u[1], 0.5f), wi = sample_uniform_cone(u[2], u[3], 0.5f);
        rgb f = value(m, wo, wi);
        least = rgb_make(minf(f.r, least.r), minf(f.g, least.g), minf(f.b, least.b));
    }
    return least;
}

static float theta_boundary(int i) { return 0.5f * PI_F * sqrf((float)i / THETA); }

// The brightness of facets in a cell of half vectors: the mean over pairs that they mirror, without
// the diffuse lobe.
static float cell_weight(const struct measured *m, int i, int j) {
    float theta = 0.5f * (theta_boundary(i) + theta_boundary(i + 1));
    float phi = 2.0f * PI_F * ((float)j + 0.5f) / PHI, sum = 0.0f;
    vec3 h = direction_of_angles(theta, phi);
    for (int k = 0; k < PAIRS; k++) {
        // At 0 to 64 degrees from h, with different azimuths.
        float tilt = 0.28f * (float)k, about = 2.4f * (float)k + phi;
        vec3 u = v3_unit(v3_cross(fabsf(h.z) > 0.9f ? v3(1, 0, 0) : v3(0, 0, 1), h));
        vec3 v = v3_cross(h, u);
        vec3 side = v3_mad(v3_mul(u, cosf(about)), sinf(about), v);
        vec3 wo = v3_mad(v3_mul(h, cosf(tilt)), sinf(tilt), side);
        vec3 wi = v3_mad(v3_mul(h, cosf(tilt)), -sinf(tilt), side);
        if (!(wo.z > 0.02f && wi.z > 0.02f)) continue;
        rgb f = value(m, wo, wi);
        sum += rgb_mean(rgb_sub(f, diffuse_component(m, f))) * cosf(tilt);
    }
    // Times the solid angle of the cell and the cosine, for the normalisation of D.
    return sum * (cosf(theta_boundary(i)) - cosf(theta_boundary(i + 1))) * h.z;
}

static void find_albedo(struct measured *m) {
    enum { MEASURED_POINTS = 512 };
    for (int i = 0; i < ALBEDO; i++) {
        float z = maxf((float)i / (ALBEDO - 1), 1e-3f);
        vec3 wo = v3(safe_sqrtf(1.0f - z * z), 0.0f, z);
        m->albedo[i] = rgb_grey(0.0f);
        for (uint32_t k = 0; k < MEASURED_POINTS; k++) {
            vec2 u = sample_sobol2(k, 6);
            vec3 wi = sample_cosine_hemisphere(u.x, u.y);
            m->albedo[i] = rgb_mad(m->albedo[i], diffuse_component(m, value(m, wo, wi)),
                                   PI_F / MEASURED_POINTS);
        }
    }
}

satin_status brdf_measured_set(struct brdf *b, struct arena *arena, const struct brdf_grid *grid) {
    struct measured *m = arena_alloc(arena, sizeof *m);
    if (!m) return SATIN_ERROR_MEMORY;
    m->grid = *grid;
    m->least = find_least(m);
    float weight[THETA * PHI];
    for (int i = 0; i < THETA; i++)
        for (int j = 0; j < PHI; j++) weight[i * PHI + j] = cell_weight(m, i, j);
    sample_cdf_build(weight, THETA * PHI, m->cdf);
    find_albedo(m);
    b->tables = m;
    b->diffuse = rgb_scale(m->least, PI_F);
    b->specular = rgb_grey(1.0f);
    b->isotropic = grid->kind == BRDF_GRID_HALF || grid->size[1] == 1;
    b->asymmetric = !b->isotropic;
    return SATIN_OK;
}

// ---- The model ----------------------------------------------------------------------------------

static void measured_eval(const struct brdf *b, vec3 wo, vec3 wi, rgb *diffuse, rgb *glossy) {
    const struct measured *m = b->tables;
    rgb f = value(m, wo, wi);
    *diffuse = diffuse_component(m, f);
    *glossy = rgb_mul(rgb_sub(f, *diffuse), b->specular);
}

// The density of the half vector over solid angle.
static float half_density(const struct measured *m, vec3 h) {
    float theta = acosf(minf(h.z, 1.0f));
    int i = (int)(sqrtf(theta * (2.0f / PI_F)) * THETA);
    int j = (int)(azimuth_fraction(h.y, h.x) * PHI);
    i = i < THETA ? i : THETA - 1;
    j = j < PHI ? j : PHI - 1;
    float p = m->cdf[i * PHI + j + 1] - m->cdf[i * PHI + j];
    return p * PHI / (2.0f * PI_F * (cosf(theta_boundary(i)) - cosf(theta_boundary(i + 1))));
}

static void measured_pdf(const struct brdf *b, vec3 wo, vec3 wi, unsigned lobes, float *diffuse,
                         float *glossy) {
    (void)lobes;
    vec3 h = v3_unit(v3_add(wo, wi));
    *diffuse = wi.z * (1.0f / PI_F);
    *glossy = COSINE_FRACTION * *diffuse +
              (1.0f - COSINE_FRACTION) * half_density(b->tables, h) / (4.0f * v3_dot(wo, h));
}

static bool measured_sample(const struct brdf *b, vec3 wo, unsigned lobes, vec3 u, vec3 *wi) {
    (void)lobes;
    const struct measured *m = b->tables;
    if (u.x < COSINE_FRACTION) {
        *wi = sample_cosine_hemisphere(u.y, u.z);
        return true;
    }
    float rest;
    size_t cell = sample_cdf(m->cdf, THETA * PHI, u.y, &rest);
    int i = (int)(cell / PHI), j = (int)(cell % PHI);
    float z = lerpf(cosf(theta_boundary(i)), cosf(theta_boundary(i + 1)), rest),
          s = safe_sqrtf(1 - z * z);
    float phi = 2.0f * PI_F * sample_stratum(j, u.z, PHI);
    vec3 h = v3(s * cosf(phi), s * sinf(phi), z);
    float c = v3_dot(wo, h);
    *wi = v3_mad(v3_neg(wo), 2.0f * c, h);
    return c > 0.0f && wi->z > 0.0f;
}

static rgb measured_diffuse_albedo(const struct brdf *b, vec3 wo) {
    const struct measured *m = b->tables;
    float x = wo.z * (ALBEDO - 1);
    int i = x < ALBEDO - 2 ? (int)x : ALBEDO - 2;
    x -= (float)i;
    return rgb_mad(rgb_scale(m->albedo[i], 1.0f - x), m->albedo[i + 1], x);
}

static void measured_probabilities(const struct brdf *b, vec3 wo, float *diffuse, float *glossy,
                                   float *delta) {
    (void)wo;
    *delta = 0.0f;
    *diffuse = rgb_mean(b->diffuse);
    *glossy = maxf(1.0f - *diffuse, 0.2f) * 0.5f;
}

#define MEASURED(plugin, text)                                                                   \
    {                                                                                            \
        .name = plugin, .doc = text, .lobes = BRDF_REFLECT, .data = true, .eval = measured_eval, \
        .pdf = measured_pdf, .diffuse_albedo = measured_diffuse_albedo,                          \
        .sample_glossy = measured_sample, .probabilities = measured_probabilities                \
    }

const struct brdf_model brdf_model_merl =
    MEASURED("merl", "a measured isotropic BRDF, by half and difference angles");
const struct brdf_model brdf_model_tabulated =
    MEASURED("tabulated", "a measured BRDF, by the angles of both directions");
