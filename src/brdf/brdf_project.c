// SPDX-License-Identifier: Apache-2.0
// Quadrature of f_r cos(theta_i) times the harmonics [K05 (2.7)]. A fixed grid over the hemisphere
// misses narrow lobes (128 x 128 midpoints have an error of 1 % at normal incidence), so the rule
// is polar around the mirror direction: every azimuth goes from there to the horizon, where the
// integrand ends, in panels that become shorter towards the lobe's peak. The integrand is smooth on
// each panel and periodic in the azimuth, so Gauss' rule and equidistant azimuths converge fast.
// Two sets of azimuths, one between the other, show whether their mean is accurate enough. If not,
// it is averaged with that of the azimuths between both.
#include "brdf/brdf_project.h"

#include <string.h>

// The largest distance of the results of two sets of azimuths whose mean is accurate enough,
// relative to the lobe's norm. The error falls exponentially with their number, so that of the mean
// is far smaller: for 20 lobes it is that of all azimuths. With .01, Phong's lobe of exponent 1.6
// has an error of 8e-4 at grazing angles.
static const double AGREE = 1e-3;

void brdf_project_rule_make(struct project_rule *rule) {
    struct quadrature gauss;
    brdf_quadrature_gauss(&gauss, PROJECT_NODES);
    for (int p = 0, k = 0; p < PROJECT_PANELS; p++) {
        double hi = ldexp(1.0, p + 1 - PROJECT_PANELS), lo = p ? 0.5 * hi : 0.0;
        for (int i = 0; i < PROJECT_NODES; i++, k++) {
            rule->x[k] = (float)(lo + (hi - lo) * gauss.x[i]);
            rule->weight[k] = (float)((hi - lo) * gauss.weight[i]);
        }
    }
}

// The mirror direction r and its tangents: `up` is towards the normal, `side` is horizontal.
struct mirror_symmetry {
    vec3 r, up, side;
};

static struct mirror_symmetry mirror_of(vec3 wo) {
    float s = sqrtf(wo.x * wo.x + wo.y * wo.y);
    float cos_phi = s > 0.0f ? wo.x / s : 1.0f, sin_phi = s > 0.0f ? wo.y / s : 0.0f;
    return (struct mirror_symmetry){v3(-wo.x, -wo.y, wo.z), v3(cos_phi * wo.z, sin_phi * wo.z, s),
                                    v3(-sin_phi, cos_phi, 0.0f)};
}

// Adds the points of one azimuth. Returns their contribution to the squared norm.
static double add_azimuth(const struct brdf *b, vec3 wo, const struct mirror_symmetry *m,
                          float azimuth, float weight, const struct project_rule *rule,
                          struct project_points *points) {
    const bool colored = points->channels == 3;
    float ca = cosf(azimuth), sa = sinf(azimuth);
    // Along the azimuth z = r.z cos(psi) + up.z cos(azimuth) sin(psi), and the horizon is at z = 0.
    float horizon = atan2f(m->r.z, -m->up.z * ca);
    vec3 tangent = v3_mad(v3_mul(m->up, ca), sa, m->side);
    double norm = 0.0;
    for (int i = 0; i < PROJECT_PANELS * PROJECT_NODES; i++) {
        float psi = horizon * rule->x[i], s = sinf(psi);
        vec3 wi = v3_mad(v3_mul(m->r, cosf(psi)), s, tangent);
        wi.z = maxf(wi.z, 1e-7f);
        rgb diffuse, f;
        b->model->eval(b, wo, wi, &diffuse, &f);
        f = rgb_scale(f, wi.z);
        float w = weight * horizon * rule->weight[i] * s;
        size_t k = points->count++;
        points->x[k] = wi.x, points->y[k] = wi.y, points->z[k] = wi.z;
        points->value[0][k] = w * f.r, points->value[1][k] = w * f.g, points->value[2][k] = w * f.b;
        norm += (double)w * (f.r * f.r + (colored ? f.g * f.g + f.b * f.b : 0.0f));
    }
    return norm;
}

// Directions of equal distances in azimuth: every `every`-th from `first` on, in units of PI /
// PROJECT_AZIMUTHS.
struct azimuth_set {
    int first, every;
};

// Finds the points of a set, and returns the squared norm by them alone.
static double sample_azimuths(const struct brdf *b, vec3 wo, struct azimuth_set set, bool half,
                              const struct project_rule *rule, struct project_points *points) {
    const struct mirror_symmetry m = mirror_of(wo);
    const int end = half ? PROJECT_AZIMUTHS + 1 : 2 * PROJECT_AZIMUTHS;
    double norm = 0.0;
    points->count = 0;
    for (int k = set.first; k < end; k += set.every) {
        float weight = PI_F / PROJECT_AZIMUTHS * (float)set.every;
        if (half && k > 0 && k < PROJECT_AZIMUTHS) weight *= 2.0f;
        norm += add_azimuth(b, wo, &m, PI_F * (float)k / PROJECT_AZIMUTHS, weight, rule, points);
    }
    return norm;
}

static void project_samples(const struct project_points *points, struct project_target target,
                            float *c) {
    const bool colored = target.channels == 3;
    const rsh_samples samples = {points->count,
                                 points->x,
                                 points->y,
                                 points->z,
                                 points->value[0],
                                 colored ? points->value[1] : NULL,
                                 colored ? points->value[2] : NULL};
    rsh_project(target.basis, target.order, &samples, c);
}

// Whether the results of two sets of azimuths, with their squared norms, agree.
static bool projections_agree(const float *a, const float *b, int count, const double norm[2]) {
    double sum = 0.0, mean = 0.5 * (norm[0] + norm[1]);
    for (int k = 0; k < count; k++) sum += (double)sqrf(a[k] - b[k]);
    return sum <= AGREE * AGREE * mean && fabs(norm[0] - norm[1]) <= AGREE * mean;
}

double brdf_project_glossy(const struct brdf *b, vec3 wo, struct project_target target,
                           const struct project_rule *rule, struct project_points *points,
                           float *c) {
    static const struct azimuth_set set[] = {{0, 4}, {2, 4}, {1, 2}};
    const int count = target.channels * target.order * target.order;
    float found[3][3 * RSH_MAX_COEFFICIENTS] = {0};
    double norm[3] = {0};
    int sets = 0;
    points->channels = target.channels;
    for (; sets < 3; sets++) {
        if (sets == 2 && projections_agree(found[0], found[1], count, norm)) break;
        norm[sets] = sample_azimuths(b, wo, set[sets], target.half, rule, points);
        project_samples(points, target, found[sets]);
    }
    // The third set has as many azimuths as the others together.
    const float weight = sets == 3 ? 0.25f : 0.5f, rest = sets == 3 ? 0.5f : 0.0f;
    for (int k = 0; k < count; k++)
        c[k] += weight * (found[0][k] + found[1][k]) + rest * found[2][k];
    return (double)weight * (norm[0] + norm[1]) + (double)rest * norm[2];
}
