// SPDX-License-Identifier: Apache-2.0
// Places where light comes down much more densely than it will at the point that looks: what a spot
// or the sun through a window lights, a caustic. To the rest of a room each is a small bright
// source, which the even rays of a hemisphere meet by luck; from here the gather learns where to
// look [Jensen 1995 guides by the photons themselves]. A coarse pass of photons is cut into leaves
// of equal numbers and these are gathered into a hierarchy of spheres, of which each point takes
// the dense ones that it sees as small.
#include <stdlib.h>

#include "base/array.h"
#include "photon/photon_map.h"

enum {
    LEAF = 32,  // photons of a leaf
    BINS = 16,  // places where a node may be split along an axis
    PROBES = 4  // rays that tell whether a place is seen
};
#define DENSE 16.0f       // irradiance of a dense place over what is expected at the point
#define SINE_LEAST 1e-4f  // of half an angle: directions are floats
#define CLEARLY 1.001f    // more than rounding
#define STEPS 1024.0f     // of an order
#define NARROW 0.35f
#define EVEN 0.4f      // mean irradiance over area over that by power, of a place that is one
#define FILLED 0.2f    // of a sphere's disc that its leaves should fill
#define FAINT 0.0002f  // of what is expected at the point: what comes from less is left to chance

struct leaf {
    size_t first, count;  // photons
    vec3 center, normal;  // mean normal times power
    float radius, power, area;
};

struct node {
    vec3 center;
    float radius, power, area;
    float dense;          // largest irradiance of its leaves,
    float common;         // and their mean, by power
    vec3 normal;          // mean of unit normals, by power
    size_t first, count;  // photons of its leaves
    int32_t right;        // its left child is the next node; 0: a leaf
};

struct photon_bright {
    struct node *node;  // depth first
    size_t node_count;
    vec3 *place;   // of photons
    float spread;  // irradiance if all the light came down on a sphere around the scene [W m^-2]
};

// ---- Leaves -----------------------------------------------------------------------------------

static float along(vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

// The axes of a box from the longest to the shortest. Ties are broken by their order, not by the
// last digit.
static void sort_axes(vec3 lo, vec3 hi, int axis[3]) {
    const vec3 d = v3_sub(hi, lo);
    axis[0] = d.y > CLEARLY * d.x ? 1 : 0;
    if (d.z > CLEARLY * along(d, axis[0])) axis[0] = 2;
    axis[1] = axis[0] == 0 ? 1 : 0;
    axis[2] = 3 - axis[0] - axis[1];
    if (along(d, axis[2]) > CLEARLY * along(d, axis[1])) {
        axis[1] = axis[2];
        axis[2] = 3 - axis[0] - axis[1];
    }
}

// Where photons of a box are along its longest axis, and of those alike along the second, so that a
// wall is cut into pieces too; coarse, so that rounding does not decide.
struct order {
    int axis[2];
    float lo[2], scale[2];
};

static struct order order_of(vec3 lo, vec3 hi) {
    int axis[3];
    sort_axes(lo, hi, axis);
    struct order o = {.axis = {axis[0], axis[1]}};
    for (int i = 0; i < 2; i++) {
        const float length = along(hi, axis[i]) - along(lo, axis[i]);
        o.lo[i] = along(lo, axis[i]);
        o.scale[i] = length > 0.0f ? STEPS / length : 0.0f;
    }
    return o;
}

static float rank(const struct order *o, const struct photon_hit *hit) {
    const float first = roundf((along(hit->p, o->axis[0]) - o->lo[0]) * o->scale[0]);
    const float second = roundf((along(hit->p, o->axis[1]) - o->lo[1]) * o->scale[1]);
    return first * (2.0f * STEPS) + second;
}

// Puts the middle one of hit[0 .. n) in the order to its place, lesser ones before it [Hoare 1961].
static void halve(struct photon_hit *hit, size_t n, const struct order *order) {
    const ptrdiff_t middle = (ptrdiff_t)(n / 2);
    ptrdiff_t lo = 0, hi = (ptrdiff_t)n - 1;
    while (lo < hi) {
        const float pivot = rank(order, &hit[lo + (hi - lo) / 2]);
        ptrdiff_t i = lo, j = hi;
        while (i <= j) {
            while (rank(order, &hit[i]) < pivot) i++;
            while (rank(order, &hit[j]) > pivot) j--;
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
    const struct order order = order_of(lo, hi);
    halve(hit + first, count, &order);
    size_t leaves = cut(hit, first, count / 2, out);
    return leaves + cut(hit, first + count / 2, count - count / 2, out + leaves);
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
            if (!(side.power > 0.0f && left[b - 1].power > 0.0f && CLEARLY * cost < best)) continue;
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
        const float E = leaf[i].power / fmaxf(leaf[i].area, 1e-30f);
        node->dense = fmaxf(node->dense, E);
        node->common += leaf[i].power * E;
        node->normal = v3_add(node->normal, leaf[i].normal);
    }
    node->power = all.power;
    node->normal = v3_mul(node->normal, 1.0f / all.power);
    node->common /= all.power;
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

satin_status photon_bright_build(const struct satin_scene *scene, struct photon_hit *hit,
                                 size_t count, struct log log, struct photon_bright **out) {
    *out = NULL;
    if (count < 2 * LEAF) return SATIN_OK;
    struct photon_bright *bright = calloc(1, sizeof *bright);
    struct leaf *leaf = array_new(2 * count / LEAF + 1, sizeof *leaf);
    size_t leaves = leaf ? cut(hit, 0, count, leaf) : 0, placed = 0;
    if (bright && leaf) {
        bright->node = array_new(2 * leaves, sizeof *bright->node);
        bright->place = array_new(count, sizeof *bright->place);
    }
    if (!bright || !leaf || !bright->node || !bright->place) {
        photon_bright_free(bright);
        free(leaf);
        return log_fail(log, SATIN_ERROR_MEMORY, "not enough memory for bright places");
    }
    add_nodes(bright, leaf, leaves, &placed, hit);
    bright->spread = bright->node->power / (4.0f * PI_F * sqrf(scene->radius));
    free(leaf);
    *out = bright;
    return SATIN_OK;
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
    const float distance = v3_len(d), sine = clampf(cone->radius / distance, SINE_LEAST, 1.0f);
    cone->axis = v3_mul(d, 1.0f / distance);
    cone->versine = sqrf(sine) / (1.0f + safe_sqrtf(1.0f - sqrf(sine)));
}

// A node as the point sees it.
struct view {
    const struct node *node;
    float most;   // irradiance that may come from it at most; 0: it does not matter
    bool narrow;  // it has a cone
    bool coarse;  // its children would be seen better
};

static struct view view_of(const struct node *node, const struct photon_eye *eye, float expected) {
    struct view view = {.node = node};
    const vec3 d = v3_sub(node->center, eye->p);
    const float distance = v3_len(d), nearest = fmaxf(distance - node->radius, 0.0f);
    if (v3_dot(d, eye->n) < -node->radius) return view;  // below the horizon
    if (node->dense < DENSE * expected) return view;
    if (node->power < FAINT * expected * PI_F * sqrf(nearest)) return view;
    view.narrow = node->radius < NARROW * distance;
    const bool sparse = node->area < FILLED * PI_F * sqrf(node->radius);
    const bool uneven = node->power < EVEN * node->common * node->area;
    view.coarse = node->right > 0 && (!view.narrow || sparse || uneven);
    if (view.narrow || view.coarse)
        view.most = node->power / (PI_F * fmaxf(sqrf(nearest), sqrf(node->radius)));
    return view;
}

// False if nothing of the node is seen or comes.
static bool make_cone(const struct photon_bright *bright, const struct satin_scene *scene,
                      const struct photon_eye *eye, const struct node *node,
                      struct photon_cone *out) {
    const vec3 d = v3_sub(node->center, eye->p);
    const float distance = v3_len(d), sine = node->radius / distance;
    const float cosine = fmaxf(v3_dot(d, eye->n) / distance, 0.25f * sine);
    const float turned = 1.0f - v3_len(node->normal);
    *out = (struct photon_cone){.center = node->center, .radius = node->radius};
    photon_cone_aim(out, eye->p);
    const float facing = clampf(turned - v3_dot(node->normal, out->axis), 0.0f, 1.0f);
    out->E = node->power * cosine * facing / (PI_F * sqrf(distance));
    out->chance = out->E / node->power * node->area;
    out->filled = facing * node->area / (2.0f * PI_F * out->versine * sqrf(distance));
    if (!(out->E > 0.0f)) return false;
    out->E *= seen(bright, scene, node, eye);
    return out->E > 0.0f;
}

// Replaces the view that may send most, of those that are coarse, by views of the node's children,
// as long as there is room.
static int refine(const struct photon_bright *bright, const struct photon_eye *eye, float expected,
                  struct view view[PHOTON_CONES]) {
    int count = 1;
    view[0] = view_of(bright->node, eye, expected);
    while (count < PHOTON_CONES) {
        int best = -1;
        for (int i = 0; i < count; i++)
            if (view[i].coarse && (best < 0 || view[i].most > view[best].most)) best = i;
        if (best < 0) break;
        const struct node *parent = view[best].node;
        view[best] = view_of(parent + 1, eye, expected);
        const struct view right = view_of(bright->node + parent->right, eye, expected);
        if (right.most > 0.0f) view[count++] = right;
        if (!(view[best].most > 0.0f)) view[best] = view[--count];
        if (count == 0) break;
    }
    return count;
}

int photon_bright_cones(const struct photon_maps *maps, const struct satin_scene *scene,
                        const struct photon_eye *eye, struct photon_cone out[PHOTON_CONES],
                        float *expected) {
    const struct photon_bright *bright = maps ? maps->bright : NULL;
    if (!bright) return 0;
    float radius;
    *expected = rgb_luminance(photon_irradiance(maps, scene, eye->p, eye->ng, &radius));
    if (!(*expected > 0.0f)) *expected = bright->spread;
    struct view view[PHOTON_CONES];
    const int views = refine(bright, eye, *expected, view);
    int count = 0;
    for (int i = 0; i < views; i++)
        if (view[i].narrow && view[i].most > 0.0f)
            count += make_cone(bright, scene, eye, view[i].node, &out[count]);
    return count;
}
