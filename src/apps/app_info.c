// SPDX-License-Identifier: Apache-2.0
// satin info: what a scene or an image holds, in words.
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "apps/app.h"
#include "film/film.h"
#include "scene/scene.h"

enum { FLAG_DEFINE, FLAG_HELP };

const struct app_flag app_info_flags[] = {
    {"--define", "-D", "NAME=VALUE", "Replaces a default of the scene file; may be repeated."},
    {"--help", "-h", NULL, "Prints this."},
    {NULL, NULL, NULL, NULL},
};

// ---- Scenes -------------------------------------------------------------------------------------

static void print_camera(const struct satin_scene *scene) {
    static const char *const filter[] = {
        [FILTER_BOX] = "box", [FILTER_TENT] = "tent", [FILTER_GAUSSIAN] = "gaussian"};
    const struct camera *c = &scene->camera;
    const struct film_spec *f = &scene->film;
    vec3 eye = mat4_point(&c->to_world, v3(0, 0, 0));
    vec3 look = v3_unit(mat4_vector(&c->to_world, v3(0, 0, 1)));
    double degrees = 360.0 / (double)PI_F;
    printf("camera     %s at (%g, %g, %g) towards (%.4g, %.4g, %.4g)\n",
           c->orthographic      ? "orthographic"
           : c->aperture > 0.0f ? "thin lens"
                                : "pinhole",
           (double)eye.x, (double)eye.y, (double)eye.z, (double)look.x, (double)look.y,
           (double)look.z);
    vec3 right = mat4_vector(&c->to_world, v3(2.0f * c->tan_x, 0, 0));
    vec3 up = mat4_vector(&c->to_world, v3(0, 2.0f * c->tan_y, 0));
    if (c->orthographic)
        printf("           sees %.4g x %.4g units", (double)v3_len(right), (double)v3_len(up));
    else
        printf("           sees %.4g x %.4g degrees", degrees * atan((double)c->tan_x),
               degrees * atan((double)c->tan_y));
    if (c->aperture > 0.0f)
        printf(", lens radius %g, focus at %g", (double)c->aperture, (double)c->focus_distance);
    printf("\nfilm       %dx%d, %s filter of radius %g", f->width, f->height, filter[f->filter],
           (double)f->radius);
    if (f->crop_width != f->width || f->crop_height != f->height)
        printf(", crop %dx%d at (%d, %d)", f->crop_width, f->crop_height, f->crop_x, f->crop_y);
    printf("\n");
}

static void print_shapes(const struct satin_scene *scene) {
    static const char *const name[] = {[SHAPE_MESH] = "mesh",
                                       [SHAPE_SPHERE] = "sphere",
                                       [SHAPE_DISK] = "disk",
                                       [SHAPE_CYLINDER] = "cylinder",
                                       [SHAPE_INSTANCE] = "instance"};
    enum { KINDS = sizeof name / sizeof *name };
    uint32_t count[KINDS] = {0};
    for (uint32_t i = 0; i < scene->shape_count; i++) count[scene->shape[i].kind]++;
    printf("shapes     %" PRIu32, scene->shape_count);
    for (int k = 0; k < KINDS; k++)
        if (count[k]) printf(", %s %" PRIu32, name[k], count[k]);
    printf("; %" PRIu64 " triangles\n", scene->triangle_count);
    if (scene->shape_count)
        printf("bounds     (%g, %g, %g) to (%g, %g, %g)\n", (double)scene->bounds_lo.x,
               (double)scene->bounds_lo.y, (double)scene->bounds_lo.z, (double)scene->bounds_hi.x,
               (double)scene->bounds_hi.y, (double)scene->bounds_hi.z);
}

static void print_materials(const struct satin_scene *scene) {
    printf("materials  %" PRIu32 "\n", scene->material_count);
    for (uint32_t m = 0; m < scene->material_count; m++) {
        uint64_t triangles = 0;
        uint32_t shapes = 0;
        for (uint32_t i = 0; i < scene->shape_count; i++) {
            const struct shape *shape = &scene->shape[i];
            if (shape->material != m) continue;
            shapes++;
            triangles += shape->kind == SHAPE_MESH ? shape->mesh.triangle_count : 0;
        }
        printf("  %-24s %s, %" PRIu32 " shapes, %" PRIu64 " triangles\n",
               scene->material[m].name ? scene->material[m].name : "(no name)",
               scene->material[m].two_sided ? "two-sided" : "one-sided", shapes, triangles);
    }
}

static void print_lights(const struct satin_scene *scene) {
    static const char *const name[] = {[LIGHT_AREA] = "area",
                                       [LIGHT_POINT] = "point",
                                       [LIGHT_SPOT] = "spot",
                                       [LIGHT_PROJECTOR] = "projector",
                                       [LIGHT_DIRECTIONAL] = "directional",
                                       [LIGHT_CONSTANT] = "constant",
                                       [LIGHT_ENVMAP] = "envmap"};
    enum { SHOWN = 20 };
    double total = 0.0;
    for (uint32_t i = 0; i < scene->light_count; i++) total += (double)scene->light[i].power;
    printf("lights     %" PRIu32 "\n", scene->light_count);
    for (uint32_t i = 0; i < scene->light_count && i < SHOWN; i++) {
        const struct light *light = &scene->light[i];
        printf("  %-12s power %.4g W (%.3g %%)\n", name[light->kind], (double)light->power,
               total > 0.0 ? 100.0 * (double)light->power / total : 0.0);
    }
    if (scene->light_count > SHOWN) printf("  and %" PRIu32 " more\n", scene->light_count - SHOWN);
}

static satin_status describe_scene(const char *path, const satin_define *define, size_t count) {
    satin_scene *scene = NULL;
    satin_status status = satin_scene_load(path, define, count, app_log_file, NULL, &scene);
    if (status != SATIN_OK) return status;
    printf("scene      %s, hash %016" PRIx64 "\n", path, satin_scene_hash(scene));
    print_camera(scene);
    print_shapes(scene);
    print_materials(scene);
    print_lights(scene);
    const struct scene_hints *hints = &scene->hints;
    if (hints->integrator) printf("integrator %s\n", hints->integrator);
    for (size_t i = 0; i < hints->option_count; i++)
        printf("  %s = %s\n", hints->option[i].name, hints->option[i].value);
    satin_scene_free(scene);
    return SATIN_OK;
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
    printf("image      %s, %dx%d\n", path, film->width, film->height);
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
    static const unsigned char magic[4] = {0x76, 0x2f, 0x31, 0x01};
    unsigned char head[4];
    size_t length = strlen(path);
    // The name decides for a file that cannot be an image by its content, so that the message fits.
    if (length > 4 && strcmp(path + length - 4, ".exr") == 0) return true;
    if (length > 4 && strcmp(path + length - 4, ".xml") == 0) return false;
    FILE *file = fopen(path, "rb");
    bool same = file && fread(head, 1, 4, file) == 4 && memcmp(head, magic, 4) == 0;
    if (file) fclose(file);
    return same;
}

// ---- The command --------------------------------------------------------------------------------

static int read_arguments(struct app_args *args, satin_define *define, size_t *defines,
                          const char **path) {
    char *value;
    for (;;) {
        int flag = app_args_next(args, app_info_flags, "", &value);
        if (flag == APP_END) break;
        if (flag == APP_BAD) return APP_WRONG;
        if (flag == FLAG_HELP) {
            *path = NULL;
            return app_help(1, (char *[]){"info"});
        }
        if (flag == FLAG_DEFINE &&
            !app_args_split(value, &define[*defines].name, &define[*defines].value))
            return app_wrong("-D needs NAME=VALUE, not '%s'", value);
        *defines += flag == FLAG_DEFINE;
        if (flag == APP_POSITIONAL && *path) return app_wrong("info takes one file");
        if (flag == APP_POSITIONAL) *path = value;
    }
    return *path ? APP_DONE : app_wrong("info takes one file: satin info FILE");
}

int app_info(int argc, char **argv) {
    struct app_args args = {.argc = argc, .argv = argv};
    satin_define *define = calloc((size_t)argc + 1, sizeof *define);
    size_t defines = 0;
    const char *path = NULL;
    if (!define) return APP_FAILED;
    int result = read_arguments(&args, define, &defines, &path);
    if (result == APP_DONE && path) {
        if (starts_as_image(path))
            result = app_exit_of(describe_image(path));
        else
            result = app_exit_of(describe_scene(path, define, defines));
    }
    free(define);
    return result;
}
