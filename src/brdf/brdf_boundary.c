// SPDX-License-Identifier: Apache-2.0
// Means over the facets of a rough boundary that are visible from a direction, see brdf_boundary.h.
#include "brdf/brdf_boundary.h"

#include "base/sampling.h"
#include "brdf/brdf_fresnel.h"

enum {
    OUTSIDE_NODES = 32,  // per dimension, where the reflectance is smooth
    INSIDE_NODES = 64    // where total reflection begins
};

// The rough boundary, for means over the visible facets.
struct boundary_side {
    struct microfacet facets;
    vec3 wo;
    float eta;  // IOR of the other side over that of this one
};

// The fraction of light that a facet of normal n reflects and that is not masked.
static float facet_reflects(const void *ctx, vec3 n) {
    const struct boundary_side *b = ctx;
    float c = v3_dot(b->wo, n);
    vec3 wi = v3_mad(v3_neg(b->wo), 2.0f * c, n);
    if (wi.z <= 0.0f) return 0.0f;
    return brdf_fresnel_dielectric(c, b->eta, NULL) * brdf_microfacet_g1(b->facets, wi);
}

// The fraction that the facet transmits and that is not masked on the other side.
static float facet_transmits(const void *ctx, vec3 n) {
    const struct boundary_side *b = ctx;
    float cos_t, c = v3_dot(b->wo, n), f = brdf_fresnel_dielectric(c, b->eta, &cos_t);
    // The direction of the transmitted light, reversed.
    vec3 inward = v3_mad(v3_mul(b->wo, 1.0f / b->eta), -(c / b->eta + cos_t), n);
    if (inward.z <= 0.0f) return 0.0f;
    return (1.0f - f) * brdf_microfacet_g1(b->facets, inward);
}

static struct boundary_side boundary_at(struct microfacet m, float cosine, float eta) {
    return (struct boundary_side){m, v3(safe_sqrtf(1.0f - cosine * cosine), 0.0f, cosine), eta};
}

// The cosine of a node of the table, which is not 0.
static float node_cosine(int i) { return maxf((float)i / (float)(BOUNDARY_SIZE - 1), 1e-6f); }

void brdf_boundary_build(struct microfacet facets, float ior, struct boundary_table *out) {
    struct quadrature rule;
    brdf_quadrature_gauss(&rule, OUTSIDE_NODES);
    for (int i = 0; i < BOUNDARY_SIZE; i++) {
        const float mu = node_cosine(i);
        const struct boundary_side side = boundary_at(facets, mu, ior);
        out->transmittance[i] =
            (float)brdf_microfacet_visible_mean(facets, mu, &rule, facet_transmits, &side);
    }
}

float brdf_boundary_enters(const struct boundary_table *table) {
    struct quadrature rule;
    double enters = 0.0;
    brdf_quadrature_gauss(&rule, OUTSIDE_NODES);
    for (int i = 0; i < OUTSIDE_NODES; i++)
        enters += rule.weight[i] * rule.x[i] *
                  (double)brdf_boundary_transmittance(table, (float)rule.x[i]);
    return (float)(2.0 * enters);
}

float brdf_boundary_inside(struct microfacet facets, float ior) {
    struct quadrature rule;
    double inside = 0.0;
    brdf_quadrature_gauss(&rule, INSIDE_NODES);
    for (int i = 0; i < BOUNDARY_SIZE; i++) {
        const float mu = node_cosine(i);
        const struct boundary_side side = boundary_at(facets, mu, 1.0f / ior);
        inside +=
            (double)mu * brdf_microfacet_visible_mean(facets, mu, &rule, facet_reflects, &side);
    }
    return (float)(2.0 * inside / BOUNDARY_SIZE);
}
