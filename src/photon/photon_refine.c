// SPDX-License-Identifier: Apache-2.0
// Entries of irradiance that are replaced by better values: see photon.h.
#include "photon/photon_map.h"

float photon_irradiance_radius(const struct photon_maps *maps, size_t entry) {
    return maps->irradiance.radius[entry];
}

size_t photon_irradiance_near(const struct photon_maps *maps, size_t entry, float distance,
                              int row[PHOTON_NEAR], float distance2[PHOTON_NEAR]) {
    const struct photon_irradiance *r = &maps->irradiance;
    photon_index_nearest(r->index, r->position.row + 6 * entry, 1, PHOTON_NEAR, sqrf(distance), row,
                         distance2);
    size_t count = 0;
    for (int i = 0; i < PHOTON_NEAR; i++) {
        if (row[i] < 0) continue;
        row[count] = row[i];
        distance2[count++] = distance2[i];
    }
    return count;
}

void photon_irradiance_replace(struct photon_maps *maps, size_t entry, rgb E) {
    struct photon_irradiance *r = &maps->irradiance;
    const float before = rgb_luminance(r->E[entry]);
    if (r->last && before > 0.0f)
        r->last[entry] = rgb_scale(r->last[entry], rgb_luminance(E) / before);
    r->E[entry] = E;
}
