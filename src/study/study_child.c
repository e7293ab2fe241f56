// SPDX-License-Identifier: Apache-2.0
// A render as a process of its own. A crash or a lack of memory then ends that render alone, no
// render inherits memory or threads from another one, its peak memory and processor time are those
// of the process, and the command line that is reported is the one that has run.
#include <errno.h>
#include <fcntl.h>
#include <malloc.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/stats.h"
#include "study/study_work.h"

enum { POLL_MS = 50, EXIT_NOT_STARTED = 127 };

// In the new process: only calls that are safe between fork and exec.
static void become(const struct study_child *child, char *const *argv, pid_t parent, int errors) {
    const int nothing = open("/dev/null", O_RDWR);
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    // If the parent has died before that call, there is no signal.
    if (getppid() != parent || nothing < 0) _exit(EXIT_NOT_STARTED);
    dup2(nothing, STDIN_FILENO);
    dup2(nothing, STDOUT_FILENO);
    dup2(errors, STDERR_FILENO);
    execv(child->program, argv);
    _exit(EXIT_NOT_STARTED);
}

// Waits until the process has ended, which closes the other end of the pipe.
static void wait_for_end(const struct study_child *child, pid_t pid, int end) {
    struct pollfd poll_end = {.fd = end};
    bool asked = false;
    while (poll(&poll_end, 1, POLL_MS) <= 0 || !(poll_end.revents & (POLLHUP | POLLERR))) {
        if (asked || !child->interrupted || !child->interrupted()) continue;
        kill(pid, SIGTERM);
        asked = true;
    }
}

static char **argument_vector(const struct study_child *child) {
    size_t count = 0;
    while (child->argument[count]) count++;
    char **argv = calloc(count + 2, sizeof *argv);
    if (!argv) return NULL;
    argv[0] = (char *)"satin";
    for (size_t i = 0; i < count; i++) argv[i + 1] = (char *)child->argument[i];
    return argv;
}

static double seconds_of(struct timeval t) { return (double)t.tv_sec + 1e-6 * (double)t.tv_usec; }

bool study_child_run(const struct study_child *child, struct study_result *out) {
    char **argv = argument_vector(child);
    const int errors = open(child->errors, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    int ends[2] = {-1, -1}, status = 0;
    struct rusage usage = {0};
    pid_t pid = -1;
    // The system counts this process's memory into the peak of one that it forks.
    malloc_trim(0);
    const double begin = stats_wall();
    if (argv && errors >= 0 && pipe2(ends, O_CLOEXEC) == 0) {
        const pid_t self = getpid();
        // Without the flag, this end stays open until the new process ends.
        fcntl(ends[1], F_SETFD, 0);
        pid = fork();
        if (pid == 0) become(child, argv, self, errors);
    }
    const int error = errno;
    if (ends[1] >= 0) close(ends[1]);
    if (pid > 0) {
        wait_for_end(child, pid, ends[0]);
        while (wait4(pid, &status, 0, &usage) < 0 && errno == EINTR) continue;
        out->wall_s = stats_wall() - begin;
        out->cpu_s = seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime);
        out->peak_bytes = 1024.0 * (double)usage.ru_maxrss;
        out->status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
        out->signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    }
    if (ends[0] >= 0) close(ends[0]);
    if (errors >= 0) close(errors);
    free(argv);
    errno = error;
    return pid > 0;
}
