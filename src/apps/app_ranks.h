// SPDX-License-Identifier: Apache-2.0
// The processes of a command that was started by mpirun or srun.
#ifndef APP_RANKS_H
#define APP_RANKS_H

#include <stdbool.h>

#include "apps/app.h"
#include "satin/ranks.h"

// What the module on MPI has (app_ranks_mpi.c). It is a shared library that is opened only if there
// are several processes, so that satin needs no MPI.
struct app_ranks_module {
    // Starts MPI. NULL with a text in *problem if that is not possible. Does not return in a
    // process for which its machine has no core: that waits for the others, and ends with their
    // status.
    const satin_ranks *(*begin)(const char **problem);
    void (*end)(int status);    // of the first process
    void (*abort)(int status);  // ends all processes
};
#define APP_RANKS_SYMBOL "satin_ranks_module"

struct app_ranks {
    const struct app_ranks_module *module;  // NULL: this process is alone
    const satin_ranks *ranks;               // NULL: this process is alone
};

// Joins the other processes, if there are any; all but the first one are silent then. Reports an
// error and returns false if that fails.
bool app_ranks_begin(struct app_ranks *ranks);
// Whether this process reports progress and writes files.
bool app_ranks_first(const struct app_ranks *ranks);
// All ranks call it with their exit status, one of `app_exit`. Returns that of the first rank whose
// status is not APP_DONE, which reports its error.
int app_ranks_agree(const struct app_ranks *ranks, int status);
// Ends the processes. If this one has failed alone, the others are ended too. All of them must have
// agreed on the status APP_WRONG.
void app_ranks_end(const struct app_ranks *ranks, int status);

#endif
