// SPDX-License-Identifier: Apache-2.0
// What a program of this folder does with satin's messages: it prints the errors.
#ifndef BENCH_LOG_H
#define BENCH_LOG_H

#include <stdio.h>

#include "satin/types.h"

static inline void bench_print_error(void *user, satin_log_severity severity, const char *message) {
    (void)user;
    if (severity == SATIN_LOG_ERROR) fprintf(stderr, "%s\n", message);
}

#endif
