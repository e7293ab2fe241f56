// SPDX-License-Identifier: Apache-2.0
// Private to render/: options as functions of effort. The options that quality decides are
// functions of one number, the effort in core seconds per pixel. Presets are three values of
// it; a time limit gives another one, by the cores and pixels of the render.
#ifndef OPTIONS_QUALITY_H
#define OPTIONS_QUALITY_H

#include "render/options_table.h"
#include "satin/options.h"

// The fields that quality decides at `preview`, which are the defaults too: for an initializer,
// because the defaults are a constant.
#define OPTIONS_QUALITY_PREVIEW                                                             \
    .light_samples = 8, .glossy_samples = 4, .photons = 300000, .caustic_photons = 1500000, \
    .irradiance_rays = 600, .irradiance_a = 0.2f, .irradiance_widen = 2.0f,                 \
    .irradiance_min_pixels = 2.0f, .radiance_order = 14, .radiance_rays = 2000,             \
    .radiance_a = 0.3f, .radiance_widen = 2.0f, .radiance_min_pixels = 3.0f

// Sets the options that quality decides to those of a preset.
void options_quality_preset(satin_options *options, satin_quality quality);

// Sets those options that are still equal to the preset options->quality to their values for
// `seconds` of one core and an image of `pixels`. Options that the user has changed stay.
void options_quality_seconds(satin_options *options, double seconds, double pixels);

// Copies the options that quality decides.
void options_quality_copy(satin_options *to, const satin_options *from);

// Whether the quality, or a time limit, decides this option: the user has not chosen another value.
bool options_quality_chooses(const satin_options *options, const struct option *option);
// Whether the number of photons, or of those of caustics, is that of the preset, and not one that
// the user chose.
bool options_quality_chooses_photons(const satin_options *options);
bool options_quality_chooses_caustics(const satin_options *options);
bool options_quality_chooses_lights(const satin_options *options);

// The samples per pixel of a quality, for satin_options.spp 0: a square number.
int options_quality_spp(satin_quality quality);

#endif
