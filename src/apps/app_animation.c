// SPDX-License-Identifier: Apache-2.0
// The arguments of an animation, and the names of its files.
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "apps/app.h"
#include "apps/app_animation.h"
#include "base/array.h"
#include "film/film.h"
#include "render/render.h"

// ---- Names --------------------------------------------------------------------------------------

// The last run of # in a name, and its length; NULL if there is none.
static const char *find_number(const char *name, int *digits) {
    const char *last = strrchr(name, '#'), *first = last;
    while (last && first > name && first[-1] == '#') first--;
    *digits = last ? (int)(last - first) + 1 : 0;
    return first;
}

// A name with the number of a frame, from malloc; of no name, NULL.
static char *frame_name(const char *name, int number) {
    int digits;
    if (!name) return NULL;
    const char *at = find_number(name, &digits);
    if (!at) return strdup(name);
    const size_t size = strlen(name) + 16;
    char *out = malloc(size);
    if (out) snprintf(out, size, "%.*s%0*d%s", (int)(at - name), name, digits, number, at + digits);
    return out;
}

char *app_frame_checkpoint(const struct app_render_request *r) {
    const char *frames = r->frames ? r->frames : "all";
    int digits;
    const char *run = find_number(r->output, &digits), *at = run ? run : strchr(r->output, 0);
    const char *rest = at + digits;
    int kept = (int)strlen(rest);
    if (app_ends_in(rest, ".exr")) kept -= 4;
    const size_t size = strlen(r->output) + strlen(frames) + sizeof ".checkpoint";
    char *name = malloc(size);
    if (name)
        snprintf(name, size, "%.*s%s%.*s.checkpoint", (int)(at - r->output), r->output, frames,
                 kept, rest);
    return name;
}

int app_frame_begin(const struct app_render_request *r, int number,
                    struct app_render_request *out) {
    *out = *r;
    out->output = frame_name(r->output, number);
    out->png = frame_name(r->png, number);
    out->stats = frame_name(r->stats, number);
    const bool whole = out->output && (out->png || !r->png) && (out->stats || !r->stats);
    return whole ? APP_DONE : app_no_memory();
}

void app_frame_end(struct app_render_request *frame) {
    free((char *)frame->output);
    free((char *)frame->png);
    free((char *)frame->stats);
}

// ---- Files of two frames ------------------------------------------------------------------------

static const char *frame_file_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

// Sets *number to that of a frame, of those from `first` to `last`, whose file by this pattern is
// the file `path`. False if there is none, or not enough memory.
static bool find_frame_of(const char *path, const char *pattern, int first, int last, int *number) {
    int digits;
    const char *run = find_number(pattern, &digits), *after = run ? run + digits : NULL;
    bool found = false;
    if (!run || !app_ends_in(path, after)) return false;
    // The digits of the number end here, and those before them may belong to the pattern.
    const char *end = path + strlen(path) - strlen(after), *at = end;
    while (at > path && at[-1] >= '0' && at[-1] <= '9' && !found) {
        const long value = strtol(--at, NULL, 10);
        if (end - at < digits || value < first || value > last) continue;
        *number = (int)value;
        char *other = frame_name(pattern, *number);
        found = other && strcmp(frame_file_name(other), frame_file_name(path)) == 0 &&
                fileio_same(other, path);
        free(other);
    }
    return found;
}

int app_frame_check_names(const struct app_render_request *r, int number,
                          const struct app_render_request *frame, int first, int last) {
    const char *const own[] = {frame->output, frame->png, frame->stats};
    const char *const pattern[] = {r->output, r->png, r->stats};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < i; j++) {
            int other;
            if (own[i] && pattern[j] && find_frame_of(own[i], pattern[j], first, last, &other))
                return app_wrong("%s: %s of frame %d and %s of frame %d have the same file", own[i],
                                 pattern[j], other, pattern[i], number);
        }
    return APP_DONE;
}

// ---- Complete frames ----------------------------------------------------------------------------

// A message that is kept to be reported as a part of another one.
struct kept_message {
    char text[512];
};

// A satin_log_fn.
static void keep_frame_message(void *user, satin_log_severity severity, const char *message) {
    struct kept_message *kept = user;
    (void)severity;
    snprintf(kept->text, sizeof kept->text, "%s", message);
}

// What makes a film another one than frame `number` of a job. False if it is that frame.
static bool find_difference(const satin_film *film, int number, const char *job, char *out,
                            size_t size) {
    const char *own = film_attribute_get(film, "satin:job"),
               *frame = film_attribute_get(film, "satin:frame");
    if (!own || !frame) {
        snprintf(out, size, "it is none of an animation");
    } else if (strcmp(own, job) != 0) {
        const int n = snprintf(out, size, "it has ");
        render_describe_difference(job, own, out + n, size - (size_t)n);
        if (strncmp(out + n, "spp=", 4) == 0)
            strncat(out, ", and samples are not added to frames", size - strlen(out) - 1);
    } else if (atoi(frame) != number) {
        snprintf(out, size, "it is frame %s", frame);
    } else {
        return false;
    }
    return true;
}

satin_status app_frame_complete(const struct app_render_request *frame, int number, const char *job,
                                struct log log, bool *complete) {
    satin_film *film = NULL;
    struct kept_message unread;
    char difference[256];
    *complete = false;
    if (access(frame->output, F_OK) != 0) return SATIN_OK;
    satin_status status = satin_film_read(frame->output, keep_frame_message, &unread, &film);
    if (status != SATIN_OK)
        return log_fail(log, status, "%s; without --resume it is replaced", unread.text);
    if (find_difference(film, number, job, difference, sizeof difference))
        status = log_fail(log, SATIN_ERROR_INPUT,
                          "%s: not a frame of this render: %s; without --resume it is replaced",
                          frame->output, difference);
    *complete = status == SATIN_OK && (!frame->stats || access(frame->stats, F_OK) == 0);
    // The picture may be missing, or of other options for its tones.
    if (*complete && frame->png)
        status = film_write_png_as(film, frame->png, &frame->tonemap, &frame->format, log);
    satin_film_free(film);
    return status;
}

// ---- Arguments ----------------------------------------------------------------------------------

// Reads A-B or A. False if it is something else.
static bool read_frames(const char *text, satin_animation *out) {
    char *end;
    if (*text < '0' || *text > '9') return false;
    const long first = strtol(text, &end, 10);
    long last = first;
    if (*end == '-' && end[1] >= '0' && end[1] <= '9') last = strtol(end + 1, &end, 10);
    if (*end || first > last || last > INT32_MAX) return false;
    out->first = (int)first;
    out->last = (int)last;
    return true;
}

static int check_name(const char *name) {
    int digits;
    if (!name || strcmp(name, APP_STDOUT) == 0 || find_number(name, &digits)) return APP_DONE;
    return app_wrong("%s: the name of a frame's file needs #### for the number of the frame", name);
}

// Checks that the frames are those of the path, which has `count` of them.
static int check_frames(const struct app_render_request *r, const satin_animation *frames,
                        int count) {
    const int last = frames->number + count - 1;
    if (frames->first >= frames->number && frames->last <= last) return APP_DONE;
    return app_wrong("--frames %s: %s has the frames %d to %d", r->frames, r->animation,
                     frames->number, last);
}

// Sets the poses at rest, and a hash of the poses in all frames.
static int prepare_motion(const struct app_render_request *r, struct app_animation *out) {
    const struct animation_path *path = &out->path;
    if (!path->object_count) return APP_DONE;
    if (strcmp(r->scene, APP_STDIN) == 0)
        return app_wrong(
            "an animation in which objects move cannot read its scene from standard "
            "input, as it is read again for each frame");
    out->pose = array_new(path->object_count, sizeof *out->pose);
    if (!out->pose) return app_no_memory();
    animation_poses_at_rest(path, out->pose);
    out->frames.motion = animation_motion_hash(path);
    return APP_DONE;
}

int app_animation_read(const struct app_render_request *r, struct app_animation *out) {
    const struct log log = {app_log_file, NULL};
    *out = (struct app_animation){0};
    if (!r->animation && r->frames) return app_wrong("--frames needs --animation");
    if (!r->animation) return APP_DONE;
    if (r->checkpoint != r->checkpoint_beside)
        return app_wrong(
            "an animation has no checkpoint file that can be named; --resume writes one beside "
            "its frames");
    if (r->resume && !app_ends_in(r->output, ".exr"))
        return app_wrong("%s: --resume needs frames as .exr, which say of which render they are",
                         r->output);
    int status = check_name(r->output);
    if (status == APP_DONE) status = check_name(r->png);
    if (status == APP_DONE) status = check_name(r->stats);
    if (status != APP_DONE) return status;
    if (r->frames && !read_frames(r->frames, &out->frames))
        return app_wrong("--frames needs A-B, such as 1-60, or one number, not '%s'", r->frames);
    status = app_exit_of(animation_read(log, r->animation, &out->path));
    if (status == APP_DONE) status = prepare_motion(r, out);
    if (status != APP_DONE) return status;
    out->frames.number = out->path.number;
    out->frames.views = out->path.view;
    out->frames.count = out->path.count;
    if (!r->frames) {
        out->frames.first = out->path.number;
        out->frames.last = out->path.number + out->path.count - 1;
    }
    return out->path.sensors || !r->frames ? APP_DONE
                                           : check_frames(r, &out->frames, out->path.count);
}

int app_animation_choose(const struct app_render_request *r, const satin_scene *scene,
                         struct app_animation *animation) {
    satin_animation *frames = &animation->frames;
    if (!animation->path.sensors) return APP_DONE;
    const int count = satin_scene_sensor_count(scene);
    if (!r->frames) frames->last = frames->number + count - 1;
    return check_frames(r, frames, count);
}

// ---- Scenes -------------------------------------------------------------------------------------

int64_t app_animation_memory(const struct app_render_request *r) {
    satin_options options = satin_options_default;
    for (size_t i = 0; i < r->setting_count; i++)
        if (strcmp(r->setting[i].name, "memory") == 0)
            satin_options_set(&options, r->setting[i].name, r->setting[i].value, NULL, NULL);
    return options.memory;
}

static satin_status read_posed_scene(const struct app_render_request *r,
                                     const struct app_animation *animation, const satin_pose *poses,
                                     struct log log, satin_scene **scene) {
    const unsigned sensors = animation->path.sensors ? SATIN_SCENE_ALL_SENSORS : 0;
    // Where objects move, two scenes are in memory.
    const int scenes = animation->path.object_count > 0 ? 2 : 1;
    const satin_scene_request request = {.defines = r->define,
                                         .define_count = r->define_count,
                                         .flags = r->scene_flags | SATIN_SCENE_STREAM | sensors,
                                         .sensor = r->sensor,
                                         .poses = poses,
                                         .pose_count = animation->path.object_count,
                                         .memory = app_animation_memory(r) / scenes};
    return satin_scene_load_request(r->scene, &request, log.fn, log.user, scene);
}

satin_status app_animation_scene(const struct app_render_request *r,
                                 const struct app_animation *animation, int number,
                                 satin_scene **scene) {
    const struct log log = {app_log_file_errors, NULL};
    const size_t count = animation->path.object_count;
    satin_pose *pose = array_new(count, sizeof *pose);
    if (!pose) return log_fail(log, SATIN_ERROR_MEMORY, "not enough memory");
    animation_poses(&animation->path, number, pose);
    const satin_status status = read_posed_scene(r, animation, pose, log, scene);
    free(pose);
    return status;
}

satin_status app_animation_load(const struct app_render_request *r,
                                const struct app_animation *animation,
                                struct app_progress *progress, satin_scene **scene) {
    const struct log log = {app_log_file, progress};
    satin_status status = read_posed_scene(r, animation, animation->pose, log, scene);
    if (status != SATIN_OK || !animation->path.object_count) return status;
    satin_scene *first = NULL;
    status = app_animation_scene(r, animation, animation->frames.first, &first);
    satin_scene_free(first);
    return status;
}

void app_animation_free(struct app_animation *animation) {
    free(animation->pose);
    animation_path_free(&animation->path);
    *animation = (struct app_animation){0};
}
