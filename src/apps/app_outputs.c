// SPDX-License-Identifier: Apache-2.0
// Checks the outputs of a command before it begins: none may overwrite a file that it reads, no two
// may be the same file, and all must be writable.
#include "apps/app.h"

static int check_inputs(const struct app_output *output, const struct app_input *input) {
    for (; input->what; input++) {
        const bool updated = output->updates && output->updates == input->path;
        if (input->path && !updated && fileio_same(output->path, input->path))
            return app_wrong("%s: the output would replace %s", output->path, input->what);
    }
    return APP_DONE;
}

int app_outputs_check(const struct app_output *output, int count, const struct app_input *input) {
    for (int i = 0; i < count; i++) {
        if (!output[i].path) continue;
        const int status = check_inputs(&output[i], input);
        if (status != APP_DONE) return status;
        for (int j = 0; j < i; j++)
            if (output[j].path && fileio_same(output[i].path, output[j].path))
                return app_wrong("two outputs are the same file: %s and %s", output[j].path,
                                 output[i].path);
        const struct log log = {app_log, NULL};
        const satin_status possible = fileio_output_check(log, output[i].path, output[i].need);
        if (possible != SATIN_OK) return app_exit_of(possible);
    }
    return APP_DONE;
}

int app_outputs_check_read(const struct app_output *output, int count,
                           const struct fileio_files *read) {
    for (int i = 0; i < count; i++)
        if (output[i].path && fileio_files_have(read, output[i].path))
            return app_wrong("%s: the output would replace a file that the scene is read from",
                             output[i].path);
    return APP_DONE;
}
