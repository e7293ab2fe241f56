// SPDX-License-Identifier: Apache-2.0
// OpenEXR files in memory: the first part, scanlines or the largest image of tiles, any pixel type
// as float. The sizes in the header are checked against the size of the file before anything is
// allocated, so that a hostile file takes no more memory than a valid one.
#ifndef BASE_EXRFILE_H
#define BASE_EXRFILE_H

#include <OpenEXR/openexr.h>
#include <stdbool.h>
#include <stdint.h>

#include "satin/types.h"

struct exrfile {
    exr_context_t exr;
    const exr_attr_chlist_t *channels;
    exr_attr_box2i_t window;
    int width, height;  // of the window
    bool tiled;
    char problem[160];  // what a function that failed reports, one line
    bool other;         // that is: it is another format, or a kind that is not supported
    // Used by the functions below.
    const unsigned char *data;
    uint64_t size;
    exr_compression_t compression;
    bool in_header;
    uint64_t header_bytes;  // read in small pieces
    bool no_memory;         // the library had no memory, even if it then reported another error
    float *scratch;         // values that are copied from there
    size_t scratch_count;
};

// Where the values of a channel go: value (x, y) of the window to `first`[y * row + x * column].
// `first` NULL: they are not read.
struct exrfile_channel {
    float *first;
    size_t column, row;
};

// Opens a file of `size` bytes, which are used until it is closed, and reads its header.
// SATIN_ERROR_INPUT, with a problem: it is damaged, or not supported; SATIN_ERROR_MEMORY. It must
// be closed in either case.
satin_status exrfile_open(struct exrfile *file, const char *name, const void *data, size_t size);
// Reads the values of all channels, which are in the order of `channels`. Errors as above.
satin_status exrfile_read(struct exrfile *file, const struct exrfile_channel *to);
void exrfile_close(struct exrfile *file);
// Sets the problem that there is no memory.
satin_status exrfile_no_memory(struct exrfile *file);

#endif
