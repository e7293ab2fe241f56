// SPDX-License-Identifier: Apache-2.0
// Runs a fuzz target over the files of the folders named as arguments, so that every compiler can
// run the seeds as a test. libFuzzer has its own main.
#include <dirent.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/fileio.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static int run_file(const char *folder, const char *name) {
    char path[4096], *data = NULL;
    size_t size = 0;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    if (fileio_read((struct log){0}, (struct log_place){0}, path, 1 << 24, &data, &size) !=
        SATIN_OK) {
        fprintf(stderr, "cannot read %s\n", path);
        return 1;
    }
    LLVMFuzzerTestOneInput((const uint8_t *)data, size);
    free(data);
    return 0;
}

int main(int argc, char **argv) {
    int files = 0, failed = 0;
    for (int i = 1; i < argc; i++) {
        DIR *folder = opendir(argv[i]);
        struct dirent *entry;
        while (folder && (entry = readdir(folder)))
            if (entry->d_name[0] != '.') {
                failed += run_file(argv[i], entry->d_name);
                files++;
            }
        if (folder) closedir(folder);
    }
    printf("%d files\n", files);
    return failed || !files;
}
