// SPDX-License-Identifier: Apache-2.0
// The MERL database's files [Matusik et al. 2003], little-endian:
//   bytes 0-11   three int32: 90 90 180, cells of theta_h (as a square root), theta_d and phi_d
//   then         doubles: all red values, phi_d fastest, then all green, then all blue
// in units of 1/1500, 1.15/1500 and 1.66/1500 sr^-1. Values that could not be measured are
// negative; they count as 0.
#include <stdlib.h>
#include <string.h>

#include "load/load_measured.h"

enum { THETA_H = 90, THETA_D = 90, PHI_D = 180, CELLS = THETA_H * THETA_D * PHI_D };
enum { HEADER = 12, BYTES = HEADER + 3 * 8 * CELLS };

static satin_status set_grid(const struct load_source *source, const char *data,
                             struct brdf_grid *out) {
    static const float scale[3] = {1.0f / 1500.0f, 1.15f / 1500.0f, 1.66f / 1500.0f};
    float *value = arena_array(source->arena, (size_t)CELLS * 3, sizeof *value);
    if (!value)
        return log_fail(source->log, SATIN_ERROR_MEMORY, "%s: not enough memory", source->path);
    for (size_t c = 0; c < 3; c++)
        for (size_t i = 0; i < CELLS; i++) {
            double v;
            memcpy(&v, data + HEADER + 8 * (c * CELLS + i), sizeof v);
            // NaN becomes 0 too.
            value[3 * i + c] = v > 0.0 && v < 1e9 ? (float)v * scale[c] : 0.0f;
        }
    *out = (struct brdf_grid){.kind = BRDF_GRID_HALF,
                              .channels = 3,
                              .size = {THETA_H, THETA_D, PHI_D, 1},
                              .value = value};
    return SATIN_OK;
}

satin_status load_measured_merl(const struct load_source *source, struct brdf_grid *out) {
    char *data;
    size_t size;
    satin_status status = load_source_read(source, BYTES + 1, &data, &size);
    if (status != SATIN_OK) return status;
    const int32_t want[3] = {THETA_H, THETA_D, PHI_D};
    if (size != BYTES || memcmp(data, want, HEADER) != 0) {
        log_error_at(
            source->log, source->place,
            "'%s' is not a MERL file: it needs the sizes 90 90 180 and %d bytes, but has %zu",
            source->path, BYTES, size);
        status = SATIN_ERROR_INPUT;
    } else {
        status = set_grid(source, data, out);
    }
    free(data);
    return status;
}
