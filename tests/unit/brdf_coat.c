// SPDX-License-Identifier: Apache-2.0
// Coats: values against the layered model in double precision, their limits, and the factors and
// shapes by which the caches know them.
#include "brdf/brdf.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "base/rng.h"
#include "base/sampling.h"

static struct brdf bare(const char *model, struct arena *arena) {
    struct brdf b = {.model = brdf_find(model),
                     .diffuse = {0.2f, 0.6f, 0.9f},
                     .specular = {0.5f, 0.4f, 0.3f},
                     .eta = {0.2f, 0.9f, 1.1f},
                     .k = {3.9f, 2.4f, 2.1f},
                     .ior = 1.5f,
                     .alpha_u = 0.3f,
                     .alpha_v = 0.3f,
                     .exponent = 8.0f};
    assert_int_equal(brdf_prepare(&b, arena, NULL), SATIN_OK);
    return b;
}

static struct brdf coated(struct brdf b, const struct brdf_coating *c, struct arena *arena) {
    assert_int_equal(brdf_coat_set(&b, arena, c), SATIN_OK);
    return b;
}

static const struct brdf_coating varnish = {
    .ior = 1.6f, .specular = {1.0f, 0.5f, 0.2f}, .depth = {0.1f, 0.4f, 1.0f}};

static vec3 sample_above(struct rng *rng) {
    const float u = rng_float(rng);
    return sample_uniform_hemisphere(u, rng_float(rng));
}

// The reflectance of a boundary by its two polarised amplitudes.
static double fresnel(double cosine, double ior) {
    const double in = sqrt(1.0 - (1.0 - cosine * cosine) / (ior * ior));
    const double s = (cosine - ior * in) / (cosine + ior * in);
    const double p = (in - ior * cosine) / (in + ior * cosine);
    return 0.5 * (s * s + p * p);
}

// What a coat leaves of light through wo, on one of its two crossings.
static double crossing(double cosine, double ior, double depth) {
    const double in = sqrt(1.0 - (1.0 - cosine * cosine) / (ior * ior));
    return (1.0 - fresnel(cosine, ior)) * exp(-depth / in) / ior;
}

static vec3 refracted(vec3 w, float ior) {
    const vec3 in = v3(w.x / ior, w.y / ior, 0.0f);
    return v3(in.x, in.y, sqrtf(1.0f - v3_len2(in)));
}

static const char *const models[] = {"diffuse", "roughdiffuse", "roughconductor", "phong",
                                     "plastic", "roughplastic", "conductor"};
enum { MODELS = sizeof models / sizeof *models };

static void values_are_those_of_the_layered_model(void **state) {
    (void)state;
    struct arena arena = {0};
    for (int i = 0; i < MODELS; i++) {
        const struct brdf inner = bare(models[i], &arena), b = coated(inner, &varnish, &arena);
        struct rng rng = rng_make(4, RNG_TEST, (uint64_t)i);
        for (int k = 0; k < 500; k++) {
            const vec3 wo = sample_above(&rng), wi = sample_above(&rng);
            const rgb f = brdf_eval(&b, wo, wi, BRDF_ALL);
            const rgb g = brdf_eval(&inner, refracted(wo, 1.6f), refracted(wi, 1.6f), BRDF_ALL);
            const double want =
                (double)g.b * crossing((double)wo.z, 1.6, 1.0) * crossing((double)wi.z, 1.6, 1.0);
            assert_true(fabs((double)f.b - want) <= 2e-5 * want + 1e-9);
            // The mirror: the coat, and a nested one under it.
            struct brdf_sample s[2], nested[2];
            const int mirrors = brdf_delta(&inner, refracted(wo, 1.6f), BRDF_RADIANCE, nested);
            double mirror = 0.2 * fresnel((double)wo.z, 1.6);
            if (mirrors)
                mirror += 1.6 * 1.6 * (double)nested[0].weight.b *
                          pow(crossing((double)wo.z, 1.6, 1.0), 2.0);
            assert_int_equal(brdf_delta(&b, wo, BRDF_RADIANCE, s), 1);
            assert_true(fabs((double)s[0].weight.b - mirror) <= 2e-5 * mirror);
        }
    }
    arena_free(&arena);
}

// A coat of the IOR of the outside is not there.
static void no_boundary_is_no_coat(void **state) {
    (void)state;
    struct arena arena = {0};
    const struct brdf_coating none = {.ior = 1.0f, .specular = {1, 1, 1}};
    for (int i = 0; i < MODELS; i++) {
        const struct brdf inner = bare(models[i], &arena), b = coated(inner, &none, &arena);
        struct rng rng = rng_make(5, RNG_TEST, (uint64_t)i);
        for (int k = 0; k < 200; k++) {
            const vec3 wo = sample_above(&rng), wi = sample_above(&rng);
            const rgb f = brdf_eval(&b, wo, wi, BRDF_ALL), g = brdf_eval(&inner, wo, wi, BRDF_ALL);
            if (!(fminf(wo.z, wi.z) > 0.01f)) continue;  // where rounding reflects some light
            assert_true(fabsf(f.g - g.g) <= 1e-4f * g.g);
            const rgb a = brdf_albedo(&b, wo, BRDF_DIFFUSE | BRDF_DELTA),
                      c = brdf_albedo(&inner, wo, BRDF_DIFFUSE | BRDF_DELTA);
            // Plastics have fits of the mean transmittance, accurate to .6 %.
            if (fabsf(a.g - c.g) > 0.007f * c.g + 1e-5f)
                fail_msg("%s at %g: %g, bare %g", models[i], (double)wo.z, (double)a.g,
                         (double)c.g);
        }
    }
    arena_free(&arena);
}

// A coat that absorbs everything leaves its reflection alone.
static void black_coats_reflect_like_plastics_do(void **state) {
    (void)state;
    struct arena arena = {0};
    const struct brdf_coating ink = {
        .ior = 1.5f, .alpha = 0.3f, .specular = {0.5f, 0.4f, 0.3f}, .depth = {1e9f, 1e9f, 1e9f}};
    const struct brdf b = coated(bare("phong", &arena), &ink, &arena);
    const struct brdf plastic = bare("roughplastic", &arena);
    struct rng rng = rng_make(6, RNG_TEST, 0);
    for (int k = 0; k < 500; k++) {
        const vec3 wo = sample_above(&rng), wi = sample_above(&rng);
        const rgb f = brdf_eval(&b, wo, wi, BRDF_ALL);
        const rgb g = brdf_eval(&plastic, wo, wi, BRDF_GLOSSY);
        assert_true(fabsf(f.r - g.r) <= 1e-5f * g.r && fabsf(f.b - g.b) <= 1e-5f * g.b);
        assert_true(rgb_black(brdf_albedo(&b, wo, BRDF_DIFFUSE)));
    }
    arena_free(&arena);
}

static float sampled_albedo(const struct brdf *b, vec3 wo, unsigned lobes) {
    enum { SAMPLES = 16384 };
    double sum = 0.0;
    for (uint32_t j = 0; j < SAMPLES; j++) {
        struct brdf_sample s;
        if (brdf_sample_wi(b, wo, sample_sobol1(j, 12), sample_sobol2(j, 11), lobes, BRDF_POWER,
                           &s))
            sum += (double)s.weight.g / SAMPLES;
    }
    return (float)sum;
}

// Where textures change colours and depths, the diffuse albedo is still that of samples: within
// 1 % of uneven nested lobes, whose table is for the constants.
static void albedos_follow_textured_colours(void **state) {
    (void)state;
    static const char *const diffuse[] = {"diffuse", "plastic", "roughdiffuse"};
    struct arena arena = {0};
    for (int i = 0; i < 3; i++) {
        struct brdf b = coated(bare(diffuse[i], &arena), &varnish, &arena);
        b.diffuse.g = 0.1f;
        b.coat_depth.g = 2.0f;
        for (float z = 0.1f; z < 1.0f; z += 0.2f) {
            const vec3 wo = v3(sqrtf(1.0f - z * z), 0.0f, z);
            const float want = sampled_albedo(&b, wo, BRDF_DIFFUSE);
            const float got = brdf_albedo(&b, wo, BRDF_DIFFUSE).g;
            if (fabsf(got - want) > 0.01f * want)
                fail_msg("%s at %g: %g, want %g", diffuse[i], (double)z, (double)got, (double)want);
        }
        b.coat_depth.g = -1.0f;  // as textures may have
        const float a = brdf_eval(&b, v3(0, 0, 1), v3(0, 0, 1), BRDF_DIFFUSE).g;
        b.coat_depth.g = 0.0f;
        assert_true(a == brdf_eval(&b, v3(0, 0, 1), v3(0, 0, 1), BRDF_DIFFUSE).g);
    }
    arena_free(&arena);
}

// The glossy lobe is that of brdf_white times brdf_glossy_factor, and its shape says when it is not
// that of another one.
static void glossy_lobes_have_their_factor(void **state) {
    (void)state;
    struct arena arena = {0};
    struct brdf_coating rough = varnish;
    rough.alpha = 0.2f;
    const struct brdf smooth = coated(bare("phong", &arena), &varnish, &arena),
                      mixed = coated(bare("phong", &arena), &rough, &arena);
    assert_true(brdf_is_factored(&smooth) && !brdf_is_factored(&mixed));
    const struct brdf *const all[] = {&smooth, &mixed};
    struct rng rng = rng_make(7, RNG_TEST, 0);
    for (int i = 0; i < 2; i++) {
        const struct brdf white = brdf_white(all[i]);
        const rgb factor = brdf_glossy_factor(all[i]);
        for (int k = 0; k < 100; k++) {
            const vec3 wo = sample_above(&rng), wi = sample_above(&rng);
            const rgb f = brdf_eval(all[i], wo, wi, BRDF_GLOSSY),
                      g = rgb_mul(factor, brdf_eval(&white, wo, wi, BRDF_GLOSSY));
            assert_true(fabsf(f.r - g.r) <= 1e-5f * g.r && fabsf(f.b - g.b) <= 1e-5f * g.b);
        }
        struct brdf other = *all[i];
        assert_true(brdf_same_shape(all[i], &other));
        other.specular.r = other.coat_specular.g = 0.9f;
        assert_true(brdf_same_shape(all[i], &other) == (i == 0));
        other = *all[i];
        other.coat_depth.b = 3.0f;
        assert_false(brdf_same_shape(all[i], &other));
    }
    assert_false(brdf_same_shape(&smooth, &mixed));
    arena_free(&arena);
}

// The coat reflects also where the nested BRDF is black, and the other way round.
static void black_lobes_are_left_out(void **state) {
    (void)state;
    struct arena arena = {0};
    struct brdf_coating rough = varnish;
    rough.alpha = 0.2f;
    struct brdf b = coated(bare("diffuse", &arena), &varnish, &arena);
    b.specular = rgb_grey(0.0f);
    assert_int_equal(brdf_lobes(&b), BRDF_DIFFUSE | BRDF_DELTA);
    b.diffuse = rgb_grey(0.0f);
    assert_int_equal(brdf_lobes(&b), BRDF_DELTA);
    b.coat_specular = rgb_grey(0.0f);
    assert_int_equal(brdf_lobes(&b), 0);
    b = coated(bare("plastic", &arena), &rough, &arena);
    assert_int_equal(brdf_lobes(&b), BRDF_REFLECT | BRDF_DELTA);
    b.specular = rgb_grey(0.0f);
    assert_int_equal(brdf_lobes(&b), BRDF_REFLECT);
    b.coat_specular = rgb_grey(0.0f);
    assert_int_equal(brdf_lobes(&b), BRDF_DIFFUSE);
    assert_string_equal(b.model->name, "roughcoating over plastic");
    arena_free(&arena);
}

// The reflection of a rough coat is widened for beams like that of other facets.
static void beams_widen_rough_coats(void **state) {
    (void)state;
    struct arena arena = {0};
    struct brdf_coating sharp = varnish, wide = varnish;
    sharp.alpha = 0.05f, wide.alpha = 0.2f;
    struct brdf a = coated(bare("diffuse", &arena), &sharp, &arena),
                b = coated(bare("diffuse", &arena), &wide, &arena);
    a.alpha_least = 0.2f;
    struct rng rng = rng_make(8, RNG_TEST, 0);
    for (int k = 0; k < 100; k++) {
        const vec3 wo = sample_above(&rng), wi = sample_above(&rng);
        const float want = brdf_eval(&b, wo, wi, BRDF_GLOSSY).g;
        assert_true(fabsf(brdf_eval(&a, wo, wi, BRDF_GLOSSY).g - want) <= 1e-5f * want);
    }
    arena_free(&arena);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values_are_those_of_the_layered_model),
        cmocka_unit_test(no_boundary_is_no_coat),
        cmocka_unit_test(black_coats_reflect_like_plastics_do),
        cmocka_unit_test(albedos_follow_textured_colours),
        cmocka_unit_test(glossy_lobes_have_their_factor),
        cmocka_unit_test(black_lobes_are_left_out),
        cmocka_unit_test(beams_widen_rough_coats),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
