// SPDX-License-Identifier: Apache-2.0
// satin info: describes a scene, an image or a file of cache records in words.
#include <fcntl.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "apps/app.h"
#include "cache/cache.h"
#include "film/film.h"

enum { INFO_FLAG_DEFINE, INFO_FLAG_SENSOR, INFO_FLAG_HELP };

const struct app_flag app_info_flags[] = {
    {"--define", "-D", "NAME=VALUE", "Replaces a default of the scene file; may be repeated."},
    {"--sensor", NULL, "INDEX|ID",
     "Describes the view of this sensor of the scene, by its id or counted from 0."},
    {"--help", "-h", NULL, "Prints this."},
    {NULL, NULL, NULL, NULL},
};

bool app_info_starts(const char *path, const char *magic) {
    char head[16];
    const size_t size = strlen(magic);
    struct stat st;
    // Non-blocking, so that it does not wait for the other end of a named pipe.
    int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    // What is read from standard input or another pipe is not there any more.
    bool same = file >= 0 && fstat(file, &st) == 0 && S_ISREG(st.st_mode) &&
                strncmp(path, "/dev/", 5) != 0 && read(file, head, size) == (ssize_t)size &&
                !memcmp(head, magic, size);
    if (file >= 0) close(file);
    return same;
}

// ---- Images -------------------------------------------------------------------------------------

static void print_channel(const char *name, const float *value, size_t count) {
    double low = INFINITY, high = -INFINITY, sum = 0.0;
    size_t finite = 0;
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(value[i])) continue;
        finite++;
        sum += (double)value[i];
        low = fmin(low, (double)value[i]);
        high = fmax(high, (double)value[i]);
    }
    printf("  %-20s", name);
    if (finite) printf(" %12.6g %12.6g %12.6g", low, sum / (double)finite, high);
    if (finite < count) printf("  %zu not finite", count - finite);
    printf("\n");
}

static satin_status describe_image(const char *path) {
    satin_film *film = NULL;
    satin_status status = satin_film_read(path, app_log_file, NULL, &film);
    if (status != SATIN_OK) return status;
    size_t count = (size_t)film->width * (size_t)film->height;
    printf("image      %s, %dx%d", path, film->width, film->height);
    if (film->full_width != film->width || film->full_height != film->height || film->x || film->y)
        printf(" at (%d, %d) of %dx%d", film->x, film->y, film->full_width, film->full_height);
    printf("\n");
    printf("channels   %-11s %12s %12s %12s\n", "", "min", "mean", "max");
    for (int c = 0; c < film->channel_count; c++)
        print_channel(film->channel_name[c], film->channel[c], count);
    if (film->attribute_count) printf("attributes\n");
    for (int i = 0; i < film->attribute_count; i++)
        printf("  %s: %s\n", film->attribute[i].name, film->attribute[i].value);
    if (film->stats) printf("statistics %s", film->stats);
    satin_film_free(film);
    return SATIN_OK;
}

static bool starts_as_image(const char *path) {
    size_t length = strlen(path);
    // A file that does not begin as an OpenEXR image counts as one if its name says so, so that the
    // error message is about images.
    if (length > 4 && strcmp(path + length - 4, ".exr") == 0) return true;
    if (length > 4 && strcmp(path + length - 4, ".xml") == 0) return false;
    return app_info_starts(path, "\x76\x2f\x31\x01");
}

// ---- Files that are not described ---------------------------------------------------------------

static const struct {
    const char *magic, *what;
} not_described[] = {
    {"satinckp", "a checkpoint, with which `satin render --checkpoint FILE --resume` goes on"},
    {"\x89PNG", "a PNG picture"},
    {"\xff\xd8\xff", "a JPEG picture"},
    {"#?", "a Radiance picture"},
    {"II*", "a TIFF picture"},
    {"II+", "a TIFF picture"},
    {"MM", "a TIFF picture"},
    {"BM", "a BMP picture"},
    {"GIF8", "a GIF picture"},
    {"RIFF", "a WebP picture"},
};

// Says what the file is if it is one that is not described.
static bool refuse_undescribed(const char *path) {
    const struct log log = {app_log_file, NULL};
    for (size_t i = 0; i < sizeof not_described / sizeof *not_described; i++) {
        if (!app_info_starts(path, not_described[i].magic)) continue;
        log_fail(log, SATIN_ERROR_INPUT,
                 "%s: it is %s; info describes scenes, OpenEXR images and cache files", path,
                 not_described[i].what);
        return true;
    }
    return false;
}

// ---- The command --------------------------------------------------------------------------------

struct info_request {
    const char *path, *sensor;
    satin_define *define;
    size_t defines;
};

static int read_info_arguments(struct app_args *args, struct info_request *r) {
    char *value;
    for (;;) {
        int flag = app_args_next(args, app_info_flags, NULL, &value);
        if (flag == APP_END) break;
        if (flag == APP_BAD) return APP_WRONG;
        if (flag == INFO_FLAG_HELP) {
            r->path = NULL;
            return app_help(1, (char *[]){"info"});
        }
        if (flag == INFO_FLAG_SENSOR) r->sensor = value;
        satin_define *define = &r->define[r->defines];
        if (flag == INFO_FLAG_DEFINE && !app_args_split(value, &define->name, &define->value))
            return app_wrong("-D needs NAME=VALUE, not '%s'", value);
        r->defines += flag == INFO_FLAG_DEFINE;
        if (flag == APP_POSITIONAL && r->path) return app_wrong("info takes one file");
        if (flag == APP_POSITIONAL) r->path = strcmp(value, "-") == 0 ? APP_STDIN : value;
    }
    return r->path ? APP_DONE : app_wrong("info takes one file: satin info FILE");
}

static satin_status describe_file(const struct info_request *r) {
    if (refuse_undescribed(r->path)) return SATIN_ERROR_INPUT;
    const bool image = starts_as_image(r->path);
    if (image || app_info_starts(r->path, CACHE_FILE_MAGIC)) {
        if (!r->sensor && !r->defines)
            return image ? describe_image(r->path) : app_info_cache(r->path);
        return log_fail((struct log){app_log_file, NULL}, SATIN_ERROR_INPUT,
                        "%s: it is no scene, for which alone --sensor and -D are", r->path);
    }
    const bool stream = strncmp(r->path, "/dev/", 5) == 0;
    const satin_scene_request request = {.defines = r->define,
                                         .define_count = r->defines,
                                         .flags = stream ? SATIN_SCENE_STREAM : 0,
                                         .sensor = r->sensor};
    return app_info_scene(r->path, &request);
}

int app_info(int argc, char **argv) {
    struct app_args args = {.argc = argc, .argv = argv};
    struct info_request r = {.define = calloc((size_t)argc + 1, sizeof *r.define)};
    if (!r.define) return app_no_memory();
    int result = read_info_arguments(&args, &r);
    if (result == APP_DONE && r.path) result = app_exit_of(describe_file(&r));
    free(r.define);
    return result;
}
