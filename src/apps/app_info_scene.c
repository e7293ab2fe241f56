// SPDX-License-Identifier: Apache-2.0
// satin info of a scene: its contents, how its materials are cached, and what will be slow.
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "apps/app.h"
#include "scene/scene.h"
#include "shade/shade.h"

static void print_camera(const struct satin_scene *scene) {
    static const char *const filter[] = {[FILTER_BOX] = "box",
                                         [FILTER_TENT] = "tent",
                                         [FILTER_GAUSSIAN] = "gaussian",
                                         [FILTER_CUBIC] = "cubic",
                                         [FILTER_LANCZOS] = "lanczos"};
    const struct camera *c = &scene->camera;
    const struct scene_film *f = &scene->film;
    vec3 eye = mat4_point(&c->to_world, v3(0, 0, 0));
    vec3 look = v3_unit(mat4_vector(&c->to_world, v3(0, 0, 1)));
    double degrees = 360.0 / (double)PI_F;
    printf("camera     %s at (%g, %g, %g) towards (%.4g, %.4g, %.4g)\n",
           c->orthographic      ? c->aperture > 0.0f ? "telecentric" : "orthographic"
           : c->spherical       ? "spherical"
           : c->aperture > 0.0f ? "thin lens"
                                : "pinhole",
           (double)eye.x, (double)eye.y, (double)eye.z, (double)look.x, (double)look.y,
           (double)look.z);
    vec3 right = mat4_vector(&c->to_world, v3(2.0f * c->tan_x, 0, 0));
    vec3 up = mat4_vector(&c->to_world, v3(0, 2.0f * c->tan_y, 0));
    if (c->orthographic)
        printf("           sees %.4g x %.4g units", (double)v3_len(right), (double)v3_len(up));
    else if (c->spherical)
        printf("           sees all directions");
    else
        printf("           sees %.4g x %.4g degrees", degrees * atan((double)c->tan_x),
               degrees * atan((double)c->tan_y));
    if (c->aperture > 0.0f)
        printf(", lens radius %g, focus at %g",
               (double)v3_len(mat4_vector(&c->to_world, v3(c->aperture, 0, 0))),
               (double)v3_len(mat4_vector(&c->to_world, v3(0, 0, c->focus_distance))));
    printf("\nfilm       %dx%d, %s filter of radius %g", f->width, f->height, filter[f->filter],
           (double)f->radius);
    if (f->crop_width != f->width || f->crop_height != f->height)
        printf(", crop %dx%d at (%d, %d)", f->crop_width, f->crop_height, f->crop_x, f->crop_y);
    printf("\n");
}

static void print_shapes(const struct satin_scene *scene) {
    static const char *const name[] = {
        [SHAPE_MESH] = "mesh",         [SHAPE_SPHERE] = "sphere", [SHAPE_DISK] = "disk",
        [SHAPE_CYLINDER] = "cylinder", [SHAPE_CURVES] = "curves", [SHAPE_INSTANCE] = "instance"};
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

static double megabytes(const struct image *image, int count) {
    double sum = 0.0;
    for (int i = 0; i < count; i++) sum += scene_image_bytes(&image[i]);
    return sum * 1e-6;
}

static void print_textures(const struct satin_scene *scene) {
    enum { SHOWN = 20 };
    if (!scene->texture_count) return;
    double total = 0.0;
    for (uint32_t i = 0; i < scene->image_count; i++)
        total += megabytes(scene->image[i].image, 1) +
                 megabytes(scene->image[i].level, scene->image[i].levels);
    printf("textures   %" PRIu32, scene->texture_count);
    if (scene->image_count)
        printf(", of %" PRIu32 " image%s in %.3g MB", scene->image_count,
               scene->image_count > 1 ? "s" : "", total);
    printf("\n");
    for (uint32_t i = 0; i < scene->image_count && i < SHOWN; i++) {
        const struct image_file *file = &scene->image[i];
        const char *slash = strrchr(file->path, '/');
        printf("  %-24s %dx%d, %d channels\n", slash ? slash + 1 : file->path, file->image->width,
               file->image->height, file->image->channels);
    }
    if (scene->image_count > SHOWN) printf("  and %" PRIu32 " more\n", scene->image_count - SHOWN);
}

// ---- Materials ----------------------------------------------------------------------------------

// State for printing materials, with counts for the advice at the end.
struct materials {
    const struct satin_scene *scene;
    const satin_options *options;
    const struct cache_tables *tables;
    uint32_t sampled, delta, bright;  // numbers of materials whose glossy lobe is sampled, that are
                                      // ideal specular, and that reflect over 80 %
    const struct material_side *front;  // the front of the material, once it was printed
};

static void print_glossy(const struct materials *m, const struct material_side *side) {
    const struct cache_tables *t = m->tables;
    const struct brdf_range *table = side->index < t->count ? t->table[side->index] : NULL;
    if (!table) {
        printf(", gloss by importance sampling");
        return;
    }
    struct brdf_table_info info = brdf_range_describe(table);
    printf(", gloss by radiance records (order %d, error below %g, %.3g %% of directions)",
           info.order, (double)m->options->radiance_error, 100.0 * (double)info.fraction);
}

static void print_side(void *ctx, const struct material_side *side) {
    struct materials *m = ctx;
    if (side->holes) return;
    unsigned lobes = brdf_lobes(&side->base);
    bool cached = side->index < m->tables->count && m->tables->table[side->index];
    if (m->front && m->front->index == side->index) return;  // the back has the same material
    printf("    %s%s", m->front ? "and " : "", side->base.model->name);
    if (lobes & BRDF_DIFFUSE)
        printf(", diffuse by %s",
               m->options->irradiance_cache ? "irradiance records" : "importance sampling");
    if (lobes & BRDF_GLOSSY) print_glossy(m, side);
    if (lobes & BRDF_DELTA) printf(", ideal reflection followed");
    printf(lobes ? "\n" : ", black\n");
    m->sampled += lobes & BRDF_GLOSSY && !cached;
    m->delta += (lobes & BRDF_DELTA) != 0;
    m->bright += rgb_max(side->base.diffuse) > 0.8f;
    m->front = side;
}

static void count_users(const struct satin_scene *scene, uint32_t material, uint32_t *shapes,
                        uint64_t *triangles) {
    *shapes = 0;
    *triangles = 0;
    for (uint32_t i = 0; i < scene->shape_count; i++) {
        const struct shape *shape = &scene->shape[i];
        if (shape->kind == SHAPE_INSTANCE || shape->material != material) continue;
        ++*shapes;
        *triangles += shape->kind == SHAPE_MESH ? shape->mesh.triangle_count : 0;
    }
}

static void print_materials(struct materials *m) {
    enum { SHOWN = 50 };
    const struct satin_scene *scene = m->scene;
    printf("materials  %" PRIu32 "\n", scene->material_count);
    for (uint32_t i = 0; i < scene->material_count; i++) {
        uint64_t triangles;
        uint32_t shapes;
        if (i == SHOWN) {
            printf("  and %" PRIu32 " more\n", scene->material_count - SHOWN);
            break;
        }
        count_users(scene, i, &shapes, &triangles);
        const struct material *material = &scene->material[i];
        printf("  %-24s %s%s, %" PRIu32 " shapes, %" PRIu64 " triangles\n",
               material->name ? material->name : "(no name)",
               material->two_sided ? "two-sided" : "one-sided",
               material->front.holes ? " with holes" : "", shapes, triangles);
        m->front = NULL;
        scene_material_visit(material, print_side, m);
    }
}

// Prints what will take time, and how to reduce it.
static void print_slow(const struct materials *m) {
    const struct satin_scene *scene = m->scene;
    const struct camera *camera = &scene->camera;
    bool any = m->sampled || m->delta || m->bright || scene->light_count > 16 ||
               scene->environment >= 0 || camera->aperture > 0.0f;
    if (!any) return;
    printf("takes time\n");
    if (m->sampled)
        printf("  %" PRIu32
               " glossy lobes are too sharp, or textured, to be cached: each of their "
               "points is gathered\n",
               m->sampled);
    if (m->delta)
        printf("  %" PRIu32 " ideal lobes: caustics cost photons (caustic-photons)\n", m->delta);
    if (m->bright)
        printf("  %" PRIu32 " diffuse lobes reflect over 80 %%: in a closed room paths are long\n",
               m->bright);
    if (scene->light_count > 16)
        printf("  %" PRIu32 " lights: one is chosen for each shadow ray\n", scene->light_count);
    if (scene->environment >= 0)
        printf("  the environment's photons are spread over the whole scene\n");
    if (camera->aperture > 0.0f) printf("  depth of field: blurred regions take samples\n");
}

static void print_lights(const struct satin_scene *scene) {
    static const char *const name[] = {[LIGHT_AREA] = "area",
                                       [LIGHT_POINT] = "point",
                                       [LIGHT_SPOT] = "spot",
                                       [LIGHT_PROJECTOR] = "projector",
                                       [LIGHT_BEAM] = "directionalarea",
                                       [LIGHT_DIRECTIONAL] = "directional",
                                       [LIGHT_CONSTANT] = "constant",
                                       [LIGHT_ENVMAP] = "envmap"};
    enum { SHOWN = 20 };
    double total = 0.0;
    for (uint32_t i = 0; i < scene->light_count; i++) total += (double)scene->light[i].power;
    printf("lights     %" PRIu32 "\n", scene->light_count);
    for (uint32_t i = 0; i < scene->light_count && i < SHOWN; i++) {
        const struct light *light = &scene->light[i];
        printf("  %-2" PRIu32 " %-12s power %.4g W (%.3g %%)\n", i,
               light->sun_chord > 0.0f ? "sunsky" : name[light->kind], (double)light->power,
               total > 0.0 ? 100.0 * (double)light->power / total : 0.0);
    }
    if (scene->light_count > SHOWN) printf("  and %" PRIu32 " more\n", scene->light_count - SHOWN);
}

// Builds the tables that a render would build, as they decide what is cached.
static satin_status describe_materials(const struct satin_scene *scene) {
    satin_options options;
    struct log log = {app_log_file, NULL};
    satin_status status = satin_options_resolve(scene, NULL, 0, log.fn, log.user, &options);
    if (status != SATIN_OK) return status;
    struct parallel *pool = parallel_new(options.threads);
    struct cache_tables tables = {0};
    if (!pool) return log_fail(log, SATIN_ERROR_MEMORY, "threads could not be started");
    status = cache_tables_build(scene, &options, pool, log, &tables);
    if (status == SATIN_OK) {
        struct materials m = {.scene = scene, .options = &options, .tables = &tables};
        print_materials(&m);
        print_lights(scene);
        print_slow(&m);
    }
    cache_tables_free(&tables);
    parallel_free(pool);
    return status;
}

satin_status app_info_scene(const char *path, const satin_scene_request *request) {
    satin_scene *scene = NULL;
    satin_status status = satin_scene_load_request(path, request, app_log_file, NULL, &scene);
    if (status != SATIN_OK) return status;
    printf("scene      %s, hash %016" PRIx64 "\n", path, satin_scene_hash(scene));
    print_camera(scene);
    print_shapes(scene);
    print_textures(scene);
    status = describe_materials(scene);
    const struct scene_hints *hints = &scene->hints;
    if (hints->integrator) printf("integrator %s\n", hints->integrator);
    for (size_t i = 0; i < hints->option_count; i++)
        printf("  %s = %s\n", hints->option[i].name, hints->option[i].value);
    satin_scene_free(scene);
    return status;
}
