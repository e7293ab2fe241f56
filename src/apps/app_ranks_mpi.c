// SPDX-License-Identifier: Apache-2.0
// The module on MPI: how the ranks of a render communicate. The counters are in memory of rank 0
// that all ranks access [MPI 3.1, 11: one-sided communication].
//
// Ranks beyond the cores of a machine would only do again what is not divided, on cores that are in
// use. They wait until the others have ended; the communicator of these is `comm`.
//
// MPI does not report that a rank was killed: it waits for that rank for ever, or until mpirun ends
// all others too. So each rank has a thread that looks whether the processes of ranks on its own
// machine still exist.
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <mpi.h>
#include <pthread.h>
#include <sched.h>
#include <semaphore.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "apps/app_ranks.h"

// The process of a rank.
struct mpi_process {
    char host[HOST_NAME_MAX + 1];
    ino_t space;  // in which process numbers are unique: containers have their own
    pid_t pid;
    cpu_set_t cores;  // on which it may run
};

// In memory of all ranks of a machine.
struct mpi_machine {
    atomic_bool explained;  // whether one of them has said why all end
    sem_t ended;            // not 0 when one of those that work has ended
};

struct mpi_state {
    satin_ranks ranks;  // those that work
    MPI_Comm comm;
    MPI_Win counters;
    int own, count;               // of all ranks
    struct mpi_process *process;  // by rank, of all
    struct mpi_machine *machine;  // the one of this rank
    MPI_Request barrier;          // of ranks that wait for each other
    double wait_start;
    bool waiting;
    pthread_t watcher;
    pthread_mutex_t mutex;  // of `ending`
    pthread_cond_t end;
    bool ending;  // the watcher is to end
};

// There is one, as MPI is one of the process.
static struct mpi_state *mpi_state_get(void) {
    static struct mpi_state state = {.mutex = PTHREAD_MUTEX_INITIALIZER,
                                     .end = PTHREAD_COND_INITIALIZER};
    return &state;
}

static uint64_t mpi_fetch_add(void *user, int counter, uint64_t add) {
    struct mpi_state *state = user;
    uint64_t before = 0;
    MPI_Fetch_and_op(&add, &before, MPI_UINT64_T, 0, counter, MPI_SUM, state->counters);
    MPI_Win_flush(0, state->counters);
    return before;
}

// ---- Ranks that wait, and ranks that were killed ------------------------------------------------

// For tests, and for machines whose cores are not those that a process sees.
static bool all_ranks_work(void) {
    const char *value = getenv("SATIN_RANKS");
    return value && strcmp(value, "all") == 0;
}

static bool same_machine(const struct mpi_state *state, int a, int b) {
    return strcmp(state->process[a].host, state->process[b].host) == 0;
}

// Whether a rank waits: its machine has no core for it beside those before it.
static bool is_spare(const struct mpi_state *state, int rank) {
    cpu_set_t cores;
    int before = 0;
    CPU_ZERO(&cores);
    for (int i = 0; i < state->count; i++) {
        if (!same_machine(state, i, rank)) continue;
        CPU_OR(&cores, &cores, &state->process[i].cores);
        before += i < rank;
    }
    return before >= CPU_COUNT(&cores) && !all_ranks_work();
}

// Whether the process of a rank on this machine has ended; those of other machines are not known.
static bool has_ended(const struct mpi_state *state, int rank) {
    const struct mpi_process *own = &state->process[state->own], *other = &state->process[rank];
    return own->space && own->space == other->space && same_machine(state, state->own, rank) &&
           kill(other->pid, 0) != 0 && errno == ESRCH;
}

// The first rank on this machine that has ended, of those that wait or of those that work; the
// number of all ranks if none has.
static int find_ended(const struct mpi_state *state, bool spare) {
    int rank = 0;
    while (rank < state->count && (!has_ended(state, rank) || is_spare(state, rank) != spare))
        rank++;
    return rank;
}

static void report_ended(const struct mpi_state *state, int rank) {
    fprintf(stderr,
            "satin: error: rank %d (process %ld) was killed; what was done is in the checkpoint, "
            "if there is one\n",
            rank, (long)state->process[rank].pid);
}

// Waits for so long or until `ending`.
static void wait_watching(struct mpi_state *state, double seconds) {
    enum { NANOSECONDS = 1000000000 };
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_nsec += (long)(fmod(seconds, 1.0) * NANOSECONDS);
    until.tv_sec += (time_t)seconds + until.tv_nsec / NANOSECONDS;
    until.tv_nsec %= NANOSECONDS;
    int late = 0;
    while (!state->ending && !late)
        late = pthread_cond_timedwait(&state->end, &state->mutex, &until);
}

// If a rank that works has ended without a message, the first one of its machine that finds it
// reports it. mpirun ends the others, which write their checkpoint in the second that it gives
// them; without it they end themselves. If a rank that waits has ended, mpirun cancels the render,
// which is left to end. MPI is not called here, as another thread may wait in it.
static void *watch_ranks(void *arg) {
    static const double LOOK_SECONDS = 0.1, LAST_SECONDS = 3.0;
    struct mpi_state *state = arg;
    int ended = state->count;
    pthread_mutex_lock(&state->mutex);
    while (!state->ending && ended == state->count) {
        wait_watching(state, LOOK_SECONDS);
        if (!state->ending) ended = find_ended(state, false);
    }
    if (!state->ending) {
        if (!atomic_exchange(&state->machine->explained, true)) report_ended(state, ended);
        wait_watching(state, LAST_SECONDS);
        if (!state->ending) _exit(APP_FAILED);
    }
    pthread_mutex_unlock(&state->mutex);
    return NULL;
}

// Begins to look for ranks; signals are left to the other threads. False if there is no thread.
static bool begin_watch(struct mpi_state *state) {
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    const bool begun = pthread_create(&state->watcher, NULL, watch_ranks, state) == 0;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return begun;
}

// To be called before any rank may end.
static void end_watch(struct mpi_state *state) {
    pthread_mutex_lock(&state->mutex);
    state->ending = true;
    pthread_cond_signal(&state->end);
    pthread_mutex_unlock(&state->mutex);
    pthread_join(state->watcher, NULL);
}

// ---- Communication ------------------------------------------------------------------------------

// Waiting takes less of a core than MPI's own.
static bool mpi_here(void *user) {
    static const double PATIENCE_SECONDS = 0.05;
    struct mpi_state *state = user;
    int done = 0;
    if (!state->waiting) {
        MPI_Ibarrier(state->comm, &state->barrier);
        state->wait_start = MPI_Wtime();
        state->waiting = true;
    }
    MPI_Test(&state->barrier, &done, MPI_STATUS_IGNORE);
    state->waiting = !done;
    if (done) return true;
    if (MPI_Wtime() - state->wait_start > PATIENCE_SECONDS)
        usleep(100);
    else
        sched_yield();
    return false;
}

static void meet_ranks(struct mpi_state *state) {
    while (!mpi_here(state)) continue;
}

static void mpi_broadcast(void *user, int root, void *data, size_t size) {
    enum { MESSAGE_MOST = 1 << 30 };  // counts of MPI are int
    struct mpi_state *state = user;
    char *at = data;
    meet_ranks(state);
    for (; size > 0; size -= size < MESSAGE_MOST ? size : MESSAGE_MOST) {
        const int n = size < MESSAGE_MOST ? (int)size : MESSAGE_MOST;
        MPI_Bcast(at, n, MPI_BYTE, root, state->comm);
        at += n;
    }
}

static void mpi_exchange(void *user, void *blocks, size_t size) {
    struct mpi_state *state = user;
    if (size > INT_MAX) {
        for (int rank = 0; rank < state->ranks.count; rank++)
            mpi_broadcast(user, rank, (char *)blocks + (size_t)rank * size, size);
        return;
    }
    meet_ranks(state);
    MPI_Allgather(MPI_IN_PLACE, 0, MPI_BYTE, blocks, (int)size, MPI_BYTE, state->comm);
}

static bool mpi_any(void *user, bool value) {
    struct mpi_state *state = user;
    int own = value, all = 0;
    meet_ranks(state);
    MPI_Allreduce(&own, &all, 1, MPI_INT, MPI_LOR, state->comm);
    return all;
}

static void mpi_reset(void *user, int counter) {
    struct mpi_state *state = user;
    const uint64_t zero = 0;
    MPI_Accumulate(&zero, 1, MPI_UINT64_T, 0, counter, 1, MPI_UINT64_T, MPI_REPLACE,
                   state->counters);
    MPI_Win_flush(0, state->counters);
}

// Exchanges the processes of all ranks. False if there is no memory.
static bool exchange_processes(struct mpi_state *state) {
    struct mpi_process own = {.pid = getpid()};
    struct stat space;
    gethostname(own.host, HOST_NAME_MAX);
    if (stat("/proc/self/ns/pid", &space) == 0) own.space = space.st_ino;
    // A machine with more cores than a set has is left to the user.
    if (sched_getaffinity(0, sizeof own.cores, &own.cores) != 0)
        memset(&own.cores, 0xff, sizeof own.cores);
    state->process = calloc((size_t)state->count, sizeof own);
    if (!state->process) return false;
    MPI_Allgather(&own, sizeof own, MPI_BYTE, state->process, sizeof own, MPI_BYTE, MPI_COMM_WORLD);
    return true;
}

// Waits until the first rank ends with its status, and ends with it. A rank that looked for that
// itself would take time from those that work, so it mostly waits for one of its machine.
static void wait_for_others(struct mpi_machine *machine) {
    MPI_Request request;
    int status = APP_FAILED, done = 0;
    const int signals[] = {SIGINT, SIGTERM, SIGHUP, SIGUSR1};
    for (size_t i = 0; i < sizeof signals / sizeof *signals; i++) signal(signals[i], SIG_IGN);
    MPI_Ibcast(&status, 1, MPI_INT, 0, MPI_COMM_WORLD, &request);
    while (MPI_Test(&request, &done, MPI_STATUS_IGNORE) == MPI_SUCCESS && !done) {
        const struct timespec until = {.tv_sec = time(NULL) + 2};
        if (sem_timedwait(&machine->ended, &until) != 0) continue;
        sem_post(&machine->ended);
        usleep(1000);
    }
    MPI_Finalize();
    exit(status);
}

// Sets `machine`.
static void machine_make(struct mpi_state *state) {
    MPI_Comm machine;
    MPI_Win window;
    MPI_Aint size = sizeof *state->machine;
    int unit, rank;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, state->own, MPI_INFO_NULL, &machine);
    MPI_Comm_rank(machine, &rank);
    // Left to MPI, as the counters.
    MPI_Win_allocate_shared(rank == 0 ? size : 0, 1, MPI_INFO_NULL, machine, &state->machine,
                            &window);
    MPI_Win_shared_query(window, 0, &size, &unit, &state->machine);
    if (rank == 0) {
        atomic_init(&state->machine->explained, false);
        sem_init(&state->machine->ended, 1, 0);
    }
    MPI_Barrier(machine);
    MPI_Comm_free(&machine);
}

// Divides the ranks into those that work and those that wait, which do not return. The first one is
// among the former, and says so.
static void divide_ranks(struct mpi_state *state) {
    const bool spare = is_spare(state, state->own);
    int waiting = 0;
    for (int i = 0; i < state->count; i++) waiting += is_spare(state, i);
    if (state->own == 0 && waiting > 0)
        fprintf(stderr,
                "satin: warning: %d of %d ranks wait: their machines have no core for them\n",
                waiting, state->count);
    MPI_Comm_split(MPI_COMM_WORLD, spare ? MPI_UNDEFINED : 0, state->own, &state->comm);
    if (spare) wait_for_others(state->machine);
    MPI_Comm_rank(state->comm, &state->ranks.rank);
    MPI_Comm_size(state->comm, &state->ranks.count);
}

static const satin_ranks *mpi_begin(const char **problem) {
    struct mpi_state *state = mpi_state_get();
    int provided = 0;
    if (MPI_Init_thread(NULL, NULL, MPI_THREAD_SERIALIZED, &provided) != MPI_SUCCESS ||
        provided < MPI_THREAD_SERIALIZED) {
        *problem = "this MPI cannot be called from several threads in turn";
        return NULL;
    }
    state->ranks = (satin_ranks){.user = state,
                                 .broadcast = mpi_broadcast,
                                 .exchange = mpi_exchange,
                                 .any = mpi_any,
                                 .here = mpi_here,
                                 .fetch_add = mpi_fetch_add,
                                 .reset = mpi_reset};
    MPI_Comm_rank(MPI_COMM_WORLD, &state->own);
    MPI_Comm_size(MPI_COMM_WORLD, &state->count);
    if (!exchange_processes(state)) {
        *problem = "there is not enough memory";
        return NULL;
    }
    machine_make(state);
    divide_ranks(state);
    uint64_t *counter = NULL;
    const MPI_Aint own = state->ranks.rank == 0 ? SATIN_RANKS_COUNTERS * sizeof *counter : 0;
    MPI_Win_allocate(own, sizeof *counter, MPI_INFO_NULL, state->comm, &counter, &state->counters);
    for (int i = 0; own && i < SATIN_RANKS_COUNTERS; i++) counter[i] = 0;
    MPI_Barrier(state->comm);
    MPI_Win_lock_all(0, state->counters);
    if (!begin_watch(state)) {
        *problem = "there is not enough memory for a thread";
        return NULL;
    }
    return &state->ranks;
}

static void mpi_end(int status) {
    struct mpi_state *state = mpi_state_get();
    MPI_Request request;
    end_watch(state);
    sem_post(&state->machine->ended);
    // All ranks are still there, unless one that waited was killed.
    const int ended = state->own == 0 ? find_ended(state, true) : state->count;
    if (ended < state->count) report_ended(state, ended);
    MPI_Ibcast(&status, 1, MPI_INT, 0, MPI_COMM_WORLD, &request);
    MPI_Wait(&request, MPI_STATUS_IGNORE);
    // The window is left to MPI: freeing it would need all ranks.
    MPI_Finalize();
}

static void mpi_abort(int status) {
    atomic_store(&mpi_state_get()->machine->explained, true);
    MPI_Abort(MPI_COMM_WORLD, status);
}

SATIN_API const struct app_ranks_module satin_ranks_module = {mpi_begin, mpi_end, mpi_abort};
