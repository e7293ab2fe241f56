// SPDX-License-Identifier: Apache-2.0
// Private to load/: files of measured BRDFs (docs/formats.md). The arrays of the grid are in the
// arena.
#ifndef LOAD_MEASURED_H
#define LOAD_MEASURED_H

#include "load/load_build.h"

// The binary form of the MERL database.
satin_status load_measured_merl(const struct load_source *source, struct brdf_grid *out);
// satin's text form: values by the angles of both directions.
satin_status load_measured_text(const struct load_source *source, struct brdf_grid *out);

#endif
