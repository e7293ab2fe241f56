// SPDX-License-Identifier: Apache-2.0
// Private to load/: spectra in scene files and .spd files.
#ifndef LOAD_SPECTRUM_H
#define LOAD_SPECTRUM_H

#include "base/log.h"
#include "scene/scene.h"

// Appends a sample. Logs and returns SATIN_ERROR_INPUT if wavelengths do not ascend or are too
// many, or SATIN_ERROR_MEMORY.
satin_status load_spectrum_add(struct log log, struct log_place place, struct spectrum *spectrum,
                               double wavelength, double value);
// Reads all samples of `wavelength:value, ...`.
satin_status load_spectrum_parse(struct log log, struct log_place place, const char *text,
                                 struct spectrum *out);
// Reads a file of lines `wavelength value`, with comments from `#` on. Continues *hash, which may
// be NULL, over its bytes.
satin_status load_spectrum_read(struct log log, struct log_place place, const char *path,
                                uint64_t *hash, struct spectrum *out);

#endif
