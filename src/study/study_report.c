// SPDX-License-Identifier: Apache-2.0
// Compares all images of a study with the references, and writes the tables and the page.
#include "study/study_report.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/array.h"
#include "base/fileio.h"

enum { REASON_BYTES = 256 };

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

// A scene whose images are compared.
struct compared_scene {
    struct study_report *report;
    size_t scene;
    struct study_reference reference;
    bool failed;  // whether an image could not be compared, which is reported once
};

static bool has_image(const struct study_render *render) {
    return render && render->result.done && render->result.status == 0 &&
           render->result.signal == 0;
}

static void keep_reason(void *user, satin_log_severity severity, const char *message) {
    (void)severity;
    snprintf(user, REASON_BYTES, "%s", message);
}

// Reports that an image cannot be compared; `reason` is what the comparison has logged.
static void report_uncompared(struct compared_scene *c, size_t point, const satin_film *image,
                              const char *reason) {
    const struct study *s = &c->report->plan->study;
    const struct study_scene *scene = &s->scene[c->scene];
    const satin_film *reference = c->reference.mean;
    const size_t pixels = (size_t)reference->width * (size_t)reference->height;
    struct film_difference difference;
    char *label = study_point_label(s, &s->point[point]);
    if (c->failed) {
        free(label);
        return;
    }
    c->failed = true;
    if (study_reference_nonfinite(reference) == pixels)
        log_error_at(c->report->log, scene->at, "%s: no pixel of its reference is finite",
                     scene->name);
    else if (s->mask_emission &&
             film_compare(image, reference, false, (struct log){0}, &difference) == SATIN_OK)
        log_error_at(c->report->log, scene->at,
                     "%s: %s: %s, because those that see an emitter are left out; "
                     "mask-emission=false compares them",
                     scene->name, label ? label : "", reason);
    else
        log_error_at(c->report->log, scene->at, "%s: %s: %s", scene->name, label ? label : "",
                     reason);
    free(label);
}

// Finds the errors of one image. They stay NAN if it cannot be compared.
static void find_image_errors(struct compared_scene *c, size_t point, const satin_film *image,
                              double *relmse, double *mean_ratio) {
    struct film_difference difference;
    char reason[REASON_BYTES] = "";
    if (film_compare(image, c->reference.mean, c->report->plan->study.mask_emission,
                     (struct log){keep_reason, reason}, &difference) == SATIN_OK) {
        *relmse = difference.relmse;
        *mean_ratio = difference.mean_ratio;
    } else {
        report_uncompared(c, point, image, reason);
    }
}

// Errors of a point's images, or of those of its first pass: over all seeds, and of each.
static satin_status compare_point(struct compared_scene *c, size_t point, bool first_pass,
                                  struct study_errors *out, struct study_row *row) {
    const struct study_report *report = c->report;
    const struct study *s = &report->plan->study;
    satin_film **image = array_new(s->seeds, sizeof *image);
    satin_status status = image ? SATIN_OK : SATIN_ERROR_MEMORY;
    size_t count = 0;
    for (size_t k = 0; k < s->seeds && status == SATIN_OK; k++) {
        const struct study_render *render =
            first_pass ? study_plan_first_pass(report->plan, c->scene, point, k)
                       : study_plan_image(report->plan, c->scene, point, k);
        double *relmse = first_pass ? &row[k].first_pass_relmse : &row[k].relmse;
        double *mean_ratio = first_pass ? &row[k].first_pass_mean_ratio : &row[k].mean_ratio;
        *relmse = *mean_ratio = (double)NAN;
        if (!has_image(render)) continue;
        status = study_store_image(report->store, report->log, render, &image[count]);
        if (status == SATIN_OK) find_image_errors(c, point, image[count++], relmse, mean_ratio);
    }
    if (status == SATIN_OK &&
        !study_errors_find(image, count, &c->reference, s->mask_emission, out))
        status = SATIN_ERROR_MEMORY;
    for (size_t k = 0; k < count; k++) satin_film_free(image[k]);
    free(image);
    return status;
}

// The mean of the points' noise of the reference; NAN if it is not known. Points differ in it by
// the pixels that their images leave out.
static double mean_reference_noise(const struct study_report *report, size_t scene) {
    double sum = 0.0, count = 0.0;
    for (size_t p = 0; p < report->plan->study.points; p++) {
        const double noise = study_report_at(report, scene, p)->image.reference_noise;
        if (!isfinite(noise)) continue;
        sum += noise;
        count += 1.0;
    }
    return count > 0.0 ? sum / count : (double)NAN;
}

static satin_status compare_scene(struct study_report *report, size_t scene) {
    const struct study *s = &report->plan->study;
    struct compared_scene c = {.report = report, .scene = scene};
    satin_status status = study_report_reference(report, scene, &c.reference);
    const size_t nonfinite = status == SATIN_OK ? study_reference_nonfinite(c.reference.mean) : 0;
    // A reference from a file has been checked when the study was planned.
    if (nonfinite && !s->scene[scene].reference)
        log_warning_at(report->log, s->scene[scene].at,
                       "%s: %zu of the pixels of its reference are not finite, and left out",
                       s->scene[scene].name, nonfinite);
    for (size_t p = 0; p < s->points && status == SATIN_OK; p++) {
        struct study_found *found = &report->found[scene * s->points + p];
        status = compare_point(&c, p, false, &found->image, found->row);
        if (status == SATIN_OK) status = compare_point(&c, p, true, &found->first_pass, found->row);
    }
    report->reference_noise[scene] = mean_reference_noise(report, scene);
    report->uncompared += c.failed;
    study_reference_free(&c.reference);
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
                                  array_new(points * s->seeds, sizeof(struct study_row)),
                                  0};
    satin_status status =
        report.found && report.reference_noise && report.rows ? SATIN_OK : SATIN_ERROR_MEMORY;
    for (size_t i = 0; i < points && status == SATIN_OK; i++)
        report.found[i].row = &report.rows[i * s->seeds];
    for (size_t i = 0; i < s->scenes && status == SATIN_OK; i++) status = compare_scene(&report, i);
    if (status == SATIN_OK) status = write_files(&report);
    if (status == SATIN_ERROR_MEMORY) log_message(log, SATIN_LOG_ERROR, "not enough memory");
    if (status == SATIN_OK && report.uncompared)
        status = log_fail(log, SATIN_ERROR_INTERNAL,
                          "%s: images of %zu of %zu scenes cannot be compared", s->root->at.file,
                          report.uncompared, s->scenes);
    free(report.found);
    free(report.reference_noise);
    free(report.rows);
    return status;
}
