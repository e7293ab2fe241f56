// SPDX-License-Identifier: Apache-2.0
// What the subcommands of `satin` have in common: exit status, arguments, messages, progress.
#ifndef APP_H
#define APP_H

#include <stdbool.h>
#include <stdio.h>

#include "base/fileio_files.h"
#include "base/fileio_output.h"
#include "satin/film.h"
#include "satin/render.h"

enum app_exit { APP_DONE = 0, APP_FAILED = 1, APP_WRONG = 2, APP_CANCELLED = 3 };

// The exit status for a status of the library.
enum app_exit app_exit_of(satin_status status);

// ---- Subcommands: arguments after the command's name --------------------------------------------

int app_render(int argc, char **argv);
int app_compare(int argc, char **argv);
int app_average(int argc, char **argv);
int app_info(int argc, char **argv);
int app_maps(int argc, char **argv);
int app_tonemap(int argc, char **argv);
int app_study(int argc, char **argv);
int app_help(int argc, char **argv);

// Prints text from column `indent` on, wrapped at blanks. The cursor is at column `at`.
void app_print_wrapped(int at, int indent, const char *text);

// Print all plugins of scene files, and all plugins of one name with their parameters. False if
// there is none; then `search` has compared the names (app_help_plugins.c).
struct text_nearest;
void app_help_plugins(void);
// Lists the plugins of an element. False if the topic is not an element.
bool app_help_element(const char *topic);
bool app_help_plugin(const char *element, const char *name, struct text_nearest *search);
void app_help_plugins_markdown(void);
// satin info of a file of cache records (app_info_cache.c) and of a scene (app_info_scene.c).
// app_info_starts: whether a file begins with the bytes of `magic`, at most 16.
bool app_info_starts(const char *path, const char *magic);
satin_status app_info_cache(const char *path);
satin_status app_info_scene(const char *path, const satin_scene_request *request);

// ---- Arguments (app_args.c) ---------------------------------------------------------------------

// A flag of a subcommand. The arguments are parsed and the help is printed by a table of these.
struct app_flag {
    const char *name;   // "--name"
    const char *brief;  // "-n" or NULL
    const char *value;  // the name of its value, in brackets if it is optional; NULL if it has none
    const char *doc;
};

struct app_command {
    const char *name;
    const char *usage;  // describes the positional arguments
    const char *doc;
    const struct app_flag *flags;  // ended by a NULL name
    int (*run)(int argc, char **argv);
};
extern const struct app_command app_commands[];  // ended by a NULL name

extern const struct app_flag app_render_flags[];
extern const struct app_flag app_compare_flags[];
extern const struct app_flag app_average_flags[];
extern const struct app_flag app_info_flags[];
extern const struct app_flag app_maps_flags[];
extern const struct app_flag app_tonemap_flags[];
extern const struct app_flag app_study_flags[];
extern const struct app_flag app_help_flags[];

struct app_args {
    int argc;
    char **argv;
    int at;
    bool positional_only;  // after `--`
};

enum { APP_POSITIONAL = -1, APP_END = -2, APP_BAD = -3 };

// Reads the next argument: returns the index of its flag in `flags`, or one of the values above.
// *value is set to the flag's value (NULL if it has none) or to the positional argument. An
// optional value is taken if it follows `=`, or if it is the next argument and `takes` accepts it
// (NULL accepts none). Before APP_BAD is returned, the error is reported.
int app_args_next(struct app_args *args, const struct app_flag *flags,
                  bool (*takes)(const char *next), char **value);

// Reads X,Y,W,H: a box of pixels from its first column and row on. False if it is something else.
bool app_take_box(const char *text, int box[4]);

// Splits `name=value`, in place. False, with nothing changed, if it is something else.
bool app_args_split(char *pair, const char **name, const char **value);

// Whether a name has that ending, in any letter case.
bool app_ends_in(const char *name, const char *ending);

// Reports `satin: error: ...` and returns APP_WRONG.
int app_wrong(const char *format, ...) __attribute__((format(printf, 1, 2)));

// Reports lack of memory and returns APP_FAILED.
int app_no_memory(void);

// ---- Pictures (app_tonemap.c) -------------------------------------------------------------------

#define APP_EXPOSURE_DOC                                                                        \
    "Makes the picture brighter by so many stops, of which each doubles the light. `auto`, or " \
    "`auto+STOPS`, first makes its mean logarithm that of 18 % grey."
#define APP_TONEMAP_DOC                                                                          \
    "How light becomes the picture's tones: `clip` is linear, `filmic` keeps details of bright " \
    "parts, and `agx` their hues too."

// Read the values of --exposure and --tonemap. Report a wrong one and return APP_WRONG.
int app_take_exposure(const char *value, satin_tonemap *tonemap);
int app_take_tonemap(const char *value, satin_tonemap *tonemap);

// ---- Outputs (app_outputs.c) --------------------------------------------------------------------

struct app_output {
    const char *path;  // NULL if it was not asked for
    enum fileio_need need;
    const char *updates;  // the path of the input that it may replace, or NULL
};

struct app_input {
    const char *path;  // NULL if it was not asked for
    const char *what;  // its name in messages
};

// The paths of standard output as an output and of standard input as an input.
#define APP_STDOUT "/dev/fd/1"
#define APP_STDIN "/dev/stdin"

// Checks all outputs. Reports the first one that is one of the inputs (the list ends with `what`
// NULL), that is the same file as an output before it, or that cannot be written, and returns
// APP_WRONG.
int app_outputs_check(const struct app_output *output, int count, const struct app_input *input);
// Checks outputs in this way against the files from which a scene was read.
int app_outputs_check_read(const struct app_output *output, int count,
                           const struct fileio_files *read);

// ---- Messages and progress (app_progress.c) -----------------------------------------------------

// Messages are not printed from the first call on, until the second one prints the last error of
// them after a prefix with a number, if there was any. The third one returns whether an error was
// printed or can be.
void app_begin_silence(void);
void app_end_silence(const char *prefix, int number) __attribute__((format(printf, 1, 0)));
bool app_has_error(void);

// Prints messages and progress on stderr: a bar on a terminal, else one line per finished stage.
struct app_progress {
    bool quiet;  // errors only
    bool terminal;
    bool bar;  // whether a bar is on the screen
    const char *stage;
    char unit[32];
    double stage_start,
        last;  // elapsed seconds: of the stage's beginning, when it was last reported
    double last_draw;
    double rate;
};

void app_progress_start(struct app_progress *progress, bool quiet);
// Whether a bar is drawn, with the time that is left.
static inline bool app_progress_bar(const struct app_progress *progress) {
    return progress->terminal && !progress->quiet;
}
// A satin_progress_fn; `user` is a struct app_progress. Returns true, which cancels the render,
// after a signal.
bool app_progress_update(void *user, const satin_progress *now);
// Ends the line of the last stage, or erases the bar.
void app_progress_end(struct app_progress *progress);

// Functions of type satin_log_fn; `user` is a struct app_progress or NULL. The first prints errors
// unchanged, for messages that begin with a file name; the second prints only errors, as the first;
// the third adds the prefix `satin: error: `.
void app_log_file(void *user, satin_log_severity severity, const char *message);
void app_log_file_errors(void *user, satin_log_severity severity, const char *message);
void app_log(void *user, satin_log_severity severity, const char *message);

// From now on SIGINT, SIGTERM, SIGHUP and SIGUSR1 cancel the render. A signal more than a second
// after the first one ends the process at once. SIGHUP stays ignored if it was ignored, as under
// nohup.
void app_catch_signals(void);
// From now on a write to a closed pipe is an error, and does not end the process.
void app_ignore_closed_pipes(void);
// Says whether the scene is being read. A signal during that ends the process with APP_CANCELLED if
// the scene has not been read a second later; no image is written then.
void app_set_reading(bool scene_is_read);
bool app_interrupted(void);

#endif
