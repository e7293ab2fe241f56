// SPDX-License-Identifier: Apache-2.0
// The module on MPI: how the ranks of a render communicate. The counters are in memory of rank 0
// that all ranks access [MPI 3.1, 11: one-sided communication].
#include <mpi.h>
#include <stdlib.h>

#include "apps/app_ranks.h"

struct mpi_state {
    satin_ranks ranks;
    MPI_Win counters;
};

static void mpi_broadcast(void *user, int root, void *data, size_t size) {
    enum { MESSAGE_MOST = 1 << 30 };  // counts of MPI are int
    char *at = data;
    (void)user;
    for (; size > 0; size -= size < MESSAGE_MOST ? size : MESSAGE_MOST) {
        const int n = size < MESSAGE_MOST ? (int)size : MESSAGE_MOST;
        MPI_Bcast(at, n, MPI_BYTE, root, MPI_COMM_WORLD);
        at += n;
    }
}

static bool mpi_any(void *user, bool value) {
    int own = value, all = 0;
    (void)user;
    MPI_Allreduce(&own, &all, 1, MPI_INT, MPI_LOR, MPI_COMM_WORLD);
    return all;
}

static uint64_t mpi_fetch_add(void *user, int counter, uint64_t add) {
    struct mpi_state *state = user;
    uint64_t before = 0;
    MPI_Fetch_and_op(&add, &before, MPI_UINT64_T, 0, counter, MPI_SUM, state->counters);
    MPI_Win_flush(0, state->counters);
    return before;
}

static void mpi_reset(void *user, int counter) {
    struct mpi_state *state = user;
    const uint64_t zero = 0;
    MPI_Accumulate(&zero, 1, MPI_UINT64_T, 0, counter, 1, MPI_UINT64_T, MPI_REPLACE,
                   state->counters);
    MPI_Win_flush(0, state->counters);
}

static const satin_ranks *mpi_begin(const char **problem) {
    static struct mpi_state state;
    int provided = 0;
    if (MPI_Init_thread(NULL, NULL, MPI_THREAD_SERIALIZED, &provided) != MPI_SUCCESS ||
        provided < MPI_THREAD_SERIALIZED) {
        *problem = "this MPI cannot be called from several threads in turn";
        return NULL;
    }
    state.ranks = (satin_ranks){.user = &state,
                                .broadcast = mpi_broadcast,
                                .any = mpi_any,
                                .fetch_add = mpi_fetch_add,
                                .reset = mpi_reset};
    MPI_Comm_rank(MPI_COMM_WORLD, &state.ranks.rank);
    MPI_Comm_size(MPI_COMM_WORLD, &state.ranks.count);
    uint64_t *counter = NULL;
    const MPI_Aint own = state.ranks.rank == 0 ? SATIN_RANKS_COUNTERS * sizeof *counter : 0;
    MPI_Win_allocate(own, sizeof *counter, MPI_INFO_NULL, MPI_COMM_WORLD, &counter,
                     &state.counters);
    for (int i = 0; own && i < SATIN_RANKS_COUNTERS; i++) counter[i] = 0;
    MPI_Barrier(MPI_COMM_WORLD);
    MPI_Win_lock_all(0, state.counters);
    return &state.ranks;
}

static void mpi_end(void) {
    // The window is left to MPI: freeing it would need all ranks.
    MPI_Finalize();
}

static void mpi_abort(int status) { MPI_Abort(MPI_COMM_WORLD, status); }

SATIN_API const struct app_ranks_module satin_ranks_module = {mpi_begin, mpi_end, mpi_abort};
