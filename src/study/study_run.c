// SPDX-License-Identifier: Apache-2.0
// Runs a study: references first, then every point by the first seed, by the second seed, and so
// on, one render at a time; then compares all images and writes what was found.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/fileio.h"
#include "base/stats.h"
#include "study/study_report.h"

// The state of a study that runs.
struct running {
    const struct study_request *request;
    struct log log;
    struct study_plan *plan;
    struct study_store *store;
    size_t total, ready, failed;  // renders in all, with results, failed
    double begin, spent;          // when it began; seconds of renders in this process
    size_t rendered;              // by this process
};

static void report_line(const struct running *r, const char *line) {
    if (r->request->report) r->request->report(r->request->user, line);
}

static bool is_interrupted(const struct running *r) {
    return r->request->interrupted && r->request->interrupted();
}

// ---- One render ---------------------------------------------------------------------------------

// The first line that a render has printed, from malloc; NULL if it has printed nothing.
static char *first_line(const char *path) {
    char *text = NULL;
    size_t size = 0;
    if (fileio_read((struct log){0}, (struct log_place){0}, path, 1 << 20, &text, &size) !=
        SATIN_OK)
        return NULL;
    text[strcspn(text, "\r\n")] = 0;
    if (*text) return text;
    free(text);
    return NULL;
}

// Runs the command with outputs in DIR/work.
static satin_status run_command(struct running *r, struct study_render *render) {
    const char *word[600];
    size_t n = 0;
    char *image = study_store_path(r->store, "work/image.exr");
    char *stats = study_store_path(r->store, "work/stats.json");
    char *errors = study_store_path(r->store, "work/errors.txt");
    satin_status status = SATIN_ERROR_MEMORY;
    word[n++] = "render";
    for (const char *const *a = render->argument; *a && n < 590; a++) word[n++] = *a;
    const char *const outputs[] = {"-o", image, "--float", "--stats", stats, "--quiet", NULL};
    memcpy(&word[n], outputs, sizeof outputs);
    if (image && stats && errors) {
        const struct study_child child = {r->request->program, word, errors,
                                          r->request->interrupted};
        if (study_child_run(&child, &render->result)) {
            status = SATIN_OK;
            const bool failed = render->result.status != 0 || render->result.signal != 0;
            if (failed) render->result.message = first_line(errors);
        } else {
            status = log_fail(r->log, SATIN_ERROR_INTERNAL, "%s: it cannot be started",
                              r->request->program);
        }
    }
    free(image);
    free(stats);
    free(errors);
    return status;
}

// How a render failed. One that was killed, or whose disk is full, may have printed nothing.
static void describe_failure(const struct study_result *result, char *out, size_t size) {
    const char *name = result->signal ? strsignal(result->signal) : NULL;
    int n;
    if (result->signal)
        n = snprintf(out, size, "failed with signal %d (%s)", result->signal, name ? name : "?");
    else
        n = snprintf(out, size, "failed with status %d", result->status);
    if (n < 0 || (size_t)n >= size) return;
    if (result->message)
        snprintf(out + n, size - (size_t)n, ": %s", result->message);
    else if (!result->signal)
        snprintf(out + n, size - (size_t)n, " and printed no message");
}

static void report_end(struct running *r, const struct study_render *render, const char *label) {
    const struct study_result *result = &render->result;
    char line[1024], end[512], left[48] = "";
    const double mean = r->spent / (double)r->rendered;
    const size_t missing = r->total - r->ready - r->failed;
    if (missing) snprintf(left, sizeof left, ", about %.0f s left", mean * (double)missing);
    if (result->status == 0 && result->signal == 0)
        snprintf(end, sizeof end, "%.2f s%s", result->wall_s, left);
    else
        describe_failure(result, end, sizeof end);
    snprintf(line, sizeof line, "[%zu/%zu] %.400s: %s", r->ready + r->failed, r->total, label, end);
    report_line(r, line);
}

// Renders what has no result yet. SATIN_CANCELLED if it was interrupted; a render that fails is no
// error of the study.
static satin_status run_render(struct running *r, struct study_render *render, const char *label) {
    if (render->result.done) return SATIN_OK;
    if (is_interrupted(r)) return SATIN_CANCELLED;
    satin_status status = run_command(r, render);
    if (status != SATIN_OK) return status;
    if (is_interrupted(r)) return SATIN_CANCELLED;
    render->result.done = true;
    r->spent += render->result.wall_s;
    r->rendered++;
    const bool good = render->result.status == 0 && render->result.signal == 0;
    if (good) status = study_store_add(r->store, r->log, render);
    r->ready += good;
    r->failed += !good;
    report_end(r, render, label);
    return status;
}

// ---- All renders --------------------------------------------------------------------------------

// Renders the pieces of a scene's reference up to one that fails. *whole: none has.
static satin_status run_reference(struct running *r, size_t scene, bool *whole) {
    const struct study *s = &r->plan->study;
    satin_status status = SATIN_OK;
    *whole = true;
    for (size_t k = 0; k < s->reference_pieces && *whole && status == SATIN_OK; k++) {
        char label[256];
        snprintf(label, sizeof label, "%s, reference, piece %zu of %zu", s->scene[scene].name,
                 k + 1, s->reference_pieces);
        struct study_render *render =
            &r->plan->render[r->plan->reference[scene * s->reference_pieces + k]];
        status = run_render(r, render, label);
        *whole = render->result.status == 0 && render->result.signal == 0;
    }
    return status;
}

// Leaves a scene out of the study, and its renders, which have another index of it if others were
// left out before, out of their number.
static void leave_scene(struct running *r, size_t scene, size_t of_renders) {
    for (size_t i = 0; i < r->plan->renders; i++)
        r->total -= r->plan->render[i].scene == of_renders && !r->plan->render[i].result.done;
    study_plan_leave_scene(r->plan, scene);
}

// Renders the references. A scene whose reference fails is left out, as nothing can be compared
// with it; SATIN_ERROR_INTERNAL, logged, if no scene remains.
static satin_status run_references(struct running *r) {
    const struct study *s = &r->plan->study;
    for (size_t i = 0, scene = 0; i < s->scenes; scene++) {
        bool whole = true;
        const satin_status status = s->scene[i].reference ? SATIN_OK : run_reference(r, i, &whole);
        if (status != SATIN_OK) return status;
        if (whole) {
            i++;
            continue;
        }
        log_message(r->log, SATIN_LOG_ERROR, "%s: its reference could not be rendered%s",
                    s->scene[i].name, s->scenes > 1 ? "; the scene is left out" : "");
        leave_scene(r, i, scene);
    }
    return s->scenes > 0 ? SATIN_OK : SATIN_ERROR_INTERNAL;
}

static satin_status run_point(struct running *r, size_t scene, size_t point, size_t seed) {
    const struct study *s = &r->plan->study;
    char *label = study_point_label(s, &s->point[point]);
    struct study_text text = {0}, first_pass_text = {0};
    struct study_render *first_pass = study_plan_first_pass(r->plan, scene, point, seed);
    satin_status status = SATIN_ERROR_MEMORY;
    study_text_add(&text, "%s, %s, seed %llu", s->scene[scene].name, label ? label : "",
                   (unsigned long long)s->seed[seed]);
    study_text_add(&first_pass_text, "%s, first pass", text.data ? text.data : "");
    if (label && !text.failed && !first_pass_text.failed) {
        status = run_render(r, study_plan_image(r->plan, scene, point, seed), text.data);
        if (status == SATIN_OK && first_pass)
            status = run_render(r, first_pass, first_pass_text.data);
    }
    free(label);
    free(text.data);
    free(first_pass_text.data);
    return status;
}

static satin_status run_points(struct running *r) {
    const struct study *s = &r->plan->study;
    satin_status status = SATIN_OK;
    for (size_t k = 0; k < s->seeds; k++)
        for (size_t i = 0; i < s->scenes; i++)
            for (size_t p = 0; p < s->points && status == SATIN_OK; p++)
                status = run_point(r, i, p, k);
    return status;
}

// Looks for results that are there already, and reports how many.
static void find_results(struct running *r, const char *changed) {
    char line[512];
    for (size_t i = 0; i < r->plan->renders; i++) {
        study_store_find(r->store, &r->plan->render[i]);
        r->ready += r->plan->render[i].result.done;
    }
    r->total = r->plan->renders;
    if (changed) {
        snprintf(line, sizeof line, "changed since the last run: %s", changed);
        report_line(r, line);
    }
    const struct study *s = &r->plan->study;
    snprintf(line, sizeof line, "%zu points, %zu scenes, %zu seeds: %zu renders, %zu of them done",
             s->points, s->scenes, s->seeds, r->total, r->ready);
    report_line(r, line);
}

// ---- The whole ----------------------------------------------------------------------------------

static satin_status run_all(struct running *r) {
    char *changed = NULL;
    satin_status status = study_store_note(r->store, r->log, r->plan, &changed);
    if (status != SATIN_OK) return status;
    find_results(r, changed);
    free(changed);
    status = run_references(r);
    // Without references nothing can be compared.
    if (status != SATIN_OK) return status;
    status = run_points(r);
    if (status != SATIN_OK && status != SATIN_CANCELLED) return status;
    const satin_status written = study_report_write(r->store, r->plan, r->log);
    // Images that cannot be compared are treated as renders that failed.
    if (written != SATIN_OK && written != SATIN_ERROR_INTERNAL) return written;
    if (status == SATIN_OK && r->failed)
        return log_fail(r->log, SATIN_ERROR_INTERNAL, "%s: %zu of %zu renders failed",
                        r->request->file, r->failed, r->total);
    return status == SATIN_OK ? written : status;
}

// Reports what would be rendered.
static satin_status list_renders(const struct running *r) {
    for (size_t i = 0; i < r->plan->renders; i++) {
        char *command = study_command(&r->plan->render[i]);
        if (!command)
            return log_fail(r->log, SATIN_ERROR_MEMORY, "not enough memory for the study");
        report_line(r, command);
        free(command);
    }
    return SATIN_OK;
}

satin_status study_run(const struct study_request *request, struct log log) {
    struct study_plan plan;
    struct study_store store = {request->folder, -1};
    struct running r = {.request = request, .log = log, .plan = &plan, .store = &store};
    satin_status status = study_plan_make(log, request, &plan);
    if (request->planned) request->planned();
    if (status == SATIN_OK && is_interrupted(&r)) status = SATIN_CANCELLED;
    if (status == SATIN_OK && request->dry) {
        status = list_renders(&r);
    } else if (status == SATIN_OK) {
        status = study_store_open(log, request->folder, &store);
        if (status == SATIN_OK) status = study_store_check(&store, log, &plan);
        if (status == SATIN_OK) status = run_all(&r);
        study_store_close(&store);
    }
    study_plan_free(&plan);
    return status;
}
