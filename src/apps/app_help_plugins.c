// SPDX-License-Identifier: Apache-2.0
// satin help plugins: what scene files may hold, printed from the tables that read them.
#include <string.h>

#include "apps/app.h"
#include "base/text.h"
#include "scene/scene.h"

enum { INDENT = 26 };

void app_help_plugins(void) {
    struct scene_plugin_info plugin;
    const char *element = "";
    for (int i = 0; scene_plugin_describe(i, &plugin); i++) {
        if (strcmp(element, plugin.element) != 0)
            printf("%s<%s type=\"...\">\n", i ? "\n" : "", plugin.element);
        element = plugin.element;
        app_print_wrapped(printf("  %s", plugin.name), INDENT, plugin.doc);
    }
}

static void print_param(const struct scene_param_info *param) {
    app_print_wrapped(printf("  %s", param->name), INDENT, param->doc);
    printf("%*s%s", INDENT, "", param->kind);
    if (param->range[0]) printf(", %s", param->range);
    if (param->required)
        printf("; required");
    else if (param->value)
        printf("; default %s", param->value);
    printf("\n");
}

bool app_help_plugin(const char *name, struct text_nearest *search) {
    struct scene_plugin_info plugin;
    struct scene_param_info param;
    bool found = false;
    for (int i = 0; scene_plugin_describe(i, &plugin); i++) {
        text_nearest_try(search, plugin.name);
        if (!text_same_name(plugin.name, name)) continue;
        int at = printf("<%s type=\"%s\">", plugin.element, plugin.name);
        app_print_wrapped(at, INDENT, plugin.doc);
        for (int p = 0; scene_param_describe(i, p, &param); p++) print_param(&param);
        found = true;
    }
    return found;
}
