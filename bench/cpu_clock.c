// SPDX-License-Identifier: Apache-2.0
// Preloaded into a program, this replaces its monotonic clock by its processor time. A time limit
// then means processor seconds, and what a render of one thread does within it hardly depends on
// the other load of the machine (runs.py, --cpu).
#define _GNU_SOURCE
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

int clock_gettime(clockid_t clock, struct timespec *now) {
    return (int)syscall(SYS_clock_gettime,
                        clock == CLOCK_MONOTONIC ? CLOCK_PROCESS_CPUTIME_ID : clock, now);
}
