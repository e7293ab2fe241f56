// SPDX-License-Identifier: Apache-2.0
// The `satin` command: passes the arguments to the subcommand that they name.
#include <signal.h>
#include <string.h>

#include "apps/app.h"
#include "base/text.h"

const struct app_command app_commands[] = {
    {"render", "SCENE.xml -o OUT.exr", "Renders a Mitsuba 3 scene.", app_render_flags, app_render},
    {"compare", "IMAGE.exr... REFERENCE.exr",
     "Measures how far images are from a reference. The noise of one by `satin average` is "
     "subtracted.",
     app_compare_flags, app_compare},
    {"average", "A.exr B.exr ... -o OUT.exr",
     "Averages independent renders, with the variance of the mean.", app_average_flags,
     app_average},
    {"info", "FILE", "Describes a scene, an image or a file of cache records.", app_info_flags,
     app_info},
    {"maps", "IMAGE.exr -o DIR",
     "Makes pictures of where an image's records are and how they serve.", app_maps_flags,
     app_maps},
    {"tonemap", "IMAGE.exr -o OUT.png", "Makes a picture of an image or of one of its layers.",
     app_tonemap_flags, app_tonemap},
    {"study", "STUDY.toml -o DIR",
     "Measures errors and times of many renders, as a table and a page.", app_study_flags,
     app_study},
    {"help", "[TOPIC]", "Explains a command, an option or a plugin.", app_help_flags, app_help},
    {NULL, NULL, NULL, NULL, NULL},
};

static int unknown_command(const char *name) {
    struct text_nearest search = {.word = name};
    for (const struct app_command *c = app_commands; c->name; c++)
        text_nearest_try(&search, c->name);
    if (search.best)
        return app_wrong("unknown command '%s' (did you mean '%s'?)", name, search.best);
    return app_wrong("unknown command '%s'; `satin help` lists them", name);
}

// Flushes standard output. Output that was printed may still fail to be written, for example on a
// full disk.
static int finish_output(int result) {
    if (fflush(stdout) == 0 && !ferror(stdout)) return result;
    app_log(NULL, SATIN_LOG_ERROR, "cannot write to standard output");
    return result == APP_DONE ? APP_FAILED : result;
}

int main(int argc, char **argv) {
    // A write beyond a file size limit then fails instead of ending the process.
    signal(SIGXFSZ, SIG_IGN);
    if (argc < 2) return app_wrong("no command; `satin help` lists them");
    if (strcmp(argv[1], "--version") == 0) {
        printf("satin %s\n", SATIN_VERSION);
        return finish_output(APP_DONE);
    }
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0)
        return finish_output(app_help(0, NULL));
    for (const struct app_command *c = app_commands; c->name; c++)
        if (strcmp(argv[1], c->name) == 0) return finish_output(c->run(argc - 2, argv + 2));
    return unknown_command(argv[1]);
}
