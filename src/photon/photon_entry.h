// SPDX-License-Identifier: Apache-2.0
// Private to photon/: the estimate of an entry of precomputed irradiance (photon_entry.c).
#ifndef PHOTON_ENTRY_H
#define PHOTON_ENTRY_H

#include "photon/photon_map.h"

// Memory for the photons of a disc.
struct photon_entry_rows {
    int row[PHOTON_K_MAX];
    float distance2[PHOTON_K_MAX];
};
// The estimate of an entry.
struct photon_entry {
    struct photon_disc disc;
    float ring;  // radius of a disc with as many photons around it; INFINITY: it is not reliable
};
// Makes it (photon_entry.c), given the k nearest photons, the clearing around the entry or NULL,
// and out->ring of these photons. It is valid as long as row, distance2 and rows are.
void photon_entry_estimate(const struct photon_precompute *what, size_t entry,
                           const struct photon_clearing *clearing, int *row, float *distance2,
                           struct photon_entry_rows rows[2], struct photon_entry *out);
// The clearing around an entry.
struct photon_clearing photon_entry_clearing(const struct photon_precompute *what, size_t entry,
                                             const int *row, const float *distance2);

#endif
