// SPDX-License-Identifier: Apache-2.0
// Boxes at which light is aimed that may become a caustic. A few boxes cover the surfaces with
// delta lobes and miss none of them. Where they are large, as with a pane of glass in front of
// everything that is seen, light is also aimed at boxes of what is seen (guide_seen.c).
#include <math.h>

#include "guide/guide.h"

// A box is a spot only if its area is less than this fraction of that around it.
#define SMALLER 0.25f

// ---- Covers -------------------------------------------------------------------------------------

// Whether a shape, or a shape of the group of which it is an instance, has a delta lobe.
static bool some_has_delta(const struct satin_scene *scene, uint32_t shape) {
    if (scene->shape[shape].kind != SHAPE_INSTANCE) return scene_shape_has_delta(scene, shape);
    const struct shape_group *shapes = &scene->group[scene->shape[shape].instance_of];
    for (uint32_t i = shapes->first; i < shapes->first + shapes->count; i++)
        if (scene_shape_has_delta(scene, i)) return true;
    return false;
}

static struct light_target box_around(const struct light_target *a, const struct light_target *b) {
    return (struct light_target){v3_min(a->lo, b->lo), v3_max(a->hi, b->hi)};
}

// By how much the area of boxes grows if two of them are joined.
static float joining_cost(const struct light_target *a, const struct light_target *b) {
    const struct light_target both = box_around(a, b);
    return light_box_area(&both) - light_box_area(a) - light_box_area(b);
}

// Joins those two of the boxes that grow least by it, if there are too many boxes or if the joined
// one is smaller than both. False if none are joined.
static bool join_two(struct light_aim *aim) {
    int first = 0, second = 0;
    float least = aim->count > LIGHT_COVERS ? INFINITY : 0.0f;
    for (int i = 0; i < aim->count; i++)
        for (int j = i + 1; j < aim->count; j++) {
            const float cost = joining_cost(&aim->box[i], &aim->box[j]);
            if (!(cost < least)) continue;
            least = cost;
            first = i;
            second = j;
        }
    if (first == second) return false;
    aim->box[first] = box_around(&aim->box[first], &aim->box[second]);
    aim->box[second] = aim->box[--aim->count];
    return true;
}

// Covers the shapes that have delta lobes. No hit is outside of the scene's bounds, which come from
// the ray tracer.
static void add_covers(const struct satin_scene *scene, struct light_aim *aim) {
    for (uint32_t i = 0; i < scene->shape_count; i++) {
        const struct shape *shape = &scene->shape[i];
        if (shape->group || !some_has_delta(scene, i)) continue;
        vec3 lo, hi;
        scene_shape_bounds(shape, &lo, &hi);
        aim->box[aim->count++] =
            (struct light_target){v3_max(lo, scene->bounds_lo), v3_min(hi, scene->bounds_hi)};
        while (join_two(aim)) continue;
    }
    aim->covers = aim->count;
}

// ---- Spots --------------------------------------------------------------------------------------

// Adds those boxes, of descending size, that are small compared to the covers, or to the one
// before.
static void add_spots(const struct light_target *box, struct light_aim *aim) {
    float around = 0.0f;
    for (int i = 0; i < aim->covers; i++) around += light_box_area(&aim->box[i]);
    for (int k = 0; k < GUIDE_SEEN_BOXES; k++) {
        const float own = light_box_area(&box[k]);
        if (!(own > 0.0f) || own > SMALLER * around) continue;
        aim->box[aim->count++] = box[k];
        around = own;
    }
}

bool guide_aim_make(const struct satin_scene *scene, const struct guide_seen *seen,
                    struct light_aim *out) {
    *out = (struct light_aim){.count = 0};
    add_covers(scene, out);
    if (out->count == 0 || scene->light_count == 0) return false;
    if (seen->count > 0) add_spots(seen->box, out);
    if (seen->specular_count > 0) add_spots(seen->specular_box, out);
    return true;
}
