// SPDX-License-Identifier: Apache-2.0
// Images through both readers: values of several formats, linearised or raw, and wrong files.
#include <png.h>
#include <sys/stat.h>

#include "base/process.h"
#include "film/film.h"
#include "mesh_case.h"

struct image_case {
    struct scene_case log;
    struct arena arena;
    uint64_t hash;
};

static satin_status load_image_load(struct image_case *c, const char *path, bool raw,
                                    struct image **image) {
    *c = (struct image_case){.hash = 1};
    struct load_source source = {
        scene_case_begin(&c->log), {"scene.xml", 3, 7}, &c->arena, path, &c->hash};
    struct load_images images = {.arena = &c->arena};
    return load_image(&source, &images, raw, image);
}

static float decoded(double x) {
    return (float)(x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4));
}

static void write_png(const char *path, png_uint_32 format, const void *pixel) {
    png_image png = {.version = PNG_IMAGE_VERSION, .width = 3, .height = 2, .format = format};
    assert_true(png_image_write_to_file(&png, path, 0, pixel, 0, NULL));
}

// Colours of one channel, and alpha, which a transparent colour of a PNG is too.
static void one_channel_is_read(void **state) {
    (void)state;
    static const unsigned char pixel[24] = {0,   10, 20, 255, 60, 128, 200, 0, 255, 254, 253, 9,
                                            100, 90, 80, 128, 70, 60,  50,  1, 40,  30,  20,  0};
    static const unsigned char grey[12] = {0, 255, 50, 7, 100, 0, 150, 1, 200, 2, 255, 3};
    write_png("rgba.png", PNG_FORMAT_RGBA, pixel);
    write_png("ga.png", PNG_FORMAT_GA, grey);
    write_png("opaque.png", PNG_FORMAT_RGB, pixel);
    for (int channel = 0; channel <= LOAD_IMAGE_ALPHA; channel++) {
        const bool alpha = channel == LOAD_IMAGE_ALPHA;
        for (int k = 0; k < 2; k++) {
            struct image_case c = {.hash = 1};
            struct load_source source = {scene_case_begin(&c.log),
                                         {"scene.xml", 3, 7},
                                         &c.arena,
                                         k ? "ga.png" : "rgba.png",
                                         &c.hash};
            struct load_images images = {.arena = &c.arena};
            struct image *image;
            assert_int_equal(load_image_texture(&source, &images, false, channel, &image),
                             SATIN_OK);
            assert_true(image->width == 3 && image->height == 2 && image->channels == 1);
            for (int i = 0; i < 6; i++) {
                const double x = (k ? grey[2 * i + alpha] : pixel[4 * i + channel]) / 255.0;
                assert_float_equal(scene_image_value(image, i), alpha ? (float)x : decoded(x),
                                   1e-6f);
            }
            arena_free(&c.arena);
        }
    }
    struct image_case c = {.hash = 1};
    struct load_source source = {
        scene_case_begin(&c.log), {"scene.xml", 3, 7}, &c.arena, "opaque.png", &c.hash};
    struct load_images images = {.arena = &c.arena};
    struct image *image;
    assert_int_equal(load_image_texture(&source, &images, false, LOAD_IMAGE_ALPHA, &image),
                     SATIN_ERROR_INPUT);
    assert_string_equal(c.log.error,
                        "scene.xml:3:7: cannot read image 'opaque.png': it has no alpha channel");
    arena_free(&c.arena);
}

// What is kept is one channel, and all colours are in memory while it is read.
static void one_channel_takes_its_memory(void **state) {
    (void)state;
    enum { SIDE = 256, PIXELS = SIDE * SIDE };
    png_image png = {
        .version = PNG_IMAGE_VERSION, .width = SIDE, .height = SIDE, .format = PNG_FORMAT_RGBA};
    unsigned char *pixel = calloc(PIXELS, 4);
    assert_non_null(pixel);
    assert_true(png_image_write_to_file(&png, "black.png", 0, pixel, 0, NULL));
    free(pixel);
    struct image_case c = {.hash = 1};
    struct load_source source = {
        scene_case_begin(&c.log), {"scene.xml", 3, 7}, &c.arena, "black.png", &c.hash};
    struct load_images images = {.arena = &c.arena};
    struct image *image;
    assert_int_equal(load_image_texture(&source, &images, false, 1, &image), SATIN_OK);
    assert_true(c.arena.bytes >= PIXELS && c.arena.bytes < 1.1 * PIXELS);
    const double kept = (1.0 + sizeof(float) / 3.0) * PIXELS;  // with the smaller copies
    assert_float_equal(images.asked, kept, 1.0);
    assert_in_range(images.needed, kept + 3.0 * PIXELS, kept + 3.1 * PIXELS);
    arena_free(&c.arena);
}

static void bytes_become_linear(void **state) {
    (void)state;
    // Transparent pixels keep their colour; alpha is dropped.
    static const unsigned char pixel[24] = {0,   10, 20, 255, 60, 128, 200, 0, 255, 254, 253, 9,
                                            100, 90, 80, 128, 70, 60,  50,  1, 40,  30,  20,  0};
    write_png("rgba.png", PNG_FORMAT_RGBA, pixel);
    for (int raw = 0; raw < 2; raw++) {
        struct image_case c;
        struct image *image;
        assert_int_equal(load_image_load(&c, "rgba.png", raw, &image), SATIN_OK);
        assert_true(image->width == 3 && image->height == 2 && image->channels == 3);
        for (int i = 0; i < 18; i++) {
            double x = pixel[i / 3 * 4 + i % 3] / 255.0;
            assert_float_equal(scene_image_value(image, i), raw ? (float)x : decoded(x), 1e-6f);
        }
        assert_true(c.hash != 1);
        arena_free(&c.arena);
    }
    static const unsigned char grey[6] = {0, 50, 100, 150, 200, 255};
    write_png("grey.png", PNG_FORMAT_GRAY, grey);
    struct image_case c;
    struct image *image;
    assert_int_equal(load_image_load(&c, "grey.png", false, &image), SATIN_OK);
    assert_int_equal(image->channels, 1);
    for (int i = 0; i < 6; i++)
        assert_float_equal(scene_image_value(image, i), decoded(grey[i] / 255.0), 1e-6f);
    arena_free(&c.arena);
}

// The texels of a texture of 8 bits stay bytes, with the values and the smaller copies that floats
// have.
static void textures_keep_bytes(void **state) {
    (void)state;
    static const unsigned char pixel[18] = {0,   10, 20, 60, 128, 200, 255, 254, 253,
                                            100, 90, 80, 70, 60,  50,  40,  30,  20};
    write_png("rgb.png", PNG_FORMAT_RGB, pixel);
    for (int raw = 0; raw < 2; raw++) {
        struct image_case c;
        struct image *floats, *bytes, *of_floats, *of_bytes;
        int levels[2];
        assert_int_equal(load_image_load(&c, "rgb.png", raw, &floats), SATIN_OK);
        struct load_source source = {
            scene_case_begin(&c.log), {"scene.xml", 3, 7}, &c.arena, "rgb.png", &c.hash};
        struct load_images images = {.arena = &c.arena};
        assert_int_equal(load_image_texture(&source, &images, raw, LOAD_IMAGE_ALL, &bytes),
                         SATIN_OK);
        assert_true(floats->texel && !floats->byte && bytes->byte && !bytes->texel);
        assert_true(scene_image_bytes(floats) == 72 && scene_image_bytes(bytes) == 18);
        for (int i = 0; i < 18; i++) {
            assert_int_equal(bytes->byte[i], pixel[i]);
            assert_true(scene_image_value(bytes, i) == floats->texel[i]);
        }
        assert_true(load_image_levels(&c.arena, floats, &of_floats, &levels[0]));
        assert_true(load_image_levels(&c.arena, bytes, &of_bytes, &levels[1]));
        assert_true(levels[0] == 1 && levels[1] == 1);
        assert_memory_equal(of_floats->texel, of_bytes->texel, 3 * sizeof(float));
        arena_free(&c.arena);
    }
}

static void floats_must_be_possible_for_light(void **state) {
    (void)state;
    // A PFM file has its rows from the bottom, little-endian.
    char file[64];
    size_t header = (size_t)sprintf(file, "PF\n1 2\n-1\n");
    const float texel[6] = {0.5f, NAN, 7.0f, -1.0f, INFINITY, 0.25f};
    memcpy(file + header, texel, sizeof texel);
    scene_case_bytes("a.pfm", file, header + sizeof texel);
    struct image_case c;
    struct image *image;
    assert_int_equal(load_image_load(&c, "a.pfm", false, &image), SATIN_OK);
    const float expected[6] = {0.0f, 0.0f, 0.25f, 0.5f, 0.0f, 7.0f};
    for (int i = 0; i < 6; i++) assert_float_equal(scene_image_value(image, i), expected[i], 0.0f);
    assert_int_equal(c.log.warnings, 1);
    assert_string_equal(c.log.warning,
                        "a.pfm: 3 values are negative, not finite or over 1e+25 and count as 0");
    arena_free(&c.arena);
}

// Colours, luminance and alpha of an OpenEXR file, in the order of an image, whatever else is in
// it.
static void exr_files_need_no_module(void **state) {
    (void)state;
    static const char *const names[] = {"Z", "glossy.R", "B", "A", "R", "G"};
    static const char *const grey[] = {"Y"};
    enum { CHANNELS = 6, WIDTH = 7, HEIGHT = 40 };  // chunks of 16 rows
    struct scene_case log;
    satin_film *film = film_new(WIDTH, HEIGHT, names, CHANNELS),
               *single = film_new(WIDTH, HEIGHT, grey, 1);
    assert_true(film && single);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        for (int c = 0; c < CHANNELS; c++) film->channel[c][i] = (float)(1000 * c + i);
        single->channel[0][i] = (float)i;
    }
    const struct log to = scene_case_begin(&log);
    assert_int_equal(satin_film_write_exr(film, "a.exr", to.fn, to.user), SATIN_OK);
    assert_int_equal(satin_film_write_exr(single, "grey.exr", to.fn, to.user), SATIN_OK);
    satin_film_free(film);
    satin_film_free(single);
    struct image_case c = {.hash = 1};
    struct load_source source = {
        scene_case_begin(&c.log), {"scene.xml", 3, 7}, &c.arena, "a.exr", &c.hash};
    struct load_images images = {.arena = &c.arena};
    struct image *image, *alpha, *luminance;
    assert_int_equal(load_image(&source, &images, false, &image), SATIN_OK);
    assert_int_equal(load_image_texture(&source, &images, false, LOAD_IMAGE_ALPHA, &alpha),
                     SATIN_OK);
    source.path = "grey.exr";
    assert_int_equal(load_image(&source, &images, false, &luminance), SATIN_OK);
    assert_false(images.module);
    assert_true(image->width == WIDTH && image->height == HEIGHT && image->channels == 3);
    assert_true(alpha->channels == 1 && luminance->channels == 1);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        static const int of_color[3] = {4, 5, 2};
        for (int k = 0; k < 3; k++)
            assert_float_equal(scene_image_value(image, 3 * i + k), (float)(1000 * of_color[k] + i),
                               0.0f);
        assert_float_equal(alpha->texel[i], (float)(3000 + i), 0.0f);
        assert_float_equal(luminance->texel[i], (float)i, 0.0f);
    }
    arena_free(&c.arena);
}

// Half floats of four channels, which the library's own way of interleaving mixes up.
static void alpha_of_half_floats_is_read(void **state) {
    (void)state;
    static const char *const names[] = {"A", "B", "G", "R"};
    enum { CHANNELS = 4, WIDTH = 5, HEIGHT = 20 };
    struct scene_case log;
    satin_film *film = film_new(WIDTH, HEIGHT, names, CHANNELS);
    assert_non_null(film);
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        for (int c = 0; c < CHANNELS; c++)
            film->channel[c][i] = (float)(c + 1) / 8.0f + (float)i / 1024.0f;
    const struct log to = scene_case_begin(&log);
    const satin_exr_format format = {0};
    assert_true(film_is_half(film, &format, "A") && film_is_half(film, &format, "R"));
    assert_int_equal(satin_film_write_exr(film, "half.exr", to.fn, to.user), SATIN_OK);
    struct image_case c = {.hash = 1};
    struct load_source source = {
        scene_case_begin(&c.log), {"scene.xml", 3, 7}, &c.arena, "half.exr", &c.hash};
    struct load_images images = {.arena = &c.arena};
    struct image *image, *alpha;
    assert_int_equal(load_image(&source, &images, false, &image), SATIN_OK);
    assert_int_equal(load_image_texture(&source, &images, false, LOAD_IMAGE_ALPHA, &alpha),
                     SATIN_OK);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        assert_true(alpha->texel[i] == film->channel[0][i]);
        for (int k = 0; k < 3; k++) assert_true(image->texel[3 * i + k] == film->channel[3 - k][i]);
    }
    satin_film_free(film);
    arena_free(&c.arena);
}

static void load_image_refuse(const char *path, const char *message) {
    struct image_case c;
    struct image *image = NULL;
    assert_int_equal(load_image_load(&c, path, false, &image), SATIN_ERROR_INPUT);
    assert_null(image);
    assert_int_equal(c.log.errors, 1);
    if (strncmp(c.log.error, message, strlen(message)) != 0)
        assert_string_equal(c.log.error, message);
    arena_free(&c.arena);
}

// Writes the first bytes of a file to another.
static void cut_file(const char *path, size_t size, const char *to) {
    char *bytes = malloc(size);
    FILE *file = fopen(path, "rb");
    assert_true(bytes && file);
    assert_int_equal(fread(bytes, 1, size, file), size);
    fclose(file);
    scene_case_bytes(to, bytes, size);
    free(bytes);
}

static void damaged_exr_files_are_refused(void **state) {
    (void)state;
    static const char *const names[] = {"R", "G", "B"};
    struct scene_case log;
    satin_film *film = film_new(64, 64, names, 3);
    assert_non_null(film);
    const struct log to = scene_case_begin(&log);
    assert_int_equal(satin_film_write_exr(film, "whole.exr", to.fn, to.user), SATIN_OK);
    satin_film_free(film);
    struct stat whole;
    assert_int_equal(stat("whole.exr", &whole), 0);
    cut_file("whole.exr", (size_t)whole.st_size - 8, "short.exr");
    load_image_refuse("short.exr", "scene.xml:3:7: cannot read image 'short.exr': invalid pixels");
    cut_file("whole.exr", 40, "header.exr");
    load_image_refuse("header.exr",
                      "scene.xml:3:7: cannot read image 'header.exr': invalid OpenEXR header");
}

static void wrong_image_files_are_refused(void **state) {
    (void)state;
    load_image_refuse("missing.png", "scene.xml:3:7: cannot read 'missing.png'");
    load_image_refuse(".", "scene.xml:3:7: cannot read '.'");
    scene_case_file("empty.png", "");
    load_image_refuse("empty.png", "scene.xml:3:7: cannot read image 'empty.png'");
    scene_case_file("text.png", "this is no image");
    load_image_refuse("text.png", "scene.xml:3:7: cannot read image 'text.png'");
    scene_case_file("huge.pfm", "PF\n100000 100000\n-1\n");
    load_image_refuse("huge.pfm", "scene.xml:3:7: image 'huge.pfm' is too large: 100000 x 100000");
    scene_case_file("long.pfm", "PF\n9000 9000\n-1\n");
    load_image_refuse("long.pfm",
                      "scene.xml:3:7: image 'long.pfm' is cut short: 9000 x 9000 in 16 bytes");
    scene_case_file("short.pfm", "PF\n100 100\n-1\n");
    load_image_refuse("short.pfm", "scene.xml:3:7: cannot read image 'short.pfm'");
    static const unsigned char grey[6] = {0};
    char png[256];
    write_png("a.png", PNG_FORMAT_GRAY, grey);
    FILE *file = fopen("a.png", "rb");
    size_t size = fread(png, 1, sizeof png, file);
    fclose(file);
    scene_case_bytes("short.png", png, size / 2);
    load_image_refuse(
        "short.png",
        "scene.xml:3:7: cannot read image 'short.png': the PNG is damaged: the file is cut short");
    png[size - 20] ^= 1;
    scene_case_bytes("wrong.png", png, size);
    load_image_refuse("wrong.png",
                      "scene.xml:3:7: cannot read image 'wrong.png': the PNG is damaged: IDAT");
}

// An image of random texels, alone in the arena.
static struct image *random_image(struct arena *arena, int width, int height, int channels) {
    const size_t count = (size_t)width * (size_t)height * (size_t)channels;
    float *texel = arena_array_alone(arena, count, sizeof *texel);
    struct image *image = arena_alloc(arena, sizeof *image);
    assert_true(texel && image);
    struct rng rng = rng_make(1, RNG_TEST, (uint64_t)count);
    for (size_t i = 0; i < count; i++) texel[i] = rng_float(&rng);
    *image = scene_image_make(width, height, channels, texel);
    return image;
}

static double texel_mean(const struct image *image) {
    const size_t count = (size_t)image->width * (size_t)image->height * (size_t)image->channels;
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) sum += (double)scene_image_value(image, i);
    return sum / (double)count;
}

static float wide_lookup(const struct image *image, const struct image *level, int levels) {
    struct texture texture = {.kind = TEXTURE_BITMAP,
                              .to_uv = {1, 0, 0, 0, 1, 0},
                              .image = image,
                              .level = level,
                              .levels = levels,
                              .filtered = true,
                              .unit = 1.0f};
    struct texture_lookup at = scene_texture_at((vec2){0.3f, 0.6f});
    at.width = 0.1f;
    return scene_texture_eval(&texture, &at).r;
}

// The largest images become coarser until all fit: their means stay, and so do lookups that are
// wider than their texels.
static void images_become_coarser(void **state) {
    (void)state;
    struct scene_case log;
    const struct log to = scene_case_begin(&log);
    struct arena arena = {0};
    // What is left is half of 20 kB; the images take 64, 12 and 9 kB and a little.
    struct load_images images = {.arena = &arena, .memory = PROCESS_BYTES + 20e3, .asked = 87e3};
    struct image *large = random_image(&arena, 64, 64, 3), *raw = random_image(&arena, 32, 32, 3),
                 *odd = random_image(&arena, 45, 51, 1), *level;
    const double mean[] = {texel_mean(large), texel_mean(raw), texel_mean(odd)};
    int levels;
    assert_true(load_image_levels(&arena, large, &level, &levels));
    const float before = wide_lookup(large, level, levels);
    const size_t bytes = arena.bytes;
    assert_true(load_images_keep(&images, large, level, levels, false));
    assert_true(large->width == 16 && level[0].width == 8 && level[levels - 1].width == 1);
    assert_true(load_images_keep(&images, raw, NULL, 0, false));
    assert_true(load_images_keep(&images, odd, NULL, 0, false));
    assert_true(large->width == 16 && large->height == 16 && raw->width == 16);
    assert_true(odd->width == 22 && odd->height == 25);
    assert_float_equal(texel_mean(large), mean[0], 1e-6);
    assert_float_equal(texel_mean(raw), mean[1], 1e-6);
    assert_float_equal(texel_mean(odd), mean[2], 1e-6);
    assert_float_equal(wide_lookup(large, level, levels), before, 1e-6f);
    assert_true(arena.bytes < bytes - 60000);
    struct scene_images what;
    load_images_end(&images, to, &what);
    assert_true(what.bytes <= 10e3 && !what.missing && !what.module);
    assert_int_equal(log.warnings, 1);
    assert_string_equal(log.warning,
                        "option memory: 3 of 3 images are coarser, in 0.00936 of 0.087 MB");
    arena_free(&arena);
}

// The mean over all directions of light between the rows, which are at equal angles.
static double environment_mean(const struct image *image) {
    enum { STEPS = 20 };
    const int rows = image->height - 1;
    double sum = 0.0, weights = 0.0;
    for (int i = 0; i < rows * STEPS; i++) {
        const double at = (i + 0.5) / STEPS, weight = sin(M_PI * at / rows), f = at - floor(at);
        for (int x = 0; x < image->width; x++) {
            const float *t = image->texel + (size_t)at * (size_t)image->width + x;
            sum += weight * ((1.0 - f) * (double)t[0] + f * (double)t[image->width]);
            weights += weight;
        }
    }
    return sum / weights;
}

// A sun keeps its light in a coarser environment, wherever it is. The rows of the copy are not
// exactly at every other one, which costs 1.6 / rows of the light beside a pole.
static void coarser_environments_keep_their_light(void **state) {
    (void)state;
    enum { WIDTH = 8, ROWS = 256 };
    static float texel[WIDTH * ROWS];
    for (int row = 0; row < ROWS; row += row < 8 ? 1 : 31) {
        struct arena arena = {0};
        for (int i = 0; i < WIDTH * ROWS; i++) texel[i] = 0.1f;
        texel[row * WIDTH + 5] = 1e5f;
        const struct image sun = scene_image_make(WIDTH, ROWS, 1, texel);
        struct image half, quarter;
        assert_true(load_image_coarser(&arena, &sun, true, &half));
        assert_true(load_image_coarser(&arena, &half, true, &quarter));
        assert_true(half.height == ROWS / 2 && quarter.width == WIDTH / 4);
        const double mean = environment_mean(&sun);
        assert_float_equal(environment_mean(&half) / mean, 1.0, 0.01);
        assert_float_equal(environment_mean(&quarter) / mean, 1.0, 0.03);
        arena_free(&arena);
    }
}

// An image that does not fit, beside its file, is not read.
static void large_images_are_missing(void **state) {
    (void)state;
    struct image_case c = {.hash = 1};
    static const unsigned char grey[6] = {0, 50, 100, 150, 200, 255};
    write_png("large.png", PNG_FORMAT_GRAY, grey);
    struct stat file;
    assert_int_equal(stat("large.png", &file), 0);
    const double size = (double)file.st_size;
    struct load_source source = {
        scene_case_begin(&c.log), {"scene.xml", 3, 7}, &c.arena, "large.png", &c.hash};
    for (int fits = 0; fits < 2; fits++) {
        struct load_images images = {.arena = &c.arena,
                                     .memory = PROCESS_BYTES + size + (fits ? 33.0 : 31.0)};
        struct image *image = NULL;
        assert_int_equal(load_image(&source, &images, false, &image), SATIN_OK);
        assert_true(images.missing == !fits && images.needed == size + 32.0);
        assert_true(image->width == (fits ? 3 : 1));
        assert_true(load_images_keep(&images, image, NULL, 0, false));
        struct scene_images what;
        load_images_end(&images, source.log, &what);
        assert_true(what.missing == !fits && what.asked == 32.0);
        assert_int_equal(c.log.warnings, 0);
    }
    arena_free(&c.arena);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_channel_is_read),
        cmocka_unit_test(one_channel_takes_its_memory),
        cmocka_unit_test(bytes_become_linear),
        cmocka_unit_test(textures_keep_bytes),
        cmocka_unit_test(exr_files_need_no_module),
        cmocka_unit_test(alpha_of_half_floats_is_read),
        cmocka_unit_test(floats_must_be_possible_for_light),
        cmocka_unit_test(wrong_image_files_are_refused),
        cmocka_unit_test(damaged_exr_files_are_refused),
        cmocka_unit_test(images_become_coarser),
        cmocka_unit_test(large_images_are_missing),
        cmocka_unit_test(coarser_environments_keep_their_light),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
