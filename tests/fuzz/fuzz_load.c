// SPDX-License-Identifier: Apache-2.0
// Any bytes given as a file that a scene names, from the loader to rays, BRDFs and lights: a scene
// that can be sampled, or one logged error; no crash, no hang, memory in proportion to the input.
// Built once for every kind of file below, which FUZZ_KIND names. Where most of a file is
// redundant, an odd first byte asks for the rest of the bytes to be packed into a whole one.
#include "base/sampling.h"
#include "fuzz_case.h"
#include "light/light.h"

#define NAMED "<string name='filename' value='%s'/>"
#define GLOWS "<bsdf type='roughconductor'/><emitter type='area'/></shape>"
#define COLOURS "type='mesh_attribute'><string name='name' value='vertex_color'/></texture>"

static int pack_merl(const uint8_t *data, size_t size, char path[FUZZ_PATH]);

// The file's name goes into the scene wherever a %s stands.
static const struct kind {
    const char *name, *scene;
    int (*pack)(const uint8_t *data, size_t size, char path[FUZZ_PATH]);
    size_t growth;  // bytes of memory per byte of the file, at most
} fuzz_load_kinds[] = {
    {"linear", "<shape type='linearcurve'>" NAMED "</shape>", NULL, 100},
    {"hair", "<shape type='hair'>" NAMED "</shape>", NULL, 100},
    {"spline", "<shape type='bsplinecurve'>" NAMED "</shape>", NULL, 100},
    {"obj", "<shape type='obj'>" NAMED GLOWS, NULL, 400},
    {"ply", "<shape type='ply'>" NAMED GLOWS, NULL, 400},
    {"serialized", "<shape type='serialized'>" NAMED GLOWS, fuzz_file_packed, 100000},
    {"attribute",
     "<shape type='ply'>" NAMED "<bsdf type='diffuse'><texture name='reflectance' " COLOURS
     "</bsdf><emitter type='area'><texture name='radiance' " COLOURS "</emitter></shape>",
     NULL, 400},
    {"heightfield", "<shape type='heightfield'>" NAMED GLOWS, NULL, 10000000},
    {"merl", "<shape type='sphere'><bsdf type='merl'>" NAMED "</bsdf></shape>", pack_merl, 10},
    {"tabulated", "<shape type='sphere'><bsdf type='tabulated'>" NAMED "</bsdf></shape>", NULL,
     100},
    {"spd",
     "<shape type='sphere'><bsdf type='conductor'><spectrum name='eta' filename='%s'/></bsdf>"
     "</shape><emitter type='point'><spectrum name='intensity' filename='%s'/></emitter>",
     NULL, 100},
    {"bitmap",
     "<emitter type='envmap'>" NAMED "</emitter><shape type='sphere'><bsdf type='diffuse'>"
     "<texture name='reflectance' type='bitmap'>" NAMED "</texture></bsdf></shape>",
     NULL, 10000000},
};

// A whole MERL file whose values repeat the bytes.
static int pack_merl(const uint8_t *data, size_t size, char path[FUZZ_PATH]) {
    enum { BYTES = 12 + 3 * 8 * 90 * 90 * 180 };
    static const int32_t head[3] = {90, 90, 180};
    uint8_t *file = calloc(1, BYTES);
    if (!file) abort();
    memcpy(file, head, sizeof head);
    size_t have = size < BYTES - sizeof head ? size : BYTES - sizeof head;
    if (have) memcpy(file + sizeof head, data, have);
    // Doubled until it is full.
    for (size_t at = sizeof head + have; have && at < BYTES; at += have) {
        have = at - sizeof head < BYTES - at ? at - sizeof head : BYTES - at;
        memcpy(file + at, file + sizeof head, have);
    }
    int fd = fuzz_file(file, BYTES, path);
    free(file);
    return fd;
}

static int write_scene(const char *body, const char *path, char scene_path[FUZZ_PATH]) {
    char text[1024], all[1100];
    snprintf(text, sizeof text, "<scene version='3.0.0'><sensor type='perspective'/>%s</scene>",
             body);
    int size = snprintf(all, sizeof all, text, path, path);
    return fuzz_file(all, (size_t)size, scene_path);
}

// Sums of light may overflow where a file holds the largest numbers.
static bool fuzz_load_counts(rgb c) { return c.r >= 0.0f && c.g >= 0.0f && c.b >= 0.0f; }
static bool sound(rgb c) { return rgb_finite(c) && fuzz_load_counts(c); }

static void use_surface(const satin_scene *scene, const struct interaction *s, vec3 wo,
                        const float *u) {
    struct brdf brdf;
    struct frame frame;
    struct brdf_sample to;
    FUZZ_REQUIRE(v3_finite(s->p) && v3_finite(s->ng) && sound(light_emitted(scene, s, wo)));
    if (!scene_brdf(scene, s, wo, &brdf, &frame)) return;
    vec3 local = frame_to_local(&frame, wo);
    if (brdf_sample_wi(&brdf, local, u[0], (vec2){u[1], u[2]}, BRDF_ALL, BRDF_RADIANCE, &to))
        FUZZ_REQUIRE(v3_finite(to.wi) && sound(to.weight) && to.pdf_w >= 0.0f);
    struct light_sample light;
    float p, of_light = u[3];
    if (!scene->light_count) return;
    uint32_t chosen = light_choose(scene, s->p, LIGHT_ALL_VISIBLE, &of_light, &p);
    FUZZ_REQUIRE(chosen < scene->light_count && p > 0.0f);
    FUZZ_REQUIRE(of_light >= 0.0f && of_light < 1.0f);
    if (light_sample_wi(scene, chosen, s->p, of_light, u[2], &light))
        FUZZ_REQUIRE(v3_finite(light.wi) && sound(light.L) && light.pdf_w > 0.0f);
}

// Rays from outside towards the middle of what was loaded, and light back from it.
static void fuzz_load_use(const satin_scene *scene) {
    vec3 centre = v3_mul(v3_add(scene->bounds_lo, scene->bounds_hi), 0.5f);
    for (uint32_t i = 0; i < 16; i++) {
        float u[4];
        struct interaction s;
        struct light_ray photon;
        sample_sobol4(i, 1, u);
        vec3 d = sample_uniform_sphere(u[0], u[1]);
        struct ray ray = {v3_mad(centre, -2.0f * scene->radius, d), 0.0f, d, INFINITY};
        if (scene_intersect(scene, &ray, &s)) use_surface(scene, &s, v3_neg(d), u);
        FUZZ_REQUIRE(sound(light_environment(scene, d)));
        if (scene->light_count && light_emit(scene, i % scene->light_count, NULL, u, &photon))
            FUZZ_REQUIRE(v3_finite(photon.ray.o) && v3_finite(photon.ray.d) &&
                         fuzz_load_counts(photon.power));
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const struct kind *kind = fuzz_load_kinds;
    while (strcmp(kind->name, FUZZ_KIND) != 0) kind++;
    char path[FUZZ_PATH], scene_path[FUZZ_PATH];
    int file = kind->pack && size && data[0] & 1 ? kind->pack(data + 1, size - 1, path)
                                                 : fuzz_file(data, size, path);
    int text = write_scene(kind->scene, path, scene_path), lines = 0;
    satin_scene *scene = NULL;
    satin_status status = satin_scene_load(scene_path, NULL, 0, fuzz_count, &lines, &scene);
    FUZZ_REQUIRE((status == SATIN_OK) == (scene != NULL) && lines == (status != SATIN_OK));
    FUZZ_REQUIRE(status == SATIN_OK || status == SATIN_ERROR_INPUT);
    if (scene) {
        off_t bytes = lseek(file, 0, SEEK_END);
        FUZZ_REQUIRE(scene->arena.bytes < kind->growth * (size_t)bytes + (1 << 20));
        fuzz_load_use(scene);
    }
    satin_scene_free(scene);
    close(text);
    close(file);
    return 0;
}
