// SPDX-License-Identifier: Apache-2.0
// The cost of loading. Writes a PLY of TRIANGLES (10 million) and loads it as a scene; beside it,
// the file's bytes are read plainly and Embree builds over the same mesh from memory. Then 1,000
// instances of a million triangles: their memory over that of one.
//
//     bench_load [FOLDER [TRIANGLES]]
//
// Wall-clock and processor seconds, the least of ROUNDS, alternating; resident memory from
// /proc/self/statm in a child of its own.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "base/array.h"
#include "base/fileio.h"
#include "bench_embree.h"
#include "scene/scene.h"

enum { ROUNDS = 3, INSTANCES = 1000 };

struct cpu_seconds {
    double wall, cpu;
};

static double clock_read(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static struct cpu_seconds now(void) {
    return (struct cpu_seconds){clock_read(CLOCK_MONOTONIC), clock_read(CLOCK_PROCESS_CPUTIME_ID)};
}

static void take_least(struct cpu_seconds start, struct cpu_seconds *least) {
    struct cpu_seconds end = now();
    least->wall = fmin(least->wall, end.wall - start.wall);
    least->cpu = fmin(least->cpu, end.cpu - start.cpu);
}

// A wavy sheet of side x side quads.
struct sheet {
    uint32_t side, vertices, triangles;
    float *position;
    uint32_t *index;
};

static struct sheet sheet_make(uint32_t triangles) {
    struct sheet s = {.side = (uint32_t)sqrt(triangles / 2.0)};
    s.vertices = (s.side + 1) * (s.side + 1);
    s.triangles = 2 * s.side * s.side;
    s.position = array_new((size_t)s.vertices * 3 + 1, sizeof *s.position);
    s.index = array_new((size_t)s.triangles * 3, sizeof *s.index);
    if (!s.position || !s.index) exit(1);
    for (uint32_t i = 0; i < s.vertices; i++) {
        float x = (float)(i % (s.side + 1)) / (float)s.side;
        float y = (float)(i / (s.side + 1)) / (float)s.side;
        const float p[3] = {x, y, 0.02f * sinf(40.0f * x) * cosf(50.0f * y)};
        memcpy(s.position + (size_t)i * 3, p, sizeof p);
    }
    for (uint32_t i = 0; i < s.side * s.side; i++) {
        uint32_t a = i / s.side * (s.side + 1) + i % s.side, b = a + s.side + 1;
        const uint32_t quad[6] = {a, a + 1, b, b, a + 1, b + 1};
        memcpy(s.index + (size_t)i * 6, quad, sizeof quad);
    }
    return s;
}

static void sheet_free(struct sheet *s) {
    free(s->position);
    free(s->index);
}

static void sheet_write(const struct sheet *s, const char *path) {
    FILE *file = fopen(path, "wb");
    if (!file) exit(1);
    fprintf(file,
            "ply\nformat binary_little_endian 1.0\nelement vertex %u\nproperty float x\n"
            "property float y\nproperty float z\nelement face %u\n"
            "property list uchar int vertex_indices\nend_header\n",
            s->vertices, s->triangles);
    fwrite(s->position, 12, s->vertices, file);
    for (uint32_t i = 0; i < s->triangles; i++) {
        fputc(3, file);
        fwrite(s->index + (size_t)i * 3, 12, 1, file);
    }
    if (fclose(file) != 0) exit(1);
}

static void text_write(const char *path, const char *text) {
    if (fileio_write((struct log){0}, path, text, strlen(text)) != SATIN_OK) exit(1);
}

// Loads a scene and returns the growth of resident memory [MB].
static double load_once(const char *path) {
    satin_scene *scene = NULL;
    if (satin_scene_load(path, NULL, 0, NULL, NULL, &scene) != SATIN_OK) exit(1);
    long pages = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    if (!file || fscanf(file, "%*s %ld", &pages) != 1) exit(1);
    fclose(file);
    satin_scene_free(scene);
    return (double)pages * (double)sysconf(_SC_PAGESIZE) * 1e-6;
}

// Loads in a child process, whose memory is empty at first.
static double load_apart(const char *path) {
    int ends[2];
    double size = 0.0;
    if (pipe(ends) != 0) exit(1);
    pid_t child = fork();
    if (child == 0) {
        size = load_once(path);
        _exit(write(ends[1], &size, sizeof size) == sizeof size ? 0 : 1);
    }
    int status;
    if (child < 0 || waitpid(child, &status, 0) != child || status != 0) exit(1);
    if (read(ends[0], &size, sizeof size) != sizeof size) exit(1);
    close(ends[0]);
    close(ends[1]);
    return size;
}

static void build_bare(const struct sheet *s) {
    RTCDevice device = rtcNewDevice(NULL);
    const struct bare_mesh mesh = {s->position, s->index, s->vertices, s->triangles};
    rtcReleaseScene(bare_build(device, &mesh));
    rtcReleaseDevice(device);
}

#define HEAD "<scene version=\"3.0.0\"><sensor type=\"perspective\"/>"
#define MESH "<shape type=\"ply\"><string name=\"filename\" value=\"bench_load.ply\"/></shape>"

static void compare_times(uint32_t triangles) {
    struct sheet s = sheet_make(triangles);
    sheet_write(&s, "bench_load.ply");
    text_write("bench_load.xml", HEAD MESH "</scene>");
    struct cpu_seconds bytes = {INFINITY, INFINITY}, bare = bytes, whole = bytes;
    for (int round = 0; round < ROUNDS; round++) {
        char *data;
        size_t size;
        struct cpu_seconds start = now();
        if (fileio_read((struct log){0}, (struct log_place){0}, "bench_load.ply", (size_t)1 << 40,
                        &data, &size) != SATIN_OK)
            exit(1);
        take_least(start, &bytes);
        free(data);
        start = now();
        build_bare(&s);
        take_least(start, &bare);
        start = now();
        load_once("bench_load.xml");
        take_least(start, &whole);
    }
    printf("%u triangles       wall    processor [s]\n", s.triangles);
    printf("reading the bytes   %7.3f %7.3f\n", bytes.wall, bytes.cpu);
    printf("Embree's build      %7.3f %7.3f\n", bare.wall, bare.cpu);
    printf("satin_scene_load    %7.3f %7.3f\n", whole.wall, whole.cpu);
    printf("ratio               %7.3f %7.3f\n", whole.wall / (bytes.wall + bare.wall),
           whole.cpu / (bytes.cpu + bare.cpu));
    sheet_free(&s);
}

static void compare_memory(uint32_t triangles) {
    struct sheet s = sheet_make(triangles);
    sheet_write(&s, "bench_load.ply");
    char *text = array_new(INSTANCES + 2, 256);
    if (!text) exit(1);
    char *at = text + sprintf(text, HEAD "<shape type=\"shapegroup\" id=\"g\">" MESH "</shape>");
    for (int i = 0; i < INSTANCES; i++)
        at += sprintf(at,
                      "<shape type=\"instance\"><ref id=\"g\"/><transform name=\"to_world\">"
                      "<rotate z=\"1\" angle=\"%d\"/><translate z=\"%d\"/></transform></shape>\n",
                      i, i);
    strcpy(at, "</scene>");
    text_write("bench_load.xml", HEAD MESH "</scene>");
    double one = load_apart("bench_load.xml");
    text_write("bench_load.xml", text);
    double many = load_apart("bench_load.xml");
    printf("%u triangles once %.1f MB, %d times %.1f MB: ratio %.3f\n", s.triangles, one, INSTANCES,
           many, many / one);
    free(text);
    sheet_free(&s);
}

int main(int argc, char **argv) {
    if (argc > 1 && chdir(argv[1]) != 0) return 1;
    uint32_t triangles = argc > 2 ? (uint32_t)atoi(argv[2]) : 10000000;
    compare_memory(triangles / 10);
    compare_times(triangles);
    unlink("bench_load.ply");
    unlink("bench_load.xml");
    return 0;
}
