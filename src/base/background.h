// SPDX-License-Identifier: Apache-2.0
// Work that a copy of this process does, which goes on if this process is killed. mpirun kills its
// processes a second after it was interrupted, together with the processes that these began; the
// copy is in a session of its own and ignores the signals that ask it to end.
#ifndef BASE_BACKGROUND_H
#define BASE_BACKGROUND_H

#include <stdbool.h>
#include <sys/types.h>

#include "base/log.h"

// A copy of this process; all zeros: there is none.
struct background {
    pid_t pid;
    int problem;  // a pipe from which the message of its failure is read
};

// Work that logs its failure and returns false.
typedef bool (*background_fn)(void *ctx, struct log log);

// Begins the work in a copy of this process as it is now, of which only the calling thread runs;
// so no other thread may hold a lock that the work needs. All open files but `keep` are closed in
// it. False if there is no copy: then nothing was done.
bool background_begin(struct background *out, int keep, background_fn fn, void *ctx);
// Waits for the end of the work. False, with its message logged, if it has failed; true if there is
// none.
bool background_end(struct background *background, struct log log);
// Stops the work where it is, and waits for that.
void background_stop(struct background *background);

#endif
