// SPDX-License-Identifier: Apache-2.0
// Private to the files that plan a study: its scenes and points (study_points.c), and the options
// of a render (study_settings.c).
#ifndef STUDY_PLANNER_H
#define STUDY_PLANNER_H

#include "study/study_plan.h"
#include "study/study_text.h"

struct planner {
    struct log log;
    struct study_plan *plan;
    satin_scene *scene;          // that is loaded
    size_t at;                   // its index
    bool lists;                  // nothing is rendered, so that the denoiser must be there now
    struct study_text warnings;  // of scenes, each once and ended by a line end
};

// Logs lack of memory.
satin_status study_plan_no_memory(struct log log);

// ---- Options of a render (study_settings.c) -----------------------------------------------------

// A setting of every option, and a few more.
enum { STUDY_SETTINGS_MAX = 512 };

struct study_combined {
    struct study_setting setting[STUDY_SETTINGS_MAX];
    size_t count;
};

// Appends a setting that the study itself makes, which replaces one of the same option.
void study_combine_one(struct study_combined *out, const char *name, const char *value);
// Appends settings, which replace those of the same options, but not the options of the list
// `without` and those that begin with one of the list `prefix`. The lists end with NULL; NULL is an
// empty list.
void study_combine(struct study_combined *out, const struct study_settings *set,
                   const char *const *without, const char *const *prefix);
// A log function for a planner: errors are at the line of the study that has the scene.
void study_log_at_scene(void *user, satin_log_severity severity, const char *message);
// The options that a render with these settings has in the loaded scene. Errors are at the line of
// the setting that makes them, or of the scene.
satin_status study_resolve(struct planner *p, const struct study_combined *set, satin_options *out);
uint64_t study_hash_text(uint64_t hash, const char *text);
uint64_t study_hash_options(uint64_t hash, const satin_options *options);

// ---- Scenes and points (study_points.c) ---------------------------------------------------------

// Loads a scene; the one that was loaded is freed.
satin_status study_plan_read_scene(struct planner *p, size_t at);
// Reads all scenes, checks their references, and finds what tables say of points. Points with the
// same options in all scenes become one.
satin_status study_plan_points(struct planner *p);

#endif
