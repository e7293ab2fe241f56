// SPDX-License-Identifier: Apache-2.0
// The results of renders in files. A result is complete when its KEY.json is there: the image is
// written before it, and both appear whole or not at all, so a study may be killed at any moment.
#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/fileio.h"
#include "base/fileio_files.h"
#include "base/stats.h"
#include "study/study_text.h"
#include "study/study_work.h"

enum { RESULT_BYTES_MAX = 1 << 20, NAME_BYTES = 48 };

const char *const study_stage_name[STUDY_STAGES] = {"load",    "photons", "tables",  "bounces",
                                                    "records", "samples", "denoise", "write"};

// ---- The folder ---------------------------------------------------------------------------------

char *study_store_path(const struct study_store *store, const char *format, ...) {
    struct study_text path = {0};
    char name[512];
    va_list args;
    va_start(args, format);
    vsnprintf(name, sizeof name, format, args);
    va_end(args);
    study_text_add(&path, "%s/%s", store->folder, name);
    if (!path.failed) return path.data;
    free(path.data);
    return NULL;
}

static satin_status make_folder(struct log log, const char *path) {
    struct stat found;
    if (!path) return log_fail(log, SATIN_ERROR_MEMORY, "not enough memory for the study");
    if (mkdir(path, 0777) == 0) return SATIN_OK;
    if (errno == EEXIST && stat(path, &found) == 0 && S_ISDIR(found.st_mode)) return SATIN_OK;
    return log_fail(log, SATIN_ERROR_INPUT, "%s: cannot make the folder: %s", path,
                    errno == EEXIST ? "a file has this name" : strerror(errno));
}

static satin_status make_subfolder(const struct study_store *store, struct log log,
                                   const char *name) {
    char *path = study_store_path(store, "%s", name);
    const satin_status status = make_folder(log, path);
    free(path);
    return status;
}

static const char *const work_files[] = {"work/image.exr", "work/stats.json", "work/errors.txt"};

static void empty_work(const struct study_store *store) {
    for (size_t i = 0; i < sizeof work_files / sizeof *work_files; i++) {
        char *path = study_store_path(store, "%s", work_files[i]);
        if (path) unlink(path);
        free(path);
    }
}

// Whether a name is that of a file which fileio_output.c had not finished when it was killed.
static bool is_unfinished(const char *name) {
    const char *end = strstr(name, ".tmp");
    size_t digits = 0;
    if (!end) return false;
    while (isxdigit((unsigned char)end[4 + digits])) digits++;
    return digits == 16 && end[4 + digits] == 0;
}

// Removes what a killed process has left in a folder that this one has locked.
static void remove_unfinished(const struct study_store *store, const char *subfolder) {
    char *path = study_store_path(store, "%s", subfolder);
    DIR *list = path ? opendir(path) : NULL;
    const struct dirent *entry;
    while (list && (entry = readdir(list)) != NULL) {
        char *name = is_unfinished(entry->d_name)
                         ? study_store_path(store, "%s/%s", subfolder, entry->d_name)
                         : NULL;
        if (name) unlink(name);
        free(name);
    }
    if (list) closedir(list);
    free(path);
}

// Refuses a folder with files that are not of a study, as the study would replace or remove those
// whose names it uses. A folder of a study has the file of its lock.
static satin_status check_owner(const struct study_store *store, struct log log, const char *lock) {
    if (access(lock, F_OK) == 0) return SATIN_OK;
    DIR *list = opendir(store->folder);
    const struct dirent *entry;
    bool empty = true;
    while (list && (entry = readdir(list)) != NULL)
        empty = empty && (!strcmp(entry->d_name, ".") || !strcmp(entry->d_name, ".."));
    if (list) closedir(list);
    if (empty) return SATIN_OK;
    return log_fail(log, SATIN_ERROR_INPUT,
                    "%s: the folder has files that are not of a study; name a new one",
                    store->folder);
}

// Locks the folder. After a failure it is not locked by this process.
static satin_status lock_folder(struct study_store *store, struct log log) {
    char *path = study_store_path(store, "study.lock");
    if (!path) return SATIN_ERROR_MEMORY;
    satin_status status = check_owner(store, log, path);
    if (status == SATIN_OK) {
        store->lock = open(path, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
        if (store->lock < 0)
            status = log_fail(log, SATIN_ERROR_INPUT, "%s: %s", path, strerror(errno));
    }
    free(path);
    if (status != SATIN_OK || flock(store->lock, LOCK_EX | LOCK_NB) == 0) return status;
    close(store->lock);
    store->lock = -1;
    return log_fail(log, SATIN_ERROR_INPUT, "%s: another process runs a study there",
                    store->folder);
}

satin_status study_store_open(struct log log, const char *folder, struct study_store *out) {
    static const char *const subfolder[] = {"runs", "references", "work"};
    *out = (struct study_store){folder, -1};
    satin_status status = make_folder(log, folder);
    if (status == SATIN_OK) status = lock_folder(out, log);
    for (size_t i = 0; i < sizeof subfolder / sizeof *subfolder && status == SATIN_OK; i++)
        status = make_subfolder(out, log, subfolder[i]);
    if (status != SATIN_OK) return status;
    for (size_t i = 0; i < sizeof subfolder / sizeof *subfolder; i++)
        remove_unfinished(out, subfolder[i]);
    remove_unfinished(out, ".");
    empty_work(out);
    return SATIN_OK;
}

void study_store_close(struct study_store *store) {
    if (store->lock < 0) return;
    empty_work(store);
    char *work = study_store_path(store, "work");
    if (work) rmdir(work);
    free(work);
    close(store->lock);
    store->lock = -1;
}

// ---- Results ------------------------------------------------------------------------------------

// The number of that name in a flat JSON object, or 0.
static double json_value(const char *json, const char *name) {
    char quoted[NAME_BYTES + 8];
    const int n = snprintf(quoted, sizeof quoted, "\"%s\": ", name);
    const char *at = n < (int)sizeof quoted ? strstr(json, quoted) : NULL;
    return at ? strtod(at + n, NULL) : 0.0;
}

// The names of the numbers in KEY.json, and where they are in a result.
static const struct {
    const char *name;
    size_t offset;
} stored[] = {
    {"wall_s", offsetof(struct study_result, wall_s)},
    {"cpu_s", offsetof(struct study_result, cpu_s)},
    {"peak_bytes", offsetof(struct study_result, peak_bytes)},
    {"threads", offsetof(struct study_result, threads)},
    {"photons", offsetof(struct study_result, photons)},
    {"records", offsetof(struct study_result, records)},
    {"spp", offsetof(struct study_result, spp)},
    {"replaced", offsetof(struct study_result, replaced)},
    {"lookup_error", offsetof(struct study_result, lookup_error)},
};
enum { STORED = sizeof stored / sizeof *stored };

static double *stored_value(struct study_result *result, size_t i) {
    return (double *)((char *)result + stored[i].offset);
}

// Whether a file can be read as an image; not if it was damaged, as by a full disk.
static bool is_whole_image(const char *path) {
    satin_film *film = NULL;
    const bool read = satin_film_read(path, NULL, NULL, &film) == SATIN_OK;
    satin_film_free(film);
    return read;
}

void study_store_find(const struct study_store *store, struct study_render *render) {
    char *path = study_store_path(store, "runs/%016" PRIx64 ".json", render->key);
    char *image = study_store_path(store, "runs/%016" PRIx64 ".exr", render->key);
    char *text = NULL;
    size_t size = 0;
    struct study_result *result = &render->result;
    // A file that is not there is no error.
    if (path && image && access(image, R_OK) == 0 && access(path, R_OK) == 0 &&
        fileio_read((struct log){0}, (struct log_place){0}, path, RESULT_BYTES_MAX, &text, &size) ==
            SATIN_OK &&
        strchr(text, '}') && is_whole_image(image)) {
        for (size_t i = 0; i < STORED; i++)
            *stored_value(result, i) = json_value(text, stored[i].name);
        for (int i = 0; i < STUDY_STAGES; i++) {
            char name[NAME_BYTES];
            snprintf(name, sizeof name, "%s_s", study_stage_name[i]);
            result->stage_s[i] = json_value(text, name);
        }
        result->done = true;
    }
    free(text);
    free(image);
    free(path);
}

// Adds what the statistics of the render say.
static void take_stats(const char *stats, struct study_result *result) {
    static const char *const time[STUDY_STAGES] = {
        [STUDY_PHOTONS] = "time.photons_s",  [STUDY_TABLES] = "time.tables_s",
        [STUDY_BOUNCES] = "time.bounces_s",  [STUDY_RECORDS] = "time.records_s",
        [STUDY_SAMPLES] = "time.image_s",    [STUDY_DENOISE] = "time.denoise_s",
        [STUDY_WRITE] = "parts.write.wall_s"};
    for (int i = 0; i < STUDY_STAGES; i++)
        if (time[i]) result->stage_s[i] = json_value(stats, time[i]);
    result->stage_s[STUDY_LOAD] =
        json_value(stats, "parts.load.wall_s") + json_value(stats, "parts.bvh.wall_s");
    result->threads = json_value(stats, "render.threads");
    result->photons = json_value(stats, "photons.emitted");
    result->records =
        json_value(stats, "records.irradiance") + json_value(stats, "records.radiance");
    result->spp = json_value(stats, "image.spp");
    result->replaced = json_value(stats, "render.replaced");
    result->lookup_error = json_value(stats, "first_pass.error");
}

static satin_status write_result(const struct study_store *store, struct log log,
                                 struct study_render *render) {
    struct study_text text = {0};
    char *command = study_command(render);
    char *path = study_store_path(store, "runs/%016" PRIx64 ".json", render->key);
    study_text_add(&text, "{\n  \"command\": ");
    study_text_json(&text, command ? command : "");
    for (size_t i = 0; i < STORED; i++) {
        study_text_add(&text, ",\n  \"%s\": ", stored[i].name);
        study_text_json_number(&text, *stored_value(&render->result, i));
    }
    for (int i = 0; i < STUDY_STAGES; i++) {
        study_text_add(&text, ",\n  \"%s_s\": ", study_stage_name[i]);
        study_text_json_number(&text, render->result.stage_s[i]);
    }
    study_text_add(&text, "\n}\n");
    satin_status status = SATIN_ERROR_MEMORY;
    if (command && path && !text.failed)
        status = fileio_write(log, path, text.data, text.size);
    else
        log_fail(log, status, "not enough memory for the study");
    free(text.data);
    free(path);
    free(command);
    return status;
}

// The channels that are compared.
static satin_film *without_layers(const satin_film *film) {
    static const char *const name[] = {"R", "G", "B", "emission.R", "emission.G", "emission.B"};
    const int count = satin_film_channel(film, name[3]) ? 6 : 3;
    satin_film *made = film_new(film->width, film->height, name, count);
    const size_t bytes = (size_t)film->width * (size_t)film->height * sizeof(float);
    for (int i = 0; made && i < count; i++) {
        const float *from = satin_film_channel(film, name[i]);
        if (from) memcpy(film_channel(made, name[i]), from, bytes);
    }
    const char *options = film_attribute_get(film, "satin:options");
    if (!made || !options || film_attribute_set(made, "satin:options", options)) return made;
    satin_film_free(made);
    return NULL;
}

static satin_status store_image(const struct study_store *store, struct log log,
                                const struct study_render *render) {
    char *from = study_store_path(store, "%s", work_files[0]);
    char *to = study_store_path(store, "runs/%016" PRIx64 ".exr", render->key);
    satin_film *film = NULL, *small = NULL;
    satin_status status =
        from && to ? satin_film_read(from, log.fn, log.user, &film) : SATIN_ERROR_MEMORY;
    if (status == SATIN_OK) {
        small = without_layers(film);
        status = small ? film_write_exr(small, to, NULL, log) : SATIN_ERROR_MEMORY;
    }
    satin_film_free(small);
    satin_film_free(film);
    free(from);
    free(to);
    return status;
}

satin_status study_store_add(const struct study_store *store, struct log log,
                             struct study_render *render) {
    char *path = study_store_path(store, "%s", work_files[1]), *text = NULL;
    size_t size = 0;
    satin_status status = store_image(store, log, render);
    if (status == SATIN_OK)
        status = path
                     ? fileio_read(log, (struct log_place){0}, path, RESULT_BYTES_MAX, &text, &size)
                     : SATIN_ERROR_MEMORY;
    if (status == SATIN_OK) {
        take_stats(text, &render->result);
        status = write_result(store, log, render);
    }
    free(text);
    free(path);
    return status;
}

satin_status study_store_check(const struct study_store *store, struct log log,
                               const struct study_plan *plan) {
    static const char *const result[] = {"study.csv", "study.json", "study.html"};
    enum { RESULTS = sizeof result / sizeof *result };
    const struct study *s = &plan->study;
    struct fileio_files files = {0};
    bool memory = fileio_files_add(&files, s->root->at.file);
    for (size_t i = 0; i < s->scenes; i++) {
        memory = memory && fileio_files_add(&files, s->scene[i].path);
        if (s->scene[i].reference)
            memory = memory && fileio_files_add(&files, s->scene[i].reference);
    }
    satin_status status = memory ? SATIN_OK : SATIN_ERROR_MEMORY;
    for (size_t i = 0; i < RESULTS + s->scenes && status == SATIN_OK; i++) {
        char *path = i < RESULTS
                         ? study_store_path(store, "%s", result[i])
                         : study_store_path(store, "references/%s.exr", s->scene[i - RESULTS].name);
        struct stat found;
        if (!path)
            status = SATIN_ERROR_MEMORY;
        else if (fileio_files_have(&files, path))
            status =
                log_fail(log, SATIN_ERROR_INPUT, "%s: the result would replace an input", path);
        else if (lstat(path, &found) == 0 && !S_ISREG(found.st_mode))
            status = log_fail(log, SATIN_ERROR_INPUT, "%s: it is not a regular file", path);
        free(path);
    }
    fileio_files_free(&files);
    return status;
}

satin_status study_store_image(const struct study_store *store, struct log log,
                               const struct study_render *render, satin_film **film) {
    char *path = study_store_path(store, "runs/%016" PRIx64 ".exr", render->key);
    const satin_status status =
        path ? satin_film_read(path, log.fn, log.user, film) : SATIN_ERROR_MEMORY;
    free(path);
    return status;
}

// ---- Notes --------------------------------------------------------------------------------------

// `name` quoted with its hash as a line of the note.
static void add_note(struct study_text *text, const char *kind, const char *name, uint64_t hash) {
    study_text_add(text, "  \"%s %s\": \"%016" PRIx64 "\",\n", kind, name, hash);
}

// Appends the names of those lines of the note before that are different now.
static void compare_notes(const char *before, const char *now, struct study_text *out) {
    for (const char *line = now; (line = strstr(line, "  \"")) != NULL; line++) {
        const char *colon = strstr(line, "\": "), *end = strchr(line, '\n');
        if (!colon || !end) return;
        const size_t name = (size_t)(colon - line), whole = (size_t)(end - line);
        char *key = strndup(line, name + 3), *all = strndup(line, whole);
        if (key && all && strstr(before, key) && !strstr(before, all))
            study_text_add(out, "%s%.*s", out->size ? ", " : "", (int)(name - 3), line + 3);
        free(key);
        free(all);
    }
}

satin_status study_store_note(const struct study_store *store, struct log log,
                              const struct study_plan *plan, char **changed) {
    struct study_text text = {0}, differences = {0};
    char *path = study_store_path(store, "runs/study.json"), *before = NULL;
    size_t size = 0;
    *changed = NULL;
    study_text_add(&text, "{\n");
    add_note(&text, "study", "file", plan->study.hash);
    add_note(&text, "satin", SATIN_VERSION, plan->program_hash);
    for (size_t i = 0; i < plan->study.scenes; i++)
        add_note(&text, "scene", plan->study.scene[i].name, plan->study.scene[i].hash);
    study_text_add(&text, "  \"format\": 1\n}\n");
    satin_status status = SATIN_ERROR_MEMORY;
    if (path && !text.failed) {
        if (access(path, R_OK) == 0 && fileio_read(log, (struct log_place){0}, path,
                                                   RESULT_BYTES_MAX, &before, &size) == SATIN_OK)
            compare_notes(before, text.data, &differences);
        status = fileio_write(log, path, text.data, text.size);
    }
    free(before);
    free(path);
    free(text.data);
    if (status == SATIN_OK && !differences.failed)
        *changed = differences.data;
    else
        free(differences.data);
    return status;
}
