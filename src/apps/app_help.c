// SPDX-License-Identifier: Apache-2.0
// satin help: commands, options and plugins, printed from the tables that parse them.
#include <string.h>

#include "apps/app.h"
#include "base/text.h"

enum { HELP_FLAG_MARKDOWN, HELP_FLAG_HELP };
enum { HELP_COLUMNS = 88 };  // columns of wrapped text

const struct app_flag app_help_flags[] = {
    {"--markdown", NULL, NULL, "Prints all options, or plugins, as Markdown tables."},
    {"--help", "-h", NULL, "Prints this."},
    {NULL, NULL, NULL, NULL},
};

void app_print_wrapped(int at, int indent, const char *text) {
    if (at + 1 > indent) {
        printf("\n");
        at = 0;
    }
    printf("%*s", indent - at, "");
    at = indent;
    while (*text) {
        int n = (int)strcspn(text, " ");
        if (at > indent && at + 1 + n > HELP_COLUMNS) {
            printf("\n%*s", indent, "");
            at = indent;
        } else if (at > indent) {
            printf(" ");
            at++;
        }
        printf("%.*s", n, text);
        at += n;
        text += n + (text[n] == ' ');
    }
    printf("\n");
}

// ---- Commands -----------------------------------------------------------------------------------

static void print_overview(void) {
    printf("satin %s: two-pass global illumination\n\n", SATIN_VERSION);
    for (const struct app_command *c = app_commands; c->name; c++) {
        int at = printf("  satin %s %s", c->name, c->usage);
        app_print_wrapped(at, 46, c->doc);
    }
    printf(
        "\n"
        "  satin help COMMAND     its arguments\n"
        "  satin help options     all options of --set and of <integrator type=\"satin\">\n"
        "  satin help plugins     what scene files may hold\n"
        "  satin help NAME        one option or plugin; or ELEMENT NAME\n"
        "  satin --version\n"
        "\n"
        "Exit status: 0 done, 1 the work failed, 2 the input or the command line is wrong,\n"
        "3 cancelled (what was done is written).\n");
}

static void print_command(const struct app_command *command) {
    printf("satin %s %s\n\n%s\n\n", command->name, command->usage, command->doc);
    for (const struct app_flag *f = command->flags; f->name; f++) {
        int at = printf("  %s%s%s%s%s", f->brief ? f->brief : "", f->brief ? ", " : "", f->name,
                        f->value ? " " : "", f->value ? f->value : "");
        app_print_wrapped(at, 32, f->doc);
    }
}

// ---- Options ------------------------------------------------------------------------------------

// Describes option `index` with the value that it has at a quality.
static satin_option_info option_at(int index, satin_quality quality) {
    satin_options options = satin_options_default;
    satin_option_info info;
    satin_options_preset(&options, quality);
    satin_options_describe(&options, index, &info);
    return info;
}

static void print_option(int index) {
    satin_option_info low = option_at(index, SATIN_DRAFT), mid = option_at(index, SATIN_PREVIEW),
                      high = option_at(index, SATIN_PRODUCTION);
    int at = printf("  %s", mid.name);
    app_print_wrapped(at, 26, mid.doc);
    printf("%26s%s; default %s", "", mid.range, mid.value);
    if (strcmp(low.value, mid.value) != 0 || strcmp(high.value, mid.value) != 0)
        if (strcmp(mid.name, "quality") != 0)
            printf(" (draft %s, production %s)", low.value, high.value);
    printf("\n");
}

static void print_options(void) {
    satin_option_info info;
    for (int i = 0; satin_options_describe(&satin_options_default, i, &info); i++) print_option(i);
}

// Prints a cell of a Markdown table, in which a vertical bar must be escaped.
static void print_cell(const char *text) {
    printf(" ");
    for (; *text; text++) printf(*text == '|' ? "\\%c" : "%c", *text);
    printf(" |");
}

static void print_options_markdown(void) {
    satin_option_info info;
    printf(
        "# Options\n\n"
        "Options are set by `satin render --set NAME=VALUE`, by `<integrator type=\"satin\">` in\n"
        "a scene, or by `satin_options_set`. Options in the scene override the preset of the\n"
        "quality, and options of the command line override both.\n"
        "\nThis page is printed by `satin help options --markdown`.\n\n"
        "| option | range | draft | preview | production | meaning |\n"
        "|---|---|---|---|---|---|\n");
    for (int i = 0; satin_options_describe(&satin_options_default, i, &info); i++) {
        printf("|");
        print_cell(info.name);
        print_cell(info.range);
        for (int q = SATIN_DRAFT; q <= SATIN_PRODUCTION; q++)
            print_cell(option_at(i, (satin_quality)q).value);
        print_cell(info.doc);
        printf("\n");
    }
}

static bool help_option(const char *topic, struct text_nearest *search) {
    satin_option_info info;
    for (int i = 0; satin_options_describe(&satin_options_default, i, &info); i++) {
        if (text_same_name(info.name, topic)) {
            print_option(i);
            return true;
        }
        text_nearest_try(search, info.name);
    }
    return false;
}

// ---- The command --------------------------------------------------------------------------------

static int help_name(const char *element, const char *topic) {
    struct text_nearest search = {.word = topic};
    for (const struct app_command *c = app_commands; c->name && !element; c++) {
        text_nearest_try(&search, c->name);
        if (strcmp(topic, c->name) != 0) continue;
        print_command(c);
        return APP_DONE;
    }
    // An option, a plugin and an element may have the same name, so all are printed.
    bool option = !element && help_option(topic, &search);
    bool plugin = app_help_plugin(element, topic, &search);
    bool list = !element && app_help_element(topic);
    if (option || plugin || list) return APP_DONE;
    if (search.best) return app_wrong("no help on '%s' (did you mean '%s'?)", topic, search.best);
    return app_wrong("no help on '%s'; `satin help` lists what there is", topic);
}

// `second` is NULL, or the name of a plugin of the element `topic`.
static int help_topic(const char *topic, const char *second, bool markdown) {
    bool options = strcmp(topic, "options") == 0, plugins = strcmp(topic, "plugins") == 0;
    if (markdown && !options && !plugins)
        return app_wrong("--markdown prints all options or plugins: satin help plugins --markdown");
    if (second) return help_name(topic, second);
    if (!options && !plugins) return help_name(NULL, topic);
    if (options && markdown) print_options_markdown();
    if (options && !markdown) print_options();
    if (plugins && markdown) app_help_plugins_markdown();
    if (plugins && !markdown) app_help_plugins();
    return APP_DONE;
}

int app_help(int argc, char **argv) {
    struct app_args args = {.argc = argc, .argv = argv};
    const char *topic = NULL, *second = NULL;
    char *value;
    bool markdown = false;
    int flag;
    while ((flag = app_args_next(&args, app_help_flags, NULL, &value)) != APP_END) {
        if (flag == APP_BAD) return APP_WRONG;
        if (flag == HELP_FLAG_MARKDOWN) markdown = true;
        if (flag == HELP_FLAG_HELP) topic = "help";
        if (flag == APP_POSITIONAL && second)
            return app_wrong("help takes one topic, or an element and its plugin");
        if (flag == APP_POSITIONAL && topic) second = value;
        if (flag == APP_POSITIONAL && !topic) topic = value;
    }
    if (topic || markdown) return help_topic(topic ? topic : "", second, markdown);
    print_overview();
    return APP_DONE;
}
