// SPDX-License-Identifier: Apache-2.0
// Explains flagged blocks as noise of few caustic photons, or of few samples per pixel, by renders
// with more of these.
//
// A render with more samples per pixel has the same photons and records, to the bit, and one with
// more caustic photons has the same photons of the global map and, except for a few, the same
// records. So an error of a record, of a photon's precomputed irradiance or of a table stays, while
// the noise of the photons or samples of which there are more falls. Legend: D is the difference of
// a flagged block from that of another image, which is in the middle of those that are not flagged;
// S is its score, so that D / S is about a standard deviation. A block is explained if the
// difference of the same two seeds is at most max(D / sqrt(8), 2 D / S) with 8 times as many, and
// at most max(D / 8, 2 D / S) with 64 times: the noise has fallen as it must, or the remaining
// difference would not have been flagged.
//
// Photons explain the layer of caustics, in which no record is read, and the beauty if the numbers
// of records and of their rays are as before. Most of a faint caustic may be in photons so rare
// that 64 times as many have some in half of the images; so a flagged block of caustics is
// explained, too, if the other image, with more photons, has as much light there: then the median
// is wrong. Samples explain all layers, under this condition.
//
// A single caustic photon that is wrong is not distinguished from noise: it falls like noise. One
// that is not finite or out of range is counted as refused, which is a flag of its own. Single
// wrong samples do not count (see blocks.h). Noise of the records, of the photons that they read,
// or of other data from which they are made is never explained, so that a wrong record cannot be
// hidden.
#ifndef SWEEP_EXPLAIN_H
#define SWEEP_EXPLAIN_H

#include "evaluate.h"

enum { EXPLANATIONS = 2 };

// The values of flagged.few.
extern const char *const explain_name[EXPLANATIONS];

// Sets `few` of the flagged blocks. `options` are those of the cell.
void explain_blocks(struct work *w, const satin_scene *scene, const satin_options *options);

#endif
