// SPDX-License-Identifier: Apache-2.0
// Private to scene/: conversion between world space and the space of an instance's group.
#ifndef SCENE_INSTANCE_H
#define SCENE_INSTANCE_H

#include "scene/scene.h"

// Sets an instance's bounds, and its contribution to the scene's epsilon, from the bounds of its
// group.
void scene_instance_bound(struct shape *shape, vec3 lo, vec3 hi);

// Transforms a world ray to the group's space. Distances stay the same, so the direction is not
// unit.
struct ray scene_instance_ray(const struct shape *shape, const struct ray *ray);
// About the largest length in the group's space of what has this length in the world.
float scene_instance_length(const struct shape *shape, float length);
// The least distance from the edges of its triangle for a hit at p (world), in the group's space.
float scene_instance_margin(const struct satin_scene *scene, const struct shape *shape, vec3 p);
// Transforms a surface interaction from the group's space to the world, including dp_du and dp_dv
// if `partials`. Its frame follows dp/du if `tangent`.
void scene_instance_to_world(const struct shape *shape, bool tangent, bool partials,
                             struct interaction *s);

#endif
