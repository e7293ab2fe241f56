// SPDX-License-Identifier: Apache-2.0
// Private to render/: the file of a checkpoint, a journal that grows while a render goes on.
// docs/formats.md has it as a table of bytes.
#ifndef RENDER_CHECKPOINT_FILE_H
#define RENDER_CHECKPOINT_FILE_H

#include "base/bytes.h"
#include "base/log.h"

enum checkpoint_entry {
    CHECKPOINT_IDENTITY = 0,  // a text, the first entry: `name=value` words, what must be equal
    CHECKPOINT_LOOP,          // results of a loop, in the order of the loops; the last ones of it
    CHECKPOINT_IMAGE,         // the state of the image
    CHECKPOINT_PIECE,         // results of a loop, of which more follow
    // Added to LOOP or PIECE: results that serve only until the next entry without it is written.
    // They follow all other entries, also the image.
    CHECKPOINT_PASSING = 4
};

struct checkpoint_file;

// Makes a new file with this identity as its first entry, goes behind it, or with `resume` opens an
// existing one, if there is one; *resumed says which.
// Another process that uses the file, a file that is no checkpoint, and one of another version are
// refused with one logged line. `path` must stay valid as long as *out.
satin_status render_checkpoint_file_open(const char *path, const struct bytes *identity,
                                         bool resume, struct log log, bool *resumed,
                                         struct checkpoint_file **out);
void render_checkpoint_file_close(struct checkpoint_file *file);        // NULL is allowed
int render_checkpoint_file_number(const struct checkpoint_file *file);  // of the open file

// Sets *out to the next entry and goes to the one after it, if that can be: the state of an image
// remains the next one, to be replaced, but passing entries behind it are read in turn. False if
// the next entry is of another kind, or damaged, which the first time is logged as a warning, or
// there is none. `kind` has PASSING if `passing`,
// the number of the loop, is not 0.
bool render_checkpoint_file_read(struct checkpoint_file *file, unsigned kind, uint32_t passing,
                                 struct bytes *out);
// Replaces everything from the next entry on by this one, and goes behind it; a passing one
// replaces what follows the passing entries so far. After a process was killed the file has all
// entries but the one that was being written. SATIN_ERROR_IO, logged, if it cannot be written: then
// the file has all entries before.
satin_status render_checkpoint_file_append(struct checkpoint_file *file, unsigned kind,
                                           uint32_t passing, const struct bytes *entry,
                                           struct log log);
// The passing entries so far serve no more: a new image is written without them.
void render_checkpoint_file_drop(struct checkpoint_file *file);
// Writes a new file: this identity, all further entries up to the next one, the image, and the
// passing entries that serve; and renames it to the name of the file. The next entry remains.
// SATIN_ERROR_IO, logged: then the file is as before.
satin_status render_checkpoint_file_replace(struct checkpoint_file *file,
                                            const struct bytes *identity, const struct bytes *image,
                                            struct log log);

#endif
