// SPDX-License-Identifier: Apache-2.0
// Gathering: light that arrives at a point, found by rays [K05 2.1]. A gather ray reads the
// first-pass radiance estimate where it hits; a hemisphere of gather rays gives what a record
// keeps.
//
// Units: lengths in those of the scene; directions are unit vectors, in world space unless said to
// be local. Letters: L radiance [W m^-2 sr^-1], E irradiance [W m^-2], r hit distance, M rows
// (elevation) and N columns (azimuth) of a stratified hemisphere.
// Every function may be called from any thread, if threads do not pass the same scratch or output.
// None fails but those that allocate memory; scenes, options and maps must outlive what points to
// them.
#ifndef GATHER_GATHER_H
#define GATHER_GATHER_H

#include "base/sampling.h"
#include "photon/photon.h"
#include "scene/scene.h"

struct gather_point;

// First pass `recursive`: the records of the next indirect bounce, made before by the functions of
// a later folder.
struct gather_records {
    // Adds to *L the indirect light that y reflects by the lobes which the records cover; returns
    // these lobes, smooth ones.
    unsigned (*read)(const void *records, const struct gather_point *y, rgb *L);
    const void *records;
    const struct gather *gather;  // by which they were made; NULL: there are no records
};

// Direct light at the entries of the photons' estimate (gather_direct_table.c): a gather ray that
// reads an entry needs no light sample for its diffuse lobe. Arrays of `count`, owned.
struct gather_direct_table {
    size_t count;
    rgb *E;      // direct irradiance on the entry's side [W m^-2]
    bool *even;  // entries around have much the same, so that it may be read
};

// What stays the same during a render. Plain data, shared by all threads.
struct gather {
    const struct satin_scene *scene;
    const satin_options *options;  // max_depth and rr_depth resolved: max_depth < 0 means no limit
    const struct photon_maps *maps;
    const struct guide_clusters *clusters;      // of the maps; may be NULL
    const struct guide_visibility *visibility;  // of lights; NULL: all are visible
    bool wide_lights;                          // lights so large that light sampling alone is noisy
    const struct gather_direct_table *direct;  // NULL: there is none
    float lookup_max;                          // photon lookups of a larger radius are not reliable
    struct gather_records
        next;  // of the next indirect bounce; its `gather` is NULL but in `recursive`
};

// The constants of a render without visibility of lights and without records. `maps` may be NULL.
struct gather gather_make(const struct satin_scene *scene, const satin_options *options,
                          const struct photon_maps *maps);

// A surface point prepared for shading in direction wo.
struct gather_point {
    struct interaction interaction;
    struct brdf brdf;
    const struct material_side *side;  // the component of a blend that it is
    struct frame frame;                // of the BRDF; n on the side that reflects
    struct frame base;                 // the frame without bumps, in which records are kept
    vec3 wo_l;                         // towards the viewer, local
    vec3 ng;                           // geometric normal on the viewer's side
    unsigned lobes;                    // of the BRDF, 0 if it reflects nothing
};

// Prepares the point where a ray along d hits s. Of a blend, one component is drawn.
void gather_point_make(const struct satin_scene *scene, const struct interaction *s, vec3 d,
                       struct gather_point *out);
// Prepares the point for a given component.
void gather_point_of(const struct satin_scene *scene, const struct material_side *side,
                     const struct interaction *s, vec3 d, struct gather_point *out);

// Whether indirect light is gathered: its paths have three segments at least.
static inline bool gather_indirect(const satin_options *o) {
    return o->integrator == SATIN_TWO_PASS && (o->max_depth < 0 || o->max_depth > 2);
}

// ---- Direct light (gather_direct.c) ------------------------------------------------------------

// How direct light is split between BRDF sampling and light sampling: for each component of the
// BRDF, how many BRDF samples there are per light sample, drawn from all lobes of the component,
// ideal ones included. Ratio 0: light sampling alone. Lobes of different components do not overlap.
// `depth`: path segments between the eye and the point; panes that light passes add to them.
struct gather_mis {
    int depth;
    struct {
        unsigned lobes;
        float ratio;
    } component[3];
};

// Light samples: how many, at least one, and the number of the first among those of its pixel.
struct gather_lights {
    int samples;
    uint32_t first;
};
// Radiance of direct light reflected at p towards wo by the smooth lobes that `mis` names, by
// sampling the lights, or few lights each once if they are more than the samples, with the power
// heuristic's weight against BRDF sampling. *variance, if not NULL, gets the variance of the
// luminance by one sample; 0 if only one is asked for, or if every light is sampled.
rgb gather_direct(const struct gather *g, const struct gather_point *p, struct gather_mis mis,
                  struct gather_lights lights, struct sampler sampler, float *variance);
// The largest number of surfaces of panes that light may pass on its way to a point at a depth;
// negative if not even direct light is within max_depth.
int gather_panes(const struct gather *g, int depth);
// Density over solid angle [sr^-1] at p with which gather_direct, choosing one light, draws the
// first direction of a straight chain from p to an emitter: `hit` is the surface interaction on it,
// NULL for the environment.
float gather_light_pdf(const struct gather *g, vec3 p, const struct light_chain *chain,
                       const struct interaction *hit);

// The surface that a ray meets first.
struct gather_first {
    float r;  // its distance; INFINITY: there is none
    vec3 ng;  // its geometric normal, on either side; 0 if it is ideally specular, or none
};
#define GATHER_NOTHING ((struct gather_first){.r = INFINITY})

// ---- Direct light at entries (gather_direct_table.c) --------------------------------------------

// Samples the lights at all entries of g->maps, on all threads of the pool. SATIN_ERROR_MEMORY or
// SATIN_CANCELLED; then *out is untouched.
satin_status gather_direct_table_build(const struct gather *g, struct parallel *pool,
                                       struct gather_direct_table *out);
size_t gather_direct_table_bytes(const struct gather_direct_table *table);
void gather_direct_table_free(struct gather_direct_table *table);  // a zeroed one is allowed

// ---- Paths (gather_path.c) ---------------------------------------------------------------------

// Radiance that is reflected towards the start of a gather ray, by path tracing with MIS of light
// and BRDF sampling. Light that is emitted along the ray itself does not count, nor emitted light
// that is seen through ideal specular surfaces alone. *first gets the surface that the ray itself
// meets.
rgb gather_path(const struct gather *g, struct ray ray, struct sampler *sampler,
                struct gather_first *first);

// What an eye ray meets.
struct gather_eye_hit {
    bool hit;
    struct gather_point point;  // of the first surface, if one was hit
    rgb emission;  // emitted light in the radiance, seen directly or through ideal specular
                   // surfaces alone
};
// Radiance along an eye ray by path tracing; option hide_emitters hides the emitters that it meets
// first.
rgb gather_path_eye(const struct gather *g, struct ray ray, struct sampler *sampler,
                    struct gather_eye_hit *out);

// ---- Gather rays (gather_ray.c) ----------------------------------------------------------------

// A gather ray, which the caller fills, and what it found, which gather_rays fills.
struct gather_ray {
    struct ray ray;
    uint32_t item;      // numbers the random decisions behind the hit
    float spread;       // width per distance of what it stands for, for textures; 0: a point
    float alpha_least;  // roughness that lobes at its hit have at least
    const vec3 *lit;  // the point whose light it looks for, to which gather_direct brings the rest:
                      // fill Le, light_pdf and Le_specular; NULL: leave these 0
    // Found:
    rgb L;            // radiance that arrives by reflection, without emitted light
    rgb Le;           // emitted light seen directly, or through panes
    float light_pdf;  // density [sr^-1] at *lit with which light samples draw it
    rgb Le_specular;  // emitted light seen by other ideal specular surfaces
    struct gather_first first;
};

// Memory of one worker of a pool for the hits of its rays; nothing in it outlives a call. One
// thread at a time may use it. If the pool's loop is cancelled, which parallel_stopped reports, the
// rest of many rays are not traced: then the caller drops what the rays found. Without a pool
// (NULL) all are.
struct gather_scratch;
struct gather_scratch *gather_scratch_new(struct parallel *pool, int worker);  // NULL: no memory
void gather_scratch_free(struct gather_scratch *scratch);                      // NULL is allowed

// Follows `ray` through ideal specular surfaces to a point with a smooth lobe, which *out gets.
// False if it meets none. *first gets the surface that it meets first.
bool gather_follow(const struct gather *g, struct ray ray, struct sampler *sampler,
                   struct gather_first *first, struct gather_point *out);

// Traces `count` rays, any number of them. `stream` and each ray's item seed the random decisions.
void gather_rays(const struct gather *g, struct gather_scratch *scratch, struct gather_ray *rays,
                 size_t count, uint64_t stream);

// ---- Hemispheres (gather_hemisphere.c) ---------------------------------------------------------

// Where a hemisphere is gathered.
struct gather_site {
    vec3 p, ng;          // the surface point and its geometric normal
    struct frame frame;  // hemisphere about frame.n
    uint64_t stream;     // random stream of this site
    bool record;         // it stands alone: rays see sharp lobes as wide as what they stand for.
                         // Else it is averaged with others of its pixel
};

// Constants of a stratified hemisphere of about `rays` rays: uniform for harmonics of `order`, or
// cosine-weighted if order is 0. NULL without memory.
struct gather_layout;
struct gather_layout *gather_layout_new(int rays, satin_basis basis, int order);
void gather_layout_free(struct gather_layout *layout);          // NULL is allowed
size_t gather_layout_rays(const struct gather_layout *layout);  // exactly, M * N

// A hemisphere of gather rays and what they found. The stratified rays come first: stratum (j, k)
// of the layout is ray j * N + k; guided rays follow. It owns the arrays, of which `count` entries
// are filled unless said otherwise.
struct gather_hemisphere {
    const struct gather_layout *layout;
    struct frame frame;        // of the site: local directions are in it
    size_t stratified, count;  // rays that are stratified, and all
    struct gather_ray *ray;    // L is weighted: every ray counts as a stratified one does
    float *x, *y, *z;          // local directions
    float *r, *g, *b;          // L times the solid angle of a stratified ray, 2 pi / stratified;
                               // undefined in a cosine-weighted layout
    float *work;               // 6 * count: for what is computed from the hemisphere
};

// Memory for up to `rays` stratified rays, and for half as many guided ones. NULL without memory.
struct gather_hemisphere *gather_hemisphere_new(size_t rays);
void gather_hemisphere_free(struct gather_hemisphere *hemisphere);  // NULL is allowed

// Fills *out, whatever it held, by the stratified rays of `layout` from the site, and by guided
// ones beside them if the options ask for them. It must have memory for the layout's rays.
void gather_hemisphere_trace(const struct gather *g, const struct gather_layout *layout,
                             const struct gather_site *site, struct gather_scratch *scratch,
                             struct gather_hemisphere *out);

// What each worker of a pool gathers with: an array of parallel_threads(pool), or of one if the
// pool is NULL, for hemispheres of up to `rays` stratified rays. NULL without memory.
struct gather_worker {
    struct gather_scratch *scratch;
    struct gather_hemisphere *hemisphere;
};
struct gather_worker *gather_workers_new(struct parallel *pool, size_t rays);
void gather_workers_free(struct gather_worker *workers, int count);  // NULL is allowed

// Irradiance on a point, with gradients.
struct gather_irradiance {
    rgb E;
    vec3 grad_t[3];  // translation: dE/dp per channel, world, in the tangent plane
    vec3 grad_r[3];  // rotation: E changes by (n_i x n) . grad_r
    uint32_t rays;   // that it was made from
};

// Incident radiance in harmonics [K05 (4.9)], in the site's frame. Arrays of 3 * order^2 (channel
// by channel), owned by the caller; dx and dy, the derivatives by p along the frame's axes, may be
// NULL.
struct gather_radiance {
    float *lambda, *dx, *dy;
    // order^2, or NULL: luminance projected with alternating signs of the strata. Its product with
    // a lobe has the standard deviation of what the lobe reflects of lambda.
    float *noise;
    uint32_t rays;  // that it was made from
};

enum { GATHER_SECTORS = 32 };

// What the rays found around the site (gather_around.c). Distances are INFINITY if nothing was hit.
struct gather_around {
    float harmonic;       // harmonic mean of hit distances
    float least;          // least hit distance
    float least_upright;  // least one without rays that graze both the site's surface and the other
    float sector[GATHER_SECTORS];  // along the tangent plane to what stands there, by azimuth
    float deviation;               // standard deviation of E, as a fraction of E [K05 6.4]
    float hessian[3];  // d2E/dx2, d2E/dxdy, d2E/dy2 of luminance in the frame, if asked for
};

// Irradiance by a hemisphere of a cosine-weighted layout.
void gather_hemisphere_irradiance(const struct gather *g,
                                  const struct gather_hemisphere *hemisphere,
                                  struct gather_irradiance *out);
// Incident radiance by a hemisphere of a uniform layout.
void gather_hemisphere_radiance(const struct gather *g, const struct gather_hemisphere *hemisphere,
                                struct gather_radiance *out);
// Radiance that `lobes` of a BRDF in the site's frame reflect towards wo (local): the sum over the
// rays of a hemisphere of a uniform layout.
rgb gather_hemisphere_reflected(const struct gather_hemisphere *hemisphere, const struct brdf *brdf,
                                vec3 wo, unsigned lobes);
// Fills *out; `hessian` asks for the Hessian, which only a cosine-weighted layout gives.
void gather_around_make(const struct gather_hemisphere *hemisphere, bool hessian,
                        struct gather_around *out);

#endif
