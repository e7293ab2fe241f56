// SPDX-License-Identifier: Apache-2.0
// The table of BRDFs that tests run over: every model at corners of its parameters.
#ifndef BRDF_CASE_H
#define BRDF_CASE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "brdf/brdf.h"

// A model at a corner of its parameters. Reflectances are white, so that `albedo` is its largest.
struct brdf_case {
    const char *model;
    enum brdf_distribution distribution;
    enum brdf_variant variant;
    bool nonlinear;
    float alpha_u, alpha_v;  // or the exponent in alpha_u
    float diffuse, specular, ior;
    float albedo;  // may not be exceeded; 0: no promise
    float weight;  // bound of the weights of each lobe alone, over sqrt(cos wo) if negative
    float width;   // of the lobe, for the rings of the test [rad]
    void (*set)(struct brdf *b);      // further numbers; may be NULL
    const struct brdf_coating *coat;  // over the BRDF; may be NULL
};

static void tinted_metal(struct brdf *b) {
    b->metallic = 0.6f, b->spec_tint = 0.5f, b->anisotropic = 0.8f;
    b->clearcoat = 1.0f, b->clearcoat_gloss = 0.3f;
}

static void cloth(struct brdf *b) {
    b->sheen = 1.0f, b->sheen_tint = 0.5f, b->flatness = 0.7f, b->clearcoat = 0.2f;
}

static void glassy(struct brdf *b) {
    b->spec_trans = 0.7f, b->metallic = 0.2f, b->clearcoat = 0.5f, b->sheen = 0.3f;
}

static void brdf_case_leaf(struct brdf *b) {
    b->diff_trans = 1.2f, b->flatness = 0.5f, b->sheen = 0.2f;
}

static void film(struct brdf *b) {
    b->spec_trans = 0.6f, b->diff_trans = 0.8f, b->spec_tint = 0.3f, b->anisotropic = 0.5f;
}

static struct arena data;  // of the models that are made from data

// The lobes are like those of the paper: a broad anisotropic one, an off-specular one and a faint
// retroreflection.
static void three_lobes(struct brdf *b) {
    const struct brdf_cosine_lobe lobe[3] = {{{-1, -.7f, 1}, 4, {.1f, .1f, .1f}},
                                             {{-.8f, -.8f, 1.05f}, 40, {.3f, .3f, .3f}},
                                             {{.6f, .6f, .6f}, 3, {.1f, .1f, .1f}}};
    assert_int_equal(brdf_lafortune_set(b, &data, lobe, 3), SATIN_OK);
}

// The values with which the grids are filled.
static struct brdf original(float alpha_v) {
    struct brdf b = {.model = brdf_find("ward"),
                     .diffuse = {.3f, .3f, .3f},
                     .specular = {.4f, .4f, .4f},
                     .alpha_u = .3f,
                     .alpha_v = alpha_v,
                     .variant = BRDF_WARD_BALANCED};
    return b;
}

static vec3 at_angles(float theta, float phi) {
    return v3(sinf(theta) * cosf(phi), sinf(theta) * sinf(phi), cosf(theta));
}

static void half_grid(struct brdf *b) {
    enum { H = 60, D = 30, P = 36 };
    struct brdf from = original(.3f);
    float *value = arena_array(&data, H * D * P, sizeof *value);
    assert_non_null(value);
    for (int i = 0; i < H * D * P; i++) {
        float h = sqrf(((float)(i / (D * P)) + .5f) / H) * 0.5f * PI_F;
        float d = ((float)(i / P % D) + .5f) / D * 0.5f * PI_F;
        float phi = ((float)(i % P) + .5f) / P * PI_F;
        vec3 n = at_angles(h, 0), e = v3(cosf(h), 0, -sinf(h)), side = v3(0, 1, 0);
        vec3 w = v3_mad(v3_mul(e, cosf(phi)), sinf(phi), side);
        vec3 wi = v3_mad(v3_mul(n, cosf(d)), sinf(d), w),
             wo = v3_mad(v3_mul(n, cosf(d)), -sinf(d), w);
        // Values continue beyond the horizon, so that interpolation beside it is right.
        wi.z = fmaxf(wi.z, .02f), wo.z = fmaxf(wo.z, .02f);
        value[i] = brdf_eval(&from, wo, wi, BRDF_ALL).g;
    }
    struct brdf_grid grid = {BRDF_GRID_HALF, 1, {H, D, P, 1}, {NULL}, value};
    assert_int_equal(brdf_measured_set(b, &data, &grid), SATIN_OK);
}

static void direction_grid(struct brdf *b) {
    enum { O = 16, Q = 24, I = 16, P = 36 };
    struct brdf from = original(.6f);
    float *value = arena_array(&data, O * Q * I * P, sizeof *value);
    float *at = arena_array(&data, O + Q + I + P, sizeof *at);
    assert_true(value && at);
    for (int i = 0; i < O; i++) at[i] = at[O + Q + i] = (float)i / (O - 1) * 1.54f;
    for (int i = 0; i < Q; i++) at[O + i] = (float)i / Q * 2.0f * PI_F;
    for (int i = 0; i < P; i++) at[O + Q + I + i] = (float)i / P * 2.0f * PI_F;
    for (int i = 0; i < O * Q * I * P; i++) {
        float phi_o = at[O + i / (I * P) % Q], phi = at[O + Q + I + i % P];
        vec3 wo = at_angles(at[i / (Q * I * P)], phi_o);
        vec3 wi = at_angles(at[O + Q + i / P % I], phi_o + phi);
        value[i] = brdf_eval(&from, wo, wi, BRDF_ALL).g;
    }
    struct brdf_grid grid = {
        BRDF_GRID_DIRECTIONS, 1, {O, Q, I, P}, {at, at + O, at + O + Q, at + O + Q + I}, value};
    assert_int_equal(brdf_measured_set(b, &data, &grid), SATIN_OK);
}

static void opaque(struct brdf *b) { b->opaque = true; }

static void simplified(struct brdf *b) { b->fast = true; }

// A thin coat is one of a lower IOR than the outside, which reflects grazing light wholly.
static const struct brdf_coating coat_clear = {.ior = 1.5f, .specular = {1, 1, 1}},
                                 coat_tinted = {.ior = 1.7f,
                                                .specular = {.5f, .5f, .5f},
                                                .depth = {.3f, .3f, .3f}},
                                 coat_rough = {.ior = 1.5f,
                                               .alpha = .2f,
                                               .distribution = BRDF_GGX,
                                               .specular = {1, 1, 1},
                                               .depth = {.1f, .1f, .1f}},
                                 coat_thin = {.ior = .8f,
                                              .alpha = .2f,
                                              .distribution = BRDF_BECKMANN,
                                              .specular = {1, 1, 1}};

// Plastics: the fits and tables of the coat err by up to 1 %. Beckmann's weights: its shadowing is
// a fit, 0.4 % above the exact one at most.
static const struct brdf_case cases[] = {
    {"diffuse", 0, 0, 0, 0, 0, 1, 0, 1.5f, 1.0f, 1.0f, 0.2f, NULL, NULL},
    {"conductor", 0, 0, 0, 0, 0, 0, 1, 1.5f, 1.0f, 1.0f, 0.2f, NULL, NULL},
    {"roughconductor", BRDF_GGX, 0, 0, .01f, .01f, 0, 1, 1.5f, 1.0f, 1.0f, 0.005f, NULL, NULL},
    {"roughconductor", BRDF_GGX, 0, 0, .1f, .1f, 0, 1, 1.5f, 1.0f, 1.0f, 0.05f, NULL, NULL},
    {"roughconductor", BRDF_GGX, 0, 0, .5f, .5f, 0, 1, 1.5f, 1.0f, 1.0f, 0.2f, NULL, NULL},
    {"roughconductor", BRDF_GGX, 0, 0, 1, 1, 0, 1, 1.5f, 1.0f, 1.0f, 0.2f, NULL, NULL},
    {"roughconductor", BRDF_GGX, 0, 0, .05f, .5f, 0, 1, 1.5f, 1.0f, 1.0f, 0.025f, NULL, NULL},
    {"roughconductor", BRDF_GGX, 0, 0, 1, .1f, 0, 1, 1.5f, 1.0f, 1.0f, 0.05f, NULL, NULL},
    {"roughconductor", BRDF_BECKMANN, 0, 0, .01f, .01f, 0, 1, 1.5f, 1.005f, 1.005f, 0.005f, NULL,
     NULL},
    {"roughconductor", BRDF_BECKMANN, 0, 0, .1f, .1f, 0, 1, 1.5f, 1.005f, 1.005f, 0.05f, NULL,
     NULL},
    {"roughconductor", BRDF_BECKMANN, 0, 0, .5f, .5f, 0, 1, 1.5f, 1.005f, 1.005f, 0.2f, NULL, NULL},
    {"roughconductor", BRDF_BECKMANN, 0, 0, 1, 1, 0, 1, 1.5f, 1.005f, 1.005f, 0.2f, NULL, NULL},
    {"roughconductor", BRDF_BECKMANN, 0, 0, .05f, .5f, 0, 1, 1.5f, 1.005f, 1.005f, 0.025f, NULL,
     NULL},
    {"roughconductor", BRDF_BECKMANN, 0, 0, 1, .1f, 0, 1, 1.5f, 1.005f, 1.005f, 0.05f, NULL, NULL},
    {"roughdielectric", BRDF_GGX, 0, 0, .02f, .02f, 0, 1, 1.5f, 1.0f, 1.0f, 0.01f, NULL, NULL},
    {"roughdielectric", BRDF_GGX, 0, 0, .3f, .3f, 0, 1, 1.5f, 1.0f, 1.0f, 0.1f, NULL, NULL},
    {"roughdielectric", BRDF_GGX, 0, 0, 1, 1, 0, 1, 2.4f, 1.0f, 1.0f, 0.2f, NULL, NULL},
    {"roughdielectric", BRDF_GGX, 0, 0, .1f, .6f, 0, 1, .7f, 1.0f, 1.0f, 0.05f, NULL, NULL},
    {"roughdielectric", BRDF_BECKMANN, 0, 0, .05f, .05f, 0, 1, 1.5f, 1.005f, 1.005f, 0.025f, NULL,
     NULL},
    {"roughdielectric", BRDF_BECKMANN, 0, 0, .5f, .2f, 0, 1, 1.33f, 1.005f, 1.005f, 0.1f, NULL,
     NULL},
    {"null", 0, 0, 0, 0, 0, 0, 0, 1.5f, 1.0f, 1.0f, 0.2f, NULL, NULL},
    {"dielectric", 0, 0, 0, 0, 0, 0, 1, 1.5f, 1.0f, 1.0f, 0.2f, NULL, NULL},
    {"dielectric", 0, 0, 0, 0, 0, 0, 1, 0.8f, 1.0f, 1.0f, 0.2f, NULL, NULL},
    {"thindielectric", 0, 0, 0, 0, 0, 0, 1, 1.5f, 1.0f, 1.0f, 0.2f, NULL, NULL},
    {"plastic", 0, 0, 0, 0, 0, 1, 1, 1.49f, 1.01f, 1.1f, 0.2f, NULL, NULL},
    {"plastic", 0, 0, 1, 0, 0, 1, 1, 1.9f, 1.01f, 1.1f, 0.2f, NULL, NULL},
    {"roughplastic", BRDF_GGX, 0, 0, .01f, .01f, 1, 1, 1.49f, 1.01f, 1.3f, 0.005f, NULL, NULL},
    {"roughplastic", BRDF_GGX, 0, 1, .1f, .1f, 1, 1, 1.9f, 1.01f, 1.3f, 0.05f, NULL, NULL},
    {"roughplastic", BRDF_GGX, 0, 0, 1, 1, 1, 1, 1.3f, 1.01f, 1.3f, 0.2f, NULL, NULL},
    {"roughplastic", BRDF_BECKMANN, 0, 0, .1f, .1f, 1, 1, 1.49f, 1.01f, 1.3f, 0.05f, NULL, NULL},
    {"roughplastic", BRDF_BECKMANN, 0, 1, .5f, .5f, 1, 1, 1.49f, 1.01f, 1.3f, 0.2f, NULL, NULL},
    {"principled", 0, 0, 0, .5f, 0, 1, 1, 1.5f, 0, 0, 0.1f, opaque, NULL},
    {"principled", 0, 0, 0, .1f, 0, 1, 1, 1.5f, 0, 0, 0.02f, opaque, NULL},
    {"principled", 0, 0, 0, .4f, 0, .8f, 1, 1.5f, 0, 0, 0.02f, tinted_metal, NULL},
    {"principled", 0, 0, 0, 1, 0, .5f, 1, 1.3f, 0, 0, 0.1f, cloth, NULL},
    {"principled", 0, 0, 0, .5f, 0, .9f, 1, 1.5f, 0, 0, 0.05f, glassy, NULL},
    {"principledthin", 0, 0, 0, .5f, 0, .8f, 1, 1.5f, 0, 0, 0.2f, brdf_case_leaf, NULL},
    {"principledthin", 0, 0, 0, .6f, 0, .8f, 1, 1.4f, 0, 0, 0.05f, film, NULL},
    {"lafortune", 0, 0, 0, 0, 0, .3f, 1, 1.5f, 1.0f, 0, 0.1f, three_lobes, NULL},
    {"merl", 0, 0, 0, 0, 0, .3f, 1, 1.5f, 1.02f, 0, 0.1f, half_grid, NULL},
    {"tabulated", 0, 0, 0, 0, 0, .3f, 1, 1.5f, 1.02f, 0, 0.1f, direction_grid, NULL},
    {"phong", 0, 0, 0, 0, 0, .5f, .5f, 1.5f, 1.0f, 2.0f, 0.2f, NULL, NULL},
    {"phong", 0, 0, 0, 1, 1, .5f, .5f, 1.5f, 1.0f, 1.5f, 0.2f, NULL, NULL},
    {"phong", 0, 0, 0, 22.5f, 0, .5f, .5f, 1.5f, 1.0f, 1.1f, 0.1f, NULL, NULL},
    {"phong", 0, 0, 0, 3000, 0, .5f, .5f, 1.5f, 1.0f, 1.1f, 0.01f, NULL, NULL},
    {"ward", 0, BRDF_WARD, 0, .15f, .15f, .1f, .9f, 1.5f, 1.0f, -1.0f, 0.05f, NULL, NULL},
    {"ward", 0, BRDF_WARD, 0, .6f, .25f, .1f, .9f, 1.5f, 0.0f, -1.0f, 0.1f, NULL, NULL},
    {"ward", 0, BRDF_WARD_DUER, 0, .15f, .5f, .1f, .9f, 1.5f, 0.0f, 0.0f, 0.05f, NULL, NULL},
    {"ward", 0, BRDF_WARD_DUER, 0, 1, 1, .1f, .9f, 1.5f, 0.0f, 0.0f, 0.2f, NULL, NULL},
    {"ward", 0, BRDF_WARD_BALANCED, 0, .6f, .25f, .1f, .9f, 1.5f, 1.0f, 2.0f, 0.1f, NULL, NULL},
    {"ward", 0, BRDF_WARD_BALANCED, 0, .01f, .1f, .1f, .9f, 1.5f, 1.0f, 2.0f, 0.005f, NULL, NULL},
    {"roughdiffuse", 0, 0, 0, .2f, 0, 1, 0, 1.5f, 1.03f, 0, 0.2f, NULL, NULL},
    {"roughdiffuse", 0, 0, 0, .7f, 0, 1, 0, 1.5f, 1.05f, 0, 0.2f, NULL, NULL},
    {"roughdiffuse", 0, 0, 0, .4f, 0, 1, 0, 1.5f, 1.02f, 0, 0.2f, simplified, NULL},
    {"diffuse", 0, 0, 0, 0, 0, 1, 0, 1.5f, 1.0f, 0, 0.2f, NULL, &coat_clear},
    {"roughdiffuse", 0, 0, 0, .4f, 0, 1, 0, 1.5f, 1.0f, 0, 0.2f, NULL, &coat_tinted},
    {"conductor", 0, 0, 0, 0, 0, 0, 1, 1.5f, 1.0f, 0, 0.2f, NULL, &coat_tinted},
    {"roughconductor", BRDF_GGX, 0, 0, .1f, .1f, 0, 1, 1.5f, 1.0f, 0, 0.05f, NULL, &coat_clear},
    {"plastic", 0, 0, 1, 0, 0, 1, 1, 1.49f, 1.01f, 0, 0.2f, NULL, &coat_clear},
    {"roughplastic", BRDF_GGX, 0, 1, .1f, .1f, 1, 1, 1.9f, 1.01f, 0, 0.05f, NULL, &coat_tinted},
    {"phong", 0, 0, 0, 22.5f, 0, .5f, .5f, 1.5f, 1.0f, 0, 0.1f, NULL, &coat_tinted},
    {"merl", 0, 0, 0, 0, 0, .3f, 1, 1.5f, 1.02f, 0, 0.1f, half_grid, &coat_clear},
    {"diffuse", 0, 0, 0, 0, 0, 1, 0, 1.5f, 1.0f, 0, 0.1f, NULL, &coat_rough},
    {"conductor", 0, 0, 0, 0, 0, 0, 1, 1.5f, 1.0f, 0, 0.1f, NULL, &coat_rough},
    {"phong", 0, 0, 0, 22.5f, 0, .5f, .5f, 1.5f, 1.0f, 0, 0.1f, NULL, &coat_rough},
    {"ward", 0, BRDF_WARD_BALANCED, 0, .6f, .25f, .1f, .9f, 1.5f, 1.0f, 0, 0.1f, NULL, &coat_rough},
    {"principled", 0, 0, 0, .5f, 0, 1, 1, 1.5f, 0, 0, 0.1f, opaque, &coat_rough},
    {"roughplastic", BRDF_BECKMANN, 0, 0, .5f, .5f, 1, 1, 1.49f, 1.01f, 0, 0.1f, NULL, &coat_thin},
};

enum { CASES = sizeof cases / sizeof *cases };

static struct brdf brdf_case_make(const struct brdf_case *c, struct arena *arena) {
    struct brdf b = {.model = brdf_find(c->model),
                     .diffuse = rgb_grey(c->diffuse),
                     .specular = rgb_grey(c->specular),
                     .transmittance = rgb_grey(1.0f),
                     .eta = {0, 0, 0},
                     .k = {1, 1, 1},  // reflects everything
                     .ior = c->ior,
                     .alpha_u = c->alpha_u,
                     .alpha_v = c->alpha_v,
                     .exponent = c->alpha_u,
                     .distribution = c->distribution,
                     .variant = c->variant,
                     .nonlinear = c->nonlinear};
    assert_non_null(b.model);
    if (c->set) c->set(&b);
    assert_int_equal(brdf_prepare(&b, arena, NULL), SATIN_OK);
    if (c->coat) assert_int_equal(brdf_coat_set(&b, arena, c->coat), SATIN_OK);
    return b;
}

#endif
