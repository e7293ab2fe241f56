// SPDX-License-Identifier: Apache-2.0
// Compares all images of a study with the references, and writes the tables and the page.
#include "study/study_report.h"

#include <math.h>
#include <stdlib.h>

#include "base/array.h"
#include "base/fileio.h"

const struct study_found *study_report_at(const struct study_report *report, size_t scene,
                                          size_t point) {
    return &report->found[scene * report->plan->study.points + point];
}

// ---- References ---------------------------------------------------------------------------------

// The pieces of a scene's reference as one image, which is also left in DIR/references.
static satin_status average_pieces(const struct study_report *report, size_t scene,
                                   struct study_reference *out) {
    const struct study *s = &report->plan->study;
    const size_t count = s->reference_pieces;
    satin_film **piece = array_new(count, sizeof *piece);
    struct study_reference made = {0};
    char *path = study_store_path(report->store, "references/%s.exr", s->scene[scene].name);
    satin_status status = piece && path ? SATIN_OK : SATIN_ERROR_MEMORY;
    for (size_t k = 0; k < count && status == SATIN_OK; k++) {
        const size_t at = report->plan->reference[scene * count + k];
        status =
            study_store_image(report->store, report->log, &report->plan->render[at], &piece[k]);
    }
    if (status == SATIN_OK) {
        const bool memory = study_reference_average(piece, count, &made);
        status = memory ? film_write_exr(made.mean, path, NULL, report->log) : SATIN_ERROR_MEMORY;
    }
    for (size_t k = 0; piece && k < count; k++) satin_film_free(piece[k]);
    free(piece);
    free(path);
    if (status == SATIN_OK)
        *out = made;
    else
        study_reference_free(&made);
    return status;
}

satin_status study_report_reference(const struct study_report *report, size_t scene,
                                    struct study_reference *out) {
    const char *path = report->plan->study.scene[scene].reference;
    *out = (struct study_reference){0};
    if (!path) return average_pieces(report, scene, out);
    return satin_film_read(path, report->log.fn, report->log.user, &out->mean);
}

// ---- Errors -------------------------------------------------------------------------------------

static bool has_image(const struct study_render *render) {
    return render && render->result.done && render->result.status == 0 &&
           render->result.signal == 0;
}

// Errors of a point's images, or of those of its first pass: over all seeds, and of each.
static satin_status compare_point(const struct study_report *report,
                                  const struct study_reference *reference, size_t scene,
                                  size_t point, bool first_pass, struct study_errors *out,
                                  struct study_row *row) {
    const struct study *s = &report->plan->study;
    satin_film **image = array_new(s->seeds, sizeof *image);
    satin_status status = image ? SATIN_OK : SATIN_ERROR_MEMORY;
    size_t count = 0;
    for (size_t k = 0; k < s->seeds && status == SATIN_OK; k++) {
        const struct study_render *render =
            first_pass ? study_plan_first_pass(report->plan, scene, point, k)
                       : study_plan_image(report->plan, scene, point, k);
        double *relmse = first_pass ? &row[k].first_pass_relmse : &row[k].relmse;
        double *mean_ratio = first_pass ? &row[k].first_pass_mean_ratio : &row[k].mean_ratio;
        struct film_difference difference;
        *relmse = *mean_ratio = (double)NAN;
        if (!has_image(render)) continue;
        status = study_store_image(report->store, report->log, render, &image[count]);
        if (status != SATIN_OK) break;
        status = film_compare(image[count++], reference->mean, s->mask_emission, report->log,
                              &difference);
        *relmse = difference.relmse;
        *mean_ratio = difference.mean_ratio;
    }
    if (status == SATIN_OK && !study_errors_find(image, count, reference, s->mask_emission, out))
        status = SATIN_ERROR_MEMORY;
    for (size_t k = 0; k < count; k++) satin_film_free(image[k]);
    free(image);
    return status;
}

static satin_status compare_scene(struct study_report *report, size_t scene) {
    const struct study *s = &report->plan->study;
    struct study_reference reference;
    satin_status status = study_report_reference(report, scene, &reference);
    if (status == SATIN_OK) report->reference_noise[scene] = study_reference_noise(reference.mean);
    for (size_t p = 0; p < s->points && status == SATIN_OK; p++) {
        struct study_found *found = &report->found[scene * s->points + p];
        status = compare_point(report, &reference, scene, p, false, &found->image, found->row);
        if (status == SATIN_OK)
            status =
                compare_point(report, &reference, scene, p, true, &found->first_pass, found->row);
    }
    study_reference_free(&reference);
    return status;
}

// ---- Files --------------------------------------------------------------------------------------

static satin_status write_text(const struct study_report *report, const char *name,
                               const struct study_text *text) {
    char *path = study_store_path(report->store, "%s", name);
    satin_status status = SATIN_ERROR_MEMORY;
    if (path && !text->failed) status = fileio_write(report->log, path, text->data, text->size);
    free(path);
    return status;
}

static satin_status write_files(const struct study_report *report) {
    struct study_text csv = {0}, json = {0};
    study_report_csv(report, &csv);
    study_report_json(report, &json);
    satin_status status = write_text(report, "study.csv", &csv);
    if (status == SATIN_OK) status = write_text(report, "study.json", &json);
    if (status == SATIN_OK) status = study_page_write(report, json.data);
    free(csv.data);
    free(json.data);
    return status;
}

satin_status study_report_write(const struct study_store *store, const struct study_plan *plan,
                                struct log log) {
    const struct study *s = &plan->study;
    const size_t points = s->scenes * s->points;
    struct study_report report = {plan,
                                  store,
                                  log,
                                  array_new(points, sizeof(struct study_found)),
                                  array_new(s->scenes, sizeof(double)),
                                  array_new(points * s->seeds, sizeof(struct study_row))};
    satin_status status =
        report.found && report.reference_noise && report.rows ? SATIN_OK : SATIN_ERROR_MEMORY;
    for (size_t i = 0; i < points && status == SATIN_OK; i++)
        report.found[i].row = &report.rows[i * s->seeds];
    for (size_t i = 0; i < s->scenes && status == SATIN_OK; i++) status = compare_scene(&report, i);
    if (status == SATIN_OK) status = write_files(&report);
    if (status == SATIN_ERROR_MEMORY) log_message(log, SATIN_LOG_ERROR, "not enough memory");
    free(report.found);
    free(report.reference_noise);
    free(report.rows);
    return status;
}
