// SPDX-License-Identifier: Apache-2.0
// Part of scene.h: what the scene's integrator and sampler elements ask for.
#ifndef SCENE_HINTS_H
#define SCENE_HINTS_H

#include <stdbool.h>
#include <stddef.h>

#include "base/log.h"

// An option of <integrator type="satin">, not yet checked.
struct scene_option {
    const char *name, *value;
    struct log_place place;
};

// Values of the first surface that an `aov` integrator asks for beside the image (load_aov.c).
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
    AOV_LIGHT,  // the radiance of the sample in CIE XYZ, whatever it hits; of `moment`
    AOV_KINDS
};
enum {
    AOV_VALUES = 30,        // of one sample at most: 1 to 3 of each kind
    AOV_CHANNELS_MAX = 192  // each costs memory per pixel
};

struct scene_aov {
    const char *name;  // of a channel, each once: "normals.X"
    int value;         // what it shows, of a sample's values
    bool squared;      // or of their squares
};

struct scene_aovs {
    struct scene_aov *channel;
    int count;
    int values;            // of a sample, those of each kind once
    int first[AOV_KINDS];  // where those of a kind begin; -1: not asked for
    bool partials;         // some are of dp/du and dp/dv
    bool aov, moment;      // such an integrator was read; moment: squares are summed too
};

// See satin_options for the meaning.
struct scene_hints {
    const char *integrator;                       // its plugin name, or NULL
    int max_depth, rr_depth, hide_emitters, spp;  // -2, 0, -1, 0 when absent
    // <integrator type="satin">: its options in order, for satin_options_resolve.
    const struct scene_option *option;
    size_t option_count;
    struct scene_aovs aovs;
};

#endif
