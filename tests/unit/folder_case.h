// SPDX-License-Identifier: Apache-2.0
// For tests that write files: the setup and teardown of a group, a working directory of their own,
// which is removed with its contents.
#ifndef FOLDER_CASE_H
#define FOLDER_CASE_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char folder_case_path[] = "/tmp/satin-test-XXXXXX";

// Whether the setup has run.
static inline int folder_case_made(void) { return !strstr(folder_case_path, "XXXXXX"); }

static inline int folder_case_setup(void **state) {
    (void)state;
    return mkdtemp(folder_case_path) && chdir(folder_case_path) == 0 ? 0 : -1;
}

static inline int folder_case_teardown(void **state) {
    (void)state;
    char command[64];
    snprintf(command, sizeof command, "rm -r %s", folder_case_path);
    return chdir("/") == 0 && system(command) == 0 ? 0 : -1;
}

#endif
