// SPDX-License-Identifier: Apache-2.0
// Loads a scene: reads the file into a tree, builds shapes, materials, lights and a camera from the
// tree's elements, and then the ray tracing structure and the sampling tables.
#include <ctype.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/fileio.h"
#include "base/text.h"
#include "load/load_state.h"
#include "load/load_warnings.h"

satin_status load_no_memory(struct load_state *loader) {
    return log_fail(loader->log, SATIN_ERROR_MEMORY, "%s: not enough memory for the scene",
                    loader->path);
}

satin_status load_refuse(struct load_state *loader, const struct params *p, const char *why) {
    log_error_at(loader->log, p->node->place, "%s '%s': %s", load_plugin_noun(p->plugin->tag),
                 p->plugin->name, why);
    return SATIN_ERROR_INPUT;
}

const char *load_keep_text(struct load_state *loader, const char *text) {
    return arena_text(&loader->scene->arena, text, strlen(text));
}

satin_status load_params(struct load_state *loader, struct xml_node *node, struct params *out) {
    const struct plugin_spec *plugin = load_plugin_find(loader->log, node);
    if (!plugin) return SATIN_ERROR_INPUT;
    struct param_source source = {loader->log, &loader->xml, &loader->scene->world, loader->lenient,
                                  loader->each};
    const satin_status status = load_params_read(source, plugin, node, out);
    return status == SATIN_OK ? load_pose_apply(loader, out) : status;
}

satin_status load_file_source(struct load_state *loader, const struct param_value *name,
                              struct load_source *out) {
    char *path = load_xml_resolve(&loader->xml, name->place, name->s);
    if (!path) return load_no_memory(loader);
    char *other = load_path_any_case(path);
    if (other) {
        log_warning_at(loader->log, name->place, "'%s' is found as '%s'", name->s, other);
        free(path);
        path = other;
    }
    if (!fileio_files_add(loader->xml.read, path)) {
        free(path);
        return load_no_memory(loader);
    }
    *out = (struct load_source){loader->log, name->place, &loader->scene->arena, path,
                                &loader->scene->world};
    return SATIN_OK;
}

// ---- The elements of <scene> --------------------------------------------------------------------

static const struct plugin_spec scene_spec = {
    .tag = XML_SCENE,
    .name = "scene",
    .children = 1u << XML_SHAPE | 1u << XML_BSDF | 1u << XML_TEXTURE | 1u << XML_EMITTER |
                1u << XML_SENSOR | 1u << XML_INTEGRATOR | 1u << XML_FILM | 1u << XML_SAMPLER |
                1u << XML_RFILTER};

// The index that a text is, in decimal digits without a sign or leading zeros; -1 if it is none.
static int sensor_index(const char *text) {
    const size_t digits = strspn(text, "0123456789");
    if (digits == 0 || digits > 9 || text[digits] || (digits > 1 && text[0] == '0')) return -1;
    return (int)strtol(text, NULL, 10);
}

// The sensor of the scene that is used, or NULL: the first one, or the one of the wanted id, else
// of the wanted index. If the wanted one is missing, logs an error and returns false.
static bool find_sensor(struct load_state *loader, const struct xml_node **out) {
    const char *wanted = loader->sensor;
    struct text_nearest search = {.word = wanted};
    const int index = wanted ? sensor_index(wanted) : 0;
    int count = 0;
    *out = NULL;
    for (const struct xml_node *node = loader->xml.root->child; node; node = node->next) {
        if (node->tag != XML_SENSOR) continue;
        if (wanted && node->id && strcmp(node->id, wanted) == 0) {
            *out = node;
            loader->scene->sensor_index = count;
            return true;
        }
        if (wanted && node->id) text_nearest_try(&search, node->id);
        if (count == index) {
            *out = node;
            loader->scene->sensor_index = count;
        }
        count++;
    }
    // A scene without sensors gets a camera later.
    if (*out || (!count && !wanted)) return true;
    if (!count)
        log_error_at(loader->log, loader->xml.root->place,
                     "the scene has no sensor '%s': it has none", wanted);
    else if (search.best)
        log_error_at(loader->log, loader->xml.root->place,
                     "the scene has no sensor '%s' (did you mean '%s'?)", wanted, search.best);
    else
        log_error_at(loader->log, loader->xml.root->place,
                     "the scene has no sensor '%s'; the index of its last one is %d", wanted,
                     count - 1);
    return false;
}

// Whether satin does not read an object that is not used, which then changes nothing.
static bool left_unread(const struct load_state *loader, const struct xml_node *node) {
    if (!load_plugin_unread(node)) return false;
    log_warning_at(loader->log, node->place, "%s '%s' is not supported; it is not used",
                   load_plugin_noun(node->tag), node->type);
    return true;
}

static satin_status build_sensor(struct load_state *loader, struct xml_node *node,
                                 const struct xml_node *used) {
    if (node == used) return load_sensor(loader, node);
    if (!loader->sensor)
        log_warning_at(loader->log, node->place,
                       "only the first sensor of a scene is used; --sensor chooses another");
    if (left_unread(loader, node)) return SATIN_OK;
    struct params p;
    struct load_spared unused;
    load_spare_unused(loader, &unused);
    satin_status status = load_params(loader, node, &p);
    load_spare_end(loader, &unused, &status);
    return status;
}

static bool same_window(const struct scene_film *a, const struct scene_film *b) {
    return a->width == b->width && a->height == b->height && a->crop_x == b->crop_x &&
           a->crop_y == b->crop_y && a->crop_width == b->crop_width &&
           a->crop_height == b->crop_height;
}

// Reads all sensors. The scene's own camera, film and number of samples are those of `used`.
static satin_status build_all_sensors(struct load_state *loader, const struct xml_node *used) {
    struct satin_scene *scene = loader->scene;
    struct satin_scene own = *scene;
    const int spp = scene->hints.spp;
    size_t count = 0;
    for (struct xml_node *node = loader->xml.root->child; node; node = node->next)
        count += node->tag == XML_SENSOR;
    scene->sensor = arena_array(&scene->arena, count, sizeof *scene->sensor);
    if (!scene->sensor) return load_no_memory(loader);
    for (struct xml_node *node = loader->xml.root->child; node; node = node->next) {
        if (node->tag != XML_SENSOR) continue;
        const struct scene_film before = scene->film;
        scene->hints.spp = spp;
        const satin_status status = load_sensor(loader, node);
        if (status != SATIN_OK) return status;
        if (scene->sensor_count > 0 && !same_window(&before, &scene->film)) {
            log_error_at(loader->log, node->place,
                         "all sensors of an animation must have films of one size and crop");
            return SATIN_ERROR_INPUT;
        }
        scene->sensor[scene->sensor_count++] = scene->camera;
        if (node == used) own = *scene;
    }
    scene->camera = own.camera;
    scene->film = own.film;
    scene->hints.spp = own.hints.spp;
    return SATIN_OK;
}

static bool is_group(const struct xml_node *node) {
    return node->tag == XML_SHAPE && node->type && strcmp(node->type, "shapegroup") == 0;
}

// Builds shapes, lights, camera and integrator. Materials, textures and groups of shapes are built
// when they are referred to.
static satin_status build_objects(struct load_state *loader) {
    const struct xml_node *sensor;
    int32_t light;
    satin_status status = find_sensor(loader, &sensor) ? SATIN_OK : SATIN_ERROR_INPUT;
    for (struct xml_node *node = loader->xml.root->child; node && status == SATIN_OK;
         node = node->next) {
        if (node->tag == XML_SHAPE && !is_group(node)) status = load_shape_add(loader, node);
        if (node->tag == XML_EMITTER) status = load_emitter_add(loader, node, NULL, &light);
        if (node->tag == XML_SENSOR && !loader->all_sensors)
            status = build_sensor(loader, node, sensor);
        if (node->tag == XML_INTEGRATOR) status = load_integrator(loader, node);
    }
    if (status == SATIN_OK) status = load_daylight_default(loader);
    loader->no_sensor = !sensor;
    if (status == SATIN_OK && sensor && loader->all_sensors)
        status = build_all_sensors(loader, sensor);
    return status;
}

static bool refers_to(const struct load_xml *xml, const struct xml_node *node,
                      const struct xml_node *target) {
    for (struct xml_node *child = node->child; child; child = child->next) {
        if (child->tag == XML_REF && load_xml_target(xml, (struct log){0}, child) == target)
            return true;
        if (refers_to(xml, child, target)) return true;
    }
    return false;
}

// Parts of a sensor may stand in <scene> for a <ref> in it, as in Mitsuba; alone they do nothing.
static void report_misplaced(struct load_state *loader) {
    for (struct xml_node *node = loader->xml.root->child; node; node = node->next) {
        const char *home = node->tag == XML_RFILTER ? "<film>" : "<sensor>";
        if (node->tag != XML_FILM && node->tag != XML_SAMPLER && node->tag != XML_RFILTER) continue;
        if (!refers_to(&loader->xml, loader->xml.root, node))
            log_warning_at(loader->log, node->place, "this %s is not used; its place is %s",
                           load_plugin_noun(node->tag), home);
    }
}

// Builds and drops the materials, textures and groups of shapes that nothing refers to, so that
// errors in them are reported, as warnings.
static satin_status check_unused(struct load_state *loader) {
    for (struct xml_node *node = loader->xml.root->child; node; node = node->next) {
        struct material material;
        struct load_spared unused;
        const struct texture *texture;
        satin_status status = SATIN_OK;
        load_spare_unused(loader, &unused);
        if (node->tag == XML_BSDF && !node->material && !left_unread(loader, node))
            status = load_material_build(loader, node, &material);
        if (node->tag == XML_TEXTURE && !node->texture)
            status = load_texture_of(loader, node, &texture);
        if (is_group(node) && !node->group) {
            const size_t shapes = loader->shape_count, groups = loader->group_count;
            status = load_shape_add(loader, node);
            loader->shape_count = shapes;
            loader->group_count = groups;
        }
        load_spare_end(loader, &unused, &status);
        if (status != SATIN_OK) return status;
    }
    return SATIN_OK;
}

// ---- The scene ----------------------------------------------------------------------------------

static void *keep_array(struct load_state *loader, const void *items, size_t count, size_t size) {
    void *copy = arena_array(&loader->scene->arena, count, size);
    if (copy && count) memcpy(copy, items, count * size);
    return copy;
}

// Moves the arrays of the loader to the scene.
static satin_status keep_objects(struct load_state *loader) {
    struct satin_scene *scene = loader->scene;
    if (loader->light_count > INT32_MAX)
        return log_fail(loader->log, SATIN_ERROR_INPUT, "%s: too many lights", loader->path);
    scene->shape = keep_array(loader, loader->shape, loader->shape_count, sizeof *scene->shape);
    scene->material =
        keep_array(loader, loader->material, loader->material_count, sizeof *scene->material);
    scene->light = keep_array(loader, loader->light, loader->light_count, sizeof *scene->light);
    scene->image = keep_array(loader, loader->image, loader->image_count, sizeof *scene->image);
    scene->group = keep_array(loader, loader->group, loader->group_count, sizeof *scene->group);
    if (!scene->shape || !scene->material || !scene->light || !scene->image || !scene->group)
        return load_no_memory(loader);
    scene->image_count = (uint32_t)loader->image_count;
    scene->group_count = (uint32_t)loader->group_count;
    scene->shape_count = (uint32_t)loader->shape_count;
    scene->material_count = (uint32_t)loader->material_count;
    scene->light_count = (uint32_t)loader->light_count;
    return SATIN_OK;
}

// In a polished surface only the paths that follow it show lights, which do not find those without
// an extent: where there is one, surfaces stay as they are.
static void polish_materials(struct satin_scene *scene) {
    for (uint32_t i = 0; i < scene->light_count; i++)
        if (light_is_delta(&scene->light[i])) return;
    for (uint32_t i = 0; i < scene->material_count; i++) scene_material_polish(&scene->material[i]);
}

// Checks that the total power of the lights is finite, because lights are chosen by power.
static satin_status check_power(const struct load_state *loader) {
    float sum = 0.0f;
    for (uint32_t i = 0; i < loader->scene->light_count; i++) sum += loader->scene->light[i].power;
    if (isfinite(sum)) return SATIN_OK;
    return log_fail(loader->log, SATIN_ERROR_INPUT, "%s: the lights' power is too large to count",
                    loader->path);
}

// Continues the hash over an element and its children, without sensors and integrators.
static uint64_t hash_world(uint64_t hash, const struct xml_node *node) {
    if (node->tag == XML_SENSOR || node->tag == XML_INTEGRATOR) return hash;
    const unsigned char head[3] = {(unsigned char)node->tag, node->mitsuba06, node->encoded};
    hash = fileio_hash(hash, head, sizeof head);
    for (const char *const *text = node->attribute; *text; text++)
        hash = fileio_hash(hash, *text, strlen(*text) + 1);
    for (const struct xml_node *child = node->child; child; child = child->next)
        hash = hash_world(hash, child);
    return fileio_hash(hash, ")", 1);
}

static satin_status load_all(struct load_state *loader) {
    struct params p;
    struct param_source source = {loader->log, &loader->xml, &loader->scene->world, loader->lenient,
                                  loader->each};
    satin_status status = load_params_read(source, &scene_spec, loader->xml.root, &p);
    if (status == SATIN_OK) status = build_objects(loader);
    if (status == SATIN_OK) status = check_unused(loader);
    if (status == SATIN_OK) report_misplaced(loader);
    if (status == SATIN_OK) status = load_poses_check(loader);
    if (status == SATIN_OK) status = keep_objects(loader);
    if (status == SATIN_OK) polish_materials(loader->scene);
    if (status == SATIN_OK) status = scene_trace_build(loader->scene, loader->log);
    if (status == SATIN_OK && loader->no_sensor) status = load_sensor_default(loader);
    if (status == SATIN_OK) status = light_prepare(loader->scene, loader->log);
    return status == SATIN_OK ? check_power(loader) : status;
}

satin_status satin_scene_load(const char *path, const satin_define *defines, size_t define_count,
                              satin_log_fn log, void *log_user, satin_scene **scene) {
    return satin_scene_load_with(path, defines, define_count, 0, log, log_user, scene);
}

satin_status satin_scene_load_with(const char *path, const satin_define *defines,
                                   size_t define_count, unsigned flags, satin_log_fn log,
                                   void *log_user, satin_scene **scene) {
    const satin_scene_request request = {
        .defines = defines, .define_count = define_count, .flags = flags};
    return satin_scene_load_request(path, &request, log, log_user, scene);
}

// Appends a text in which all bytes but those of plain words are written as %XX.
static void print_plain(FILE *out, const char *text) {
    for (const unsigned char *at = (const unsigned char *)text; *at; at++)
        fprintf(out, isalnum(*at) || strchr("._-+/", *at) ? "%c" : "%%%02x", *at);
}

// The parameters as one word, for messages: of many, their hash alone.
static satin_status describe_definitions(struct load_state *loader,
                                         const satin_scene_request *request) {
    enum { WORD_MOST = 200 };
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out) return load_no_memory(loader);
    for (size_t i = 0; i < request->define_count; i++) {
        if (i) fputc(',', out);
        print_plain(out, request->defines[i].name);
        fputc('=', out);
        print_plain(out, request->defines[i].value);
    }
    const bool whole = fclose(out) == 0;
    char hash[32];
    snprintf(hash, sizeof hash, "hash-%016" PRIx64, fileio_hash(FILEIO_HASH, text, size));
    const char *word = size == 0 ? "none" : size <= WORD_MOST ? text : hash;
    struct satin_scene *scene = loader->scene;
    scene->definitions = whole ? arena_text(&scene->arena, word, strlen(word)) : NULL;
    free(text);
    return scene->definitions ? SATIN_OK : load_no_memory(loader);
}

// Reads the scene file, and begins the hashes with its bytes.
static satin_status read_scene_file(struct load_state *loader, const satin_scene_request *request) {
    struct satin_scene *scene = loader->scene;
    scene->hash = FILEIO_HASH;
    scene->environment = -1;
    scene->hints = (struct scene_hints){.max_depth = -2, .hide_emitters = -1};
    const satin_status status =
        load_xml_read(loader->log, loader->each, loader->path, request, &scene->hash, &loader->xml);
    // The contents of further files are added to the world's hash when they are read.
    if (status == SATIN_OK)
        scene->world = load_poses_hash(loader, hash_world(FILEIO_HASH, loader->xml.root));
    return status;
}

satin_status satin_scene_load_request(const char *path, const satin_scene_request *request,
                                      satin_log_fn log, void *log_user, satin_scene **scene) {
    const struct stats_span begin = stats_span_begin();
    struct load_warnings warnings = {
        .to = {log, log_user}, .strict = request && (request->flags & SATIN_SCENE_STRICT) != 0};
    struct load_state loader = {
        .log = load_warnings_log(&warnings), .each = load_warnings_each(&warnings), .path = path};
    if (!path || !scene || !request || (request->define_count && !request->defines) ||
        (request->pose_count && !request->poses))
        return log_fail(loader.log, SATIN_ERROR_ARGUMENT, "satin_scene_load: NULL argument");
    loader.scene = calloc(1, sizeof *loader.scene);
    if (!loader.scene) return load_no_memory(&loader);
    loader.lenient = (request->flags & SATIN_SCENE_LENIENT) != 0;
    loader.sensor = request->sensor;
    loader.all_sensors = (request->flags & SATIN_SCENE_ALL_SENSORS) != 0;
    loader.images =
        (struct load_images){.arena = &loader.scene->arena, .memory = (double)request->memory};
    satin_status status = load_poses_begin(&loader, request);
    if (status == SATIN_OK) status = describe_definitions(&loader, request);
    if (status == SATIN_OK) status = read_scene_file(&loader, request);
    if (status == SATIN_OK) {
        status = load_all(&loader);
        const uint64_t world = loader.scene->world;
        loader.scene->hash = fileio_hash(loader.scene->hash, &world, sizeof world);
        const int sensor = loader.scene->sensor_index;
        if (sensor > 0)
            loader.scene->hash = fileio_hash(loader.scene->hash, &sensor, sizeof sensor);
        loader.scene->read = *loader.xml.read;
        *loader.xml.read = (struct fileio_files){0};
    }
    load_images_end(&loader.images, status == SATIN_OK ? warnings.to : (struct log){0},
                    &loader.scene->images);
    load_xml_free(&loader.xml);
    free(loader.shape);
    free(loader.material);
    free(loader.light);
    free(loader.image);
    free(loader.group);
    free(loader.attribute);
    free(loader.pose);
    loader.scene->load_span = stats_span_since(begin);
    load_warnings_report(&warnings);
    if (status == SATIN_OK && warnings.failed) status = SATIN_ERROR_INPUT;
    if (status == SATIN_OK)
        *scene = loader.scene;
    else
        satin_scene_free(loader.scene);
    return status;
}
