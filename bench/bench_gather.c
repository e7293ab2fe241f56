// SPDX-License-Identifier: Apache-2.0
// The cost of a gather ray in record creation: nanoseconds of everything that makes the records of
// a scene (choice of sites, photon clusters, rays, lookups, bounces, projection, insertion),
// divided by the number of gather rays, over the nanoseconds of a bare rtcIntersect1 of the same
// rays in the same acceleration structure. The rays of each hemisphere are traced bare as soon as
// they were gathered, so that a busy machine is busy for both. And the fraction of the time that
// each part takes.
//
//   bench_gather SCENE.xml [OPTION=VALUE ...]
//
// Renders on one thread until RAYS gather rays were traced. The linker passes calls between
// satin's files through the functions WRAPPED below (meson.build), which trace the rays bare and
// note which part runs, for a signal that samples this by processor time. Noting costs a few
// nanoseconds per call, which are included.
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/time.h>

#include "bench_embree.h"
#include "bench_log.h"
#include "bench_timing.h"
#include "fill/fill.h"
#include "gather/gather_bounces.h"
#include "gather/gather_near.h"
#include "photon/photon_index.h"
#include "satin/render.h"

enum { RAYS = 3000000, SETTINGS_MOST = 32, SAMPLE_MICROSECONDS = 1000 };

// What the time of record creation is spent on; calls within calls count for the inner part.
enum gather_part {
    OTHER,  // not record creation
    FILLING,
    HEMISPHERE,
    CLUSTERS,
    PROJECTION,
    SEGMENTS,
    INTERACTION,
    FIRST_HIT,
    LOOKUP,
    NEAREST,
    NEAREST_FEW,
    BOUNCES,
    LIGHT_SAMPLES,
    BRDFS,
    SHADOW_RAYS,
    PARTS
};
static const char *const gather_part_name[PARTS] = {
    [FILLING] = "choosing sites, radii, insertion",
    [HEMISPHERE] = "directions of the hemisphere",
    [CLUSTERS] = "cones of photon clusters",
    [PROJECTION] = "values, gradients, surroundings",
    [SEGMENTS] = "gather rays, without the parts below",
    [INTERACTION] = "surface interactions, shading points",
    [FIRST_HIT] = "rtcIntersect1",
    [LOOKUP] = "lookups, without the searches",
    [NEAREST] = "searches for the nearest entry",
    [NEAREST_FEW] = "searches for several entries",
    [BOUNCES] = "bounces, without the parts below",
    [LIGHT_SAMPLES] = "light samples",
    [BRDFS] = "BRDFs",
    [SHADOW_RAYS] = "rtcOccluded1",
};

// State of the run, which the wrapped functions change.
static struct {
    volatile sig_atomic_t part;
    volatile sig_atomic_t samples[PARTS];
    double fill_ns, bare_ns;
    size_t rays;
    float sum;       // of distances, which keeps the compiler from removing the work
    RTCScene accel;  // the structure in which gather rays are traced
} creation;

// ---- Wrapped functions --------------------------------------------------------------------------

static sig_atomic_t begin_part(enum gather_part part) {
    const sig_atomic_t outer = creation.part;
    if (outer != OTHER) creation.part = (sig_atomic_t)part;
    return outer;
}

static void end_part(sig_atomic_t outer) { creation.part = outer; }

// The names that the linker gives to a function and to its wrapper.
#define REAL(name) __real_##name
#define WRAPPED(name) __wrap_##name

// Defines the wrapper of a function, which belongs to a part.
#define WRAP(part, type, name, parameters, arguments) \
    type REAL(name) parameters;                       \
    type WRAPPED(name) parameters;                    \
    type WRAPPED(name) parameters {                   \
        const sig_atomic_t outer = begin_part(part);  \
        const type result = REAL(name) arguments;     \
        end_part(outer);                              \
        return result;                                \
    }
#define WRAP_VOID(part, name, parameters, arguments) \
    void REAL(name) parameters;                      \
    void WRAPPED(name) parameters;                   \
    void WRAPPED(name) parameters {                  \
        const sig_atomic_t outer = begin_part(part); \
        REAL(name) arguments;                        \
        end_part(outer);                             \
    }

satin_status REAL(fill_records)(struct fill *fill, enum cache_kind kind,
                                const struct fill_sites *sites);
satin_status WRAPPED(fill_records)(struct fill *fill, enum cache_kind kind,
                                   const struct fill_sites *sites);
satin_status WRAPPED(fill_records)(struct fill *fill, enum cache_kind kind,
                                   const struct fill_sites *sites) {
    const double start = now_ns(), bare = creation.bare_ns;
    creation.part = FILLING;
    const satin_status status = REAL(fill_records)(fill, kind, sites);
    creation.part = OTHER;
    creation.fill_ns += now_ns() - start - (creation.bare_ns - bare);
    return status;
}

#if SATIN_EMBREE == 4
WRAP_VOID(FIRST_HIT, rtcIntersect1,
          (RTCScene scene, struct RTCRayHit *hit, struct RTCIntersectArguments *arguments),
          ((creation.accel = scene), hit, arguments))
WRAP_VOID(SHADOW_RAYS, rtcOccluded1,
          (RTCScene scene, struct RTCRay *ray, struct RTCOccludedArguments *arguments),
          (scene, ray, arguments))
static void intersect_bare(struct RTCRayHit *hit) {
    REAL(rtcIntersect1)(creation.accel, hit, NULL);
}
#else
WRAP_VOID(FIRST_HIT, rtcIntersect1,
          (RTCScene scene, struct RTCIntersectContext *context, struct RTCRayHit *hit),
          ((creation.accel = scene), context, hit))
WRAP_VOID(SHADOW_RAYS, rtcOccluded1,
          (RTCScene scene, struct RTCIntersectContext *context, struct RTCRay *ray),
          (scene, context, ray))
static void intersect_bare(struct RTCRayHit *hit) {
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    REAL(rtcIntersect1)(creation.accel, &context, hit);
}
#endif

static void trace_bare(const struct gather_ray *rays, size_t count) {
    const double start = now_ns();
    creation.part = OTHER;
    for (size_t i = 0; i < count; i++) {
        struct RTCRayHit hit = bare_ray(&rays[i].ray);
        intersect_bare(&hit);
        creation.sum += hit.ray.tfar;
    }
    creation.bare_ns += now_ns() - start;
    creation.rays += count;
}

void REAL(gather_rays_guided)(const struct gather *g, struct gather_scratch *scratch,
                              struct gather_ray *rays, size_t count, uint64_t stream,
                              struct gather_near *near);
void WRAPPED(gather_rays_guided)(const struct gather *g, struct gather_scratch *scratch,
                                 struct gather_ray *rays, size_t count, uint64_t stream,
                                 struct gather_near *near);
void WRAPPED(gather_rays_guided)(const struct gather *g, struct gather_scratch *scratch,
                                 struct gather_ray *rays, size_t count, uint64_t stream,
                                 struct gather_near *near) {
    const sig_atomic_t outer = begin_part(SEGMENTS);
    REAL(gather_rays_guided)(g, scratch, rays, count, stream, near);
    if (outer != OTHER) trace_bare(rays, count);
    end_part(outer);
}

WRAP_VOID(HEMISPHERE, gather_hemisphere_trace,
          (const struct gather *g, const struct gather_layout *layout,
           const struct gather_site *site, struct gather_scratch *scratch,
           struct gather_hemisphere *out),
          (g, layout, site, scratch, out))
WRAP(CLUSTERS, int, guide_cones_from,
     (const struct guide_clusters *clusters, const struct satin_scene *scene,
      const struct guide_point *at, struct guide_cone out[GUIDE_CONES], float *expected),
     (clusters, scene, at, out, expected))
WRAP_VOID(CLUSTERS, gather_near_probe,
          (const struct gather *g, const struct gather_hits *hits, size_t count,
           struct gather_near *near),
          (g, hits, count, near))
WRAP_VOID(PROJECTION, gather_hemisphere_irradiance,
          (const struct gather_hemisphere *hemisphere, satin_gradients gradients,
           struct cache_irradiance_value *out),
          (hemisphere, gradients, out))
WRAP_VOID(PROJECTION, gather_hemisphere_radiance,
          (const struct gather_hemisphere *hemisphere, satin_gradients gradients,
           struct gather_radiance *out),
          (hemisphere, gradients, out))
WRAP_VOID(PROJECTION, gather_surroundings_make,
          (const struct gather_hemisphere *hemisphere, satin_gradients gradients, bool hessian,
           struct gather_surroundings *out),
          (hemisphere, gradients, hessian, out))
WRAP(INTERACTION, bool, scene_intersect,
     (const struct satin_scene *scene, const struct ray *ray, struct interaction *out),
     (scene, ray, out))
WRAP_VOID(INTERACTION, scene_shading_point_make,
          (const struct satin_scene *scene, const struct interaction *s, vec3 d,
           struct shading_point *out),
          (scene, s, d, out))
WRAP_VOID(LOOKUP, photon_irradiance_many,
          (const struct photon_maps *maps, const struct satin_scene *scene,
           const struct photon_lookups *lookups),
          (maps, scene, lookups))
WRAP_VOID(k == 1 ? NEAREST : NEAREST_FEW, photon_index_nearest,
          (const struct photon_index *index, const float *query, size_t count, int k, float far2,
           int *row, float *distance2),
          (index, query, count, k, far2, row, distance2))
WRAP(BOUNCES, rgb, gather_bounces,
     (const struct gather *g, const struct shading_point *y, struct gather_estimate estimate,
      const struct gather_cones *cones, struct sampler sampler),
     (g, y, estimate, cones, sampler))
WRAP(LIGHT_SAMPLES, rgb, gather_sample_lights,
     (const struct gather *g, const struct shading_point *p, struct gather_mis mis,
      struct gather_light_samples light_samples, struct sampler sampler, float *variance),
     (g, p, mis, light_samples, sampler, variance))
WRAP(LIGHT_SAMPLES, float, gather_light_pdf,
     (const struct gather *g, vec3 p, struct light_visibility visibility,
      const struct light_connection *to, const struct interaction *hit),
     (g, p, visibility, to, hit))
WRAP(BRDFS, rgb, brdf_eval, (const struct brdf *b, vec3 wo, vec3 wi, unsigned lobes),
     (b, wo, wi, lobes))
WRAP(BRDFS, float, brdf_pdf, (const struct brdf *b, vec3 wo, vec3 wi, unsigned lobes),
     (b, wo, wi, lobes))
WRAP(BRDFS, rgb, brdf_albedo, (const struct brdf *b, vec3 wo, unsigned lobes), (b, wo, lobes))

// ---- The run ------------------------------------------------------------------------------------

static void sample_part(int signal_number) {
    (void)signal_number;
    creation.samples[creation.part]++;
}

static void start_sampling(void) {
    const struct sigaction action = {.sa_handler = sample_part, .sa_flags = SA_RESTART};
    const struct itimerval every = {{0, SAMPLE_MICROSECONDS}, {0, SAMPLE_MICROSECONDS}};
    sigaction(SIGPROF, &action, NULL);
    setitimer(ITIMER_PROF, &every, NULL);
}

static void stop_sampling(void) {
    const struct itimerval never = {{0, 0}, {0, 0}};
    setitimer(ITIMER_PROF, &never, NULL);
}

static bool stop_after_records(void *user, const satin_progress *progress) {
    (void)user;
    return creation.rays >= RAYS || strcmp(progress->stage, "image") == 0;
}

static void print_parts(double ns_per_ray, double bare) {
    double all = 0.0;
    for (int part = FILLING; part < PARTS; part++) all += creation.samples[part];
    for (int part = FILLING; part < PARTS; part++) {
        const double fraction = creation.samples[part] / all;
        printf("  %-38s %5.1f %%  %7.1f ns  %6.2f\n", gather_part_name[part], 100.0 * fraction,
               fraction * ns_per_ray, fraction * ns_per_ray / bare);
    }
}

// Renders until there are enough rays. The options are NAME=VALUE, which are cut at the sign.
static bool render_records_alone(const satin_scene *scene, char **option, int count) {
    satin_setting setting[SETTINGS_MOST] = {{"threads", "1"}};
    for (int i = 0; i < count; i++) {
        char *value = strchr(option[i], '=');
        if (!value) return false;
        *value = '\0';
        setting[1 + i] = (satin_setting){option[i], value + 1};
    }
    satin_options options;
    if (satin_options_resolve(scene, setting, 1 + (size_t)count, bench_print_error, NULL,
                              &options) != SATIN_OK)
        return false;
    const satin_callbacks callbacks = {.log = bench_print_error, .progress = stop_after_records};
    satin_film *film = NULL;
    start_sampling();
    const satin_status status = satin_render(scene, &options, &callbacks, &film);
    stop_sampling();
    satin_film_free(film);
    return (status == SATIN_OK || status == SATIN_CANCELLED) && creation.rays > 0;
}

int main(int argc, char **argv) {
    satin_scene *scene = NULL;
    if (argc < 2 || argc - 2 >= SETTINGS_MOST) {
        fprintf(stderr, "usage: bench_gather SCENE.xml [OPTION=VALUE ...]\n");
        return 2;
    }
    if (satin_scene_load(argv[1], NULL, 0, bench_print_error, NULL, &scene) != SATIN_OK) return 1;
    if (!render_records_alone(scene, argv + 2, argc - 2)) {
        fprintf(stderr, "bench_gather: no records were made\n");
        return 1;
    }
    const double ns_per_ray = creation.fill_ns / (double)creation.rays,
                 bare = creation.bare_ns / (double)creation.rays;
    printf(
        "gather rays %zu\nrecord creation %.1f ns per ray\nrtcIntersect1   %.1f ns per ray\n"
        "ratio %.2f\n",
        creation.rays, ns_per_ray, bare, ns_per_ray / bare);
    print_parts(ns_per_ray, bare);
    satin_scene_free(scene);
    return creation.sum != creation.sum;
}
