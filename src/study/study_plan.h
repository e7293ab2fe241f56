// SPDX-License-Identifier: Apache-2.0
// Private to study/: the renders that a study consists of, and their results.
#ifndef STUDY_PLAN_H
#define STUDY_PLAN_H

#include "study/study.h"
#include "study/study_file.h"

enum study_what {
    STUDY_REFERENCE,  // a piece of a scene's reference
    STUDY_IMAGE,      // of a point
    STUDY_FIRST_PASS  // the image of a point's first pass
};

// The stages of a render whose seconds are reported: loading the scene, the stages that the
// library's progress function names, and writing the image.
enum study_stage {
    STUDY_LOAD,
    STUDY_PHOTONS,
    STUDY_TABLES,
    STUDY_BOUNCES,
    STUDY_RECORDS,
    STUDY_SAMPLES,
    STUDY_DENOISE,
    STUDY_WRITE,
    STUDY_STAGES
};
extern const char *const study_stage_name[STUDY_STAGES];

// How a render ended, and what it took.
struct study_result {
    bool done;           // whether it has run; false: not yet, or it was interrupted
    int status, signal;  // exit status; the signal that ended the process, or 0
    double wall_s, cpu_s, peak_bytes;
    double threads, photons, records, spp;
    double replaced;      // 1: paths were traced instead, as the time limit was too short
    double lookup_error;  // noise of a lookup of the first pass, over the mean; 0: not known
    double stage_s[STUDY_STAGES];
    char *message;  // of a render that failed; from malloc, or NULL
};

struct study_render {
    enum study_what what;
    size_t scene;
    uint64_t key;  // of scene, options, seed and program: equal for renders with equal results
    const char *const *argument;  // of `satin render` without outputs; ended by NULL
    struct study_result result;
};

struct study_plan {
    struct study study;
    uint64_t program_hash;
    struct study_render *render;
    size_t renders, render_capacity;
    size_t *reference;   // [scene][piece]: index of a render
    size_t *image;       // [scene][point][seed]
    size_t *first_pass;  // [scene][point][seed]; STUDY_NONE if the first pass cannot be shown
};
#define STUDY_NONE ((size_t)-1)

// Reads the study's file, loads its scenes to check all options against them, and lists the
// renders. Points with the same options in all scenes become one. Options with which no render can
// begin are an error, but for a denoiser that is not installed, unless the renders are only to be
// listed. Errors are those of study_file_read. study_plan_free must follow in any case.
satin_status study_plan_make(struct log log, const struct study_request *request,
                             struct study_plan *out);
void study_plan_free(struct study_plan *plan);
// Leaves a scene out, of which nothing can be compared.
void study_plan_leave_scene(struct study_plan *plan, size_t scene);

// ---- study_access.c

// The renders of the point's seed `seed`, counted from 0: its image and that of its first pass,
// which may be NULL.
struct study_render *study_plan_image(const struct study_plan *plan, size_t scene, size_t point,
                                      size_t seed);
struct study_render *study_plan_first_pass(const struct study_plan *plan, size_t scene,
                                           size_t point, size_t seed);
// The samples per pixel of each piece of a reference that is rendered; 0 if none is.
uint64_t study_piece_spp(const struct study *study);
// A command line that repeats a render, for a shell. From malloc; NULL if there is no memory.
char *study_command(const struct study_render *render);
// A point as text: its name, or the labels of what varies. From malloc, as above.
char *study_point_label(const struct study *study, const struct study_point *point);

#endif
