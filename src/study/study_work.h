// SPDX-License-Identifier: Apache-2.0
// Private to study/: renders as processes, their results in files, and errors of images.
#ifndef STUDY_WORK_H
#define STUDY_WORK_H

#include "film/film.h"
#include "study/study_plan.h"

// ---- A process (study_child.c) ------------------------------------------------------------------

struct study_child {
    const char *program;
    const char *const *argument;  // after the program's name, ended by NULL
    const char *errors;           // the file that standard error goes to
    bool (*interrupted)(void);    // if it returns true, the process gets SIGTERM; may be NULL
};

// Runs a process to its end: its standard input and output are empty. It is killed if this process
// dies. Sets status, signal, wall_s, cpu_s and peak_bytes. False, with errno set, if it could not
// be started.
bool study_child_run(const struct study_child *child, struct study_result *out);

// ---- Results in files (study_store.c) -----------------------------------------------------------

// DIR/runs/KEY.exr and KEY.json, of which the second is written last; DIR/references/SCENE.exr; and
// DIR/work, with the files of the render that runs.
struct study_store {
    const char *folder;
    int lock;  // a file that is locked, so that one process at a time uses the folder
};

// Makes the folder, locks it and empties DIR/work. SATIN_ERROR_INPUT, logged, if it cannot be used,
// if it has files that are not of a study, or if another process has locked it.
satin_status study_store_open(struct log log, const char *folder, struct study_store *out);
// SATIN_ERROR_INPUT, logged, if a result of the study would replace a file that it reads, or what
// is not a regular file.
satin_status study_store_check(const struct study_store *store, struct log log,
                               const struct study_plan *plan);
void study_store_close(struct study_store *store);
// A path in the folder by a format, from malloc; NULL if there is no memory.
char *study_store_path(const struct study_store *store, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
// Reads the result of a render if there is a complete one.
void study_store_find(const struct study_store *store, struct study_render *render);
// Stores the image and the result of a render that has just succeeded; of the channels only R, G, B
// and those of emission. What the statistics in work/stats.json say is added to the result.
satin_status study_store_add(const struct study_store *store, struct log log,
                             struct study_render *render);
// Reads the image of a render. SATIN_ERROR_INPUT, logged, if it is not there.
satin_status study_store_image(const struct study_store *store, struct log log,
                               const struct study_render *render, satin_film **film);
// Notes the study and its scenes in DIR/runs/study.json; *changed is set to what has changed since
// another run left such a note, in words, or to NULL. From malloc.
satin_status study_store_note(const struct study_store *store, struct log log,
                              const struct study_plan *plan, char **changed);

// ---- Errors (study_errors.c) --------------------------------------------------------------------

// The error of a point in one scene, over its seeds. All are relative as relMSE is: squares are
// divided by the square of the reference + 0.01.
struct study_errors {
    size_t images;        // that there are
    double relmse;        // mean over the seeds
    double relmse_error;  // its standard error; NAN of one seed
    double bias2;         // the square of what all seeds have in common; NAN of one seed
    double bias2_error;   // its standard error; NAN of fewer than 3 seeds
    double variance;      // the rest: mean over pixels of the variance between seeds
    double mean_ratio;    // mean of the image over that of the reference
    double mean_ratio_error;
    // The relative variance of the reference itself in the pixels that are compared, in relMSE; NAN
    // if it is not known. Without images, in those that the reference has to compare.
    double reference_noise;
};

// A scene's reference.
struct study_reference {
    satin_film *mean;      // with channels variance.R, .G and .B if its variance is known
    satin_film **without;  // the same without one of the pieces, for each piece
    size_t pieces;         // 0 if there are none or fewer than 3
};
void study_reference_free(struct study_reference *reference);
// Sets the mean of pieces, with the emission of the first of them, and the means without each.
// False, with nothing set, if there is no memory or the sizes differ.
bool study_reference_average(satin_film *const *piece, size_t count, struct study_reference *out);

// Compares `count` images of independent seeds with the reference, of which the noise is subtracted
// if it is known. All have one size and channels R, G and B. False if there is no memory.
bool study_errors_find(satin_film *const *image, size_t count,
                       const struct study_reference *reference, bool mask_emission,
                       struct study_errors *out);
// The number of pixels of a reference, which has channels R, G and B, that are not finite.
size_t study_reference_nonfinite(const satin_film *reference);
#endif
