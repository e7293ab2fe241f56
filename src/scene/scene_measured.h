// SPDX-License-Identifier: Apache-2.0
// Private to scene/: files of measured BRDFs (docs/formats.md). The grid's arrays live in the
// arena.
#ifndef SCENE_MEASURED_H
#define SCENE_MEASURED_H

#include "scene/scene_build.h"

// The binary form of the MERL database.
satin_status scene_measured_merl(const struct scene_source *source, struct brdf_grid *out);
// satin's text form: values by the angles of both directions.
satin_status scene_measured_text(const struct scene_source *source, struct brdf_grid *out);

#endif
