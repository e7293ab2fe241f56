// SPDX-License-Identifier: Apache-2.0
// Private to photon/: a photon map, how it is built and how it is searched.
#ifndef PHOTON_MAP_H
#define PHOTON_MAP_H

#include "photon/photon.h"
#include "photon/photon_index.h"
#include "photon/photon_morton.h"
#include "photon/photon_voxel.h"

enum {
    PHOTON_K_MAX = 10000,  // largest number of photons of a density estimate, the limit of
                           // options->photon_k
    PHOTON_STRIDE = 8,     // irradiance is precomputed at every 8th photon of the sorted global map
    PHOTON_CAUSTIC_STRIDE = 1  // that of caustics is precomputed at every photon of their map
};

// ---- Photons ------------------------------------------------------------------------------------

enum { PHOTON_BOUNCES_MOST = UINT8_MAX };

// The most that a shading normal which is tilted towards a photon raises its power, as the few
// photons at grazing angles would be very bright.
#define PHOTON_TILT_MOST 8.0f

// A photon as it was traced.
struct photon_hit {
    vec3 p;
    rgb power;          // [W]
    uint32_t wi, n;     // packed directions: to its origin; geometric normal on that side
    uint8_t bounces;    // number of its bounces before, at most PHOTON_BOUNCES_MOST
    bool last : 1;      // whether it has bounced as often as photons may
    bool indirect : 1;  // whether it is of class PHOTON_INDIRECT
    uint8_t path : 6;   // a hash of the light path on which it is
    int8_t tilt;        // see photon_pack_tilt
    uint8_t copies;  // of a divided photon: how many of its copies an estimate there counts, apart
                     // from this one
};

// A photon in a map, which has the positions in a separate array for the search.
struct photon {
    rgb power;
    uint32_t wi, n;
    uint8_t bounces;  // these as in photon_hit
    bool last : 1, indirect : 1;
    uint8_t path : 6;
    int8_t tilt;
    uint8_t copies;
};

// Packs a unit vector into 32 bits by the octahedral map [Cigolle et al. 2014], with an error of at
// most 7e-5 rad.
uint32_t photon_pack(vec3 w);
vec3 photon_unpack(uint32_t packed);

// Packs the factor of a photon's power for irradiance of the plane of the shading normal, by which
// BRDFs and so reflected light are defined [Veach 1997, 5.3.2]: the cosine of wi with this normal
// over that with n, times the shadowing by the slopes of a bump or normal map. It is at
// most PHOTON_TILT_MOST. A factor of .12 and more has an error of at most .83 %, 1 none, and one
// below .06 becomes 0.
int8_t photon_pack_tilt(float factor);
float photon_unpack_tilt(int8_t packed);

// The least cosine between normals of one surface within the disc of a density estimate.
#define PHOTON_FACING 0.5f
// Largest distance of a photon from the plane of a point, as a fraction of the disc's radius.
#define PHOTON_LAYER 0.35f
// Whether a photon of normal m, at a height over the plane of a point of normal n, is on the same
// surface, for a disc of this squared radius.
static inline bool photon_is_on_surface(vec3 n, vec3 m, float height, float r2) {
    return v3_dot(n, m) >= PHOTON_FACING && height * height <= PHOTON_LAYER * PHOTON_LAYER * r2;
}

// ---- Tracing (photon_trace.c) -------------------------------------------------------------------

// What becomes of the power that lights emit [W, luminance]: surfaces absorb it, it leaves the
// scene, or its photons end, as they have no more bounces or are refused. Together this is what was
// emitted. What is absorbed is negative where surfaces send out more than they receive.
struct photon_power {
    double emitted, absorbed, escaped, ended;
};
// It is known for each light of a scene; the last one of many stands for all that follow, too.
enum { PHOTON_POWERS = 16 };
static inline uint32_t photon_power_index(uint32_t light) {
    return light < PHOTON_POWERS ? light : PHOTON_POWERS - 1;
}

// The photons of a tracing pass for one consumer. From malloc; freed by photon_trace_free.
struct photon_trace {
    struct photon_hit *hit;
    size_t count;
    uint64_t emitted;  // number of paths that were started for this consumer
    uint64_t refused;  // photons of the pass that were not finite, for any consumer
    uint64_t stored[PHOTON_CLASSES];
    struct photon_power power[PHOTON_POWERS];  // of all paths of the pass; 0 for a caustic pass
};

// A consumer of the photons of a pass. It gets them as if the pass had only these paths.
struct photon_consumer {
    uint64_t paths;                             // 0: none
    unsigned classes;                           // mask of 1 << photon_class
    const struct guide_allocation *allocation;  // how paths are allocated to lights; NULL: by power
};
enum { PHOTON_CONSUMERS = 3 };

struct photon_tracing {
    const struct satin_scene *scene;
    uint64_t seed;
    struct photon_consumer consumer[PHOTON_CONSUMERS];
    int bounces;  // photons that have bounced more often are not stored; < 0: no limit
    // Caustic pass: where paths start, and how many; paths end at their first smooth scattering.
    // NULL: a pass for all photons.
    const struct guide_emission *emission;
    // Where light from infinitely far enters, for a pass for all photons; NULL: everywhere.
    const struct light_aim *aim;
    // Paths of all batches of which this pass is one, each of which emits all light: its power is
    // that of its paths among them. 0: it is the only one.
    uint64_t batches;
    bool repeated;  // whether it emits the light of a pass before it again, whose power is known
    bool passing;   // photons serve only until the results of their pass or batch are written
};

// Traces the paths of all consumers and sets out[i] to the photons of consumer i. On failure,
// SATIN_CANCELLED or SATIN_ERROR_MEMORY, `out` is unchanged.
satin_status photon_trace_run(const struct photon_tracing *tracing, struct parallel *pool,
                              struct log log, struct photon_trace out[PHOTON_CONSUMERS]);
void photon_trace_free(struct photon_trace *trace);
// Adds the counts of a trace to the statistics photons.*.
void photon_trace_count(const struct photon_trace *trace, struct stats *stats);
// Multiplies the statistics photons.*power_*.
void photon_power_scale(double factor, struct stats *stats);

// ---- The map (photon_map.c) ---------------------------------------------------------------------

struct photon_map {
    size_t count;
    float *position;        // 3 per photon, sorted in Morton order
    struct photon *photon;  // `count`, in the same order
    struct photon_index *index;
    uint8_t *whole_disc;  // of every stride-th photon: whether no edge or wall cuts its disc
    size_t stride;
    float *radius2;               // of each photon's own disc, squared; NULL: not known
    struct photon_own_area *own;  // of that disc; NULL: not known
    struct photon_cover *cover;   // around these discs, by node of the index; NULL: not known
    bool limited;                 // whether the number of bounces of photons is limited
    float radius_max;             // largest radius of an estimate
    struct photon_morton morton;  // the order in which the photons are sorted
};
// The number of photons of an estimate by that of an option: at least two, as the outermost one is
// not counted.
static inline int photon_clamp_k(int k) { return k < 2 ? 2 : k > PHOTON_K_MAX ? PHOTON_K_MAX : k; }
// The limit of an estimate's squared radius.
static inline float photon_map_far2(const struct photon_map *map) {
    return map->radius_max * map->radius_max;
}

// Builds a map of copies of the hits, which may be none. SATIN_CANCELLED or SATIN_ERROR_MEMORY.
satin_status photon_map_build(const struct satin_scene *scene, const struct photon_hit *hit,
                              size_t count, struct parallel *pool, struct log log,
                              struct photon_map *out);
// Traces the photons of all consumers, builds the map from those of the first one, frees these, and
// adds to the statistics photons.*. SATIN_CANCELLED or SATIN_ERROR_MEMORY.
satin_status photon_map_trace(const struct photon_tracing *tracing, struct parallel *pool,
                              struct log log, struct stats *stats, struct photon_map *map,
                              struct photon_trace trace[PHOTON_CONSUMERS]);
void photon_map_free(struct photon_map *map);
// Sets map->radius2 (photon_radii.c). SATIN_CANCELLED or SATIN_ERROR_MEMORY.
satin_status photon_map_find_radii(struct photon_map *map, int k, struct parallel *pool);
// Lessens radii that photon_map_find_radii found with k, where light is curved
// (photon_bandwidth.c). Statuses as of that; then radii may be of either kind.
satin_status photon_map_narrow_radii(struct photon_map *map, int k, struct parallel *pool);
size_t photon_map_bytes(const struct photon_map *map);

// How strong photons are divided (photon_divide.c).
struct photon_divide {
    uint64_t seed;
    int k;              // photons of an estimate
    float irradiance;   // the mean one of lit surfaces, luminance; 0: none is divided
    float radius_most;  // in which a photon may be divided
};
// Replaces the photons of a map that would be visible as single bright discs by weaker ones around
// them. map->radius_max must be that of estimates. On failure the map is unchanged:
// SATIN_CANCELLED or SATIN_ERROR_MEMORY.
satin_status photon_map_divide(const struct photon_divide *by, const struct satin_scene *scene,
                               struct parallel *pool, struct log log, struct photon_map *map);

static inline vec3 photon_position(const struct photon_map *map, size_t i) {
    const float *p = map->position + 3 * i;
    return v3(p[0], p[1], p[2]);
}

// ---- The area that is there (photon_area.c) -----------------------------------------------------

// Directions of an area, and the points along each at which the map's own discs look for gaps. On
// strips narrower than a disc one point keeps .6 of the power, two .8, and three all of it, for 1.2
// times the time of the estimates (docs/experiments/first-passes.md).
enum { AREA_SECTORS = 16, AREA_POINTS = 3 };

// The area of a disc of radius r around a surface point in which there is a surface of the same
// orientation, found by rays from just above the point: its extent by direction.
struct photon_area {
    struct frame frame;
    float height;                 // of the rays over the point
    float rotation;               // of the first sector, in radians
    float inverse[AREA_SECTORS];  // 1 / extent in units of r; up to 1 the surface extends to the
                                  // boundary of the disc
    bool whole_disc;              // whether the surface covers the whole disc
};

// Measures an area. Along each direction the surface is looked for at so many points, at least one;
// the last one is at the boundary of the disc.
void photon_area_make(const struct satin_scene *scene, vec3 p, vec3 n, float r, int points,
                      struct photon_area *out);
// Whether a ray at the height of the area, from over its point p to over the photon at q, meets a
// wall. Where walls meet, extents that are interpolated between two directions go beyond them.
bool photon_area_hides(const struct satin_scene *scene, const struct photon_area *area, vec3 p,
                       vec3 q);
// The rotation of the first sector around p in radians, by the bits of p: no direction is
// preferred.
float photon_area_rotation(vec3 p);
// The real number in [0, AREA_SECTORS] of the sector in which (x, y) is, in the frame of an area.
float photon_area_sector(float x, float y, float rotation);
// The largest 1 / extent, at least 1.
float photon_area_inverse(const struct photon_area *area);
// The centroid of the area in the frame of it, in units of r.
vec2 photon_area_centroid(const struct photon_area *area);
// Whether the surface covers the whole disc; fast if it does not. So it does in smaller discs, down
// to this fraction of the radius: no edge is so low that only the larger ones extend beyond it.
bool photon_area_clear(const struct satin_scene *scene, vec3 p, vec3 n, float r, float smallest);
// A position around which there is no edge or wall up to a distance; 0: not known.
struct photon_clearing {
    vec3 p, n;
    float radius, smallest;  // the least radius of a disc that is known to be clear in it
};
// Photons, neighbours in Morton order, for which one clearing is tried: far from edges, it saves
// their rays.
enum { PHOTON_CLEARING_DISCS = 8 };
// The clearing around the disc of radius r at p, somewhat larger than the disc.
struct photon_clearing photon_clearing_find(const struct satin_scene *scene, vec3 p, vec3 n,
                                            float r);
// Whether all of the disc of radius r at p is in the clearing.
bool photon_clearing_has(const struct photon_clearing *clearing, vec3 p, vec3 n, float r);
// The height above a photon's plane from which the surface around it is searched: above ripples,
// and below objects that stand on it; as a fraction of the distance or of the disc's radius. It
// hardly matters: of 1,910 and 2,270 copies of photons in staircase2 and living-room
// (photon_divide.c), 33 and 370 find no surface; with .025 they are 37 and 392, with .4 32 and 296.
#define PHOTON_SURFACE_HEIGHT 0.1f
// The surface below a point, up to `depth` against n: its position and its geometric normal on the
// side of n. False if there is none; then they are unchanged. Holes of masks count as surface.
bool photon_surface_below(const struct satin_scene *scene, vec3 above, vec3 n, float depth, vec3 *p,
                          vec3 *ng);
// Whether p + d is within the area.
bool photon_area_has(const struct photon_area *area, vec3 d, float r);

// Kernels: weights over q = (d / r)^2 in [0, 1], of mean 1 over the disc.
enum photon_kernel { KERNEL_FLAT = 0, KERNEL_PARABOLA };
static inline float photon_kernel_weight(enum photon_kernel kernel, float q) {
    return kernel == KERNEL_FLAT ? 1.0f : 2.0f * (1.0f - q);
}
// The kernel's integral over the area, over its integral over the whole disc.
float photon_area_fraction(const struct photon_area *area, enum photon_kernel kernel);

// ---- Density (photon_density.c) -----------------------------------------------------------------

// One density estimate: the photons near p, and the area of their surface.
struct photon_disc {
    const struct photon_map *map;
    vec3 p, n;
    enum photon_kernel kernel;
    int count;  // number of entries of row and distance2, which the caller owns
    const int *row;
    const float *distance2;
    float r, r2;     // its radius, and squared; 0: no photons
    float scale;     // 1 / (area of the surface in the disc) [m^-2]; not used if `own`
    bool corrected;  // whether photons count only inside `area`
    struct photon_area area;
    int points;  // see photon_area_make; 0: AREA_POINTS
    bool own;    // whether each photon's kernel has the radius and the area of its own disc, which
                 // must be known (photon_cover.h); r, r2 and scale are not used then
};

// The input of a disc.
struct photon_query {
    const struct photon_map *map;
    const struct satin_scene *scene;
    vec3 p, n;  // n is the unit geometric normal on the lit side
    int k;
    enum photon_kernel kernel;
    enum photon_correction { AREA_WHOLE = 0, AREA_IF_NEEDED, AREA_MEASURED } correction;
};

// The squared radius of the disc of k rows that photon_index_nearest found: that of the outermost
// of them, or the map's limit if that is smaller or if the map has fewer photons.
float photon_radius2(const struct photon_map *map, const int *row, const float *distance2, int k);
// Moves the k nearest of the 2 k photons nearest to a point to the front. Returns the radius of a
// disc with the area of the ring of the others: its k photons are not those of the estimate, so it
// measures the width of the estimate independently of its value. If there are fewer than 2 k
// photons, it is the radius of the disc itself.
float photon_ring_radius(int *row, float *distance2, int k);
// Searches the photons of a query and makes their disc; row and distance2 have PHOTON_K_MAX items.
void photon_disc_find(const struct photon_query *query, int *row, float *distance2,
                      struct photon_disc *out);
// Makes the disc of the k rows that photon_index_nearest found for the query.
void photon_disc_make(const struct photon_query *query, const int *row, const float *distance2,
                      struct photon_disc *out);
// Removes the photons that do not count from those of a disc, whose row and distance2 these are:
// those that are not within its radius or on its surface, those of a surface behind its own one or
// before it, for which a ray finds whether it is another one, or curved or stepped, and, if walls
// cut the disc, those behind these.
void photon_disc_drop_hidden(const struct satin_scene *scene, int *row, float *distance2,
                             struct photon_disc *disc);
// Sets the scale of a disc whose other members are set, by the area of the surface in it, which is
// measured in the scene; NULL: that of the whole disc.
void photon_disc_scale(struct photon_disc *disc, const struct satin_scene *scene);
// The weight of entry i of the disc [m^-2]; 0 if the photon is not counted.
float photon_disc_weight(const struct photon_disc *disc, int i);
// Irradiance [W m^-2]: the weighted sum of the photons' power.
rgb photon_disc_irradiance(const struct photon_disc *disc);
// That of photons that have bounced so often at most.
rgb photon_disc_irradiance_within(const struct photon_disc *disc, int bounces);
// A surface point that reflects the photons of a disc.
struct photon_reflection {
    const struct frame *frame;
    const struct brdf *brdf;
    vec3 wo;         // local
    unsigned lobes;  // smooth lobes
    float pdf_most;  // the glossy lobe is left out in directions of a larger density [sr^-1]
    int bounces;     // photons that have bounced more often are left out
};
// All photons, by all of the lobes.
static inline struct photon_reflection photon_reflection_make(const struct frame *frame,
                                                              const struct brdf *brdf, vec3 wo,
                                                              unsigned lobes) {
    return (struct photon_reflection){frame, brdf, wo, lobes, INFINITY, PHOTON_BOUNCES_MOST};
}
// The radiance that the point reflects. Photons carry flux per geometric area, while reflection is
// by the cosine to the shading normal.
rgb photon_disc_radiance(const struct photon_disc *disc, const struct photon_reflection *at);
// That part of the irradiance whose photons have bounced as often as they may.
rgb photon_disc_last(const struct photon_disc *disc);
// Whether the photons of a disc without hidden ones are those of few light paths
// (photon_reliable.c). In a crack between bright walls a photon that has found its way in is stored
// dozens of times, and looks like dense light.
bool photon_disc_has_few_paths(const struct photon_disc *disc);
// Whether they lie on one side of the surface in it, as beside a bright strip.
bool photon_disc_is_aside(const struct photon_disc *disc);
// Whether gather rays may read the estimate: neither is so.
bool photon_disc_reliable(const struct photon_disc *disc);
// The number of photons that would be counted if all of a disc of radius r > 0 were surface, up to
// about `most`. Others of its photons are on the other side of the surface, or on other ones.
float photon_disc_counted(const struct photon_disc *disc, float most);
// The variance of the irradiance, summed over the channels: the sum of the squares.
float photon_disc_variance(const struct photon_disc *disc);
// The least distance from the centre to a wall or an edge, by the sectors of the disc.
float photon_disc_clear(const struct photon_disc *disc);

// The height of the step from p, of unit normal n, to q, of unit normal m: > 0 if q is higher; 0 if
// there is none, as both are before the plane of the other or both are behind it, or it is less
// than a hundredth of their distance (photon_layer.c).
float photon_layer_step(vec3 p, vec3 n, vec3 q, vec3 m);

// ---- Irradiance at photons (photon_irradiance.c) ------------------------------------------------

// The positions at which irradiance was precomputed, as rows of the search index.
struct photon_positions {
    float *row;    // 6 each: position, scale * normal
    float scale;   // positive
    float *clear;  // distance from each up to which there is no wall or edge
};
static inline vec3 photon_entry_position(const struct photon_positions *positions, size_t i) {
    const float *q = positions->row + 6 * i;
    return v3(q[0], q[1], q[2]);
}
static inline vec3 photon_entry_normal(const struct photon_positions *positions, size_t i) {
    const float *row = positions->row + 6 * i, s = 1.0f / positions->scale;
    return v3(s * row[3], s * row[4], s * row[5]);
}
// Sets a row of the search index, or a query.
static inline void photon_entry_row_set(float row[6], vec3 p, vec3 n, float scale) {
    row[0] = p.x;
    row[1] = p.y;
    row[2] = p.z;
    row[3] = scale * n.x;
    row[4] = scale * n.y;
    row[5] = scale * n.z;
}
void photon_entry_position_set(struct photon_positions *positions, size_t i, vec3 p, vec3 n);

// Irradiance that was precomputed at the positions of photons, the entries.
struct photon_irradiance {
    size_t count;    // number of entries
    size_t refused;  // number of estimates that were not finite
    struct photon_positions position;
    rgb *E;            // by entry [W m^-2]
    rgb *last;         // by entry: photon_disc_last; NULL: bounces are not limited, or light ends
    uint8_t *bounces;  // by entry of light that ends: the largest number of bounces of a photon of
                       // its estimate; NULL: not limited
    float *radius;     // by entry: radius of its estimate; INFINITY: the map has too few photons
    float *ring;       // by entry: photon_ring_radius; INFINITY: its photons are of few light
                       // paths; NULL for light that ends
    float fade2;       // squared distance from which on an entry fades, over its squared radius
    bool ends;         // whether its light is 0 from three times that distance on
    float far2;        // squared distance of rows beyond which no entry is used
    float radius_max;  // that of the map
    struct photon_index *index;
    struct photon_voxels voxels;
};

// Parameters of the precomputation of irradiance.
struct photon_precompute {
    struct photon_map *map;
    const struct satin_scene *scene;
    size_t stride;  // irradiance is computed at every stride-th photon
    int k;          // number of photons of an estimate
    enum photon_kernel kernel;
    bool area;     // whether estimates divide by the area of the surface in the disc
    bool smooth;   // whether photon_caustic_smooth is applied
    bool ends;     // whether light has borders, as caustics have: there is none where there are no
                   // photons, and each photon has a radius of its own
    bool narrows;  // whether an estimate whose photons lie on one side is made of fewer of them
};

// Computes irradiance at every stride-th photon of the map, and sets the map's `whole_disc` flags.
// SATIN_CANCELLED or SATIN_ERROR_MEMORY.
satin_status photon_irradiance_build(const struct photon_precompute *what, struct parallel *pool,
                                     struct log log, struct photon_irradiance *out);
// Removes noise from the irradiance of all entries (photon_caustic_smooth.c). After SATIN_CANCELLED
// or SATIN_ERROR_MEMORY, some entries may be changed.
satin_status photon_caustic_smooth(const struct photon_precompute *what, struct parallel *pool,
                                   struct photon_irradiance *irradiance);
void photon_irradiance_free(struct photon_irradiance *irradiance);
size_t photon_irradiance_bytes(const struct photon_irradiance *irradiance);
// As photon_irradiance_area.
float photon_irradiance_entry_area(const struct photon_irradiance *irradiance, size_t entry);

// ---- Noise (photon_noise.c) ---------------------------------------------------------------------

// The variance of the luminance of a disc's irradiance over its square, from its photons; negative
// if it has no light.
double photon_disc_noise2(const struct photon_disc *disc);
// Sets maps->noise2, given the global map and the entries. SATIN_ERROR_MEMORY.
satin_status photon_noise_find(const struct satin_scene *scene, struct parallel *pool,
                               struct photon_maps *maps);

// ---- Batches of photons (photon_reverse.c) ------------------------------------------------------

// All batches of first pass `reverse`.
struct photon_reverse {
    const struct photon_tracing *tracing;  // of the first batch
    uint64_t paths, batches;               // of all batches; the number of batches, at least 1
};
// The number of paths of a batch.
uint64_t photon_reverse_paths(const struct photon_reverse *what, uint64_t batch);
// Traces all batches but the first one, whose map is `first`, and adds them to the irradiance that
// was computed from it, which becomes that of all photons. Frees the map, and adds to the
// statistics photons.*. After SATIN_CANCELLED or SATIN_ERROR_MEMORY, the irradiance is of no use.
satin_status photon_reverse_add(const struct photon_reverse *what, struct photon_map *first,
                                struct parallel *pool, struct log log, struct stats *stats,
                                struct photon_irradiance *irradiance);

// ---- Lookups of entries (photon_lookup.c) -------------------------------------------------------

// Light that ends is 0 beyond this times the squared distance at which it begins to fade.
#define PHOTON_ENDS 9.0f
// The entry that is read at p on the side of n, or -1.
int photon_irradiance_entry(const struct photon_irradiance *irradiance, vec3 p, vec3 n);
// Whether the entry's position is visible from p, along a ray a little above the surface.
bool photon_irradiance_visible(const struct photon_irradiance *irradiance,
                               const struct satin_scene *scene, int entry, vec3 p, vec3 n);
// Whether the entry's estimate has fewer than k photons, as the map limits its radius.
bool photon_irradiance_sparse(const struct photon_irradiance *irradiance, int entry);
// The irradiance at p by an entry; black for entry -1.
rgb photon_irradiance_value(const struct photon_irradiance *irradiance, int entry, vec3 p);
// Whether a wall separates position i from p, a point on a surface with normal n.
bool photon_entry_position_hidden(const struct photon_positions *positions,
                                  const struct satin_scene *scene, size_t i, vec3 p, vec3 n);

// ---- Direct light at entries (photon_direct.c) --------------------------------------------------

// Sums the direct photons where each entry is read, given the global map of `maps`. *out has one
// item per entry, from malloc; it is NULL if there are no photons or entries. SATIN_CANCELLED or
// SATIN_ERROR_MEMORY.
satin_status photon_direct_build(const struct photon_maps *maps, const struct satin_scene *scene,
                                 const struct photon_trace *direct, struct parallel *pool,
                                 struct log log, struct photon_direct **out);
size_t photon_direct_bytes(const struct photon_maps *maps);

struct photon_maps {
    struct photon_map global, caustic;
    struct photon_irradiance irradiance, caustic_irradiance;
    struct guide_clusters *clusters;  // may be NULL
    struct photon_direct *direct;     // by entry of `irradiance`; may be NULL
    int photon_k, caustic_k;
    bool area, smooth;  // the options photon_area and caustic_smooth
    float lookup_max;
    float noise2;  // see photon_noise2
};

#endif
