// SPDX-License-Identifier: Apache-2.0
// Private to photon/: a map of photons, what it is made of and how it is searched.
#ifndef PHOTON_MAP_H
#define PHOTON_MAP_H

#include "photon/photon.h"
#include "photon/photon_curve.h"
#include "photon/photon_index.h"

enum {
    PHOTON_K_MAX = 10000,      // photons in one density estimate, the bound of options->photon_k
    PHOTON_STRIDE = 8,         // irradiance is precomputed at every 8th photon of the sorted map
    PHOTON_CAUSTIC_STRIDE = 1  // and at every one of the caustic map
};

// ---- Photons ----------------------------------------------------------------------------------

// A photon as it was traced.
struct photon_hit {
    vec3 p;
    rgb power;       // [W]
    uint32_t wi, n;  // packed directions: to where it came from; geometric normal on that side
    bool last;       // it has bounced as often as photons may
};

// A photon in a map, where the positions stand apart for the search.
struct photon {
    rgb power;
    uint32_t wi, n;
    bool last;  // as of photon_hit
};

// Unit vectors in 32 bits, by the octahedral map [Cigolle et al. 2014]; off by at most 7e-5 rad.
uint32_t photon_pack(vec3 w);
vec3 photon_unpack(uint32_t packed);

// Least cosine between normals of one surface, within a density estimate's disc.
#define PHOTON_FACING 0.5f

// ---- Tracing (photon_trace.c) -----------------------------------------------------------------

// Photons that a tracing pass leaves to one consumer. By malloc; free with photon_trace_free.
struct photon_trace {
    struct photon_hit *hit;
    size_t count;
    uint64_t emitted;  // paths that were started for this consumer
    uint64_t refused;  // photons of the pass that were not finite, for any consumer
    uint64_t stored[PHOTON_CLASSES];
};

// A consumer of the photons of a pass, who gets them as if the pass had just these paths.
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
    int bounces;  // photons that bounced more often are not kept; < 0: no limit
    // Caustic pass: paths end at their first smooth scattering; this says where they start and how
    // many they are. NULL: all.
    const struct guide_emission *emission;
};

// Traces the paths of all consumers; out[i] gets the photons of consumer i. SATIN_CANCELLED or
// SATIN_ERROR_MEMORY on failure; then `out` is untouched.
satin_status photon_trace_run(const struct photon_tracing *tracing, struct parallel *pool,
                              struct log log, struct photon_trace out[PHOTON_CONSUMERS]);
void photon_trace_free(struct photon_trace *trace);

// ---- The map (photon_map.c) -------------------------------------------------------------------

struct photon_map {
    size_t count;
    float *position;        // 3 per photon, sorted along a Morton curve
    struct photon *photon;  // `count`, in the same order
    struct photon_index *index;
    uint8_t *open;  // every stride-th photon: nothing cuts its disc
    size_t stride;
    bool limited;               // photons may bounce so and so often
    float radius_max;           // of an estimate
    struct photon_curve curve;  // along which the photons are sorted
};
// The bound of an estimate's squared radius.
static inline float photon_map_far2(const struct photon_map *map) {
    return map->radius_max * map->radius_max;
}

// Makes a map of copies of the hits; an empty one of none. SATIN_CANCELLED or SATIN_ERROR_MEMORY.
satin_status photon_map_build(const struct satin_scene *scene, const struct photon_hit *hit,
                              size_t count, struct parallel *pool, struct log log,
                              struct photon_map *out);
void photon_map_free(struct photon_map *map);
size_t photon_map_bytes(const struct photon_map *map);

static inline vec3 photon_position(const struct photon_map *map, size_t i) {
    const float *p = map->position + 3 * i;
    return v3(p[0], p[1], p[2]);
}

// ---- The area that is there (photon_area.c) ---------------------------------------------------

enum { AREA_SECTORS = 16 };

// The area of a disc of radius r around a surface point where there is surface of the same facing,
// as rays from just above the point meet it: its extent by direction.
struct photon_area {
    struct frame frame;
    float rotation;               // of the first sector, radians
    float inverse[AREA_SECTORS];  // 1 / extent in units of r; up to 1: the disc's rim is reached
    bool open;                    // all of the disc is there
};

// `key` rotates the sectors, so that no direction is favoured.
void photon_area_make(const struct satin_scene *scene, vec3 p, vec3 n, float r, uint64_t key,
                      struct photon_area *out);
// Whether all of the disc is there; quick to say no.
bool photon_area_clear(const struct satin_scene *scene, vec3 p, vec3 n, float r);
// Whether p + d is in the area that is there.
bool photon_area_has(const struct photon_area *area, vec3 d, float r);

// Kernels: weights over q = (d / r)^2 in [0, 1], of mean 1 over the disc.
enum photon_kernel { KERNEL_FLAT = 0, KERNEL_PARABOLA };
static inline float photon_kernel_weight(enum photon_kernel kernel, float q) {
    return kernel == KERNEL_FLAT ? 1.0f : 2.0f * (1.0f - q);
}
// The kernel's integral over what is there of the disc, over that of the whole.
float photon_area_fraction(const struct photon_area *area, enum photon_kernel kernel);

// ---- Density (photon_density.c) ---------------------------------------------------------------

// One density estimate: the photons near p, and the area that they came down on.
struct photon_disc {
    const struct photon_map *map;
    vec3 p, n;
    enum photon_kernel kernel;
    int count;  // entries of row and distance2, which the caller owns
    const int *row;
    const float *distance2;
    float r, r2;     // its radius, and squared; 0: no photons
    float scale;     // 1 / (area of the disc that is there) [m^-2]
    bool corrected;  // photons count only where `area` has surface
    struct photon_area area;
};

// What a disc is made from.
struct photon_query {
    const struct photon_map *map;
    const struct satin_scene *scene;
    vec3 p, n;  // n unit, the geometric normal on the side that is lit
    int k;
    enum photon_kernel kernel;
    enum photon_correction { AREA_WHOLE = 0, AREA_IF_NEEDED, AREA_MEASURED } correction;
};

// Of the 2 k photons nearest to a point, moves the k nearest to the front. Returns the radius of a
// disc as large as the ring in which the others lie: as the k in it are others than those of the
// estimate, it says how wide the estimate is without regard to whether it came out bright or dark.
// The radius of the disc itself if there are no 2 k photons.
float photon_ring_radius(int *row, float *distance2, int k);
// Sets up the disc of the k rows that photon_index_nearest found for the query.
void photon_disc_make(const struct photon_query *query, const int *row, const float *distance2,
                      struct photon_disc *out);
// The weight of entry i of the disc [m^-2]; 0 for a photon that does not count.
float photon_disc_weight(const struct photon_disc *disc, int i);
// Irradiance [W m^-2]: the weighted sum of the photons' power.
rgb photon_disc_irradiance(const struct photon_disc *disc);
// As much of it as photons bring that have bounced as often as they may.
rgb photon_disc_last(const struct photon_disc *disc);
// The variance of that sum over all channels: the sum of the squares.
float photon_disc_variance(const struct photon_disc *disc);
// The least distance from the centre at which a wall or an edge may be, by the sectors of the disc.
float photon_disc_clear(const struct photon_disc *disc);

// ---- Irradiance at photons (photon_irradiance.c) ----------------------------------------------

// The positions at which irradiance was precomputed, as rows of the search index.
struct photon_positions {
    float *row;    // 6 each: position, scale * normal
    float scale;   // positive
    float *clear;  // distance from each within which no wall or edge is
};
static inline vec3 photon_entry_position(const struct photon_positions *positions, size_t i) {
    const float *q = positions->row + 6 * i;
    return v3(q[0], q[1], q[2]);
}
void photon_entry_position_set(struct photon_positions *positions, size_t i, vec3 p, vec3 n);
// Whether a wall stands between position i and p, a point on a surface with normal n.
bool photon_entry_position_hidden(const struct photon_positions *positions,
                                  const struct satin_scene *scene, size_t i, vec3 p, vec3 n);

// Irradiance that was precomputed at positions of photons, which are its entries.
struct photon_irradiance {
    size_t count;    // of entries
    size_t refused;  // estimates that were not finite
    struct photon_positions position;
    rgb *E;            // by entry [W m^-2]
    rgb *last;         // by entry, of E by photon_disc_last; NULL: photons may bounce at will
    float *radius;     // by entry, of its estimate; INFINITY: the map has too few photons
    float *ring;       // by entry, of the photons around those of its estimate: photon_ring_radius
    float influence2;  // squared influence radius of an entry, in units of its squared radius
    bool ends;         // nothing is left of it at three times its influence radius
    float far2;        // squared distance of rows beyond which no entry answers
    struct photon_index *index;
};

// What irradiance is precomputed from.
struct photon_precompute {
    struct photon_map *map;
    const struct satin_scene *scene;
    size_t stride;  // at every so many photons
    int k;          // photons of an estimate
    enum photon_kernel kernel;
    bool area;    // estimates divide by the area that is there
    bool smooth;  // by photon_caustic_smooth
    bool ends;    // light has borders, as caustics have: where no photons are near, there is none
};

// Precomputes irradiance at every stride-th photon of the map, and the map's `open` flags.
// SATIN_CANCELLED or SATIN_ERROR_MEMORY.
satin_status photon_irradiance_build(const struct photon_precompute *what, struct parallel *pool,
                                     struct log log, struct photon_irradiance *out);
// Takes noise off the irradiance of all entries (photon_caustic_smooth.c). SATIN_CANCELLED or
// SATIN_ERROR_MEMORY; then some entries may be changed.
satin_status photon_caustic_smooth(const struct photon_precompute *what, struct parallel *pool,
                                   struct photon_irradiance *irradiance);
void photon_irradiance_free(struct photon_irradiance *irradiance);
size_t photon_irradiance_bytes(const struct photon_irradiance *irradiance);
// The entry that answers for p on the side of n, or -1.
int photon_irradiance_entry(const struct photon_irradiance *irradiance, vec3 p, vec3 n);
// Whether nothing stands between p and the entry's position, a little above the surface.
bool photon_irradiance_sees(const struct photon_irradiance *irradiance,
                            const struct satin_scene *scene, int entry, vec3 p, vec3 n);
// Irradiance at p by an entry; black for entry -1.
rgb photon_irradiance_value(const struct photon_irradiance *irradiance, int entry, vec3 p);

// ---- Direct light at entries (photon_direct.c) ------------------------------------------------

// Adds up the direct photons that came down nearest to each entry; *out has one item per entry, by
// malloc, and is NULL if there are no photons or entries. SATIN_CANCELLED or SATIN_ERROR_MEMORY.
satin_status photon_direct_build(const struct photon_irradiance *irradiance,
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
};

#endif
