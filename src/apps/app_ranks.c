// SPDX-License-Identifier: Apache-2.0
// The processes of a command that was started by mpirun or srun: see app_ranks.h. The first one
// speaks for all; the others are silent unless one of them fails alone.
#include "apps/app_ranks.h"

#include <dlfcn.h>
#include <stdlib.h>
#include <unistd.h>

#include "base/library.h"

// Variables of the number of processes, as Open MPI, MPICH and Slurm set them.
static const char *const size_variables[] = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE",
                                             "SLURM_STEP_NUM_TASKS"};

// Where the module is, as that of load_image.c.
static const char *const mpi_modules[] = {
    "satin/satin_mpi.so",
    "../" SATIN_LIBDIR "/satin/satin_mpi.so",
    "satin_mpi.so",
};

static bool has_processes(void) {
    for (size_t i = 0; i < sizeof size_variables / sizeof *size_variables; i++) {
        const char *value = getenv(size_variables[i]);
        if (value && atoi(value) > 1) return true;
    }
    return false;
}

static bool refuse_ranks(const char *problem) {
    app_wrong("several processes were started, but %s", problem);
    return false;
}

bool app_ranks_begin(struct app_ranks *ranks) {
    char path[PATH_MAX];
    *ranks = (struct app_ranks){.module = NULL};
    if (!has_processes()) return true;
    if (!library_find(mpi_modules, sizeof mpi_modules / sizeof *mpi_modules, path))
        return refuse_ranks("this satin was built without MPI (libopenmpi-dev)");
    void *library = library_open(path);
    const struct app_ranks_module *module = library ? dlsym(library, APP_RANKS_SYMBOL) : NULL;
    if (!module) return refuse_ranks(dlerror());
    const char *problem = NULL;
    ranks->ranks = module->begin(&problem);
    if (!ranks->ranks) return refuse_ranks(problem);
    ranks->module = module;
    if (!app_ranks_first(ranks)) app_begin_silence();
    return true;
}

bool app_ranks_first(const struct app_ranks *ranks) {
    return !ranks->ranks || ranks->ranks->rank == 0;
}

static void report_problem(const struct app_ranks *ranks) {
    if (!app_ranks_first(ranks)) app_end_silence("satin: error: rank %d: ", ranks->ranks->rank);
}

int app_ranks_agree(const struct app_ranks *ranks, int status) {
    const satin_ranks *r = ranks->ranks;
    if (!r) return status;
    if (!r->any(r->user, status != APP_DONE)) return APP_DONE;
    int agreed = APP_DONE, rank = 0;
    for (; rank < r->count && agreed == APP_DONE; rank++) {
        agreed = status;
        r->broadcast(r->user, rank, &agreed, sizeof agreed);
    }
    if (rank - 1 == r->rank) report_problem(ranks);
    return agreed;
}

// If the input is wrong, all ranks have agreed on that, and the first that has found an error
// reports it.
static void report_wrong_input(const struct app_ranks *ranks) {
    const satin_ranks *r = ranks->ranks;
    bool found = false;
    for (int rank = 0; rank < r->count && !found; rank++) {
        found = app_has_error();
        r->broadcast(r->user, rank, &found, sizeof found);
        if (found && rank == r->rank) report_problem(ranks);
    }
}

void app_ranks_end(const struct app_ranks *ranks, int status) {
    if (!ranks->module) return;
    if (status == APP_FAILED) {
        // If the first rank has failed too, it ends all within this time, and reports the error.
        if (!app_ranks_first(ranks)) sleep(1);
        report_problem(ranks);
        ranks->module->abort(status);
    }
    if (status == APP_WRONG) report_wrong_input(ranks);
    ranks->module->end(status);
}
