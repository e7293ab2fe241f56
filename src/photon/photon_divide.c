// SPDX-License-Identifier: Apache-2.0
// Divides strong caustic photons. Emission is sampled where most caustics begin; a photon from
// elsewhere may have a thousand times the power of the others, and where it lies alone its kernel
// is a bright disc. Such a photon is divided among photons on the surface around it, so widely that
// none of them is visible by itself. Their power is that of the photon.
#include <limits.h>
#include <math.h>
#include <stdlib.h>

#include "base/array.h"
#include "base/rng.h"
#include "photon/photon_map.h"

enum {
    DIVIDE_CHUNK = 64,  // photons that are near each other, in Morton order
    // Numbers of copies: the least of one photon, and on the area of the largest disc of an
    // estimate, by which the peak of a copy's kernel is at most a tenth of that which counts as
    // strong. In panes, half and double of each leave 1.54 to 1.63 times the squared mean of the
    // caustics as the variance between two seeds, these 1.55, no division 1.91.
    COPIES_LEAST = 16,
    COPIES_DISC = 10,
    COPIES_MOST = 4096,  // a bound of memory alone: the most was 368
    // At a position, each at half the distance. Of 1,910 and 2,270 copies in staircase2 and
    // living-room, 33 and 370 find no surface and stay at the photon; with two attempts 160 and
    // 701, with eight none and 157.
    DIVIDE_ATTEMPTS = 4
};
// A photon is divided if the peak of its kernel is above both: this fraction of the mean
// irradiance, the difference that is visible by Weber's law; and DIVIDE_STRONG times this one of
// the irradiance around it, of which the peaks of kernels of k = 60 equal photons have .03. It is
// divided so widely that the peak falls to the larger of both fractions. With DIVIDE_STRONG 1, in a
// bathroom 70 % more photons were copies, and estimates of k photons were noisier.
static const float DIVIDE_VISIBLE = 0.02f, DIVIDE_AROUND = 0.1f, DIVIDE_STRONG = 2.0f;
// Where photons are dense, only those of this fraction of the power of k photons near them are
// looked at: half of what the above ask for, as those are not exactly the nearest ones.
static const float CANDIDATE = 0.05f;

struct dividing {
    const struct satin_scene *scene;
    const struct photon_map *map;
    const struct photon_divide *by;
    uint32_t *copies;  // by photon; 1: it stays
    uint8_t *beside;   // of these, how many an estimate at the photon counts, apart from one
    float *radius;     // in which they lie
    size_t *first;     // index of the first of them
    struct photon_hit *hit;
};

// The radius in which a photon has a kernel with this peak: 2 power / (pi r^2).
static float radius_of_peak(float power, float peak) { return sqrtf(2.0f * power / (PI_F * peak)); }

// The luminance of the irradiance by the other photons around photon i; *radius is set to that of
// its own kernel.
static float irradiance_around(const struct dividing *d, size_t i, float *radius) {
    int row[PHOTON_K_MAX];
    float distance2[PHOTON_K_MAX], sum = 0.0f;
    const int k = d->by->k;
    photon_index_nearest(d->map->index, d->map->position + 3 * i, 1, k, photon_map_far2(d->map),
                         row, distance2);
    const float r2 = photon_radius2(d->map, row, distance2, k);
    for (int j = 0; j < k; j++)
        if (row[j] >= 0 && (size_t)row[j] != i && distance2[j] < r2)
            sum += rgb_luminance(d->map->photon[row[j]].power);
    *radius = sqrtf(r2);
    return sum / (PI_F * r2);
}

// The geometric mean of the power of the photons [begin, end), which a few strong ones hardly
// change.
static float typical_power(const struct photon_map *map, size_t begin, size_t end) {
    double sum = 0.0;
    for (size_t i = begin; i < end; i++)
        sum += log((double)fmaxf(rgb_luminance(map->photon[i].power), 1e-30f));
    return (float)exp(sum / (double)(end - begin));
}

static void count_copies(void *ctx, size_t begin, size_t end, int worker) {
    const struct dividing *d = ctx;
    const float most = d->map->radius_max, visible = DIVIDE_VISIBLE * d->by->irradiance;
    const float typical = typical_power(d->map, begin, end);
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        const float power = rgb_luminance(d->map->photon[i].power);
        d->copies[i] = 1;
        if (!(radius_of_peak(power, visible) > most) &&
            !(power > CANDIDATE * (float)d->by->k * typical))
            continue;
        float own;
        const float around = irradiance_around(d, i, &own);
        const float faint = DIVIDE_AROUND * around;
        if (!(radius_of_peak(power, fmaxf(visible, DIVIDE_STRONG * faint)) > own)) continue;
        const float radius =
            fminf(radius_of_peak(power, fmaxf(visible, faint)), d->by->radius_most);
        d->radius[i] = radius;
        d->copies[i] =
            (uint32_t)fminf(COPIES_LEAST + COPIES_DISC * sqrf(radius / most), COPIES_MOST);
        // The density of copies is twice the mean one in the middle.
        const float of_all = fminf(2.0f * sqrf(own / radius), 1.0f);
        d->beside[i] = (uint8_t)fminf(fmaxf(of_all * (float)d->copies[i] - 1.0f, 0.0f), UINT8_MAX);
    }
}

// Moves *hit along the surface to the offset from the photon. False if the surface ends before.
static bool move_along(const struct satin_scene *scene, vec3 offset, vec3 n,
                       struct photon_hit *hit) {
    const float height = PHOTON_SURFACE_HEIGHT * v3_len(offset);
    const vec3 from = v3_mad(hit->p, height, n), above = v3_add(from, offset);
    const struct ray along = scene_spawn_to(scene, from, n, above, v3(0, 0, 0));
    vec3 p, ng;
    if (scene_occluded(scene, &along) ||
        !photon_surface_below(scene, above, n, 2.0f * height, &p, &ng) ||
        v3_dot(ng, n) < PHOTON_FACING)
        return false;
    hit->p = p;
    hit->n = photon_pack(ng);
    return true;
}

// Puts the copies of photon i, with a density that falls to 0 at the radius.
static void put_copies(const struct dividing *d, size_t i) {
    const struct photon *photon = &d->map->photon[i];
    const uint32_t copies = d->copies[i];
    const struct photon_hit whole = {photon_position(d->map, i),
                                     rgb_scale(photon->power, 1.0f / (float)copies),
                                     photon->wi,
                                     photon->n,
                                     photon->bounces,
                                     photon->last,
                                     photon->indirect,
                                     photon->path,
                                     photon->tilt,
                                     d->beside[i]};
    const vec3 n = photon_unpack(photon->n);
    const struct frame frame = frame_from_normal(n);
    struct rng rng = rng_make(d->by->seed, RNG_DIVIDE, i);
    const float rotation = 2.0f * PI_F * rng_float(&rng);
    for (uint32_t j = 0; j < copies; j++) {
        struct photon_hit *hit = &d->hit[d->first[i] + j];
        *hit = whole;
        if (copies == 1) return;
        // A spiral by the golden angle.
        const float angle = rotation + 2.39996323f * (float)j;
        const float u = ((float)j + 0.5f) / (float)copies;
        float r = d->radius[i] * sqrtf(1.0f - sqrtf(1.0f - u));
        for (int attempt = 0; attempt < DIVIDE_ATTEMPTS; attempt++, r *= 0.5f) {
            const vec3 offset = v3_mad(v3_mul(frame.u, r * cosf(angle)), r * sinf(angle), frame.v);
            if (move_along(d->scene, offset, n, hit)) break;
        }
    }
}

static void put_all(void *ctx, size_t begin, size_t end, int worker) {
    (void)worker;
    for (size_t i = begin; i < end; i++) put_copies(ctx, i);
}

static size_t number_copies(struct dividing *d) {
    size_t count = 0;
    for (size_t i = 0; i < d->map->count; i++) {
        d->first[i] = count;
        count += d->copies[i];
    }
    return count;
}

// Replaces the map by that of all copies.
static satin_status rebuild(struct dividing *d, size_t count, struct parallel *pool, struct log log,
                            struct photon_map *map) {
    d->hit = array_new_unset(count, sizeof *d->hit);
    if (!d->hit) return log_fail(log, SATIN_ERROR_MEMORY, "not enough memory for the photon map");
    if (!parallel_for(pool, map->count, DIVIDE_CHUNK, put_all, d)) return SATIN_CANCELLED;
    struct photon_map divided;
    const satin_status status = photon_map_build(d->scene, d->hit, count, pool, log, &divided);
    if (status != SATIN_OK) return status;
    divided.radius_max = map->radius_max;
    photon_map_free(map);
    *map = divided;
    return SATIN_OK;
}

satin_status photon_map_divide(const struct photon_divide *by, const struct satin_scene *scene,
                               struct parallel *pool, struct log log, struct photon_map *map) {
    struct dividing d = {.scene = scene, .map = map, .by = by};
    if (map->count == 0 || !(by->irradiance > 0.0f)) return SATIN_OK;
    d.copies = array_new_unset(map->count, sizeof *d.copies);
    d.beside = array_new(map->count, sizeof *d.beside);
    d.radius = array_new(map->count, sizeof *d.radius);
    d.first = array_new_unset(map->count, sizeof *d.first);
    satin_status status = SATIN_CANCELLED;
    if (!d.copies || !d.beside || !d.radius || !d.first) {
        status = log_fail(log, SATIN_ERROR_MEMORY, "not enough memory for the photon map");
    } else if (parallel_for(pool, map->count, DIVIDE_CHUNK, count_copies, &d)) {
        const size_t count = number_copies(&d);
        // The kd-tree numbers photons by int.
        const bool divides = count > map->count && count <= INT_MAX;
        status = divides ? rebuild(&d, count, pool, log, map) : SATIN_OK;
    }
    free(d.copies);
    free(d.beside);
    free(d.radius);
    free(d.first);
    free(d.hit);
    return status;
}
