// SPDX-License-Identifier: Apache-2.0
// Gathering: the light at a point, found by rays [K05 2.1]. A gather ray reads the first-pass
// radiance estimate at its hit; a hemisphere of gather rays gives the value of a record.
//
// Units: lengths are those of the scene; directions are unit vectors, in world space unless they
// are called local. Symbols: L radiance [W m^-2 sr^-1], E irradiance [W m^-2], r hit distance, M
// rows (elevation) and N columns (azimuth) of a stratified hemisphere. Every function may be called
// from any thread, if threads do not use the same scratch or output. Only those that allocate
// memory can fail. Scenes, options and maps must outlive what refers to them.
#ifndef GATHER_GATHER_H
#define GATHER_GATHER_H

#include "base/sampling.h"
#include "cache/cache.h"
#include "photon/photon.h"
#include "scene/scene.h"

// First pass `recursive`: the records of the next indirect bounce, which were made before.
struct gather_records {
    const struct cache_reader *reader;
    const struct gather *gather;  // with which they were made; NULL: there are no records
};

// Direct light at the entries of the photons' estimate (gather_direct.c): a gather ray that
// reads an entry needs no light sample for its diffuse lobe. Arrays of `count`, owned.
struct gather_direct {
    size_t count;
    rgb *E;         // direct irradiance on the entry's side [W m^-2]
    bool *similar;  // neighbouring entries have similar values, so that it may be read
};

// The constants of a render. Plain data, shared by all threads.
struct gather {
    const struct satin_scene *scene;
    const satin_options *options;  // max_depth and rr_depth resolved: max_depth < 0 means no limit
    const struct photon_maps *maps;
    const struct guide_clusters *clusters;      // of the maps; may be NULL
    const struct guide_visibility *visibility;  // of the lights; NULL: all are visible
    int deeper;             // segments between what is seen and the points that gather
    bool wide_lights;       // whether lights are so large that light sampling alone is noisy
    bool rays_find_lights;  // whether some light is hit by rays: not all are points or directions
    const struct gather_direct *direct;  // NULL: there is none
    const struct photon_sppm *sppm;      // whose photons paths read; NULL: no photons
    float lookup_max;  // photon lookups of a larger radius are not reliable; 0: there are none
    // The records of the next indirect bounce; `gather` is NULL except in first pass `recursive`.
    struct gather_records next;
};

// Sets the constants of a render, without visibility of lights and without records. `maps` may be
// NULL.
struct gather gather_make(const struct satin_scene *scene, const satin_options *options,
                          const struct photon_maps *maps);

// Whether gather rays look photons up at their hits.
static inline bool gather_looks_up(const struct gather *g) { return g->lookup_max > 0.0f; }
// Ends that: they go on as paths, and are not guided to the clusters of the photons.
static inline void gather_end_lookups(struct gather *g) {
    g->lookup_max = 0.0f;
    g->clusters = NULL;
}

// Whether indirect light is gathered at surfaces that are `depth` segments from the eye: two more
// lead to the light.
static inline bool gather_indirect(const satin_options *o, int depth) {
    return o->integrator == SATIN_TWO_PASS && (o->max_depth < 0 || o->max_depth >= depth + 2);
}

// Whether samples of the image are paths, whose mean converges to the truth.
static inline bool gather_traces_paths(const satin_options *o) {
    return o->integrator == SATIN_PATH || o->integrator == SATIN_SPPM;
}

// ---- Direct light (gather_sample_lights.c) ------------------------------------------------------

// How direct light is divided between BRDF sampling and light sampling: for each set of lobes of
// the BRDF, the number of BRDF samples per light sample, drawn from all lobes of the set,
// including ideal ones. Ratio 0 is light sampling alone. No lobe is in two sets. `depth` is the
// number of path segments between the eye and the point; panes that light passes are added.
struct gather_mis {
    int depth;
    struct {
        unsigned lobes;
        float ratio;
    } set[3];
};

// Light samples: their number, at least one, and the index of the first among those of its pixel.
struct gather_light_samples {
    int count;
    uint32_t first;
};
// The radiance of direct light that the smooth lobes of `mis` reflect at p to wo. Lights are
// sampled, or all of a few lights once each, and weighted against BRDF sampling by the power
// heuristic. *variance, if not NULL, is set to the variance of the luminance by one sample; 0 if
// there is only one sample or if every light is sampled.
rgb gather_sample_lights(const struct gather *g, const struct shading_point *p,
                         struct gather_mis mis, struct gather_light_samples light_samples,
                         struct sampler sampler, float *variance);
// The largest number of surfaces of panes that light may pass on its way to a point at a depth;
// negative if even direct light exceeds max_depth.
int gather_panes(const struct gather *g, int depth);
// The point as a receiver of the light that is sampled there.
static inline struct light_receiver gather_receiver(const struct shading_point *p) {
    return (struct light_receiver){p->interaction.p, p->frame.n, brdf_transmits(&p->brdf)};
}
// The visibility of the lights for that, and in *product what the result points to.
static inline struct light_visibility gather_visibility(const struct gather *g,
                                                        const struct shading_point *p,
                                                        struct light_product *product) {
    const struct light_receiver at = gather_receiver(p);
    return guide_visibility_at(g->visibility, &at, product);
}
// The density over solid angle [sr^-1] at p with which gather_sample_lights, choosing one light,
// draws the first direction of a connection from p to an emitter: `hit` is the surface interaction
// on the emitter, NULL for the environment. The visibility is that at p.
float gather_light_pdf(const struct gather *g, vec3 p, struct light_visibility visibility,
                       const struct light_connection *to, const struct interaction *hit);

// Emitted light that a ray meets.
struct gather_met_light {
    rgb Le;       // [W m^-2 sr^-1]
    bool direct;  // whether light samples at `from` can find it too
    float
        light_pdf;  // density [sr^-1] with which light samples at `from` draw it; 0: there are none
};
// The light that is emitted at `hit` (NULL: the environment) towards the end of a chain, where the
// ray has direction d. `from` is the point with light samples at which the chain began, against
// which the light is to be weighted (mis_power); NULL: there is none.
struct gather_met_light gather_meet_light(const struct gather *g, const struct light_chain *chain,
                                          vec3 d, const struct light_receiver *from,
                                          const struct interaction *hit);

// Light that ideal specular surfaces send to a sampled glossy lobe is from caustic photons, except
// in directions that the lobe draws with a larger density [sr^-1], as few photons come from there.
// A small lamp behind curved glass is hardly ever met by following a wide lobe: with 3, single rays
// are most of some records (docs/experiments/rooms.md).
#define GATHER_CAUSTIC_PDF_MOST 100.0f
// Whether caustic photons have the light that specular surfaces send to the glossy lobe of y from
// the local direction wi. The inside of a surface that transmits has no photons.
static inline bool gather_has_caustic_photons(const struct shading_point *y, vec3 wi) {
    return y->wo_l.z > 0.0f && wi.z > 0.0f &&
           !brdf_is_sharp(&y->brdf, y->wo_l, wi, GATHER_CAUSTIC_PDF_MOST);
}

// The first surface that a ray hits.
struct gather_first {
    float r;  // its distance; INFINITY if there is none
    vec3 ng;  // its geometric normal, on either side; 0 if it is ideal specular, or there is none
};
#define GATHER_NOTHING ((struct gather_first){.r = INFINITY})

// ---- Direct light at entries (gather_direct.c) --------------------------------------------------

// How many samples of the lights an entry takes: where it is known which part of the environment is
// visible, and elsewhere.
struct gather_entry_samples {
    int sky, others;
};
// Samples the lights at each entry of g->maps, on all threads of the pool. On failure,
// SATIN_ERROR_MEMORY or SATIN_CANCELLED, *out is unchanged.
satin_status gather_direct_build(const struct gather *g, struct gather_entry_samples samples,
                                 struct parallel *pool, struct gather_direct *out);
// Does so at no more than `most` of them, without a result, to measure the time. *fraction is that
// of the entries.
satin_status gather_direct_try(const struct gather *g, struct gather_entry_samples samples,
                               size_t most, struct parallel *pool, double *fraction);
size_t gather_direct_bytes(const struct gather_direct *direct);
void gather_direct_free(struct gather_direct *direct);  // a zeroed one is allowed

// ---- Paths (gather_path.c) ----------------------------------------------------------------------

// The radiance that is reflected to the start of a gather ray, by path tracing with MIS of light
// and BRDF sampling. Light that is emitted along the ray itself, directly or through ideal specular
// surfaces, is not included. *first is set to the first surface that the ray hits.
rgb gather_path(const struct gather *g, struct ray ray, struct sampler *sampler,
                struct gather_first *first);

// The result of an eye ray.
struct gather_eye_hit {
    bool hit;
    struct shading_point point;  // of the first surface, if one was hit
    // The first one with smooth lobes, behind ideal specular surfaces; throughput 0: there is none.
    struct shading_point smooth;
    rgb T;         // throughput to the eye
    rgb emission;  // the part of the radiance that is emitted light, seen directly or through ideal
                   // specular surfaces alone
};
// The radiance along an eye ray by path tracing. With option hide_emitters, emitters that the ray
// hits first are black.
rgb gather_path_eye(const struct gather *g, struct ray ray, struct sampler *sampler,
                    struct gather_eye_hit *out);

// ---- Gather rays (gather_ray.c) -----------------------------------------------------------------

// A gather ray, which the caller sets, and its results, which gather_rays sets.
struct gather_ray {
    struct ray ray;
    uint32_t item;      // seeds the random decisions after the hit
    float spread;       // width over distance of what it represents, for textures; 0: a point
    float alpha_least;  // least roughness of lobes at its hit; 0: any
    float pdf_w;  // density [sr^-1] by which it is drawn, if the mean of such rays is to be free
                  // of the noise of lookups that they have in common; 0: that may remain
    const struct light_receiver *lit;  // for whose direct light Le, light_pdf and Le_specular are
                                       // set, to be combined with gather_sample_lights; NULL: they
                                       // are 0
    // Results:
    rgb L;            // reflected radiance along the ray, without emitted light
    rgb Le;           // emitted light that the ray hits directly or through panes
    float light_pdf;  // density [sr^-1] at *lit with which light samples draw it
    rgb Le_specular;  // emitted light by other ideal specular surfaces
    struct gather_first first;
};

// The memory of one worker of a pool for the hits of its rays; nothing in it is kept between calls.
// One thread at a time may use it. If the pool's loop is cancelled, which parallel_stopped reports,
// the rest of many rays may not be traced, and the caller must drop the results. Without a pool
// (NULL) all rays are traced.
struct gather_scratch;
struct gather_scratch *gather_scratch_new(struct parallel *pool, int worker);  // NULL: no memory
void gather_scratch_free(struct gather_scratch *scratch);                      // NULL is allowed

// Follows `ray` through ideal specular surfaces to a point with a smooth lobe, and sets *out to it.
// False if there is none. *first is set to the first surface that the ray hits.
bool gather_follow(const struct gather *g, struct ray ray, struct sampler *sampler,
                   struct gather_first *first, struct shading_point *out);

// Traces any number `count` of rays. `stream` and the item of each ray seed the random decisions.
void gather_rays(const struct gather *g, struct gather_scratch *scratch, struct gather_ray *rays,
                 size_t count, uint64_t stream);

// The radiance that gather rays to p read there, without emitted light, if p is `depth` segments
// from the eye. For first passes that have something stored, not for `path` and `none`.
rgb gather_first_pass(const struct gather *g, struct gather_scratch *scratch,
                      const struct shading_point *p, int depth, struct sampler sampler);

// ---- The noise of the first pass (gather_noise.c) ----------------------------------------------

// The noise of what single gather rays read at their hits, as standard deviations over the mean of
// all. Bias is not included: the blur of photon lookups, the interpolation between records, the
// light of bounces that first pass `none` leaves out.
struct gather_noise {
    size_t lookups;  // rays that hit something and are counted
    double sampled;  // noise of the random decisions after the hit: by two lookups of each ray
    double stored;   // noise of the photons or of the records that are read, which rays that hit
                     // near to each other have in common
    double error;    // of both together
    double cpu_s;    // of one lookup, with its ray
    double read;     // fraction of the rays that read photons at their hits
};
// Measures it by these gather rays, with random decisions of their own. All of *out is 0 if they
// find no light. SATIN_ERROR_MEMORY: *out is unchanged.
satin_status gather_noise_measure(const struct gather *g, const struct ray *ray, size_t count,
                                  struct parallel *pool, struct gather_noise *out);

// ---- Lookups of single rays (gather_lookup.c) ---------------------------------------------------

// What a gather ray reads of the photons at its hit.
struct gather_lookup {
    int entry;     // -1: none is as near as the spacing of the photons
    rgb L;         // radiance that the hit reflects [W m^-2 sr^-1]
    float common;  // fraction of the rays of its lobe that read photons of the same disc; 0 if
                   // there is no entry
};
// Follows a ray that a lobe has drawn with this density [sr^-1]. False if nothing is read: there is
// no surface with a diffuse lobe, or the estimate is not reliable.
bool gather_look_up(const struct gather *g, struct ray ray, float pdf_w, struct sampler *sampler,
                    struct gather_lookup *out);
// Gathers E[i], indirect irradiance, at entry[i] of g->maps by so many rays. On failure,
// SATIN_ERROR_MEMORY or SATIN_CANCELLED, E is not whole.
satin_status gather_entries(const struct gather *g, const int *entry, size_t count, int rays,
                            struct parallel *pool, rgb *E);

// ---- Single rays (gather_single.c) --------------------------------------------------------------

// The photon clusters around points of an image tile, to which single gather rays are guided: those
// of the last few points at which they were searched. The memory of one worker of a pool.
struct gather_singles;
struct gather_singles *gather_singles_new(void);           // NULL: no memory
void gather_singles_free(struct gather_singles *singles);  // NULL is allowed
// Forgets all of them, before the first point of a tile.
void gather_singles_begin(struct gather_singles *singles);
// The clusters around a point, where a pixel has the width `pixel`: those of a point near it that
// has been asked for, or else they are searched now. Valid until the next call. Without option
// guide-clusters there are none.
struct gather_single_clusters;
struct gather_single_clusters *gather_single_find(const struct gather *g,
                                                  const struct shading_point *p, float pixel,
                                                  struct gather_singles *singles);
// As brdf_sample_wi for smooth lobes of the point, but some samples are directions to the clusters.
// pdf_w is the density of the direction by both.
bool gather_single_sample(const struct gather_single_clusters *clusters,
                          const struct shading_point *p, unsigned lobes, float u_lobe, vec2 u,
                          struct brdf_sample *out);
// As gather_rays, for rays from the point: bounces from hits near it are guided too. The first such
// hits decide to which clusters, for these and for all later ones; `clusters` stores them.
void gather_single_rays(const struct gather *g, struct gather_scratch *scratch,
                        struct gather_single_clusters *clusters, struct gather_ray *rays,
                        size_t count, uint64_t stream);

// ---- Hemispheres (gather_hemisphere.c) ----------------------------------------------------------

// A point at which a hemisphere is gathered.
struct gather_site {
    vec3 p, ng;          // surface point and geometric normal
    struct frame frame;  // the hemisphere is around frame.n
    uint64_t stream;     // random stream of this site
    bool record;  // it is for a record: its rays take sharp lobes for as wide as the solid angle
                  // they represent; otherwise it is averaged with others of its pixel
    // the BRDF by whose glossy lobes as many rays are drawn as there are stratified ones, for light
    // that is reflected to wo (in the frame). NULL: none are.
    const struct brdf *glossy;
    vec3 wo;
};

// The constants of a stratified hemisphere of about `rays` rays: uniform for harmonics of `order`,
// or cosine-weighted if order is 0. NULL if there is no memory.
struct gather_layout;
struct gather_layout *gather_layout_new(int rays, satin_basis basis, int order);
void gather_layout_free(struct gather_layout *layout);          // NULL is allowed
size_t gather_layout_rays(const struct gather_layout *layout);  // the exact number, M * N

// A hemisphere of gather rays and their results. The stratified rays are first: stratum (j, k) of
// the layout is ray j * N + k; guided rays follow. It owns the arrays, of which `count` entries are
// set unless said otherwise.
struct gather_hemisphere {
    const struct gather_layout *layout;
    struct frame frame;        // of the site; local directions refer to it
    size_t stratified, count;  // numbers of stratified rays, and of these and those to clusters
    size_t all;                // number of rays with those of glossy lobes, which are the last
    struct gather_ray *ray;
    rgb *L;            // radiance along each ray, weighted so that all count as stratified ones
    float *x, *y, *z;  // local directions
    float *r, *g, *b;  // L times the solid angle of a stratified ray, 2 pi / stratified; undefined
                       // in a cosine-weighted layout
    float *weight;     // if all > count: weights of all rays in sums over all; gradients are of the
                       // other rays, which they leave as they are
    float *work;       // 6 * all, scratch for computations on the hemisphere
};

// The weight of a ray in sums over all rays of a hemisphere of a uniform layout.
static inline float gather_hemisphere_weight(const struct gather_hemisphere *h, size_t i) {
    return h->all > h->count ? h->weight[i] : 1.0f;
}

// Allocates memory for up to `rays` rays, stratified and by glossy lobes, and half as many to
// clusters. NULL if there is no memory.
struct gather_hemisphere *gather_hemisphere_new(size_t rays);
void gather_hemisphere_free(struct gather_hemisphere *hemisphere);  // NULL is allowed

// Replaces *out by the stratified rays of `layout` from the site, if the options include them
// guided rays, and if the site has glossy lobes rays by these. *out must have memory for the
// layout's rays, and for as many by glossy lobes.
void gather_hemisphere_trace(const struct gather *g, const struct gather_layout *layout,
                             const struct gather_site *site, struct gather_scratch *scratch,
                             struct gather_hemisphere *out);

// The memory of each worker of a pool for gathering: an array of parallel_threads(pool), or of one
// if the pool is NULL, for hemispheres of up to `rays` stratified rays. NULL if there is no memory.
struct gather_worker {
    struct gather_scratch *scratch;
    struct gather_hemisphere *hemisphere;
    struct gather_singles *singles;
};
struct gather_worker *gather_workers_new(struct parallel *pool, size_t rays);
void gather_workers_free(struct gather_worker *workers, int count);  // NULL is allowed

// Incident radiance in harmonics [K05 (4.9)], in the site's frame. Arrays of 3 * order^2 (channel
// by channel), owned by the caller; dx and dy, the derivatives by p along the frame's axes, may be
// NULL.
struct gather_radiance {
    float *lambda, *dx, *dy;
    // order^2, or NULL: luminance projected with alternating signs of the strata. Its product with
    // a lobe has the standard deviation of the light of lambda that the lobe reflects.
    float *noise;
    uint32_t rays;  // number of rays from which it was made
};

// What the rays show of the surroundings of the site (gather_surroundings.c). Distances are
// INFINITY if nothing was hit.
struct gather_surroundings {
    float harmonic;       // harmonic mean of hit distances
    float least;          // least hit distance
    float least_upright;  // least hit distance without rays at grazing angles to both surfaces
    float sector[CACHE_SECTORS];  // distances along the tangent plane, by azimuth
    float deviation;              // standard deviation of E, as a fraction of E [K05 6.4]
    float gradient_deviation;  // that of dE/dp in any direction, over E; 0: there are no gradients
    float hessian[3];          // d2E/dx2, d2E/dxdy, d2E/dy2 of luminance in the frame, if requested
};

// Computes irradiance from a hemisphere of a cosine-weighted layout. Without gradients, those by
// position are as with SATIN_GRADIENTS_STRATIFIED, as they show how fast E changes.
void gather_hemisphere_irradiance(const struct gather_hemisphere *hemisphere,
                                  satin_gradients gradients, struct cache_irradiance_value *out);
// Computes incident radiance from a hemisphere of a uniform layout; gradients likewise.
void gather_hemisphere_radiance(const struct gather_hemisphere *hemisphere,
                                satin_gradients gradients, struct gather_radiance *out);
// The radiance that `lobes` of a BRDF in the site's frame reflect to wo (local): the sum over the
// rays of a hemisphere of a uniform layout.
rgb gather_hemisphere_reflected(const struct gather_hemisphere *hemisphere, const struct brdf *brdf,
                                vec3 wo, unsigned lobes);
// Computes *out. The deviation of these gradients and the Hessian, which `hessian` requests, are
// those of irradiance, and need a cosine-weighted layout.
void gather_surroundings_make(const struct gather_hemisphere *hemisphere, satin_gradients gradients,
                              bool hessian, struct gather_surroundings *out);

#endif
