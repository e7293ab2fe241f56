// SPDX-License-Identifier: Apache-2.0
// satin help plugins: the plugins of scene files, printed from the tables by which they are read.
// docs/scene.md has the same as Markdown.
#include <string.h>

#include "apps/app.h"
#include "base/text.h"
#include "load/load.h"

enum { INDENT = 26 };

void app_help_plugins(void) {
    struct load_plugin_info plugin;
    const char *element = "";
    for (int i = 0; load_plugin_describe(i, &plugin); i++) {
        if (strcmp(element, plugin.element) != 0)
            printf("%s<%s type=\"...\">\n", i ? "\n" : "", plugin.element);
        element = plugin.element;
        app_print_wrapped(printf("  %s", plugin.name), INDENT, plugin.doc);
    }
}

// Whether a topic is the name of an element, in the singular or plural: `shape`, `shapes`.
static bool names_element(const char *topic, const char *element) {
    size_t n = strlen(element);
    return strncmp(topic, element, n) == 0 && (!topic[n] || strcmp(topic + n, "s") == 0);
}

bool app_help_element(const char *topic) {
    struct load_plugin_info plugin;
    bool found = false;
    for (int i = 0; load_plugin_describe(i, &plugin); i++) {
        if (!names_element(topic, plugin.element)) continue;
        if (!found) printf("<%s type=\"...\">\n", plugin.element);
        app_print_wrapped(printf("  %s", plugin.name), INDENT, plugin.doc);
        found = true;
    }
    return found;
}

static void print_param(const struct load_param_info *param) {
    app_print_wrapped(printf("  %s", param->name), INDENT, param->doc);
    printf("%*s%s", INDENT, "", param->kind);
    if (param->range[0]) printf(", %s", param->range);
    if (param->required)
        printf("; required");
    else if (param->value)
        printf("; default %s", param->value);
    printf("\n");
}

bool app_help_plugin(const char *element, const char *name, struct text_nearest *search) {
    struct load_plugin_info plugin;
    struct load_param_info param;
    bool found = false;
    for (int i = 0; load_plugin_describe(i, &plugin); i++) {
        text_nearest_try(search, plugin.name);
        if (!text_same_name(plugin.name, name)) continue;
        if (element && strcmp(plugin.element, element) != 0) continue;
        int at = printf("<%s type=\"%s\">", plugin.element, plugin.name);
        app_print_wrapped(at, INDENT, plugin.doc);
        for (int p = 0; load_param_describe(i, p, &param); p++) print_param(&param);
        found = true;
    }
    return found;
}

// ---- Markdown -----------------------------------------------------------------------------------

static void print_plugin_markdown(int index, const struct load_plugin_info *plugin) {
    struct load_param_info param;
    printf("\n### %s\n\n`<%s type=\"%s\">`: %s.\n", plugin->name, plugin->element, plugin->name,
           plugin->doc);
    for (int p = 0; load_param_describe(index, p, &param); p++) {
        if (p == 0)
            printf(
                "\n| parameter | element | range | default | meaning |\n|---|---|---|---|---|\n");
        printf("| %s | %s | %s | %s | %s |\n", param.name, param.kind, param.range,
               param.required ? "required"
               : param.value  ? param.value
                              : "",
               param.doc);
    }
}

void app_help_plugins_markdown(void) {
    struct load_plugin_info plugin;
    const char *element = "";
    printf(
        "# Plugins of scene files\n\n"
        "These are the plugins that a scene file may hold, by element;\n"
        "[language.md](language.md) describes the rest of the language. Plugins of Mitsuba 3 have\n"
        "the names and parameters that they have there. Any other plugin is an error\n"
        "with its line, unless the image can be made without it, which is a warning; so are\n"
        "parameters that are no slip of a known one.\n"
        "\nThis page is printed by `satin help plugins --markdown`. `satin help NAME` prints one\n"
        "plugin.\n");
    for (int i = 0; load_plugin_describe(i, &plugin); i++) {
        if (strcmp(element, plugin.element) != 0) printf("\n## %s\n", plugin.element);
        element = plugin.element;
        print_plugin_markdown(i, &plugin);
    }
    printf(
        "\n## Refused\n\n"
        "Mitsuba has these plugins, but satin does not support them: they are errors that say so.\n"
        "The same holds for media, volumes and phase functions, and for everything that needs\n"
        "wavelengths or polarisation.\n\n");
    element = "";
    for (int i = 0; load_unread_describe(i, &plugin); i++) {
        if (strcmp(element, plugin.element) != 0) printf("%s- %s:", i ? "\n" : "", plugin.element);
        printf(" %s", plugin.name);
        element = plugin.element;
    }
    printf("\n");
}
