// SPDX-License-Identifier: Apache-2.0
// Private to study/: what a study has found, as tables and as a page.
#ifndef STUDY_REPORT_H
#define STUDY_REPORT_H

#include "study/study_text.h"
#include "study/study_work.h"

// One render of a point: a row of the table.
struct study_row {
    double relmse, mean_ratio;                        // NAN if there is no image
    double first_pass_relmse, first_pass_mean_ratio;  // of the image of the first pass, or NAN
};

// What was found of one point in one scene.
struct study_found {
    struct study_errors image, first_pass;
    struct study_row *row;  // of each seed
};

struct study_report {
    const struct study_plan *plan;
    const struct study_store *store;
    struct log log;
    struct study_found *found;  // [scene][point]
    double *reference_noise;    // of each scene, the mean over its points
    struct study_row *rows;
    size_t uncompared;  // number of scenes of which an image could not be compared
};

// Compares all images with the references, writes study.csv, study.json and study.html.
// SATIN_ERROR_INTERNAL, logged, if there are images that cannot be compared, of which no errors are
// written; SATIN_ERROR_INPUT, SATIN_ERROR_IO and SATIN_ERROR_MEMORY, logged.
satin_status study_report_write(const struct study_store *store, const struct study_plan *plan,
                                struct log log);

// The reference of a scene: the image that the file names, or the mean of its pieces. The caller
// frees it.
satin_status study_report_reference(const struct study_report *report, size_t scene,
                                    struct study_reference *out);
const struct study_found *study_report_at(const struct study_report *report, size_t scene,
                                          size_t point);
// The tables as text (study_tables.c).
void study_report_csv(const struct study_report *report, struct study_text *out);
void study_report_json(const struct study_report *report, struct study_text *out);

// ---- The page (study_page.c) --------------------------------------------------------------------

// The page; `json` is the text of study.json.
satin_status study_page_write(const struct study_report *report, const char *json);

// ---- Pictures (study_pictures.c) ----------------------------------------------------------------

// Appends a JSON object with a picture of every point's first seed in every scene, of its
// difference from the reference, of the reference, and of the image of the first pass.
satin_status study_pictures_add(const struct study_report *report, struct study_text *out);

#endif
