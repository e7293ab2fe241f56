// SPDX-License-Identifier: Apache-2.0
// The memory that a process takes whatever it renders.
#ifndef BASE_PROCESS_H
#define BASE_PROCESS_H

#include <stdbool.h>

// Measured: the program with its libraries and small buffers takes 11.5 to 13 MB, and 128 to 134 MB
// more with OpenImageIO, which reads all images but PNG files.
#define PROCESS_BYTES 13e6
#define PROCESS_MODULE_BYTES 136e6

// `module`: whether it reads images by OpenImageIO.
static inline double process_bytes(bool module) {
    return PROCESS_BYTES + (module ? PROCESS_MODULE_BYTES : 0.0);
}

#endif
