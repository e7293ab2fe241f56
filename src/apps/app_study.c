// SPDX-License-Identifier: Apache-2.0
// satin study: runs the study that a file describes, or continues it.
#include "apps/app.h"
#include "study/study.h"

enum { STUDY_FLAG_OUTPUT, STUDY_FLAG_LIST, STUDY_FLAG_QUIET, STUDY_FLAG_HELP };

const struct app_flag app_study_flags[] = {
    {"--output", "-o", "DIR",
     "The folder of the results; made if it is not there. A study that was stopped goes on."},
    {"--list", NULL, NULL, "Checks the study and prints its commands instead of running them."},
    {"--quiet", "-q", NULL, "Prints errors only."},
    {"--help", "-h", NULL, "Prints this."},
    {NULL, NULL, NULL, NULL},
};

static void print_progress(void *user, const char *line) {
    const bool *quiet = user;
    if (!*quiet) fprintf(stderr, "%s\n", line);
}

static void end_reading(void) { app_set_reading(false); }

static void print_listed(void *user, const char *line) {
    (void)user;
    printf("%s\n", line);
}

int app_study(int argc, char **argv) {
    struct app_args args = {.argc = argc, .argv = argv};
    bool quiet = false;
    // The program runs itself, even if its file is replaced meanwhile.
    struct study_request request = {.program = "/proc/self/exe",
                                    .report = print_progress,
                                    .user = &quiet,
                                    .interrupted = app_interrupted,
                                    .planned = end_reading};
    char *value;
    int flag;
    while ((flag = app_args_next(&args, app_study_flags, NULL, &value)) != APP_END) {
        if (flag == APP_BAD) return APP_WRONG;
        if (flag == STUDY_FLAG_HELP) return app_help(1, (char *[]){"study"});
        if (flag == STUDY_FLAG_OUTPUT) request.folder = value;
        if (flag == STUDY_FLAG_LIST) request.dry = true;
        if (flag == STUDY_FLAG_QUIET) quiet = true;
        if (flag == APP_POSITIONAL && request.file) return app_wrong("study takes one file");
        if (flag == APP_POSITIONAL) request.file = value;
    }
    const bool folder = request.folder && *request.folder;
    if (!request.file || (!folder && !request.dry))
        return app_wrong("study takes a file and a folder: satin study STUDY.toml -o DIR");
    if (request.dry) request.report = print_listed;
    // Nothing is written before all scenes are read, which may take long.
    app_set_reading(true);
    app_catch_signals();
    app_ignore_closed_pipes();
    const struct log log = {quiet ? app_log_file_errors : app_log_file, NULL};
    const int result = app_exit_of(study_run(&request, log));
    if (result == APP_DONE && !request.dry && !quiet)
        fprintf(stderr, "%s/study.html\n", request.folder);
    if (result == APP_CANCELLED && !quiet) fprintf(stderr, "stopped; the same command goes on\n");
    return result;
}
