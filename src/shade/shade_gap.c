// SPDX-License-Identifier: Apache-2.0
// Gaps of a pixel or two, as above a flat lamp or below a chest. Light falls there within less than
// the least radius of a record, and whether a record lies in one at all is chance: if none does,
// those beside it are read. So no record is made in a gap, and samples gather.
#include "shade/shade_eye.h"

// The width of gaps in projected pixels, measured in docs/experiments/cache-errors.md.
static const float GAP_PIXELS = 2.0f;

bool shade_in_gap(const struct shade *shade, const struct shade_vertex *v) {
    const struct satin_scene *scene = shade->g->scene;
    const struct shading_point *p = &v->point;
    struct ray ray = scene_spawn(scene, p->interaction.p, p->interaction.ng, p->ng);
    ray.tfar = GAP_PIXELS * v->pixel;
    struct interaction facing;
    return isfinite(scene_distance(scene, &ray)) && scene_intersect(scene, &ray, &facing) &&
           !scene_material_transmits(&scene->material[facing.material], true);
}
