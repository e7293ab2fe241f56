// SPDX-License-Identifier: Apache-2.0
// A program may load and render again and again: after renders of every kind, among them those that
// end with an error or are cancelled, no more memory is in use than after the first few.
#include "satin/render.h"

#include <malloc.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

// Renders of each kind, of which the first few may allocate what stays until the program ends:
// libraries, with their threads and buffers.
enum { RENDERS = 45, FIRST_RENDERS = 5 };
// malloc gives out at least 32 bytes: what every render leaves behind is more than this. At most
// 864 bytes more were measured.
enum { ALLOCATED_SLACK = 32 * (RENDERS - FIRST_RENDERS) - 1 };
// Resident memory has the pages of freed blocks that lie between others. At most 36 kB more
// were measured.
enum { RESIDENT_SLACK = 1 << 20 };

static const char *scene_folder, *checkpoint;  // of the command line

// A kind of renders.
struct render_kind {
    const char *name, *scene;
    satin_status status;   // of loading or, if that succeeds, of the render
    const char *cancel;    // the stage that is cancelled, or NULL
    satin_setting set[4];  // ended by a name of NULL
    bool files;            // the render writes records and a checkpoint, and the film is written
};

#define GLOSSY "cornell-glossy.xml"  // with BRDF tables and radiance records
#define CORNER "cases/corner.xml"
#define LAMP "cases/spot-lamp.xml"
static const struct render_kind render_kinds[] = {
    {.name = "two-pass", .scene = GLOSSY, .set = {{"cryptomatte", "both"}, {"record-maps", "on"}}},
    {.name = "two-pass, files", .scene = LAMP, .files = true},
    {.name = "environment", .scene = "furnace-sphere-off.xml"},
    {.name = "caustics", .scene = "caustic.xml"},
    {.name = "indirect bounces",
     .scene = LAMP,
     .set = {{"first-pass", "recursive"}, {"recursive-bounces", "1"}}},
    {.name = "path", .scene = CORNER, .set = {{"integrator", "path"}}},
    {.name = "direct", .scene = CORNER, .set = {{"integrator", "direct"}}},
    {.name = "photons", .scene = LAMP, .set = {{"integrator", "photons"}}},
    {.name = "sppm", .scene = LAMP, .set = {{"integrator", "sppm"}, {"spp", "2"}}},
    {.name = "time limit", .scene = LAMP, .set = {{"time", ".02"}}},
    {.name = "denoised", .scene = LAMP, .set = {{"denoise", "on"}}},
    {.name = "no photons", .scene = CORNER, .status = SATIN_CANCELLED, .cancel = "photons"},
    {.name = "no tables", .scene = GLOSSY, .status = SATIN_CANCELLED, .cancel = "BRDF tables"},
    {.name = "no records",
     .scene = LAMP,
     .status = SATIN_CANCELLED,
     .cancel = "records",
     .files = true},
    {.name = "half an image",
     .scene = CORNER,
     .status = SATIN_CANCELLED,
     .cancel = "image",
     .set = {{"integrator", "path"}, {"spp", "1000000"}}},
    {.name = "no file", .scene = "none.xml", .status = SATIN_ERROR_INPUT},
    {.name = "no scene", .scene = "meshes/vase.ply", .status = SATIN_ERROR_INPUT},
    {.name = "no such layer",
     .scene = CORNER,
     .status = SATIN_ERROR_INPUT,
     .set = {{"layers", "fog"}}},
    {.name = "no such material",
     .scene = CORNER,
     .status = SATIN_ERROR_INPUT,
     .set = {{"material-cache", "fog=on"}}},
};

static void ignore_message(void *user, satin_log_severity severity, const char *message) {
    (void)user, (void)severity, (void)message;
}

static bool cancel_stage(void *user, const satin_progress *now) {
    const struct render_kind *kind = user;
    return kind->cancel && strcmp(now->stage, kind->cancel) == 0;
}

static void ignore_snapshot(void *user, const satin_film *film) { (void)user, (void)film; }

static void write_and_read(const satin_film *film) {
    char image[4096];
    satin_film *back = NULL;
    snprintf(image, sizeof image, "%s.exr", checkpoint);
    assert_int_equal(satin_film_write_exr(film, image, NULL, NULL), SATIN_OK);
    assert_int_equal(satin_film_read(image, NULL, NULL, &back), SATIN_OK);
    satin_film_free(back);
    snprintf(image, sizeof image, "%s.png", checkpoint);
    assert_int_equal(satin_film_write_png(film, image, NULL, NULL, NULL), SATIN_OK);
}

static satin_status render_of_kind(const struct render_kind *kind, const satin_scene *scene) {
    satin_setting set[9] = {{"quality", "draft"},
                            {"width", "8"},
                            {"height", "6"},
                            {"photons", "300"},
                            {"caustic-photons", "500"},
                            {"radiance-order", "2"},
                            {"irradiance-rays", "50"},
                            {"radiance-rays", "50"},
                            {"threads", "2"}};
    satin_options options;
    assert_int_equal(satin_options_resolve(scene, set, 9, NULL, NULL, &options), SATIN_OK);
    for (int i = 0; kind->set[i].name; i++)
        assert_int_equal(
            satin_options_set(&options, kind->set[i].name, kind->set[i].value, NULL, NULL),
            SATIN_OK);
    char cache[4096];
    snprintf(cache, sizeof cache, "%s.cache", checkpoint);
    const satin_callbacks callbacks = {.log = ignore_message,
                                       .progress = cancel_stage,
                                       .progress_user = (void *)(uintptr_t)kind,
                                       .snapshot = ignore_snapshot,
                                       .save_cache = kind->files ? cache : NULL,
                                       .checkpoint = kind->files ? checkpoint : NULL};
    satin_film *film = NULL;
    const satin_status status = satin_render(scene, &options, &callbacks, &film);
    if (film && kind->files) write_and_read(film);
    satin_film_free(film);
    return status;
}

static void render_once(const struct render_kind *kind) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", scene_folder, kind->scene);
    satin_scene *scene = NULL;
    satin_status status = satin_scene_load(path, NULL, 0, NULL, NULL, &scene);
    if (status == SATIN_OK) status = render_of_kind(kind, scene);
    assert_int_equal(status, kind->status);
    satin_scene_free(scene);
}

// Bytes that malloc has given out, of all threads.
static size_t allocated(void) {
    const struct mallinfo2 info = mallinfo2();
    return info.uordblks + info.hblkhd;
}

static size_t resident(void) {
    malloc_trim(0);
    FILE *file = fopen("/proc/self/statm", "r");
    size_t pages = 0;
    assert_non_null(file);
    assert_int_equal(fscanf(file, "%*s %zu", &pages), 1);
    fclose(file);
    return pages * (size_t)sysconf(_SC_PAGESIZE);
}

static void renders_return_their_memory(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof render_kinds / sizeof *render_kinds; i++) {
        for (int k = 0; k < FIRST_RENDERS; k++) render_once(&render_kinds[i]);
        const size_t allocated_first = allocated(), resident_first = resident();
        for (int k = FIRST_RENDERS; k < RENDERS; k++) render_once(&render_kinds[i]);
        const ptrdiff_t more = (ptrdiff_t)(allocated() - allocated_first);
        const ptrdiff_t more_resident = (ptrdiff_t)(resident() - resident_first);
        printf("%-16s %9zu bytes, %+td; %9zu resident, %+td\n", render_kinds[i].name,
               allocated_first, more, resident_first, more_resident);
        assert_true(more <= ALLOCATED_SLACK);
        assert_true(more_resident <= RESIDENT_SLACK);
    }
}

// Begins again with the environment that the test needs, which glibc reads before main. Unless it
// is asked not to, it gives heaps to threads, and counts freed blocks that it keeps for them as
// allocated.
static bool begin_again(char **argv) {
    static const char tunables[] = "glibc.malloc.tcache_count=0:glibc.malloc.arena_max=1";
    const char *before = getenv("GLIBC_TUNABLES");
    if (before && strcmp(before, tunables) == 0) return true;
    setenv("GLIBC_TUNABLES", tunables, 1);
    setenv("SATIN_OIDN", FAKE_OIDN, 0);
    execv("/proc/self/exe", argv);
    return false;
}

// The arguments are a folder of scenes, and the name of a checkpoint; both have defaults.
int main(int argc, char **argv) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(renders_return_their_memory)};
    if (!begin_again(argv)) return 1;
    scene_folder = argc > 1 ? argv[1] : SCENES;
    checkpoint = argc > 2 ? argv[2] : "memory_returns.checkpoint";
    return cmocka_run_group_tests(tests, NULL, NULL);
}
