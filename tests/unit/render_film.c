// SPDX-License-Identifier: Apache-2.0
// The film of an image whose sums are filled in by hand: its channels, the means of samples and of
// rays at rims, and the values of pixels without a sample.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "render/render_image.h"

enum { WIDTH = 37, HEIGHT = 21 };

static struct render render_film_make(satin_integrator integrator) {
    struct render r = {.options = satin_options_default};
    r.options.integrator = integrator;
    r.scene.film.crop_width = WIDTH;
    r.scene.film.crop_height = HEIGHT;
    r.pool = parallel_new(2);
    r.image = render_image_new(&r.scene, &r.options);
    assert_true(r.pool && r.image);
    return r;
}

static void render_film_stop(struct render *r) {
    render_image_free(r->image);
    parallel_free(r->pool);
}

static struct image_pixel *pixel_at(struct render *r, int x, int y) {
    return &r->image->pixel[y * WIDTH + x];
}

static float render_film_value_at(struct render *r, const char *channel, int x, int y) {
    const float *plane = film_channel(r->image->film, channel);
    assert_non_null(plane);
    return plane[y * WIDTH + x];
}

// The two samples weigh 1.5 together.
static void fill_pixel(struct image_pixel *p, float L) {
    p->samples = 2;
    p->weight = 1.5f;
    p->beauty = rgb_grey(1.5f * L);
    p->layer[SHADE_DIRECT] = rgb_grey(1.5f * L);
    p->depth = 3.0f;
}

// render_image_new points to the aovs of a scene that has moved since.
static void render_film_make_film(struct render *r, bool any) {
    bool found;
    r->image->aovs = &r->scene.hints.aovs;
    render_image_film(r, &found);
    assert_int_equal(found, any);
}

static void integrators_have_what_they_compute(void **state) {
    (void)state;
    static const struct {
        satin_integrator integrator;
        bool direct, caustic, diffuse, density;
    } wanted[] = {{SATIN_TWO_PASS, true, true, true, true},
                  {SATIN_PATH, false, false, false, false},
                  {SATIN_DIRECT, true, false, false, false},
                  {SATIN_PHOTONS, false, false, true, false},
                  {SATIN_SPPM, false, false, false, false}};
    for (size_t i = 0; i < sizeof wanted / sizeof *wanted; i++) {
        struct render r = render_film_make(wanted[i].integrator);
        struct satin_film *film = r.image->film;
        assert_int_equal(film_channel(film, "direct.R") != NULL, wanted[i].direct);
        assert_int_equal(film_channel(film, "caustic.G") != NULL, wanted[i].caustic);
        assert_int_equal(film_channel(film, "indirect_diffuse.B") != NULL, wanted[i].diffuse);
        assert_int_equal(film_channel(film, "density.Y") != NULL, wanted[i].density);
        assert_true(film_channel(film, "B") && film_channel(film, "emission.R"));
        assert_true(!film_channel(film, "records.a") && !film_channel(film, "noisy.R"));
        render_film_stop(&r);
    }
}

static void options_and_scenes_add_channels(void **state) {
    (void)state;
    satin_options o = satin_options_default;
    struct scene_aov channel[] = {{.name = "depth.Z"}, {.name = "normals.X", .value = 1}};
    const struct satin_scene scene = {
        .film = {WIDTH, HEIGHT, .crop_width = WIDTH, .crop_height = HEIGHT},
        .hints.aovs = {.channel = channel, .count = 2, .values = 2}};
    struct satin_film *plain = render_film_new(&scene, &o);
    o.record_maps = o.denoise = true;
    struct satin_film *all = render_film_new(&scene, &o);
    assert_int_equal(all->channel_count, plain->channel_count + 4 + 6);
    assert_true(film_channel(all, "records.rays") && film_channel(all, "uncached.B"));
    assert_non_null(film_channel(plain, "normals.X"));
    // The scene's channel replaces that of the same name.
    int depths = 0;
    for (int i = 0; i < plain->channel_count; i++)
        depths += strcmp(plain->channel_name[i], "depth.Z") == 0;
    assert_int_equal(depths, 1);
    satin_film_free(plain);
    satin_film_free(all);
}

static void a_pixel_is_the_mean_by_weight(void **state) {
    (void)state;
    struct render r = render_film_make(SATIN_TWO_PASS);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) fill_pixel(pixel_at(&r, x, y), (float)(x + y));
    pixel_at(&r, 4, 3)->used.count = 5;
    render_film_make_film(&r, true);
    assert_float_equal(render_film_value_at(&r, "G", 4, 3), 7.0f, 1e-6f);
    assert_float_equal(render_film_value_at(&r, "direct.R", 36, 20), 56.0f, 1e-5f);
    assert_float_equal(render_film_value_at(&r, "depth.Z", 4, 3), 2.0f, 1e-6f);
    assert_float_equal(render_film_value_at(&r, "density.Y", 4, 3), 2.5f, 1e-6f);
    assert_float_equal(render_film_value_at(&r, "samples.Y", 4, 3), 2.0f, 0.0f);
    assert_true(stats_get(&r.stats, "image.filled") == 0.0);
    render_film_stop(&r);
}

// Emission is the mean of samples and further rays; the other light that of the samples.
// As by a filter with negative lobes.
static void an_opaque_pixel_is_opaque_whatever_its_weight(void **state) {
    (void)state;
    static const float WEIGHT[] = {1.5f, 1e-6f};
    for (size_t i = 0; i < sizeof WEIGHT / sizeof *WEIGHT; i++) {
        struct render r = {.options = satin_options_default};
        r.scene.film.alpha = true;
        r.scene.film.crop_width = r.scene.film.crop_height = 2;
        r.pool = parallel_new(1);
        r.image = render_image_new(&r.scene, &r.options);
        assert_true(r.pool && r.image);
        struct image_pixel *opaque = &r.image->pixel[0], *half = &r.image->pixel[1];
        fill_pixel(opaque, 1.0f);
        fill_pixel(half, 1.0f);
        opaque->alpha = opaque->weight = half->weight = WEIGHT[i];
        half->alpha = 0.5f * WEIGHT[i];
        render_film_make_film(&r, true);
        const float *alpha = film_channel(r.image->film, "A");
        assert_non_null(alpha);
        assert_true(alpha[0] == 1.0f && alpha[1] == 0.5f);
        render_film_stop(&r);
    }
}

static void emission_is_the_mean_of_what_is_for_it_alone(void **state) {
    (void)state;
    struct render r = render_film_make(SATIN_TWO_PASS);
    struct image_pixel *p = pixel_at(&r, 0, 0);
    fill_pixel(p, 2.0f);
    p->layer[SHADE_EMISSION] = rgb_grey(1.5f * 10.0f);
    p->beauty = rgb_grey(1.5f * 12.0f);
    p->emission = (struct image_emission){.sum = rgb_grey(8.5f * 4.0f), .weight = 8.5f};
    render_film_make_film(&r, true);
    const float emission = 4.0f;
    assert_float_equal(render_film_value_at(&r, "emission.R", 0, 0), emission, 1e-5f);
    assert_float_equal(render_film_value_at(&r, "direct.R", 0, 0), 2.0f, 1e-5f);
    assert_float_equal(render_film_value_at(&r, "R", 0, 0), 2.0f + emission, 1e-5f);
    render_film_stop(&r);
}

static void pixels_without_samples_show_a_neighbour(void **state) {
    (void)state;
    struct render r = render_film_make(SATIN_TWO_PASS);
    assert_int_equal(r.image->coarsest, 16);
    render_film_make_film(&r, false);
    fill_pixel(pixel_at(&r, 16, 0), 1.0f);
    fill_pixel(pixel_at(&r, 16, 16), 2.0f);
    fill_pixel(pixel_at(&r, 20, 16), 3.0f);
    fill_pixel(pixel_at(&r, 21, 17), 4.0f);
    pixel_at(&r, 22, 17)->dropped = 3;
    assert_ptr_equal(render_image_source(r.image, 21, 17), pixel_at(&r, 21, 17));
    assert_ptr_equal(render_image_source(r.image, 20, 17), pixel_at(&r, 20, 16));
    assert_ptr_equal(render_image_source(r.image, 23, 18), pixel_at(&r, 20, 16));
    assert_ptr_equal(render_image_source(r.image, 24, 16), pixel_at(&r, 16, 16));
    assert_ptr_equal(render_image_source(r.image, 31, 15), pixel_at(&r, 16, 0));
    // Pixels whose samples were dropped are not filled from others.
    assert_ptr_equal(render_image_source(r.image, 22, 17), pixel_at(&r, 22, 17));
    assert_null(render_image_source(r.image, 15, 0));
    render_film_make_film(&r, true);
    assert_float_equal(render_film_value_at(&r, "R", 23, 18), 3.0f, 1e-6f);
    assert_float_equal(render_film_value_at(&r, "samples.Y", 23, 18), 0.0f, 0.0f);
    assert_float_equal(render_film_value_at(&r, "R", 15, 0), 0.0f, 0.0f);
    assert_float_equal(render_film_value_at(&r, "R", 22, 17), 0.0f, 0.0f);
    assert_true(stats_get(&r.stats, "image.filled") == WIDTH * HEIGHT - 5);
    assert_true(stats_get(&r.stats, "image.nonfinite") == 3.0);
    render_film_stop(&r);
}

// A pixel without samples has its own emission where eye rays have looked for it.
static void pixels_without_samples_have_emission(void **state) {
    (void)state;
    struct render r = render_film_make(SATIN_TWO_PASS);
    struct image_pixel *lamp = pixel_at(&r, 0, 0), *wall = pixel_at(&r, 1, 0);
    fill_pixel(lamp, 2.0f);
    lamp->layer[SHADE_EMISSION] = rgb_grey(1.5f * 10.0f);
    lamp->beauty = rgb_grey(1.5f * 12.0f);
    wall->emission = (struct image_emission){.sum = rgb_grey(4.0f * 0.5f), .weight = 4.0f};
    render_film_make_film(&r, true);
    assert_float_equal(render_film_value_at(&r, "emission.R", 1, 0), 0.5f, 1e-6f);
    assert_float_equal(render_film_value_at(&r, "R", 1, 0), 2.5f, 1e-6f);
    assert_float_equal(render_film_value_at(&r, "emission.R", 2, 0), 10.0f, 1e-6f);
    render_film_stop(&r);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(integrators_have_what_they_compute),
        cmocka_unit_test(options_and_scenes_add_channels),
        cmocka_unit_test(a_pixel_is_the_mean_by_weight),
        cmocka_unit_test(an_opaque_pixel_is_opaque_whatever_its_weight),
        cmocka_unit_test(emission_is_the_mean_of_what_is_for_it_alone),
        cmocka_unit_test(pixels_without_samples_show_a_neighbour),
        cmocka_unit_test(pixels_without_samples_have_emission),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
