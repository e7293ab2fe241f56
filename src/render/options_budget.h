// SPDX-License-Identifier: Apache-2.0
// Private to render/: what effort buys. The options that a quality decides are functions of one
// number, the effort: core seconds per pixel. Presets are three points of the curve; a time limit
// is another, by the cores and pixels that it has.
#ifndef OPTIONS_BUDGET_H
#define OPTIONS_BUDGET_H

#include "satin/options.h"

// Sets the options that a quality decides to those of a preset.
void options_budget_preset(satin_options *options, satin_quality quality);

// Sets those of them that still are as the preset options->quality has them to what `seconds` of
// one core buy for an image of `pixels`; those that the user chose stay.
void options_budget_seconds(satin_options *options, double seconds, double pixels);

// Whether the number of photons is the preset's: not one that the user chose.
bool options_budget_chooses_photons(const satin_options *options);

// Samples per pixel that a quality asks for where satin_options.spp is 0: a square number.
int options_quality_spp(satin_quality quality);

#endif
