// SPDX-License-Identifier: Apache-2.0
// For other folders: what of the input of a render can be checked without rendering.
#ifndef RENDER_RENDER_H
#define RENDER_RENDER_H

#include <stdbool.h>
#include <stddef.h>

#include "base/log.h"
#include "satin/options.h"
#include "satin/scene.h"

// Checks whether satin_render would begin with these options, which are those of
// satin_options_resolve: the film and its crop, materials and layers, and whether there is a
// denoiser, if they need one. Returns SATIN_ERROR_INPUT, with the line that satin_render would log,
// or SATIN_ERROR_MEMORY. Files of records are not checked.
satin_status render_check(const satin_scene *scene, const satin_options *options, struct log log);

// The size of the image that satin_render makes with these options. SATIN_ERROR_INPUT, with one
// logged line, if the film is too large or the crop is not inside of it.
satin_status render_size(const satin_scene *scene, const satin_options *options, struct log log,
                         int *width, int *height);

// The options that satin_render begins with: samples, depths and emitters that these options leave
// open are those of the scene or of the quality. With a time limit, which decides the samples, spp
// may stay 0. SATIN_ERROR_INPUT, with the line that satin_render would log, or SATIN_ERROR_MEMORY.
satin_status render_used_options(const satin_scene *scene, const satin_options *options,
                                 struct log log, satin_options *out);

// Describes by what the render `there` differs from that of `here`, two texts as satin_complete_fn
// has them: `seed=2 instead of seed=0`. False if they are equal.
bool render_describe_difference(const char *here, const char *there, char *out, size_t size);

#endif
