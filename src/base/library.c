// SPDX-License-Identifier: Apache-2.0
// Shared libraries that are opened when they are first needed, from folders relative to the
// program.
#include "base/library.h"

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

// Cuts a path after its last slash. False if it has none.
static bool cut_to_folder(char *path) {
    char *slash = strrchr(path, '/');
    if (slash) slash[1] = 0;
    return slash;
}

// The folder of the program, or of the library that holds this code, with a final slash.
static bool own_folder(bool program, char folder[PATH_MAX]) {
    static const char here = 0;
    if (program) {
        ssize_t n = readlink("/proc/self/exe", folder, PATH_MAX - 1);
        if (n <= 0) return false;
        folder[n] = 0;
    } else {
        Dl_info info;
        if (!dladdr(&here, &info) || !info.dli_fname || !realpath(info.dli_fname, folder))
            return false;
    }
    return cut_to_folder(folder);
}

bool library_find(const char *const *paths, size_t count, char path[PATH_MAX]) {
    char folder[PATH_MAX];
    for (int program = 0; program < 2; program++) {
        if (!own_folder(program, folder)) continue;
        for (size_t i = 0; i < count; i++) {
            int n = snprintf(path, PATH_MAX, "%s%s", folder, paths[i]);
            if (n > 0 && n < PATH_MAX && access(path, R_OK) == 0) return true;
        }
    }
    return false;
}

void *library_open(const char *path) { return dlopen(path, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE); }
