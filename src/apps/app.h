// SPDX-License-Identifier: Apache-2.0
// What is common to the subcommands of `satin`: exit status, arguments, messages, progress.
#ifndef APP_H
#define APP_H

#include <stdbool.h>
#include <stdio.h>

#include "base/fileio_files.h"
#include "base/fileio_output.h"
#include "satin/render.h"

enum app_exit { APP_DONE = 0, APP_FAILED = 1, APP_WRONG = 2, APP_CANCELLED = 3 };

// The exit status that a status of the library leads to.
enum app_exit app_exit_of(satin_status status);

// ---- Subcommands: arguments after the command's name --------------------------------------------

int app_render(int argc, char **argv);
int app_compare(int argc, char **argv);
int app_info(int argc, char **argv);
int app_maps(int argc, char **argv);
int app_help(int argc, char **argv);

// Prints text from column `indent` on, wrapped at blanks; the cursor stands at column `at`.
void app_print_wrapped(int at, int indent, const char *text);

// All plugins of scene files, and all of one name with their parameters; false if there is none,
// then `search` has tried the names (app_help_plugins.c).
struct text_nearest;
void app_help_plugins(void);
// Lists the plugins of an element; false if the topic is none.
bool app_help_element(const char *topic);
bool app_help_plugin(const char *element, const char *name, struct text_nearest *search);
void app_help_plugins_markdown(void);
// satin info of a file of cache records (app_info_cache.c), and of a scene (app_info_scene.c).
// Whether a file begins with these, at most 16, bytes.
bool app_info_starts(const char *path, const char *magic);
satin_status app_info_cache(const char *path);
satin_status app_info_scene(const char *path, const satin_define *define, size_t count);

// ---- Arguments (app_args.c) ---------------------------------------------------------------------

// A flag of a subcommand. The table parses the arguments and prints the help.
struct app_flag {
    const char *name;   // "--name"
    const char *brief;  // "-n" or NULL
    const char *value;  // what its value is called, in brackets if it may be left out; NULL: none
    const char *doc;
};

struct app_command {
    const char *name;
    const char *usage;  // of the positional arguments
    const char *doc;
    const struct app_flag *flags;  // ended by a NULL name
    int (*run)(int argc, char **argv);
};
extern const struct app_command app_commands[];  // ended by a NULL name

extern const struct app_flag app_render_flags[];
extern const struct app_flag app_compare_flags[];
extern const struct app_flag app_info_flags[];
extern const struct app_flag app_maps_flags[];
extern const struct app_flag app_help_flags[];

struct app_args {
    int argc;
    char **argv;
    int at;
    bool positional_only;  // after `--`
};

enum { APP_POSITIONAL = -1, APP_END = -2, APP_BAD = -3 };

// The next argument: the index of its flag in `flags`, or one of the values above. *value gets the
// flag's value (NULL if it has none) or the positional argument. A value that may be left out is
// taken if it follows `=` or is the next argument and one that `takes` says yes to (NULL: none).
// APP_BAD was reported.
int app_args_next(struct app_args *args, const struct app_flag *flags,
                  bool (*takes)(const char *next), char **value);

// Cuts `name=value` in two, in place; false, and nothing changed, if it is something else.
bool app_args_split(char *pair, const char **name, const char **value);

// Reports `satin: error: ...` and returns APP_WRONG.
int app_wrong(const char *format, ...) __attribute__((format(printf, 1, 2)));

// Reports lack of memory and returns APP_FAILED.
int app_no_memory(void);

// ---- Outputs (app_outputs.c) --------------------------------------------------------------------

struct app_output {
    const char *path;  // NULL: it is not asked for
    enum fileio_need need;
    const char *updates;  // the path of the input that it may replace, or NULL
};

struct app_input {
    const char *path;  // NULL: it is not asked for
    const char *what;  // as messages call it
};

// Standard output as the path of an output.
#define APP_STDOUT "/dev/fd/1"

// Reports the first output that is one of the inputs (ended by `what` NULL), an output before it,
// or impossible to write, and returns APP_WRONG.
int app_outputs_check(const struct app_output *output, int count, const struct app_input *input);
// app_refuse for the files that a scene was read from.
int app_outputs_check_read(const struct app_output *output, int count,
                           const struct fileio_files *read);

// ---- Messages and progress (app_progress.c) -----------------------------------------------------

// Prints messages and progress on stderr. A terminal gets a bar, anything else a line per finished
// stage.
struct app_progress {
    bool quiet;  // errors only
    bool terminal;
    bool bar;  // a bar is on the screen
    const char *stage;
    char unit[32];
    double stage_start,
        last;  // elapsed seconds: of the stage's beginning, when it was last reported
    double last_draw;
    double rate;
};

void app_progress_start(struct app_progress *progress, bool quiet);
// A satin_progress_fn; `user` is a struct app_progress. True after a signal asked for a stop.
bool app_progress_update(void *user, const satin_progress *now);
// Ends the last stage's line or erases the bar.
void app_progress_end(struct app_progress *progress);

// satin_log_fns; `user` is a struct app_progress or NULL. The first is for messages that begin with
// their file and prints errors as they are; the second prefixes `satin: error: `.
void app_log_file(void *user, satin_log_severity severity, const char *message);
void app_log(void *user, satin_log_severity severity, const char *message);

// From here on SIGINT, SIGTERM and SIGHUP ask for a stop; one that comes more than a second after
// the first ends the process at once. SIGHUP stays ignored if it was, as under nohup. A reader of
// messages that goes away is not missed.
void app_catch_signals(void);
bool app_interrupted(void);

#endif
