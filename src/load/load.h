// SPDX-License-Identifier: Apache-2.0
// Reading scene files and all that they name. satin_scene_load (satin/scene.h) is the entry; here
// is how the plugins of scene files are described (load_plugins.c). Thread-safe.
#ifndef LOAD_LOAD_H
#define LOAD_LOAD_H

#include <stdbool.h>

struct load_plugin_info {
    const char *element, *name, *doc;  // of the element's `type`
};

struct load_param_info {
    const char *name;
    char kind[64];      // the element that gives it, or the values to choose from
    const char *value;  // the default, or NULL
    const char *range;  // of numbers and colours, or ""
    bool required;
    const char *doc;
};

// Describe plugin `index`, and its parameter `index`, counting from 0; false beyond the last.
bool load_plugin_describe(int index, struct load_plugin_info *out);
bool load_param_describe(int plugin, int index, struct load_param_info *out);
// Name `index`, counting from 0, of what Mitsuba knows and satin refuses, without a doc; false
// beyond the last.
bool load_unread_describe(int index, struct load_plugin_info *out);

#endif
