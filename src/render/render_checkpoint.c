// SPDX-License-Identifier: Apache-2.0
// A checkpoint: the results of loops, and the state of the image. A render that resumes runs all
// steps as one from the beginning does, and makes the same decisions, but takes the results of its
// loops from the checkpoint as far as it has them. So it goes on as if it had not been interrupted.
//
// The state of the image is not that of a loop: samples are added to it. It is written every so
// often between the tiles of a pass, where all pixels have all or none of the samples of the pass.
// The results of a long loop are written as often, and when the render is cancelled.
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/background.h"
#include "base/fileio.h"
#include "base/text.h"
#include "render/options_table.h"
#include "render/render_checkpoint_file.h"
#include "render/render_image.h"

struct render_checkpoint {
    struct checkpoint_file *file;     // NULL: another rank has it, or nothing more is written
    struct checkpoint_file *ended;    // the file of an animation whose frames are begun; else NULL
    struct parallel_journal journal;  // of the pool
    char *identity;                   // of this render, and its word FIRST_SPP; from malloc
    int first_spp;                    // samples per pixel that the first process was to take
    int spp;                          // those of this one, if it adds samples; else 0
    char *chosen;                     // with a time limit, the options' words; from malloc
    struct bytes image;               // with a time limit, the state of the image that was read
    size_t image_at;                  // offset in it, behind what is of the time limit
    bool resumed;                     // the file has existed before
    bool reading;                     // its entries are read; else they are written
    bool reading_passing;             // its passing entries are read when they are asked for
    bool due;                         // a pass was stopped so that its state is written
    double written;                   // wall clock when something was written last
    struct background writer;         // of the last state; see begin_writer
};

bool render_has_checkpoint(const struct render *r) { return r->callbacks.checkpoint; }

// ---- What must be equal -------------------------------------------------------------------------

static long number_of(const struct identity_word *word) { return atol(word->at + word->name + 1); }

static satin_status refuse_other(const struct render *r, const struct identity_word *here,
                                 const struct identity_word *there) {
    const char *path = r->callbacks.checkpoint;
    if (render_identity_is(here, "scene"))
        return log_fail(r->log, SATIN_ERROR_INPUT, "%s: a checkpoint of another scene", path);
    if (render_identity_is(here, "records"))
        return log_fail(r->log, SATIN_ERROR_INPUT, "%s: a checkpoint with other records loaded",
                        path);
    if (render_identity_is(here, "time"))
        return log_fail(r->log, SATIN_ERROR_INPUT, "%s: a checkpoint %s a time limit", path,
                        r->options.time > 0.0 ? "without" : "with");
    if (render_identity_is(here, "memory") && (r->options.memory == 0 || number_of(there) == 0))
        return log_fail(r->log, SATIN_ERROR_INPUT, "%s: a checkpoint %s a limit of memory", path,
                        r->options.memory > 0 ? "without" : "with");
    return log_fail(r->log, SATIN_ERROR_INPUT, "%s: a checkpoint with %.*s, but here it is %.*s",
                    path, (int)there->length, there->at, (int)(here->length - here->name - 1),
                    here->at + here->name + 1);
}

// A word behind those of the render: photons and records are as many as if this were spp.
static const char FIRST_SPP[] = "first-spp";

// Whether two words are the number of samples per pixel, and that of the checkpoint is less. The
// frames of an animation have no more samples than others that were made with the same records.
static bool adds_samples(const struct render *r, const struct identity_word *here,
                         const struct identity_word *there) {
    return !r->callbacks.animation && render_identity_is(here, "spp") &&
           number_of(there) < number_of(here);
}

// Compares the words of two identities: only samples may be added. Takes FIRST_SPP from there.
static satin_status compare_identities(struct render *r, const char *here, const char *there) {
    struct identity_word a, b;
    while (render_identity_differ(&here, &there, &a, &b)) {
        if (a.name != b.name || strncmp(a.at, b.at, a.name) != 0)
            return log_fail(r->log, SATIN_ERROR_INPUT, "%s: a checkpoint of another version",
                            r->callbacks.checkpoint);
        if (render_identity_is(&a, FIRST_SPP))
            r->checkpoint->first_spp = (int)number_of(&b);
        else if (!adds_samples(r, &a, &b))
            return refuse_other(r, &a, &b);
    }
    return SATIN_OK;
}

// Sets the identity of this render.
static satin_status make_identity(struct render *r) {
    struct render_checkpoint *c = r->checkpoint;
    char *words = render_identity(r), *all = NULL;
    if (words && asprintf(&all, "%s %s=%d", words, FIRST_SPP, c->first_spp) < 0) all = NULL;
    free(words);
    free(c->identity);
    c->identity = all;
    return all ? SATIN_OK : SATIN_ERROR_MEMORY;
}

// ---- Opening ------------------------------------------------------------------------------------

// For the pool: the next results of a loop.
static bool read_loop(void *user, struct parallel_entry *entry, struct bytes *out) {
    struct render *r = user;
    struct render_checkpoint *c = r->checkpoint;
    const unsigned passing = entry->passing ? CHECKPOINT_PASSING : 0;
    if (!(passing ? c->reading_passing : c->reading) || !c->file) return false;
    entry->last =
        render_checkpoint_file_read(c->file, CHECKPOINT_LOOP | passing, entry->passing, out);
    const bool found = entry->last || render_checkpoint_file_read(
                                          c->file, CHECKPOINT_PIECE | passing, entry->passing, out);
    // The next passing entry may be that of a later loop.
    if (!found && !passing) c->reading = false;
    stats_add(&r->stats, "checkpoint.loops", entry->last);
    return found;
}

// After a failure nothing more is written, and the render goes on.
static void note_failure(struct render *r, satin_status status) {
    if (status == SATIN_OK) return;
    r->outcome.checkpointed = status;
    render_checkpoint_file_close(r->checkpoint->file);
    r->checkpoint->file = NULL;
    log_message(r->log, SATIN_LOG_WARNING, "the render goes on without a checkpoint");
}

static struct bytes identity_bytes(const struct render_checkpoint *c) {
    return (struct bytes){(unsigned char *)c->identity, strlen(c->identity) + 1, 0, false};
}

// A background_fn: writes the state of the image.
static bool write_state(void *ctx, struct log log) {
    const struct render *r = ctx;
    const struct render_checkpoint *c = r->checkpoint;
    struct bytes state = {0};
    const struct bytes identity = identity_bytes(c);
    if (r->options.time > 0.0) render_timed_pack(r, c->chosen, &state);
    render_image_pack(r->image, &state);
    const satin_status status =
        state.failed
            ? log_fail(log, SATIN_ERROR_MEMORY, "%s: not enough memory", r->callbacks.checkpoint)
            : render_checkpoint_file_replace(c->file, &identity, &state, log);
    bytes_free(&state);
    return status == SATIN_OK;
}

static void write_now(struct render *r) {
    note_failure(r, write_state(r, r->log) ? SATIN_OK : SATIN_ERROR_IO);
    atomic_store(&r->image->progressed, false);
    atomic_store(&r->image->unwritten, false);
    r->checkpoint->written = stats_wall();
}

// For the pool: writes results. Photons of a pass follow the image to which they are added.
static void write_loop(void *user, struct parallel_entry entry, const struct bytes *results) {
    struct render *r = user;
    struct render_checkpoint *c = r->checkpoint;
    const unsigned passing = entry.passing ? CHECKPOINT_PASSING : 0;
    const unsigned kind = (entry.last ? CHECKPOINT_LOOP : CHECKPOINT_PIECE) | passing;
    if (c->file && entry.passing && atomic_load(&r->image->unwritten)) write_now(r);
    if (!c->file) return;
    note_failure(r, results->count ? render_checkpoint_file_append(c->file, kind, entry.passing,
                                                                   results, r->log)
                                   : log_fail(r->log, SATIN_ERROR_MEMORY, "%s: not enough memory",
                                              r->callbacks.checkpoint));
    c->written = stats_wall();
}

// For the pool: whether so much time has passed that something is to be written.
static bool is_due(void *user) {
    const struct render *r = user;
    const struct render_checkpoint *c = r->checkpoint;
    const double every = r->callbacks.checkpoint_seconds > 0.0 ? r->callbacks.checkpoint_seconds
                                                               : RENDER_CHECKPOINT_SECONDS;
    return c->file && stats_wall() - c->written >= every;
}

// Compares the identity of a file that has existed.
static satin_status identify(struct render *r) {
    struct render_checkpoint *c = r->checkpoint;
    struct bytes there = {0};
    satin_status status = SATIN_OK;
    if (!render_checkpoint_file_read(c->file, CHECKPOINT_IDENTITY, 0, &there) || there.count == 0 ||
        there.data[there.count - 1] != 0)
        status = log_fail(r->log, SATIN_ERROR_INPUT, "%s: the checkpoint is damaged",
                          r->callbacks.checkpoint);
    else
        status = compare_identities(r, c->identity, (const char *)there.data);
    if (status == SATIN_OK && (c->first_spp < 1 || c->first_spp > r->options.spp))
        status = log_fail(r->log, SATIN_ERROR_INPUT, "%s: the checkpoint is damaged",
                          r->callbacks.checkpoint);
    bytes_free(&there);
    return status == SATIN_OK ? make_identity(r) : status;
}

static satin_status open_file(struct render *r) {
    struct render_checkpoint *c = r->checkpoint;
    const char *path = r->callbacks.checkpoint;
    if (fileio_files_have(&r->scene.read, path))
        return log_fail(r->log, SATIN_ERROR_INPUT, "%s: the scene was read from this file", path);
    satin_status status = make_identity(r);
    if (status != SATIN_OK) return status;
    const struct bytes identity = identity_bytes(c);
    status = render_checkpoint_file_open(path, &identity, r->callbacks.resume, r->log, &c->resumed,
                                         &c->file);
    c->reading = c->resumed;
    if (status == SATIN_OK && c->resumed) status = identify(r);
    c->reading_passing = c->resumed;
    c->journal = (struct parallel_journal){r, read_loop, write_loop, is_due};
    return status;
}

static satin_status refuse_image(const struct render *r) {
    return log_fail(r->log, SATIN_ERROR_INPUT, "%s: the image of the checkpoint is damaged",
                    r->callbacks.checkpoint);
}

// Reads the state of the image, which all ranks get. False if there is none.
static bool read_image_state(struct render *r, struct bytes *out) {
    struct render_checkpoint *c = r->checkpoint;
    const bool found = c->reading && render_checkpoint_file_read(c->file, CHECKPOINT_IMAGE, 0, out);
    c->reading = false;
    return parallel_broadcast(r->pool, found, out);
}

// With a time limit there are no loops, and the image is read now, as it has the decisions.
static satin_status open_timed(struct render *r) {
    struct render_checkpoint *c = r->checkpoint;
    c->chosen = render_options_text(&r->options);
    if (!c->chosen) return SATIN_ERROR_MEMORY;
    if (!read_image_state(r, &c->image)) return parallel_status(r->pool);
    struct bytes_reader in = {c->image.data, c->image.count, false};
    if (!render_timed_unpack(r, &in)) return refuse_image(r);
    free(c->chosen);
    c->chosen = render_options_text(&r->options);
    c->image_at = c->image.count - in.left;
    return c->chosen ? SATIN_OK : SATIN_ERROR_MEMORY;
}

// Until there is an image, all is done as by the first process, whose samples these are.
static void begin_with_first_samples(struct render *r) {
    struct render_checkpoint *c = r->checkpoint;
    const int first = (int)render_agreed(r, c->first_spp);
    if (first == r->options.spp) return;
    c->spp = r->options.spp;
    r->options.spp = first;
}

satin_status render_checkpoint_add_samples(struct render *r) {
    struct render_checkpoint *c = r->checkpoint;
    if (!c || !c->spp) return SATIN_OK;
    r->options.spp = c->spp;
    c->spp = 0;
    const struct cache *cache = r->second_pass.shade.records.cache;
    shade_destroy(&r->second_pass.shade);
    return render_shading(r, cache);
}

satin_status render_checkpoint_open(struct render *r) {
    if (!r->callbacks.checkpoint) return SATIN_OK;
    // An animation whose frames are all complete does no work, but a checkpoint serves no more
    // then.
    const bool needed = !r->callbacks.animation || r->frames.wanted;
    if (!needed && render_agreed(r, access(r->callbacks.checkpoint, F_OK)) != 0.0) return SATIN_OK;
    const bool timed = r->options.time > 0.0;
    if (timed && !render_timed_resumes(r))
        return log_fail(r->log, SATIN_ERROR_INPUT,
                        "a render with a time limit has no checkpoint with integrator two-pass; "
                        "set spp instead of time");
    struct render_checkpoint *c = r->checkpoint = calloc(1, sizeof *c);
    if (!c) return SATIN_ERROR_MEMORY;
    c->first_spp = r->options.spp;
    satin_status status = render_is_first(r) ? open_file(r) : SATIN_OK;
    status = render_ranks_status(r, status);
    if (status == SATIN_OK) begin_with_first_samples(r);
    if (status == SATIN_OK && timed) status = open_timed(r);
    if (status == SATIN_OK && !timed)
        parallel_set_journal(r->pool, render_is_first(r) ? &c->journal : NULL, PARALLEL_ALL_LOOPS);
    c->written = stats_wall();
    return status;
}

satin_status render_checkpoint_check(const struct render *r, satin_status status) {
    const satin_status failed = r->pool ? parallel_status(r->pool) : SATIN_OK;
    if (failed == SATIN_OK || r->outcome.error_logged) return status;
    if (failed == SATIN_ERROR_INPUT)
        log_fail(r->log, failed, "%s: the checkpoint is damaged", r->callbacks.checkpoint);
    return failed;
}

void render_checkpoint_free(struct render *r) {
    if (!r->checkpoint) return;
    render_checkpoint_end(r);
    render_checkpoint_file_close(r->checkpoint->file);
    render_checkpoint_file_close(r->checkpoint->ended);
    bytes_free(&r->checkpoint->image);
    free(r->checkpoint->chosen);
    free(r->checkpoint->identity);
    free(r->checkpoint);
}

void render_checkpoint_end_loops(struct render *r) {
    struct render_checkpoint *c = r->checkpoint;
    if (!c) return;
    parallel_set_journal(r->pool, NULL, PARALLEL_NO_LOOPS);
    c->ended = c->file;
    c->file = NULL;
    c->reading = false;
}

void render_checkpoint_remove(struct render *r) {
    struct render_checkpoint *c = r->checkpoint;
    // What cannot be removed does no harm.
    if (c && c->ended && unlink(r->callbacks.checkpoint) != 0) errno = 0;
}

// ---- The image ----------------------------------------------------------------------------------

satin_status render_checkpoint_begin_image(struct render *r, bool *restored) {
    struct render_checkpoint *c = r->checkpoint;
    *restored = false;
    if (!c) return SATIN_OK;
    // Photons of a pass serve for that pass alone.
    const bool passing = render_steps(r)->passes && !(r->options.time > 0.0);
    parallel_set_journal(r->pool, render_is_first(r) ? &c->journal : NULL,
                         passing ? PARALLEL_PASSING_LOOPS : PARALLEL_NO_LOOPS);
    *restored = c->image.count > 0 || read_image_state(r, &c->image);
    satin_status status = parallel_status(r->pool);
    const struct bytes state = {c->image.data + c->image_at, c->image.count - c->image_at, 0,
                                false};
    if (status == SATIN_OK && *restored && !render_image_unpack(r->image, &state))
        status = refuse_image(r);
    bytes_free(&c->image);
    stats_set(&r->stats, "checkpoint.samples", (double)r->image->counts.samples);
    c->written = stats_wall();
    return status;
}

bool render_checkpoint_due(struct render *r) {
    struct render_checkpoint *c = r->checkpoint;
    if (!c || !c->file || r->image->state != IMAGE_SAMPLING || !r->image->begun) return false;
    // The state is not written twice without a tile between, however short the time is.
    if (!atomic_load(&r->image->progressed)) return false;
    c->due = c->due || is_due(r);
    return c->due;
}

bool render_checkpoint_pause(struct render *r) {
    struct render_checkpoint *c = r->checkpoint;
    if (!c || render_cancelled(r)) return false;
    bool due = c->due;
    c->due = false;
    due = parallel_broadcast(r->pool, due, &(struct bytes){0});
    if (due) render_checkpoint_write(r);
    return due;
}

// Begins to write the state, the last one, in a copy of this process, as mpirun kills this one
// within a second after it was interrupted.
static bool begin_writer(struct render *r, background_fn write) {
    struct render_checkpoint *c = r->checkpoint;
    background_stop(&c->writer);
    return r->callbacks.ranks && render_cancelled(r) &&
           background_begin(&c->writer, render_checkpoint_file_number(c->file), write, r);
}

// A background_fn: writes the state with the samples of this rank alone.
static bool write_own_state(void *ctx, struct log log) {
    struct render *r = ctx;
    render_pass_collect_own(r->image->pass);
    return write_state(r, log);
}

void render_checkpoint_interrupt(struct render *r) {
    const struct render_checkpoint *c = r->checkpoint;
    const bool samples = r->image && r->image->state == IMAGE_SAMPLING && r->image->begun;
    if (c && c->file && !c->writer.pid && samples) begin_writer(r, write_own_state);
}

void render_checkpoint_write(struct render *r) {
    struct render_checkpoint *c = r->checkpoint;
    if (!c || !c->file || !atomic_load(&r->image->unwritten)) return;
    if (begin_writer(r, write_state)) {
        render_checkpoint_file_close(c->file);
        c->file = NULL;
        return;
    }
    write_now(r);
}

void render_checkpoint_end_pass(struct render *r) {
    if (r->checkpoint && r->checkpoint->file) render_checkpoint_file_drop(r->checkpoint->file);
}

void render_checkpoint_between(struct render *r) {
    if (r->checkpoint && is_due(r)) render_checkpoint_write(r);
}

void render_checkpoint_end(struct render *r) {
    struct render_checkpoint *c = r->checkpoint;
    if (c && !background_end(&c->writer, r->log)) r->outcome.checkpointed = SATIN_ERROR_IO;
}
