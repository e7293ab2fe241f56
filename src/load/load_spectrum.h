// SPDX-License-Identifier: Apache-2.0
// Private to load/: spectra as scene files and .spd files have them.
#ifndef LOAD_SPECTRUM_H
#define LOAD_SPECTRUM_H

#include "base/log.h"
#include "scene/scene.h"

// Appends a sample. SATIN_ERROR_INPUT, logged, if wavelengths do not ascend or are too many;
// SATIN_ERROR_MEMORY, logged.
satin_status spectrum_add(struct log log, struct log_place place, struct spectrum *spectrum,
                          double wavelength, double value);
// Reads `wavelength:value, ...`, all samples of it.
satin_status spectrum_parse(struct log log, struct log_place place, const char *text,
                            struct spectrum *out);
// Reads a file of lines `wavelength value`, `#` starting comments; continues *hash (or NULL) over
// its bytes.
satin_status spectrum_read(struct log log, struct log_place place, const char *path, uint64_t *hash,
                           struct spectrum *out);

#endif
