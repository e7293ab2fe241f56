// SPDX-License-Identifier: Apache-2.0
// Places where light comes down much more densely than elsewhere: what a spot or the sun through a
// window lights, a caustic. To the rest of the scene each is a small bright source, which the even
// rays of a hemisphere meet by luck; from here the gather learns where to look [Jensen 1995 guides
// by the photons themselves]. A coarse pass of photons is cut into leaves of equal numbers; the
// dense ones go into a hierarchy of spheres, of which each gather point takes those that it sees
// as small.
#include <stdlib.h>

#include "base/array.h"
#include "photon/photon_map.h"

enum {
    LEAF = 64,  // photons of a leaf
    BINS = 16,  // places where a node may be split along an axis
    PROBES = 4  // rays that tell whether a place is seen
};
#define DENSE 4.0f
#define WORTH 0.02f  // of all power must have come down densely
#define NARROW 0.35f
#define FILLED 0.2f    // of a sphere's disc that its leaves should fill
#define FAINT 0.0002f  // of the mean irradiance: what comes from less is left to chance
#define ALIKE 0.7f     // cosine between normals of one surface

struct leaf {
    size_t first, count;  // photons
    vec3 center, normal;  // mean normal times power
    float radius, power, area;
    bool whole;  // all on one surface
};

struct node {
    vec3 center;
    float radius, power, area;
    vec3 normal;          // mean of unit normals, by power
    size_t first, count;  // photons of its leaves
    int32_t right;        // its left child is the next node; 0: a leaf
};

struct photon_bright {
    struct node *node;  // depth first
    size_t node_count;
    vec3 *place;  // of photons
    float mean;   // irradiance where photons come down [W m^-2]
};

// ---- Leaves -----------------------------------------------------------------------------------

static float along(vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

static int longest(vec3 lo, vec3 hi) {
    vec3 d = v3_sub(hi, lo);
    return d.x >= d.y && d.x >= d.z ? 0 : d.y >= d.z ? 1 : 2;
}

// Puts the middle one of hit[0 .. n) along the axis to its place, lesser ones before it [Hoare
// 1961].
static void halve(struct photon_hit *hit, size_t n, int axis) {
    const ptrdiff_t middle = (ptrdiff_t)(n / 2);
    ptrdiff_t lo = 0, hi = (ptrdiff_t)n - 1;
    while (lo < hi) {
        const float pivot = along(hit[lo + (hi - lo) / 2].p, axis);
        ptrdiff_t i = lo, j = hi;
        while (i <= j) {
            while (along(hit[i].p, axis) < pivot) i++;
            while (along(hit[j].p, axis) > pivot) j--;
            if (i > j) break;
            struct photon_hit swap = hit[i];
            hit[i++] = hit[j];
            hit[j--] = swap;
        }
        if (middle <= j)
            hi = j;
        else if (middle >= i)
            lo = i;
        else
            break;
    }
}

static struct leaf make_leaf(const struct photon_hit *hit, size_t first, size_t count) {
    struct leaf leaf = {.first = first, .count = count};
    vec3 lo = hit[first].p, hi = lo;
    for (size_t i = first; i < first + count; i++) {
        float power = rgb_luminance(hit[i].power);
        leaf.power += power;
        leaf.normal = v3_mad(leaf.normal, power, photon_unpack(hit[i].n));
        lo = v3_min(lo, hit[i].p);
        hi = v3_max(hi, hit[i].p);
    }
    const vec3 d = v3_sub(hi, lo);
    leaf.area = fmaxf(d.x * d.y, fmaxf(d.y * d.z, d.z * d.x));
    leaf.center = v3_mul(v3_add(lo, hi), 0.5f);
    for (size_t i = first; i < first + count; i++)
        leaf.radius = fmaxf(leaf.radius, v3_dist2(hit[i].p, leaf.center));
    leaf.radius = sqrtf(leaf.radius);
    const vec3 n = v3_unit(leaf.normal);
    leaf.whole = true;
    for (size_t i = first; i < first + count && leaf.whole; i++)
        leaf.whole = v3_dot(photon_unpack(hit[i].n), n) > ALIKE;
    return leaf;
}

// Cuts the photons in halves of equal numbers until leaves are left; returns how many.
static size_t cut(struct photon_hit *hit, size_t first, size_t count, struct leaf *out) {
    if (count <= LEAF) {
        *out = make_leaf(hit, first, count);
        return 1;
    }
    vec3 lo = hit[first].p, hi = lo;
    for (size_t i = first; i < first + count; i++) {
        lo = v3_min(lo, hit[i].p);
        hi = v3_max(hi, hit[i].p);
    }
    halve(hit + first, count, longest(lo, hi));
    size_t leaves = cut(hit, first, count / 2, out);
    return leaves + cut(hit, first + count / 2, count - count / 2, out + leaves);
}

// Moves the dense leaves to the front; returns how many, 0 if they are not worth it.
static size_t keep_dense(struct leaf *leaf, size_t count, float *mean) {
    double power = 0.0, area = 0.0, dense = 0.0;
    for (size_t i = 0; i < count; i++) {
        if (!leaf[i].whole) continue;
        power += (double)leaf[i].power;
        area += (double)leaf[i].area;
    }
    *mean = area > 0.0 ? (float)(power / area) : 0.0f;
    size_t kept = 0;
    for (size_t i = 0; i < count && area > 0.0; i++) {
        if (!(leaf[i].power > DENSE * *mean * leaf[i].area)) continue;
        dense += (double)leaf[i].power;
        leaf[kept++] = leaf[i];
    }
    return dense > (double)WORTH * power ? kept : 0;
}

// ---- The hierarchy ----------------------------------------------------------------------------

// What a part of the leaves is together.
struct span {
    vec3 lo, hi;
    float power;
};
static const struct span NO_SPAN = {
    {INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}, 0.0f};

static void span_add(struct span *span, vec3 lo, vec3 hi, float power) {
    span->lo = v3_min(span->lo, lo);
    span->hi = v3_max(span->hi, hi);
    span->power += power;
}

// Power times the square of the extent: low for parts that are bright and small.
static float span_cost(const struct span *span) {
    return span->power > 0.0f ? span->power * v3_dist2(span->lo, span->hi) : 0.0f;
}

static int bin_of(const struct leaf *leaf, int axis, vec3 lo, vec3 hi) {
    float from = along(lo, axis), to = along(hi, axis);
    int bin = to > from ? (int)((float)BINS * (along(leaf->center, axis) - from) / (to - from)) : 0;
    return bin < BINS ? bin : BINS - 1;
}

// Parts the leaves where the cost of both sides is least; returns how many are in the first part.
static size_t part(struct leaf *leaf, size_t count) {
    struct span all = NO_SPAN;
    for (size_t i = 0; i < count; i++) span_add(&all, leaf[i].center, leaf[i].center, 0.0f);
    float best = INFINITY;
    int best_axis = -1, best_bin = 0;
    for (int axis = 0; axis < 3; axis++) {
        struct span bin[BINS], left[BINS], side = NO_SPAN;
        for (int b = 0; b < BINS; b++) bin[b] = NO_SPAN;
        for (size_t i = 0; i < count; i++) {
            const vec3 r = v3(leaf[i].radius, leaf[i].radius, leaf[i].radius);
            span_add(&bin[bin_of(&leaf[i], axis, all.lo, all.hi)], v3_sub(leaf[i].center, r),
                     v3_add(leaf[i].center, r), leaf[i].power);
        }
        for (int b = 0; b < BINS; b++) {
            span_add(&side, bin[b].lo, bin[b].hi, bin[b].power);
            left[b] = side;
        }
        side = NO_SPAN;
        for (int b = BINS - 1; b > 0; b--) {
            span_add(&side, bin[b].lo, bin[b].hi, bin[b].power);
            float cost = span_cost(&left[b - 1]) + span_cost(&side);
            if (!(side.power > 0.0f && left[b - 1].power > 0.0f && cost < best)) continue;
            best = cost;
            best_axis = axis;
            best_bin = b;
        }
    }
    if (best_axis < 0) return count / 2;
    size_t first = 0;
    for (size_t i = 0; i < count; i++) {
        if (bin_of(&leaf[i], best_axis, all.lo, all.hi) >= best_bin) continue;
        struct leaf swap = leaf[i];
        leaf[i] = leaf[first];
        leaf[first++] = swap;
    }
    return first > 0 && first < count ? first : count / 2;
}

static void bound(const struct leaf *leaf, size_t count, struct node *node) {
    struct span all = NO_SPAN;
    for (size_t i = 0; i < count; i++) {
        span_add(&all, leaf[i].center, leaf[i].center, leaf[i].power);
        node->area += leaf[i].area;
        node->normal = v3_add(node->normal, leaf[i].normal);
    }
    node->power = all.power;
    node->normal = v3_mul(node->normal, 1.0f / all.power);
    node->center = v3_mul(v3_add(all.lo, all.hi), 0.5f);
    for (size_t i = 0; i < count; i++)
        node->radius =
            fmaxf(node->radius, sqrtf(v3_dist2(leaf[i].center, node->center)) + leaf[i].radius);
}

// Appends the nodes of some leaves, whose places go beside them.
static void add_nodes(struct photon_bright *out, struct leaf *leaf, size_t count, size_t *placed,
                      const struct photon_hit *hit) {
    struct node *node = &out->node[out->node_count++];
    *node = (struct node){.first = *placed};
    bound(leaf, count, node);
    if (count == 1) {
        for (size_t i = 0; i < leaf->count; i++) out->place[(*placed)++] = hit[leaf->first + i].p;
    } else {
        size_t left = part(leaf, count);
        add_nodes(out, leaf, left, placed, hit);
        node->right = (int32_t)out->node_count;
        add_nodes(out, leaf + left, count - left, placed, hit);
    }
    node->count = *placed - node->first;
}

satin_status photon_bright_build(struct photon_hit *hit, size_t count, struct log log,
                                 struct photon_bright **out) {
    *out = NULL;
    if (count < 2 * LEAF) return SATIN_OK;
    satin_status status = SATIN_ERROR_MEMORY;
    struct photon_bright *bright = calloc(1, sizeof *bright);
    struct leaf *leaf = array_new(2 * count / LEAF + 1, sizeof *leaf);
    if (!bright || !leaf) goto done;
    size_t kept = keep_dense(leaf, cut(hit, 0, count, leaf), &bright->mean), places = 0;
    status = SATIN_OK;
    if (kept == 0) goto done;
    for (size_t i = 0; i < kept; i++) places += leaf[i].count;
    status = SATIN_ERROR_MEMORY;
    bright->node = array_new(2 * kept, sizeof *bright->node);
    bright->place = array_new(places, sizeof *bright->place);
    if (!bright->node || !bright->place) goto done;
    places = 0;
    add_nodes(bright, leaf, kept, &places, hit);
    *out = bright;
    bright = NULL;
    status = SATIN_OK;
done:
    photon_bright_free(bright);
    free(leaf);
    if (status == SATIN_ERROR_MEMORY) log_fail(log, status, "not enough memory for bright places");
    return status;
}

void photon_bright_free(struct photon_bright *bright) {
    if (!bright) return;
    free(bright->node);
    free(bright->place);
    free(bright);
}

size_t photon_bright_bytes(const struct photon_bright *bright) {
    if (!bright) return 0;
    const struct node *root = bright->node;
    return bright->node_count * sizeof *root + root->count * sizeof *bright->place;
}

// ---- What a point sees of it ------------------------------------------------------------------

// How much of some of its photons is seen from p.
static float seen(const struct photon_bright *bright, const struct satin_scene *scene,
                  const struct node *node, const struct photon_eye *eye) {
    int clear = 0;
    for (size_t i = 0; i < PROBES; i++) {
        vec3 place = bright->place[node->first + (2 * i + 1) * node->count / (2 * PROBES)];
        vec3 d = v3_sub(place, eye->p);
        float distance = v3_len(d);
        if (!(v3_dot(d, eye->n) > 0.0f)) continue;
        struct ray ray = scene_spawn(scene, eye->p, eye->ng, v3_mul(d, 1.0f / distance));
        ray.tfar = 0.999f * distance;
        clear += !scene_occluded(scene, &ray);
    }
    return (float)clear / PROBES;
}

void photon_cone_aim(struct photon_cone *cone, vec3 p) {
    const vec3 d = v3_sub(cone->center, p);
    const float distance = v3_len(d);
    cone->axis = v3_mul(d, 1.0f / distance);
    cone->cosine = fminf(safe_sqrtf(1.0f - sqrf(cone->radius / distance)), 1.0f - 1e-6f);
}

// The cone of a node, if the point sees it as narrow and bright enough; *deeper tells whether its
// children would be seen better.
static bool look(const struct photon_bright *bright, const struct node *node,
                 const struct photon_eye *eye, struct photon_cone *out, bool *deeper) {
    vec3 d = v3_sub(node->center, eye->p);
    float distance = v3_len(d), height = v3_dot(d, eye->n);
    *deeper = false;
    if (height < -node->radius) return false;  // below the horizon
    float nearest = fmaxf(distance - node->radius, 0.0f);
    if (node->power < FAINT * bright->mean * PI_F * sqrf(nearest)) return false;
    const bool wide = !(node->radius < NARROW * distance);
    const bool sparse = node->area < FILLED * PI_F * sqrf(node->radius);
    *deeper = node->right > 0 && (wide || sparse);
    if (*deeper || wide) return false;
    const vec3 axis = v3_mul(d, 1.0f / distance);
    const float sine = node->radius / distance, turned = 1.0f - v3_len(node->normal);
    float cosine = fmaxf(height / distance, 0.25f * sine);
    float facing = clampf(turned - v3_dot(node->normal, axis), 0.0f, 1.0f);
    *out = (struct photon_cone){.center = node->center, .radius = node->radius};
    photon_cone_aim(out, eye->p);
    out->E = node->power * cosine * facing / (PI_F * sqrf(distance));
    out->chance = out->E / node->power * node->area;
    out->filled = fminf(facing * node->area / (PI_F * sqrf(node->radius)), 1.0f);
    return out->E > FAINT * bright->mean;
}

int photon_bright_cones(const struct photon_maps *maps, const struct satin_scene *scene,
                        const struct photon_eye *eye, struct photon_cone out[PHOTON_CONES],
                        float *mean) {
    enum { STACK = 64 };
    const struct photon_bright *bright = maps ? maps->bright : NULL;
    if (!bright) return 0;
    *mean = bright->mean;
    int32_t stack[STACK];
    int depth = 0, count = 0;
    for (int32_t i = 0; i >= 0 && count<PHOTON_CONES; i = depth> 0 ? stack[--depth] : -1) {
        const struct node *node = &bright->node[i];
        bool deeper;
        if (look(bright, node, eye, &out[count], &deeper)) {
            out[count].E *= seen(bright, scene, node, eye);
            count += out[count].E > 0.0f;
        }
        if (!deeper || depth + 2 > STACK) continue;
        stack[depth++] = node->right;
        stack[depth++] = i + 1;
    }
    return count;
}
