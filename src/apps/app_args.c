// SPDX-License-Identifier: Apache-2.0
// Parses arguments by a table of flags: `--name VALUE`, `--name=VALUE`, `-n VALUE`, `-nVALUE`.
#include <stdarg.h>
#include <string.h>
#include <strings.h>

#include "apps/app.h"
#include "base/text.h"

enum app_exit app_exit_of(satin_status status) {
    switch (status) {
        case SATIN_OK:
            return APP_DONE;
        case SATIN_ERROR_ARGUMENT:
        case SATIN_ERROR_INPUT:
            return APP_WRONG;
        case SATIN_CANCELLED:
            return APP_CANCELLED;
        default:
            return APP_FAILED;
    }
}

int app_wrong(const char *format, ...) {
    char text[1024];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    app_log(NULL, SATIN_LOG_ERROR, text);
    return APP_WRONG;
}

int app_no_memory(void) {
    app_log(NULL, SATIN_LOG_ERROR, "not enough memory");
    return APP_FAILED;
}

// Whether `argument` is this flag. *attached is set to the value that is attached to it, or to
// NULL.
static bool matches(const struct app_flag *flag, char *argument, char **attached) {
    size_t n = strlen(flag->name);
    *attached = NULL;
    if (strncmp(argument, flag->name, n) == 0 && (!argument[n] || argument[n] == '=')) {
        if (argument[n]) *attached = argument + n + 1;
        return true;
    }
    if (!flag->brief || strncmp(argument, flag->brief, 2) != 0) return false;
    if (argument[2]) *attached = argument + 2;
    return flag->value || !argument[2];
}

// The value that is given to an unknown argument, for a message. `next` is the argument after it,
// or NULL.
static const char *given_value(const char *argument, const char *next) {
    const char *value = strchr(argument, '=');
    if (value) return value + 1;
    return next && next[0] != '-' ? next : "VALUE";
}

// The option whose name is nearest to `word`; .best is NULL if none is near. Its name is kept in
// `info`.
static struct text_nearest nearest_option(const char *word, satin_option_info *info) {
    struct text_nearest search = {.word = word};
    for (int i = 0; satin_options_describe(&satin_options_default, i, info); i++)
        text_nearest_try(&search, info->name);
    return search;
}

// Whether a word is the name of an option that adds a material to another option.
static bool is_material_option(const char *word) {
    satin_options scratch = satin_options_default;
    return strchr(word, '.') && satin_options_set(&scratch, word, "on", NULL, NULL) == SATIN_OK;
}

// Reports how an argument of `satin render` is meant that is an option or nearly the name of one:
// such as --photons, which is set by --set. `nearest` is the nearest flag. False if it is none.
static bool is_render_option(const char *name, const char *value,
                             const struct text_nearest *nearest) {
    satin_option_info info;
    struct text_nearest option = nearest_option(name + 2, &info);
    if (is_material_option(name + 2)) option = (struct text_nearest){name + 2, name + 2, 0};
    if (!option.best || (nearest->best && nearest->edits <= option.edits)) return false;
    if (option.edits == 0)
        app_wrong("unknown argument '%s': it is an option, set by --set %s=%s", name, option.best,
                  value);
    else
        app_wrong("unknown argument '%s' (did you mean '--set %s=%s'?)", name, option.best, value);
    return true;
}

// Reports where an argument of `satin study` belongs that is an option of renders or nearly the
// name of one: in the file. False if it is none.
static bool is_study_option(const char *name, const struct text_nearest *nearest) {
    satin_option_info info;
    struct text_nearest option = nearest_option(name + 2, &info);
    if (is_material_option(name + 2)) option = (struct text_nearest){name + 2, name + 2, 0};
    const bool set = strcmp(name, "--set") == 0;
    if (!set && (!option.best || (nearest->best && nearest->edits <= option.edits))) return false;
    if (!set && strcmp(option.best, "seed") == 0)
        app_wrong("unknown argument '%s': the key 'seeds' in the file of the study chooses seeds",
                  name);
    else if (set || option.edits == 0)
        app_wrong(
            "unknown argument '%s': options of renders stand in [set] or [vary] in the file "
            "of the study",
            name);
    else
        app_wrong(
            "unknown argument '%s' (did you mean '%s', in [set] or [vary] in the file of the "
            "study?)",
            name, option.best);
    return true;
}

static int unknown_flag(const struct app_flag *flags, const char *argument, const char *next) {
    char name[64];
    snprintf(name, sizeof name, "%.*s", (int)strcspn(argument, "="), argument);
    struct text_nearest search = {.word = name};
    for (const struct app_flag *f = flags; f->name; f++) text_nearest_try(&search, f->name);
    if (strncmp(name, "--", 2) == 0) {
        if (flags == app_render_flags &&
            is_render_option(name, given_value(argument, next), &search))
            return APP_BAD;
        if (flags == app_study_flags && is_study_option(name, &search)) return APP_BAD;
    }
    if (search.best)
        app_wrong("unknown argument '%s' (did you mean '%s'?)", name, search.best);
    else
        app_wrong("unknown argument '%s'", name);
    return APP_BAD;
}

int app_args_next(struct app_args *args, const struct app_flag *flags,
                  bool (*takes)(const char *next), char **value) {
    *value = NULL;
    if (args->at == args->argc) return APP_END;
    char *argument = args->argv[args->at++], *attached;
    if (!args->positional_only && strcmp(argument, "--") == 0) {
        args->positional_only = true;
        return app_args_next(args, flags, takes, value);
    }
    if (args->positional_only || argument[0] != '-' || !argument[1]) {
        *value = argument;
        return APP_POSITIONAL;
    }
    for (int i = 0; flags[i].name; i++) {
        const struct app_flag *flag = &flags[i];
        if (!matches(flag, argument, &attached)) continue;
        char *next = args->at < args->argc ? args->argv[args->at] : NULL;
        bool optional = flag->value && flag->value[0] == '[';
        if (attached && !flag->value) {
            app_wrong("%s takes no value", flag->name);
            return APP_BAD;
        }
        if (!attached && flag->value && next && (!optional || (takes && takes(next)))) {
            attached = next;
            args->at++;
        }
        if (flag->value && !optional && !attached) {
            app_wrong("%s needs a value: %s", argument, flag->value);
            return APP_BAD;
        }
        *value = attached;
        return i;
    }
    return unknown_flag(flags, argument, args->at < args->argc ? args->argv[args->at] : NULL);
}

bool app_take_box(const char *text, int box[4]) {
    int end = 0;
    if (strspn(text, "0123456789,") != strlen(text) || strlen(text) > 40) return false;
    const int count = sscanf(text, "%9d,%9d,%9d,%9d%n", &box[0], &box[1], &box[2], &box[3], &end);
    return count == 4 && text[end] == 0 && box[2] > 0 && box[3] > 0;
}

bool app_args_split(char *pair, const char **name, const char **value) {
    char *equals = strchr(pair, '=');
    if (!equals || equals == pair) return false;
    *equals = 0;
    *name = pair;
    *value = equals + 1;
    return true;
}

bool app_ends_in(const char *name, const char *ending) {
    const size_t n = strlen(name), m = strlen(ending);
    return n >= m && strcasecmp(name + n - m, ending) == 0;
}
