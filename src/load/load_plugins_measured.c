// SPDX-License-Identifier: Apache-2.0
// <bsdf type="lafortune">, "merl" and "tabulated": BRDFs that are given by numbers.
#include <stdlib.h>

#include "load/load_measured.h"
#include "load/load_plugins_bsdf.h"

static const struct param_spec measured_file = {
    "filename", PARAM_STRING, NULL, 0, PARAM_REQUIRED, NULL, "The file of the measured BRDF."};
static const struct param_spec lafortune_lobes = {
    "lobes",
    PARAM_STRING,
    NULL,
    0,
    PARAM_REQUIRED,
    NULL,
    "A list of seven numbers for each lobe: cx, cy, cz, exponent, red, green, blue."};

param_list bsdf_lafortune_params = {&bsdf_diffuse_reflectance, &bsdf_specular_reflectance,
                                    &lafortune_lobes, NULL};
param_list bsdf_measured_params = {&measured_file, NULL};

// Checks, for a few directions, that the BRDF does not reflect more light than it gets.
static satin_status check_measured_albedo(struct load_state *loader, const struct params *p,
                                          const struct brdf *b) {
    for (int i = 0; i < 24; i++) {
        float theta = 0.2f * (float)(i % 8), phi = 0.6f * (float)(i / 8);
        vec3 wo = v3(sinf(theta) * cosf(phi), sinf(theta) * sinf(phi), cosf(theta));
        float albedo = rgb_max(brdf_albedo(b, wo, BRDF_ALL));
        if (albedo <= 1.05f) continue;
        log_error_at(loader->log, p->node->place, "it reflects %.3g times the light that it gets",
                     (double)albedo);
        return SATIN_ERROR_INPUT;
    }
    return SATIN_OK;
}

satin_status load_bsdf_lafortune_build(struct load_state *loader, const struct params *p,
                                       void *object) {
    struct material_side *side = object;
    const struct param_value *text = load_param(p, "lobes");
    struct brdf_cosine_lobe lobe[BRDF_COSINE_LOBES_MAX];
    double number[7 * BRDF_COSINE_LOBES_MAX];
    int count = load_param_words(text->s);
    if (count == 0 || count % 7 || count > 7 * BRDF_COSINE_LOBES_MAX) {
        log_error_at(loader->log, text->place,
                     "'lobes' has %d numbers, but needs seven for each of one to %d lobes", count,
                     BRDF_COSINE_LOBES_MAX);
        return SATIN_ERROR_INPUT;
    }
    if (!load_param_numbers(loader->log, text->place, text->s, count, number))
        return SATIN_ERROR_INPUT;
    for (int i = 0; i < count / 7; i++) {
        const double *n = number + 7 * i;
        for (int k = 0; k < 7; k++) {
            bool good = k < 3 ? fabs(n[k]) <= 10.0 : n[k] >= 0.0 && n[k] <= 1e4;
            if (good) continue;
            log_error_at(loader->log, text->place, "number %d of lobe %d is out of range", k + 1,
                         i + 1);
            return SATIN_ERROR_INPUT;
        }
        lobe[i] = (struct brdf_cosine_lobe){v3((float)n[0], (float)n[1], (float)n[2]), (float)n[3],
                                            rgb_make((float)n[4], (float)n[5], (float)n[6])};
    }
    satin_status status = load_bsdf_set_reflectances(loader, p, side);
    if (status != SATIN_OK) return status;
    if (brdf_lafortune_set(&side->base, &loader->scene->arena, lobe, count / 7) != SATIN_OK)
        return load_no_memory(loader);
    return check_measured_albedo(loader, p, &side->base);
}

static satin_status build_measured(struct load_state *loader, const struct params *p,
                                   struct material_side *side,
                                   satin_status (*read)(const struct load_source *source,
                                                        struct brdf_grid *out)) {
    struct load_source source;
    struct brdf_grid grid;
    satin_status status = load_file_source(loader, load_param(p, "filename"), &source);
    if (status != SATIN_OK) return status;
    status = read(&source, &grid);
    free((char *)source.path);
    if (status != SATIN_OK) return status;
    status = brdf_measured_set(&side->base, &loader->scene->arena, &grid);
    return status == SATIN_OK ? status : load_no_memory(loader);
}

satin_status load_bsdf_merl_build(struct load_state *loader, const struct params *p, void *object) {
    return build_measured(loader, p, object, load_measured_merl);
}

satin_status load_bsdf_tabulated_build(struct load_state *loader, const struct params *p,
                                       void *object) {
    return build_measured(loader, p, object, load_measured_text);
}
