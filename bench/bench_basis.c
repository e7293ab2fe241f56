// SPDX-License-Identifier: Apache-2.0
// The harmonics that a record should have: the error of reflected radiance by the truncation of
// light and BRDF, for both bases and every order, on light gathered in real scenes.
//
//   bench_basis SCENE.xml ...      rows of a Markdown table
//
// At points that the eye sees, light is gathered in 65,536 directions and projected; so is each
// BRDF in the same directions, for wo at 40 angles. Reflected radiance from the products of the
// vectors is compared with the sum over the directions: the rms difference over points and wo
// relative to the rms of the sum, in per cent. Then two rules for the order, the least one up to 14
// whose squared error is within 1e-2 for the BRDF [K05 (3.4)], or within 1e-4 for what it reflects
// of typical light (src/brdf/brdf_table.c): the fraction of wo that some order serves, their mean
// order, and the rms difference among them, each with its own order. At the end, the mean power of
// light in a coefficient of each band times (l + 1)^3, relative to that of all bands.
#include <stdio.h>
#include <stdlib.h>

#include "bench_log.h"
#include "gather/gather.h"
#include "rsh/rsh.h"

enum {
    ORDER = 14,
    N2 = ORDER * ORDER,
    POINTS = 12,
    LAYERS = 4,  // hemispheres of 16,384 rays
    RAYS = 16384,
    COUNT = LAYERS * RAYS,
    POLAR = 5,
    AZIMUTHS = 8,
    DIRECTIONS = POLAR * AZIMUTHS,
    BASES = 2,
    SCENES_MOST = 8
};

static const int SHOWN[] = {3, 5, 7, 10, 14};
enum { SHOWN_COUNT = sizeof SHOWN / sizeof *SHOWN };

struct incident {
    float L[COUNT];
    float lambda[BASES][N2];
};

static float x[COUNT], y[COUNT], z[COUNT];  // directions, the same at every point

static void project_light(const float *value, float out[BASES][N2]) {
    for (int basis = 0; basis < BASES; basis++) {
        for (int k = 0; k < N2; k++) out[basis][k] = 0.0f;
        const rsh_samples samples = {COUNT, x, y, z, value, NULL, NULL};
        rsh_project(basis ? RSH_SPHERE : RSH_HEMISPHERE, ORDER, &samples, out[basis]);
    }
}

// Gathers at the surface that the eye sees at (u, v) of the film; false if there is none.
static bool gather_light(const struct gather *g, float u, float v, struct incident *out) {
    const struct scene_film *film = &g->scene->film;
    const vec2 at = {u * (float)film->width, v * (float)film->height};
    struct ray ray = scene_camera_ray(g->scene, &g->scene->camera, at, (vec2){0.5f, 0.5f}, NULL);
    struct interaction s;
    if (!scene_intersect(g->scene, &ray, &s) || s.light >= 0) return false;
    const vec3 n = v3_dot(s.ng, ray.d) < 0.0f ? s.ng : v3_neg(s.ng);
    struct gather_layout *layout = gather_layout_new(RAYS, SATIN_HSH, ORDER);
    struct gather_worker *worker = gather_workers_new(NULL, RAYS);
    const struct gather_hemisphere *h = worker->hemisphere;
    float lambda[3 * N2];
    for (uint64_t layer = 0; layer < LAYERS; layer++) {
        const struct gather_site site = {s.p,  n,        frame_from_normal(n), layer, true,
                                         NULL, {0, 0, 0}};
        gather_hemisphere_trace(g, layout, &site, worker->scratch, worker->hemisphere);
        gather_hemisphere_radiance(h, g->options->radiance_gradients,
                                   &(struct gather_radiance){.lambda = lambda});
        for (size_t i = 0, k = layer * RAYS; i < RAYS; i++, k++) {
            x[k] = h->x[i], y[k] = h->y[i], z[k] = h->z[i];
            out->L[k] = 2.0f * PI_F / COUNT * rgb_luminance(h->L[i]);
        }
    }
    project_light(out->L, out->lambda);
    gather_layout_free(layout);
    gather_workers_free(worker, 1);
    return true;
}

// ---- One BRDF -----------------------------------------------------------------------------------

enum { RULES = 2 };  // by the BRDF, by what it reflects
static const double BOUND[RULES] = {1e-2, 1e-4};

struct outgoing {
    float f[COUNT], C[BASES][N2];
    int order[RULES][BASES];  // least one within the bound; 0: none
};

// The least order whose bands hold all but `bound` of the power, that of band l over (l + 1)^fall.
static int least_order_of_error(const float C[N2], double norm, double fall, double bound) {
    double band[ORDER + 1] = {0}, all = 0.0, held = 0.0;
    for (int l = 0, k = 0; l < ORDER; l++)
        for (; k < (l + 1) * (l + 1); k++) band[l] += (double)sqrf(C[k]);
    band[ORDER] = norm;
    for (int l = 0; l < ORDER; l++) band[ORDER] -= band[l];
    for (int l = 0; l <= ORDER; l++) {
        band[l] = fmax(band[l], 0.0) / pow(l + 1.0, fall);
        all += band[l];
    }
    for (int l = 0; l < ORDER; l++) {
        held += band[l];
        if (all - held <= bound * all) return l + 1;
    }
    return 0;
}

static void see_light(const struct brdf *b, vec3 wo, struct outgoing *out) {
    double norm = 0.0;
    for (size_t i = 0; i < COUNT; i++) {
        rgb f = brdf_eval(b, wo, v3(x[i], y[i], z[i]), BRDF_GLOSSY);
        out->f[i] = rgb_luminance(f) * z[i];
        norm += 2.0 * (double)PI_F / COUNT * (double)(out->f[i] * out->f[i]);
    }
    project_light(out->f, out->C);
    for (int basis = 0; basis < BASES; basis++) {
        for (int k = 0; k < N2; k++) out->C[basis][k] *= 2.0f * PI_F / COUNT;
        for (int rule = 0; rule < RULES; rule++)
            out->order[rule][basis] =
                least_order_of_error(out->C[basis], norm, rule ? 3.0 : 0.0, BOUND[rule]);
    }
}

// Sums over outgoing directions and points; of a rule, over the directions that it serves.
struct tally {
    double error[BASES][ORDER + 1], size;  // squares
    struct {
        double error, size, directions, order;
    } by[RULES][BASES];
};

static void note(const struct incident *light, const struct outgoing *outgoing, struct tally *t) {
    double exact = 0.0;
    for (size_t i = 0; i < COUNT; i++) exact += (double)(light->L[i] * outgoing->f[i]);
    t->size += exact * exact;
    for (int basis = 0; basis < BASES; basis++) {
        double sum = 0.0;
        for (int n = 1, k = 0; n <= ORDER; n++) {
            for (; k < n * n; k++) sum += (double)(light->lambda[basis][k] * outgoing->C[basis][k]);
            double e = fmax(sum, 0.0) - exact;
            t->error[basis][n] += e * e;
            for (int rule = 0; rule < RULES; rule++) {
                if (n != outgoing->order[rule][basis]) continue;
                t->by[rule][basis].error += e * e;
                t->by[rule][basis].size += exact * exact;
            }
        }
    }
}

static void print_row(const char *name, int basis, const struct tally *t) {
    printf("| %s | %s |", name, basis ? "SH" : "HSH");
    for (int i = 0; i < SHOWN_COUNT; i++)
        printf(" %.2f |", 100.0 * sqrt(t->error[basis][SHOWN[i]] / t->size));
    for (int rule = 0; rule < RULES; rule++) {
        double directions = t->by[rule][basis].directions;
        if (directions > 0.0)
            printf(" %.0f %% | %.1f | %.2f |", 100.0 * directions / DIRECTIONS,
                   t->by[rule][basis].order / directions,
                   100.0 * sqrt(t->by[rule][basis].error / t->by[rule][basis].size));
        else
            printf(" 0 | - | - |");
    }
    printf("\n");
    fflush(stdout);
}

static void measure_model(const char *name, const struct brdf *b, const struct incident *light,
                          int points) {
    static const float degrees[POLAR] = {10.0f, 30.0f, 50.0f, 68.0f, 80.0f};
    static struct outgoing outgoing;
    struct tally t = {0};
    for (int v = 0; v < DIRECTIONS; v++) {
        float theta = degrees[v % POLAR] * PI_F / 180.0f;
        float phi = 2.0f * PI_F * ((float)(v / POLAR) + 0.3f) / AZIMUTHS;
        see_light(b, v3(sinf(theta) * cosf(phi), sinf(theta) * sinf(phi), cosf(theta)), &outgoing);
        for (int k = 0; k < RULES * BASES; k++) {
            t.by[k / BASES][k % BASES].directions += outgoing.order[k / BASES][k % BASES] > 0;
            t.by[k / BASES][k % BASES].order += outgoing.order[k / BASES][k % BASES];
        }
        for (int p = 0; p < points; p++) note(&light[p], &outgoing, &t);
    }
    for (int basis = 0; basis < BASES; basis++) print_row(name, basis, &t);
}

static void print_light(const struct incident *light, int points) {
    for (int basis = 0; basis < BASES; basis++) {
        printf("%s, power of light times (l + 1)^3:", basis ? "SH" : "HSH");
        for (int l = 0; l < ORDER; l++) {
            double sum = 0.0;
            for (int p = 0; p < points; p++) {
                double band = 0.0, all = 0.0;
                for (int k = 0; k < N2; k++) {
                    double power = (double)sqrf(light[p].lambda[basis][k]);
                    all += power;
                    if (k >= l * l && k < (l + 1) * (l + 1)) band += power / (2 * l + 1);
                }
                sum += band / all / points;
            }
            printf(" %.2f", sum * pow(l + 1.0, 3.0));
        }
        printf("\n");
    }
}

struct named_model {
    const char *name, *model;
    float exponent, alpha_u, alpha_v;
};

static const struct named_model BRDFS[] = {
    {"phong 5", "phong", 5, 0, 0},
    {"phong 22", "phong", 22, 0, 0},
    {"phong 100", "phong", 100, 0, 0},
    {"ward .3", "ward", 0, 0.3f, 0.3f},
    {"ward .15", "ward", 0, 0.15f, 0.15f},
    {"ward .4, .15", "ward", 0, 0.4f, 0.15f},
    {"roughconductor .3", "roughconductor", 0, 0.3f, 0.3f},
    {"roughconductor .15", "roughconductor", 0, 0.15f, 0.15f},
    {"roughplastic .2", "roughplastic", 0, 0.2f, 0.2f},
    {"lafortune 24, 7, 2", "lafortune", 0, 0, 0},
};

static bool make_model(const struct named_model *n, struct arena *arena, struct brdf *out) {
    static const struct brdf_cosine_lobe lobe[] = {{{-1, -1, 1}, 24, {1.5f, 1.45f, 1.35f}},
                                                   {{-0.98f, -0.98f, 1}, 7, {0.3f, 0.29f, 0.27f}},
                                                   {{-0.95f, -0.95f, 0.9f}, 2, {.05f, .05f, .05f}}};
    *out = (struct brdf){.model = brdf_find(n->model),
                         .diffuse = rgb_grey(0.3f),
                         .specular = rgb_grey(0.7f),
                         .transmittance = rgb_grey(1.0f),
                         .eta = rgb_grey(1.2f),
                         .k = rgb_grey(7.0f),
                         .ior = 1.5f,
                         .alpha_u = n->alpha_u,
                         .alpha_v = n->alpha_v,
                         .exponent = n->exponent,
                         .distribution = BRDF_GGX,
                         .variant = BRDF_WARD_DUER};
    if (n->model[0] == 'l' && brdf_lafortune_set(out, arena, lobe, 3) != SATIN_OK) return false;
    return out->model && brdf_prepare(out, arena, NULL) == SATIN_OK;
}

// Light at POINTS points of the scene; returns how many were found.
static int gather_scene(const char *path, uint64_t stream, struct incident *light) {
    satin_scene *scene = NULL;
    if (satin_scene_load(path, NULL, 0, bench_print_error, NULL, &scene) != SATIN_OK) exit(1);
    satin_options options = satin_options_default;
    options.first_pass = SATIN_FIRST_PATH;
    options.max_depth = 4;
    options.rr_depth = 5;
    const struct gather g = gather_make(scene, &options, NULL);
    struct rng rng = rng_make(1, RNG_GATHER, stream);
    int count = 0;
    for (int tries = 0; count < POINTS && tries < 1000; tries++) {
        float u = rng_float(&rng), v = rng_float(&rng);
        count += gather_light(&g, u, v, &light[count]);
    }
    satin_scene_free(scene);
    return count;
}

static void print_head(void) {
    printf("| BRDF | basis |");
    for (int i = 0; i < SHOWN_COUNT; i++) printf(" n = %d |", SHOWN[i]);
    for (int rule = 0; rule < RULES; rule++)
        printf(" %s: directions | n | at n |", rule ? "by reflection" : "by BRDF");
    printf("\n|---|---|");
    for (int i = 0; i < SHOWN_COUNT + 3 * RULES; i++) printf("---|");
    printf("\n");
}

int main(int argc, char **argv) {
    static struct incident light[POINTS * SCENES_MOST];
    int points = 0;
    for (int i = 1; i < argc && i <= SCENES_MOST; i++)
        points += gather_scene(argv[i], (uint64_t)i, &light[points]);
    if (points == 0) {
        fprintf(stderr, "usage: bench_basis SCENE.xml ...\n");
        return 2;
    }
    print_head();
    for (size_t i = 0; i < sizeof BRDFS / sizeof *BRDFS; i++) {
        struct arena arena = {0};
        struct brdf b;
        if (!make_model(&BRDFS[i], &arena, &b)) return 1;
        measure_model(BRDFS[i].name, &b, light, points);
        arena_free(&arena);
    }
    print_light(light, points);
    return 0;
}
