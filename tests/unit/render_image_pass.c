// SPDX-License-Identifier: Apache-2.0
// Samples of a pixel by their weights in the film's filter.
#include <math.h>

#include "film/film.h"
#include "satin/render.h"
#include "scene_case.h"

static const char *const with_lobes[] = {"mitchell", "catmullrom", "lanczos"};

// The mean over the image of a filter with negative lobes, whatever the number of samples: before a
// sky whose radiance is 1 everywhere it is exactly that, beside a black ball it has noise.
static void means_are_those_of_any_filter(void **state) {
    (void)state;
    static const char *const ball[] = {"",
                                       "<shape type='sphere'><bsdf type='diffuse'>"
                                       "<rgb name='reflectance' value='0'/></bsdf></shape>"};
    for (size_t i = 0; i < 2 * sizeof with_lobes / sizeof *with_lobes; i++) {
        char text[1024];
        struct scene_case c;
        snprintf(text, sizeof text,
                 "<scene version='3.0.0'><sensor type='perspective'><float name='fov' value='40'/>"
                 "<transform name='to_world'><lookat origin='0,0,5' target='0,0,0' up='0,1,0'/>"
                 "</transform><film type='hdrfilm'><integer name='width' value='48'/>"
                 "<integer name='height' value='48'/><rfilter type='%s'/></film></sensor>"
                 "<emitter type='constant'/>%s</scene>",
                 with_lobes[i / 2], ball[i % 2]);
        satin_scene *scene = scene_case_load(&c, text);
        assert_non_null(scene);
        double mean[4] = {0};
        for (int n = 0; n < 4; n++) {
            satin_options options = satin_options_default;
            options.integrator = SATIN_PATH;
            options.spp = (int[]){1, 2, 4, 64}[n];
            satin_film *film = NULL;
            assert_int_equal(satin_render(scene, &options, NULL, &film), SATIN_OK);
            const float *green = film_channel(film, "G");
            for (int k = 0; k < 48 * 48; k++) mean[n] += (double)green[k] / (48.0 * 48.0);
            satin_film_free(film);
        }
        print_message("%s, %s: %.4f, %.4f, %.4f by 1, 2, 4 samples, %.4f by 64\n",
                      with_lobes[i / 2], i % 2 ? "ball" : "sky", mean[0], mean[1], mean[2],
                      mean[3]);
        for (int n = 0; n < 4; n++) assert_true(fabs(mean[n] - mean[3]) < (i % 2 ? 0.006 : 1e-5));
        assert_true(i % 2 ? mean[3] < 0.9 : fabs(mean[3] - 1.0) < 1e-5);
        satin_scene_free(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(means_are_those_of_any_filter)};
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
