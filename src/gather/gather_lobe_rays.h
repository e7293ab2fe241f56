// SPDX-License-Identifier: Apache-2.0
// Private to gather/: rays of a hemisphere that are drawn by the glossy lobes of its site.
#ifndef GATHER_LOBE_RAYS_H
#define GATHER_LOBE_RAYS_H

#include "gather/gather_cluster_rays.h"

// Appends rays by the site's lobes to those of a hemisphere, and sets the weights of all rays.
void gather_lobe_rays_add(const struct gather *g, const struct gather_site *site,
                          const struct gather_cluster_rays *clusters, struct gather_hemisphere *h);

#endif
