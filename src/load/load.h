// SPDX-License-Identifier: Apache-2.0
// Descriptions of the plugins of scene files (load_plugins.c). Scene files and the files that they
// name are read by satin_scene_load (satin/scene.h). Thread-safe.
#ifndef LOAD_LOAD_H
#define LOAD_LOAD_H

#include <stdbool.h>

struct load_plugin_info {
    const char *element, *name, *doc;  // of the element's `type`
};

struct load_param_info {
    const char *name;
    char kind[64];      // name of the element, or the choices
    const char *value;  // the default, or NULL
    const char *range;  // of numbers and colours; else ""
    bool required;
    const char *doc;
};

// Describe plugin `index`, and parameter `index` of a plugin, counted from 0. False beyond the last
// one.
bool load_plugin_describe(int index, struct load_plugin_info *out);
bool load_param_describe(int plugin, int index, struct load_param_info *out);
// Names plugin `index`, counted from 0, of those that Mitsuba has and satin refuses; it has no doc.
// False beyond the last one.
bool load_unread_describe(int index, struct load_plugin_info *out);

#endif
