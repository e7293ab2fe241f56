// SPDX-License-Identifier: Apache-2.0
// study.csv, a row per image, and study.json, the same with what is common to the seeds of a point.
// Columns of times and memory come last in a row; all others are the same in every run.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "study/study_report.h"

static const struct study_render *find_render(const struct study_report *report, size_t scene,
                                              size_t point, size_t seed) {
    return study_plan_image(report->plan, scene, point, seed);
}

// Numbers that are 0 where they have no meaning.
static double if_positive(double value) { return value > 0.0 ? value : (double)NAN; }

// ---- CSV ----------------------------------------------------------------------------------------

static void csv_names(const char *const *name, struct study_text *out) {
    for (; *name; name++) study_text_add(out, "%s%s", out->size ? "," : "", *name);
}

static void csv_header(const struct study *s, struct study_text *out) {
    csv_names(study_columns_before, out);
    for (size_t c = 0; c < s->columns; c++) {
        study_text_add(out, ",");
        study_text_csv(out, s->column[c].name);
    }
    csv_names(study_columns_after, out);
    for (int i = 0; i < STUDY_STAGES; i++) study_text_add(out, ",%s_s", study_stage_name[i]);
    csv_names(study_columns_last, out);
    study_text_add(out, "\n");
}

static void csv_numbers(struct study_text *out, const double *value, size_t count) {
    for (size_t i = 0; i < count; i++) {
        study_text_add(out, ",");
        study_text_csv_number(out, value[i]);
    }
}

static void csv_row(const struct study_report *report, size_t scene, size_t point, size_t seed,
                    const char *label, struct study_text *out) {
    const struct study *s = &report->plan->study;
    const struct study_found *found = study_report_at(report, scene, point);
    const struct study_row *row = &found->row[seed];
    const struct study_render *render = find_render(report, scene, point, seed);
    const struct study_result *result = &render->result;
    const double errors[] = {row->relmse,
                             row->mean_ratio,
                             found->image.bias2,
                             found->image.bias2_error,
                             found->image.variance,
                             row->first_pass_relmse,
                             row->first_pass_mean_ratio,
                             found->first_pass.bias2,
                             found->first_pass.variance,
                             found->image.reference_noise,
                             if_positive(result->lookup_error)};
    const double counts[] = {if_positive(result->spp), if_positive(result->photons),
                             if_positive(result->records), if_positive(result->threads),
                             result->done ? result->replaced : NAN};
    const double times[] = {if_positive(result->wall_s), if_positive(result->cpu_s)};
    char *command = study_command(render);
    study_text_csv(out, s->scene[scene].name);
    study_text_add(out, ",");
    study_text_csv(out, label);
    for (size_t c = 0; c < s->columns; c++) {
        const char *cell = s->point[point].cell[c];
        study_text_add(out, ",");
        study_text_csv(out, cell ? cell : "");
    }
    study_text_add(out, ",%llu", (unsigned long long)s->seed[seed]);
    csv_numbers(out, errors, sizeof errors / sizeof *errors);
    if (result->done)
        study_text_add(out, ",%d,%d", result->status, result->signal);
    else
        study_text_add(out, ",,");
    csv_numbers(out, counts, sizeof counts / sizeof *counts);
    study_text_add(out, ",");
    if (!command) out->failed = true;
    study_text_csv(out, command ? command : "");
    csv_numbers(out, times, 2);
    csv_numbers(out, result->stage_s, STUDY_STAGES);
    study_text_add(out, ",%.1f\n", result->peak_bytes / 1048576.0);
    free(command);
}

void study_report_csv(const struct study_report *report, struct study_text *out) {
    const struct study *s = &report->plan->study;
    csv_header(s, out);
    for (size_t i = 0; i < s->scenes; i++)
        for (size_t p = 0; p < s->points; p++) {
            char *label = study_point_label(s, &s->point[p]);
            if (!label) out->failed = true;
            for (size_t k = 0; k < s->seeds; k++) csv_row(report, i, p, k, label ? label : "", out);
            free(label);
        }
}

// ---- JSON ---------------------------------------------------------------------------------------

static void json_member(struct study_text *out, const char *name, double value) {
    study_text_add(out, "\"%s\": ", name);
    study_text_json_number(out, value);
    study_text_add(out, ", ");
}

static void json_errors(struct study_text *out, const char *name, const struct study_errors *e) {
    study_text_add(out, "\"%s\": {", name);
    json_member(out, "relmse", e->relmse);
    json_member(out, "relmse_error", e->relmse_error);
    json_member(out, "bias2", e->bias2);
    json_member(out, "bias2_error", e->bias2_error);
    json_member(out, "variance", e->variance);
    json_member(out, "mean_ratio", e->mean_ratio);
    json_member(out, "mean_ratio_error", e->mean_ratio_error);
    study_text_add(out, "\"images\": %zu}", e->images);
}

static void json_run(const struct study_report *report, size_t scene, size_t point, size_t seed,
                     struct study_text *out) {
    const struct study_row *row = &study_report_at(report, scene, point)->row[seed];
    const struct study_render *render = find_render(report, scene, point, seed);
    const struct study_result *result = &render->result;
    char *command = study_command(render);
    study_text_add(out, "{\"seed\": %llu, ", (unsigned long long)report->plan->study.seed[seed]);
    study_text_add(out, "\"done\": %s, \"status\": %d, \"signal\": %d, ",
                   result->done ? "true" : "false", result->status, result->signal);
    json_member(out, "relmse", row->relmse);
    json_member(out, "mean_ratio", row->mean_ratio);
    json_member(out, "first_pass_relmse", row->first_pass_relmse);
    json_member(out, "lookup_error", if_positive(result->lookup_error));
    json_member(out, "seconds", if_positive(result->wall_s));
    json_member(out, "cpu_seconds", if_positive(result->cpu_s));
    json_member(out, "memory_bytes", if_positive(result->peak_bytes));
    json_member(out, "samples", if_positive(result->spp));
    json_member(out, "photon_paths", if_positive(result->photons));
    json_member(out, "records", if_positive(result->records));
    json_member(out, "threads_used", if_positive(result->threads));
    json_member(out, "replaced", result->done ? result->replaced : NAN);
    study_text_add(out, "\"stages\": [");
    for (int i = 0; i < STUDY_STAGES; i++) {
        study_text_add(out, i ? ", " : "");
        study_text_json_number(out, result->stage_s[i]);
    }
    study_text_add(out, "], \"message\": ");
    study_text_json(out, result->message ? result->message : "");
    study_text_add(out, ", \"command\": ");
    if (!command) out->failed = true;
    study_text_json(out, command ? command : "");
    study_text_add(out, "}");
    free(command);
}

static void json_point(const struct study_report *report, size_t scene, size_t point,
                       struct study_text *out) {
    const struct study *s = &report->plan->study;
    const struct study_found *found = study_report_at(report, scene, point);
    study_text_add(out, "    {\"scene\": %zu, \"point\": %zu, ", scene, point);
    json_errors(out, "image", &found->image);
    study_text_add(out, ", ");
    json_errors(out, "first_pass", &found->first_pass);
    study_text_add(out, ",\n     \"runs\": [");
    for (size_t k = 0; k < s->seeds; k++) {
        study_text_add(out, k ? ",\n       " : "");
        json_run(report, scene, point, k, out);
    }
    study_text_add(out, "]}");
}

static void json_lists(const struct study_report *report, struct study_text *out) {
    const struct study *s = &report->plan->study;
    study_text_add(out, "  \"stages\": [");
    for (int i = 0; i < STUDY_STAGES; i++)
        study_text_add(out, "%s\"%s\"", i ? ", " : "", study_stage_name[i]);
    study_text_add(out, "],\n  \"axes\": [");
    for (size_t c = 0; c < s->columns; c++) {
        study_text_add(out, c ? ", " : "");
        study_text_json(out, s->column[c].name);
    }
    study_text_add(out, "],\n  \"scenes\": [");
    for (size_t i = 0; i < s->scenes; i++) {
        study_text_add(out, "%s\n    {\"name\": ", i ? "," : "");
        study_text_json(out, s->scene[i].name);
        study_text_add(out, ", \"file\": ");
        study_text_json(out, s->scene[i].path);
        study_text_add(out, ", \"reference\": ");
        study_text_json(out, s->scene[i].reference ? s->scene[i].reference : "");
        study_text_add(out, ", \"reference_noise\": ");
        study_text_json_number(out, report->reference_noise[i]);
        study_text_add(out, "}");
    }
    study_text_add(out, "],\n  \"points\": [");
    for (size_t p = 0; p < s->points; p++) {
        char *label = study_point_label(s, &s->point[p]);
        if (!label) out->failed = true;
        study_text_add(out, "%s\n    {\"label\": ", p ? "," : "");
        study_text_json(out, label ? label : "");
        study_text_add(out, ", \"values\": [");
        for (size_t c = 0; c < s->columns; c++) {
            study_text_add(out, c ? ", " : "");
            if (s->point[p].cell[c])
                study_text_json(out, s->point[p].cell[c]);
            else
                study_text_add(out, "null");
        }
        study_text_add(out, "]}");
        free(label);
    }
    study_text_add(out, "],\n");
}

// The integrator of references that are rendered.
static const char *reference_integrator(const struct study *s) {
    const char *found = "path";
    for (size_t i = 0; i < s->reference.count; i++)
        if (strcmp(s->reference.setting[i].name, "integrator") == 0)
            found = s->reference.setting[i].value;
    return found;
}

void study_report_json(const struct study_report *report, struct study_text *out) {
    const struct study *s = &report->plan->study;
    study_text_add(out, "{\n  \"satin\": \"%s\",\n  \"title\": ", SATIN_VERSION);
    study_text_json(out, s->title ? s->title : "");
    study_text_add(out, ",\n  \"question\": ");
    study_text_json(out, s->question ? s->question : "");
    study_text_add(out, ",\n  \"mask_emission\": %s, \"reference_spp\": %llu, \"seeds\": %zu,\n",
                   s->mask_emission ? "true" : "false",
                   (unsigned long long)(study_piece_spp(s) * s->reference_pieces), s->seeds);
    study_text_add(out, "  \"reference_integrator\": ");
    study_text_json(out, reference_integrator(s));
    study_text_add(out, ",\n");
    json_lists(report, out);
    study_text_add(out, "  \"results\": [\n");
    for (size_t i = 0; i < s->scenes; i++)
        for (size_t p = 0; p < s->points; p++) {
            json_point(report, i, p, out);
            study_text_add(out, i + 1 == s->scenes && p + 1 == s->points ? "\n" : ",\n");
        }
    study_text_add(out, "  ]\n}\n");
}
