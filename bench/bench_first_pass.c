// SPDX-License-Identifier: Apache-2.0
// The error of the first pass alone, and its memory: the irradiance of indirect light that gather
// rays read at their hits, against that by path tracing from there.
//
//   bench_first_pass SCENE.xml PHOTONS BATCH ...
//
// For each number of photons, and the paths of a batch of first pass `reverse` (0: first pass
// `precomputed`), a row of relative squared errors: of the means over SEEDS seeds, without what
// their variance adds to it (bias); and the variance of one seed. Points are where gather rays from
// what the eye sees hit a surface. Each row is computed by a process of its own, whose peak memory
// is that of the program.
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/sampling.h"
#include "bench_log.h"
#include "bench_timing.h"
#include "gather/gather.h"
#include "render/render_budget.h"

enum { POINTS = 512, RAYS = 8192, SEEDS = 4, TRIES = 100000 };

struct first_pass_point {
    vec3 p, n;
    double E, noise;  // by path tracing, luminance [W m^-2]; the variance of E
};

// ---- Reference ----------------------------------------------------------------------------------

// Finds the surface that a ray hits.
static bool find_hit(const struct satin_scene *scene, struct ray ray, vec3 *p, vec3 *n) {
    struct interaction s;
    if (!scene_intersect(scene, &ray, &s) || s.light >= 0) return false;
    *p = s.p;
    *n = v3_dot(s.ng, ray.d) < 0.0f ? s.ng : v3_neg(s.ng);
    return true;
}

static struct ray cosine_ray(const struct satin_scene *scene, vec3 p, vec3 n, vec2 u) {
    const struct frame frame = frame_from_normal(n);
    return scene_spawn(scene, p, n, frame_to_world(&frame, sample_cosine_hemisphere(u.x, u.y)));
}

// The point that a gather ray hits from what the eye sees at a random pixel.
static bool find_point(const struct satin_scene *scene, struct rng *rng, vec3 *p, vec3 *n) {
    const struct scene_film *film = &scene->film;
    const float x = rng_float(rng), y = rng_float(rng), u = rng_float(rng), v = rng_float(rng);
    const vec2 at = {x * (float)film->width, y * (float)film->height};
    const struct ray eye = scene_camera_ray(scene, &scene->camera, at, (vec2){0.5f, 0.5f}, NULL);
    return find_hit(scene, eye, p, n) &&
           find_hit(scene, cosine_ray(scene, *p, *n, (vec2){u, v}), p, n);
}

// Computes the irradiance of indirect light at a point by path tracing.
static void trace_point(const struct gather *g, uint32_t index, struct first_pass_point *point) {
    static struct gather_ray ray[RAYS];
    struct gather_scratch *scratch = gather_scratch_new(NULL, 0);
    if (!scratch) exit(1);
    for (uint32_t i = 0; i < RAYS; i++)
        ray[i] = (struct gather_ray){
            .ray = cosine_ray(g->scene, point->p, point->n, sample_sobol2(i, index)), .item = i};
    gather_rays(g, scratch, ray, RAYS, index);
    double sum = 0.0, sum2 = 0.0;
    for (int i = 0; i < RAYS; i++) {
        const double L = (double)rgb_luminance(ray[i].L);
        sum += L / RAYS;
        sum2 += L * L / RAYS;
    }
    point->E = M_PI * sum;
    point->noise = M_PI * M_PI * fmax(sum2 - sum * sum, 0.0) / RAYS;
    gather_scratch_free(scratch);
}

static int trace_reference(const struct satin_scene *scene, struct first_pass_point *point) {
    satin_options options = satin_options_default;
    options.first_pass = SATIN_FIRST_PATH;
    options.max_depth = -1;
    options.rr_depth = 5;
    const struct gather g = gather_make(scene, &options, NULL);
    struct rng rng = rng_make(1, RNG_GATHER, 1);
    int count = 0;
    for (int i = 0; i < TRIES && count < POINTS; i++)
        count += find_point(scene, &rng, &point[count].p, &point[count].n);
    for (int i = 0; i < count; i++) trace_point(&g, (uint32_t)i, &point[i]);
    return count;
}

// ---- First passes -------------------------------------------------------------------------------

// Sets E[i] to the irradiance that the first pass has at each point.
static void read_first_pass(const struct satin_scene *scene, const satin_options *options,
                            const struct first_pass_point *point, int count, double *E) {
    struct parallel *pool = parallel_new(1);
    struct stats stats = {0};
    struct photon_maps *maps = NULL;
    const struct photon_request request = {
        .scene = scene, .options = options, .paths = render_budget_paths(options, 0.0)};
    if (photon_maps_build(&request, pool, (struct log){0}, &stats, &maps) != SATIN_OK) exit(1);
    for (int i = 0; i < count; i++) {
        float radius;
        E[i] = (double)rgb_luminance(
            photon_irradiance_at(maps, scene, point[i].p, point[i].n, &radius, NULL));
    }
    photon_maps_free(maps);
    parallel_free(pool);
}

static void print_errors(const struct satin_scene *scene, int64_t photons, int64_t batch,
                         const struct first_pass_point *point, int count) {
    static double E[SEEDS][POINTS];
    satin_options options = satin_options_default;
    options.first_pass = batch ? SATIN_FIRST_REVERSE : SATIN_FIRST_PRECOMPUTED;
    options.photons = photons;
    options.photon_batch = batch ? batch : 1;
    options.max_depth = -1;
    options.rr_depth = 5;
    for (int s = 0; s < SEEDS; s++) {
        options.seed = (uint64_t)s + 1;
        read_first_pass(scene, &options, point, count, E[s]);
    }
    double bias2 = 0.0, variance = 0.0, ratio = 0.0;
    for (int i = 0; i < count; i++) {
        const double scale = 1.0 / (point[i].E * point[i].E + 1e-12) / count;
        double mean = 0.0, squares = 0.0;
        for (int s = 0; s < SEEDS; s++) mean += E[s][i] / SEEDS;
        for (int s = 0; s < SEEDS; s++) squares += (E[s][i] - mean) * (E[s][i] - mean);
        const double own = squares / (SEEDS - 1), off = mean - point[i].E;
        variance += scale * own;
        bias2 += scale * (off * off - own / SEEDS - point[i].noise);
        ratio += mean / (point[i].E + 1e-12) / count;
    }
    printf("| %lld | %lld | %.2f | %.2f | %.2f | %+.2f | %.1f |", (long long)photons,
           (long long)batch, 1e4 * (bias2 + variance), 1e4 * bias2, 1e4 * variance,
           100.0 * (ratio - 1.0), 1e-9 * now_ns() / SEEDS);
    fflush(stdout);
}

// Computes a row in a process of its own.
static int print_first_pass(const struct satin_scene *scene, int64_t photons, int64_t batch,
                            const struct first_pass_point *point, int count) {
    const pid_t child = fork();
    if (child == 0) {
        print_errors(scene, photons, batch, point, count);
        _exit(0);
    }
    int status = 1;
    struct rusage usage;
    if (child < 0 || wait4(child, &status, 0, &usage) != child || status != 0) return 1;
    printf(" %.0f |\n", (double)usage.ru_maxrss / 1024.0);
    fflush(stdout);
    return 0;
}

int main(int argc, char **argv) {
    static struct first_pass_point point[POINTS];
    satin_scene *scene = NULL;
    if (argc < 4 || argc % 2 != 0) {
        fprintf(stderr, "usage: bench_first_pass SCENE.xml PHOTONS BATCH ...\n");
        return 2;
    }
    if (satin_scene_load(argv[1], NULL, 0, bench_print_error, NULL, &scene) != SATIN_OK) return 1;
    const int count = trace_reference(scene, point);
    double noise = 0.0;
    for (int i = 0; i < count; i++)
        noise += point[i].noise / (point[i].E * point[i].E + 1e-12) / count;
    printf("%d points; noise of the reference, which is subtracted: %.2f\n\n", count, 1e4 * noise);
    printf(
        "| photons | batch | error, 1e-4 | bias | variance | mean - 1, %% | CPU s | MB |\n"
        "|---|---|---|---|---|---|---|---|\n");
    fflush(stdout);
    int failed = 0;
    for (int i = 2; i < argc; i += 2)
        failed |= print_first_pass(scene, atoll(argv[i]), atoll(argv[i + 1]), point, count);
    satin_scene_free(scene);
    return failed;
}
