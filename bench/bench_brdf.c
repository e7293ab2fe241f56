// SPDX-License-Identifier: Apache-2.0
// Nanoseconds per evaluation, density, sample and albedo of each model, and per lookup of its
// harmonics: medians of several rounds over random directions.
#include <stdio.h>
#include <stdlib.h>

#include "base/rng.h"
#include "base/sampling.h"
#include "base/stats.h"
#include "brdf/brdf.h"

enum { DIRECTIONS = 1024, REPEATS = 40, ROUNDS = 7 };

enum operation { EVAL, PDF, SAMPLE, ALBEDO, LOOKUP, OPERATIONS };

struct bench {
    struct brdf b;
    struct brdf_table *table;
    vec3 wo[DIRECTIONS], wi[DIRECTIONS];
};

static float run_model(const struct bench *n, enum operation op, int i) {
    struct brdf_sample s = {0};
    float u = (float)i / DIRECTIONS, c[300];
    switch (op) {
        case EVAL:
            return brdf_eval(&n->b, n->wo[i], n->wi[i], BRDF_SMOOTH).g;
        case PDF:
            return brdf_pdf(&n->b, n->wo[i], n->wi[i], BRDF_SMOOTH);
        case SAMPLE:
            brdf_sample_wi(&n->b, n->wo[i], u, (vec2){n->wi[i].z, u}, BRDF_ALL, BRDF_RADIANCE, &s);
            return s.weight.g;
        case ALBEDO:
            return brdf_albedo(&n->b, n->wo[i], BRDF_ALL).g;
        default:
            return n->table && brdf_table_lookup(n->table, n->wo[i], c) ? c[0] : 0.0f;
    }
}

static int ascending_ns(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median_ns(const struct bench *n, enum operation op, float *sink) {
    double ns[ROUNDS];
    for (int round = 0; round < ROUNDS; round++) {
        double start = stats_cpu();
        for (int k = 0; k < REPEATS; k++)
            for (int i = 0; i < DIRECTIONS; i++) *sink += run_model(n, op, i);
        ns[round] = (stats_cpu() - start) * 1e9 / (REPEATS * DIRECTIONS);
    }
    qsort(ns, ROUNDS, sizeof *ns, ascending_ns);
    return ns[ROUNDS / 2];
}

static const struct {
    const char *label, *model;
    enum brdf_distribution distribution;
} rows[] = {
    {"diffuse", "diffuse", BRDF_BECKMANN},
    {"roughconductor beckmann", "roughconductor", BRDF_BECKMANN},
    {"roughconductor ggx", "roughconductor", BRDF_GGX},
    {"dielectric", "dielectric", BRDF_BECKMANN},
    {"plastic", "plastic", BRDF_BECKMANN},
    {"roughplastic beckmann", "roughplastic", BRDF_BECKMANN},
    {"roughplastic ggx", "roughplastic", BRDF_GGX},
    {"phong", "phong", BRDF_BECKMANN},
    {"ward", "ward", BRDF_BECKMANN},
};

static satin_status prepare_model(struct bench *n, int row, struct arena *arena,
                                  struct parallel *pool) {
    *n = (struct bench){.b = {.model = brdf_find(rows[row].model),
                              .diffuse = {.5f, .4f, .3f},
                              .specular = {.5f, .5f, .4f},
                              .transmittance = {1, 1, 1},
                              .eta = {.2f, .9f, 1.2f},
                              .k = {3, 2.5f, 2},
                              .ior = 1.5f,
                              .alpha_u = .3f,
                              .alpha_v = .3f,
                              .exponent = 22,
                              .distribution = rows[row].distribution}};
    struct rng rng = rng_make(1, RNG_TEST, 0);
    for (int k = 0; k < DIRECTIONS; k++) {
        n->wo[k] = sample_cosine_hemisphere(rng_float(&rng), rng_float(&rng));
        n->wi[k] = sample_cosine_hemisphere(rng_float(&rng), rng_float(&rng));
    }
    satin_status status = brdf_prepare(&n->b, arena, NULL);
    if (status || !(n->b.model->lobes & BRDF_GLOSSY)) return status;
    const struct brdf_fit fit = {SATIN_HSH, 10, 0.05f, false};
    return brdf_table_build(&n->b, &fit, pool, &n->table);
}

int main(void) {
    struct arena arena = {0};
    struct parallel *pool = parallel_new(1);
    struct bench *n = malloc(sizeof *n);
    float sink = 0.0f;
    printf("%-24s %6s %6s %6s %6s %6s  [ns]\n", "model", "eval", "pdf", "sample", "albedo",
           "lookup");
    for (int row = 0; n && pool && row < (int)(sizeof rows / sizeof *rows); row++) {
        if (prepare_model(n, row, &arena, pool)) return 1;
        printf("%-24s", rows[row].label);
        for (int op = 0; op < OPERATIONS; op++)
            printf(" %6.1f", median_ns(n, (enum operation)op, &sink));
        printf("\n");
        brdf_table_free(n->table);
    }
    free(n);
    arena_free(&arena);
    parallel_free(pool);
    return sink > 1e30f;
}
