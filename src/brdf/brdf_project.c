// SPDX-License-Identifier: Apache-2.0
// Quadrature of f_r cos(theta_i) times the harmonics [K05 (2.7)]. A fixed grid over the hemisphere
// misses narrow lobes (128 x 128 midpoints have an error of 1 % at normal incidence), so the rule
// is polar around the mirror direction: every azimuth goes from there to the horizon, where the
// integrand ends, in panels that become shorter towards the lobe's peak. The integrand is smooth on
// each panel and periodic in the azimuth, so Gauss' rule and equidistant azimuths converge fast.
#include "brdf/brdf_project.h"

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

double brdf_project_glossy(const struct brdf *b, vec3 wo, struct project_target target,
                           const struct project_rule *rule, struct project_points *points,
                           float *c) {
    struct mirror_symmetry m = mirror_of(wo);
    int azimuths = target.half ? PROJECT_AZIMUTHS + 1 : 2 * PROJECT_AZIMUTHS;
    double norm = 0.0;
    points->count = 0;
    points->channels = target.channels;
    for (int k = 0; k < azimuths; k++) {
        float weight = PI_F / PROJECT_AZIMUTHS;
        if (target.half && k > 0 && k < PROJECT_AZIMUTHS) weight *= 2.0f;
        norm += add_azimuth(b, wo, &m, PI_F * (float)k / PROJECT_AZIMUTHS, weight, rule, points);
    }
    const bool colored = target.channels == 3;
    const rsh_samples samples = {points->count,
                                 points->x,
                                 points->y,
                                 points->z,
                                 points->value[0],
                                 colored ? points->value[1] : NULL,
                                 colored ? points->value[2] : NULL};
    rsh_project(target.basis, target.order, &samples, c);
    return norm;
}
