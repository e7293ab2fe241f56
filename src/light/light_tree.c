// SPDX-License-Identifier: Apache-2.0
// Many lights are chosen through a tree: every node has a box around its lights, the cone of their
// directions and the sum of their strengths, which bound the light at a point [Conty Estevez and
// Kulla 2018, "Importance sampling of many lights with adaptive tree splitting"]. A choice descends
// by the bounds of the two children; in a leaf the lights' own estimates decide. Deviations: the
// receiver's normal is not used, nodes are split at the median, and lights at infinity have a
// separate tree under the root.
#include "light/light_tree.h"

#include <stdlib.h>

#include "base/median_split.h"
#include "base/sampling.h"

// The fraction of each decision that is by strength alone, because the bounds ignore shadows.
#define TREE_BLIND_FRACTION 0.1f
// The least cosine that the bounds assume.
#define COSINE_MIN 0.02f

// Directions of emission: within `emission_angle` of the normals, which are within `normal_angle`
// of the axis.
struct emission_cone {
    vec3 axis;
    float normal_angle, emission_angle;
};

struct light_node {
    vec3 lo, hi;
    struct emission_cone cone;
    float strength;
    bool far;               // whether lights are at infinity, where lo and hi have no meaning
    uint32_t first, count;  // leaf: range of lights in light_tree.order
    uint32_t child;         // index of the first of two children; 0: a leaf
};

struct light_tree {
    struct light_node *node;
    uint32_t node_count;
    uint32_t *order;
    uint32_t *path;  // of each light: the child to take at each node, from the lowest bit on
};

// ---- Bounds -------------------------------------------------------------------------------------

static struct emission_cone cone_all(void) {
    return (struct emission_cone){v3(0, 0, 1), PI_F, 0.5f * PI_F};
}

// A cone around both: the axis is rotated towards that of the narrower one.
static struct emission_cone cone_union(struct emission_cone a, struct emission_cone b) {
    if (b.normal_angle > a.normal_angle) {
        struct emission_cone swap = a;
        a = b;
        b = swap;
    }
    float emission_angle = fmaxf(a.emission_angle, b.emission_angle),
          between = v3_angle(a.axis, b.axis);
    if (between + b.normal_angle <= a.normal_angle)
        return (struct emission_cone){a.axis, a.normal_angle, emission_angle};
    float normal_angle = 0.5f * (a.normal_angle + between + b.normal_angle),
          angle = normal_angle - a.normal_angle;
    vec3 side = v3_unit(v3_mad(b.axis, -v3_dot(a.axis, b.axis), a.axis));
    if (normal_angle >= PI_F || v3_len2(side) < 0.5f)
        return (struct emission_cone){a.axis, PI_F, emission_angle};
    vec3 axis = v3_unit(v3_mad(v3_mul(a.axis, cosf(angle)), sinf(angle), side));
    return (struct emission_cone){axis, normal_angle, emission_angle};
}

static void area_bounds(const struct satin_scene *scene, const struct light *light,
                        struct light_node *node) {
    scene_shape_bounds(&scene->shape[light->shape], &node->lo, &node->hi);
    if (!light->face) return;
    node->cone = (struct emission_cone){light->face[0].n, 0.0f, 0.5f * PI_F};
    for (uint32_t i = 1; i < light->face_count; i++)
        node->cone =
            cone_union(node->cone, (struct emission_cone){light->face[i].n, 0.0f, 0.5f * PI_F});
}

static struct light_node node_of(const struct satin_scene *scene, uint32_t index) {
    const struct light *light = &scene->light[index];
    struct light_node node = {.cone = cone_all(), .strength = light->strength};
    node.far = light->kind >= LIGHT_BEAM;
    if (light->kind == LIGHT_AREA) {
        area_bounds(scene, light, &node);
    } else {
        node.lo = node.hi = node.far ? v3(0, 0, 0) : light->position;
    }
    if (light->kind == LIGHT_SPOT)
        node.cone = (struct emission_cone){light->direction, 0.0f, acosf(light->cos_cutoff)};
    return node;
}

static struct light_node node_union(const struct light_node *a, const struct light_node *b) {
    struct light_node node = *a;
    node.lo = v3_min(a->lo, b->lo);
    node.hi = v3_max(a->hi, b->hi);
    node.cone = cone_union(a->cone, b->cone);
    node.strength = a->strength + b->strength;
    node.far = a->far && b->far;
    return node;
}

// ---- Building -----------------------------------------------------------------------------------

struct tree_build {
    struct light_tree *tree;
    const struct light_node *leaf;  // of each light, as a node of its own
    struct split_point *point;      // the centre of each light's box
};

// Splits lights at the median of their positions, after separating those at infinity. Returns the
// number of lights of the first child.
static uint32_t split_lights(const struct tree_build *b, struct split_point *point,
                             uint32_t count) {
    uint32_t near = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (b->leaf[point[i].item].far) continue;
        const struct split_point swap = point[near];
        point[near++] = point[i];
        point[i] = swap;
    }
    if (near > 0 && near < count) return near;
    median_split(point, count);
    return count / 2;
}

static void build_node(struct tree_build *b, uint32_t at, uint32_t first, uint32_t count,
                       uint32_t path, uint32_t depth) {
    struct split_point *point = b->point + first;
    struct light_node node = b->leaf[point[0].item];
    uint32_t far = node.far;
    for (uint32_t i = 1; i < count; i++) {
        const struct light_node *leaf = &b->leaf[point[i].item];
        node = node_union(&node, leaf);
        far += leaf->far;
    }
    node.first = first;
    node.count = count;
    if (count > LIGHT_LEAF_MAX || (far && far < count)) {
        uint32_t left = split_lights(b, point, count);
        node.child = b->tree->node_count;
        b->tree->node_count += 2;
        build_node(b, node.child, first, left, path, depth + 1);
        build_node(b, node.child + 1, first + left, count - left, path | 1u << depth, depth + 1);
    } else {
        for (uint32_t i = 0; i < count; i++) {
            b->tree->order[first + i] = point[i].item;
            b->tree->path[point[i].item] = path;
        }
    }
    b->tree->node[at] = node;
}

satin_status light_tree_build(struct satin_scene *scene) {
    uint32_t n = scene->light_count;
    struct arena *arena = &scene->arena;
    struct light_tree *tree = arena_alloc(arena, sizeof *tree);
    struct light_node *leaf = malloc((size_t)n * sizeof *leaf);
    struct split_point *point = malloc((size_t)n * sizeof *point);
    // At most as many leaves as lights.
    if (tree) {
        tree->node = arena_array(arena, 2 * (size_t)n, sizeof *tree->node);
        tree->order = arena_array(arena, n, sizeof *tree->order);
        tree->path = arena_array(arena, n, sizeof *tree->path);
    }
    if (!tree || !leaf || !point || !tree->node || !tree->order || !tree->path) {
        free(leaf);
        free(point);
        return SATIN_ERROR_MEMORY;
    }
    for (uint32_t i = 0; i < n; i++) {
        leaf[i] = node_of(scene, i);
        const vec3 middle = v3_mul(v3_add(leaf[i].lo, leaf[i].hi), 0.5f);
        point[i] = (struct split_point){.p = middle, .item = i};
    }
    tree->node_count = 1;
    struct tree_build b = {tree, leaf, point};
    build_node(&b, 0, 0, n, 0, 0);
    free(leaf);
    free(point);
    scene->light_tree = tree;
    return SATIN_OK;
}

// ---- Choice -------------------------------------------------------------------------------------

// A bound, except for COSINE_MIN, of the irradiance at p from the lights of the node.
static float node_estimate(const struct light_node *node, vec3 p) {
    if (node->far) return node->strength;
    vec3 centre = v3_mul(v3_add(node->lo, node->hi), 0.5f), d = v3_sub(p, centre);
    float r2 = 0.25f * v3_dist2(node->lo, node->hi), d2 = v3_len2(d);
    if (d2 <= r2) return node->strength / fmaxf(r2, 1e-20f);
    float off = node->cone.normal_angle + asinf(sqrtf(r2 / d2));
    float most = PI_F - off, cosine = 1.0f;
    if (most > 0.0f) {
        float beyond = v3_angle(node->cone.axis, v3_mul(d, 1.0f / sqrtf(d2))) - off;
        if (beyond > 0.0f)
            cosine =
                beyond < node->cone.emission_angle ? fmaxf(cosf(beyond), COSINE_MIN) : COSINE_MIN;
    }
    return node->strength * cosine / d2;
}

// The probability of choosing the second child of an inner node.
static float second_probability(const struct light_tree *tree, const struct light_node *node,
                                vec3 p) {
    const struct light_node *a = &tree->node[node->child], *b = a + 1;
    float blind = b->strength / (a->strength + b->strength);
    float ra = node_estimate(a, p), rb = node_estimate(b, p), informed = rb / (ra + rb);
    if (!isfinite(informed)) informed = blind;
    if (!isfinite(blind)) return 0.5f;
    return informed + TREE_BLIND_FRACTION * (blind - informed);
}

// The weights of a leaf's lights, and their sum. Lights that contribute nothing have weight 0,
// unless all do.
static float leaf_weights(const struct satin_scene *scene, const struct light_node *leaf, vec3 p,
                          float weight[LIGHT_LEAF_MAX]) {
    float sum = 0.0f;
    uint32_t lit = 0;
    const uint32_t *order = scene->light_tree->order + leaf->first;
    for (uint32_t i = 0; i < leaf->count; i++) {
        weight[i] = light_estimate(scene, &scene->light[order[i]], p);
        sum += weight[i];
        lit += weight[i] > 0.0f;
    }
    bool good = sum > 0.0f && isfinite(sum);
    float least = good ? sum * (TREE_BLIND_FRACTION / (float)lit) : 0.0f;
    for (uint32_t i = 0; i < leaf->count; i++) {
        if (!good) weight[i] = 1.0f;
        if (good && weight[i] > 0.0f) weight[i] = weight[i] * (1.0f - TREE_BLIND_FRACTION) + least;
    }
    return good ? sum : (float)leaf->count;
}

uint32_t light_tree_choose(const struct satin_scene *scene, vec3 p, float *u, float *probability) {
    const struct light_tree *tree = scene->light_tree;
    const struct light_node *node = tree->node;
    double x = (double)*u, chosen = 1.0;
    while (node->child) {
        double second = (double)second_probability(tree, node, p), first = 1.0 - second;
        bool right = x >= first;
        x = fmin(right ? (x - first) / second : x / first, 0x1.fffffffffffffp-1);
        chosen *= right ? second : first;
        node = &tree->node[node->child + right];
    }
    float weight[LIGHT_LEAF_MAX], sum = leaf_weights(scene, node, p, weight);
    uint32_t i = 0;
    for (x *= (double)sum; i + 1 < node->count && x >= (double)weight[i]; i++)
        x -= (double)weight[i];
    while (!(weight[i] > 0.0f) && i > 0)
        i--;  // rounding may have passed the last light with a
              // weight
    *u = minf((float)(x / (double)weight[i]), SAMPLE_BELOW_ONE);
    *probability = (float)(chosen * (double)(weight[i] / sum));
    return tree->order[node->first + i];
}

float light_tree_probability(const struct satin_scene *scene, vec3 p, uint32_t light) {
    const struct light_tree *tree = scene->light_tree;
    const struct light_node *node = tree->node;
    double chosen = 1.0;
    for (uint32_t path = tree->path[light]; node->child; path >>= 1) {
        double second = (double)second_probability(tree, node, p);
        chosen *= path & 1 ? second : 1.0 - second;
        node = &tree->node[node->child + (path & 1)];
    }
    float weight[LIGHT_LEAF_MAX], sum = leaf_weights(scene, node, p, weight);
    for (uint32_t i = 0; i < node->count; i++)
        if (tree->order[node->first + i] == light)
            return (float)(chosen * (double)(weight[i] / sum));
    return 0.0f;
}
