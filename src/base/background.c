// SPDX-License-Identifier: Apache-2.0
// Work that a copy of this process does: see background.h.
#include "base/background.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

enum { PROBLEM_BYTES = 1024 };  // a message is not longer

// For the work's log: sends its errors to the process that waits for it.
static void send_problem(void *user, satin_log_severity severity, const char *message) {
    const int *pipe = user;
    // If nobody reads it any more, there is nobody to report to.
    if (severity == SATIN_LOG_ERROR && write(*pipe, message, strlen(message)) < 0) errno = 0;
}

// Closes all files but two, and replaces the standard ones by an empty device: the copy must hold
// no connection of the process.
static void close_others(int a, int b) {
    const unsigned low = (unsigned)(a < b ? a : b), high = (unsigned)(a < b ? b : a);
    const int null = open("/dev/null", O_RDWR);
    for (int i = 0; i < 3 && null >= 0; i++)
        if (i != a && i != b) dup2(null, i);
    if (low > 3) close_range(3, low - 1, 0);
    if (high > low + 1 && high > 3) close_range(low < 3 ? 3 : low + 1, high - 1, 0);
    close_range(high < 3 ? 3 : high + 1, ~0u, 0);
}

static void run_copy(int problem, int keep, background_fn fn, void *ctx) {
    static const int ignored[] = {SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGPIPE};
    for (size_t i = 0; i < sizeof ignored / sizeof *ignored; i++) signal(ignored[i], SIG_IGN);
    setsid();
    close_others(problem, keep);
    _exit(fn(ctx, (struct log){send_problem, &problem}) ? 0 : 1);
}

bool background_begin(struct background *out, int keep, background_fn fn, void *ctx) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) return false;
    const pid_t pid = fork();
    if (pid == 0) run_copy(ends[1], keep, fn, ctx);
    close(ends[1]);
    if (pid < 0)
        close(ends[0]);
    else
        *out = (struct background){pid, ends[0]};
    return pid > 0;
}

// Waits for the process, and returns its status as of waitpid.
static int wait_for(struct background *background) {
    int status = 0;
    close(background->problem);
    while (waitpid(background->pid, &status, 0) < 0 && errno == EINTR) continue;
    *background = (struct background){0};
    return status;
}

bool background_end(struct background *background, struct log log) {
    char problem[PROBLEM_BYTES] = "";
    size_t size = 0;
    if (background->pid == 0) return true;
    while (size + 1 < sizeof problem) {
        const ssize_t n = read(background->problem, problem + size, sizeof problem - 1 - size);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) break;
        size += (size_t)n;
    }
    const int status = wait_for(background);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return true;
    log_message(log, SATIN_LOG_ERROR, "%s", size ? problem : "a process of satin was killed");
    return false;
}

void background_stop(struct background *background) {
    if (background->pid == 0) return;
    kill(background->pid, SIGKILL);
    wait_for(background);
}
