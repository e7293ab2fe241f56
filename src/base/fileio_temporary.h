// SPDX-License-Identifier: Apache-2.0
// Private to base/: output files before they are complete (fileio_temporary.c).
#ifndef BASE_FILEIO_TEMPORARY_H
#define BASE_FILEIO_TEMPORARY_H

// Makes a new file beside the target and opens it for writing. Sets *name to its name, from malloc.
// Returns -1 with errno set, and *name NULL, on failure.
int fileio_temporary_open(const char *target, char **name);
// Removes such files of this target that processes which were killed on this machine have left.
void fileio_temporary_clean(const char *target);

#endif
