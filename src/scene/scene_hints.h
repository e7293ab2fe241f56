// SPDX-License-Identifier: Apache-2.0
// Part of scene.h: settings of the scene's integrator and sampler elements.
#ifndef SCENE_HINTS_H
#define SCENE_HINTS_H

#include <stdbool.h>
#include <stddef.h>

#include "base/log.h"

// An option of <integrator type="satin">, which is not checked yet.
struct scene_option {
    const char *name, *value;
    struct log_place place;
};

// Quantities of the first surface that an `aov` integrator outputs beside the image (load_aov.c).
enum aov_kind {
    AOV_ALBEDO,
    AOV_DEPTH,
    AOV_POSITION,
    AOV_UV,
    AOV_GEO_NORMAL,
    AOV_SH_NORMAL,
    AOV_DP_DU,
    AOV_DP_DV,
    AOV_DUV_DX,
    AOV_DUV_DY,
    AOV_PRIM_INDEX,
    AOV_SHAPE_INDEX,
    AOV_LIGHT,  // of `moment`: the radiance of the sample in CIE XYZ, whatever it hits
    AOV_KINDS
};
enum {
    AOV_VALUES = 30,        // largest number of values of one sample: 1 to 3 of each kind
    AOV_CHANNELS_MAX = 192  // each channel costs memory per pixel
};

struct scene_aov {
    const char *name;  // unique name of the channel, such as "normals.X"
    int value;         // index among the values of a sample
    bool squared;      // whether it is the mean of squares
};

struct scene_aovs {
    struct scene_aov *channel;
    int count;
    int values;            // number of values of a sample, with each kind once
    int first[AOV_KINDS];  // index of the first value of each kind; -1: not needed
    bool partials;         // whether dp/du or dp/dv is among them
    bool aov, moment;      // which integrators were read; moment: squares are summed too
};

// See satin_options for the meaning.
struct scene_hints {
    const char *integrator;                       // name of its plugin, or NULL
    int max_depth, rr_depth, hide_emitters, spp;  // -2, 0, -1, 0 when absent
    // The options of <integrator type="satin"> in order, for satin_options_resolve.
    const struct scene_option *option;
    size_t option_count;
    struct scene_aovs aovs;
};

#endif
