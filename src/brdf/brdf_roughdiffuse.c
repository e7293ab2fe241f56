// SPDX-License-Identifier: Apache-2.0
// Rough diffuse surfaces [Oren and Nayar 1994]: V-shaped grooves of Lambertian facets, which
// shadow, mask and light each other. As in Mitsuba 0.6 the roughness is that of Beckmann facets,
// alpha, of which the standard deviation of the slope angles is sigma = alpha / sqrt(2). With
// `fast` it is the paper's qualitative model, without interreflection. With theta the larger and
// beta the smaller of the angles of both directions to the normal, and phi the angle between their
// azimuths:
//   f = diffuse / pi (C1 + t S + diffuse C4 (1 - cos phi (2 beta / pi)^2)),
// where C1, t and C4 depend on sigma alone and S on the directions alone (directional_term).
//
// Deviation: where the fit of the full model is negative (down to -.005 sr^-1, for alpha over 3),
// it is 0. White surfaces of alpha below .15 reflect up to 1.0003 of uniform light, and towards
// grazing directions up to 1.03 of it, with alpha .5 up to 1.05, as the published fit does.
#include "base/sampling.h"
#include "brdf/brdf_models.h"
#include "brdf/brdf_quadrature.h"

enum { MEAN_NODES = 129, MEAN_RULE = 24 };

// Means of S over uniform light from all sides, at equal distances of the angle of wo to the
// normal: interpolated with an error below 5e-5.
struct groove_means {
    float node[MEAN_NODES];
};

// The factors that depend on the roughness.
struct groove_factors {
    float single, directional, twice;  // C1, t, C4
};

static struct groove_factors groove_factors_of(const struct brdf *b) {
    const float s2 = 0.5f * sqrf(b->alpha_u);
    return (struct groove_factors){1.0f - 0.5f * s2 / (s2 + 0.33f), s2 / (s2 + 0.09f),
                                   b->fast ? 0.0f : 0.17f * s2 / (s2 + 0.13f)};
}

// Two directions: the sines and cosines of theta and beta, these in units of pi / 2, and cos(phi).
struct groove_angles {
    float sin_large, sin_small, cos_large, cos_small, large, small, cos_phi;
};

static struct groove_angles groove_angles_of(vec3 wo, vec3 wi) {
    if (wo.z < wi.z) {
        const vec3 w = wo;
        wo = wi;
        wi = w;
    }
    const float so = sqrtf(wo.x * wo.x + wo.y * wo.y), si = sqrtf(wi.x * wi.x + wi.y * wi.y);
    const float both = so * si, along = wo.x * wi.x + wo.y * wi.y;
    return (struct groove_angles){
        .sin_large = si,
        .sin_small = so,
        .cos_large = wi.z,
        .cos_small = wo.z,
        .large = atan2f(si, wi.z) * (2.0f / PI_F),
        .small = atan2f(so, wo.z) * (2.0f / PI_F),
        .cos_phi = both > 0.0f ? clampf(along / both, -1.0f, 1.0f) : 0.0f};
}

// S, with C2 = .45 t (...) and C3 = .125 t (...)^2 of the paper.
static float directional_term(struct groove_angles a, bool fast) {
    const float tan_small = a.sin_small / a.cos_small;
    if (fast) return 0.45f * maxf(a.cos_phi, 0.0f) * a.sin_large * tan_small;
    const float away = a.cos_phi < 0.0f ? a.small * a.small * a.small : 0.0f;
    const float tan_half = (a.sin_large + a.sin_small) / (a.cos_large + a.cos_small);
    return 0.45f * a.cos_phi * (a.sin_large - away) * tan_small +
           0.125f * (1.0f - fabsf(a.cos_phi)) * sqrf(a.large * a.small) * tan_half;
}

static void roughdiffuse_eval(const struct brdf *b, vec3 wo, vec3 wi, rgb *diffuse, rgb *glossy) {
    const struct groove_factors f = groove_factors_of(b);
    const struct groove_angles a = groove_angles_of(wo, wi);
    const float once = f.single + f.directional * directional_term(a, b->fast);
    const float twice = f.twice * (1.0f - a.cos_phi * a.small * a.small);
    const rgb sum = rgb_mad(rgb_grey(once), b->diffuse, twice);
    const rgb least = rgb_make(maxf(sum.r, 0.0f), maxf(sum.g, 0.0f), maxf(sum.b, 0.0f));
    *diffuse = rgb_scale(rgb_mul(b->diffuse, least), 1.0f / PI_F);
    *glossy = rgb_grey(0.0f);
}

// The mean of S over the azimuth: that of max(cos phi, 0) is 1 / pi, of |cos phi| 2 / pi.
static double azimuth_mean(double theta_o, double theta_i, bool fast) {
    const double large = fmax(theta_o, theta_i), small = fmin(theta_o, theta_i);
    if (fast) return 0.45 * M_1_PI * sin(large) * tan(small);
    const double away = pow(small * M_2_PI, 3.0), both = large * small * M_2_PI * M_2_PI;
    return 0.45 * M_1_PI * away * tan(small) +
           0.125 * (1.0 - M_2_PI) * both * both * tan(0.5 * (large + small));
}

// The integral of azimuth_mean times 2 cos sin over the angles of wi, which has a kink at that of
// wo.
static double groove_light_mean(double theta_o, bool fast, const struct quadrature *rule) {
    const double end[3] = {0.0, theta_o, 0.5 * M_PI};
    double sum = 0.0;
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < rule->count; i++) {
            const double theta = end[k] + (end[k + 1] - end[k]) * rule->x[i];
            sum += (end[k + 1] - end[k]) * rule->weight[i] * sin(2.0 * theta) *
                   azimuth_mean(theta_o, theta, fast);
        }
    return sum;
}

static satin_status roughdiffuse_prepare(struct brdf *b, struct arena *arena) {
    struct groove_means *means = arena_alloc(arena, sizeof *means);
    struct quadrature rule;
    if (!means) return SATIN_ERROR_MEMORY;
    brdf_quadrature_gauss(&rule, MEAN_RULE);
    for (int i = 0; i < MEAN_NODES; i++)
        means->node[i] =
            (float)groove_light_mean(0.5 * M_PI * i / (MEAN_NODES - 1), b->fast, &rule);
    b->tables = means;
    return SATIN_OK;
}

static rgb roughdiffuse_albedo(const struct brdf *b, vec3 wo) {
    const struct groove_means *means = b->tables;
    const struct groove_factors f = groove_factors_of(b);
    const float angle = atan2f(sqrtf(wo.x * wo.x + wo.y * wo.y), wo.z);
    const float x = angle * (2.0f / PI_F) * (float)(MEAN_NODES - 1);
    const int i = x < (float)(MEAN_NODES - 2) ? (int)x : MEAN_NODES - 2;
    const float mean = lerpf(means->node[i], means->node[i + 1], x - (float)i);
    const float once = f.single + f.directional * mean;
    return rgb_mul(b->diffuse, rgb_mad(rgb_grey(once), b->diffuse, f.twice));
}

const struct brdf_model brdf_model_roughdiffuse = {
    .name = "roughdiffuse",
    .doc = "rough diffuse surface: grooves of Lambertian facets",
    .lobes = BRDF_DIFFUSE,
    .slots = 1u << BRDF_SLOT_DIFFUSE | 1u << BRDF_SLOT_ALPHA_U,
    .prepare = roughdiffuse_prepare,
    .eval = roughdiffuse_eval,
    .pdf = brdf_diffuse_pdf,
    .diffuse_albedo = roughdiffuse_albedo,
};
