// SPDX-License-Identifier: Apache-2.0
// Spectra are converted to the same linear sRGB as by Mitsuba 3.9, from which the numbers are.
#include "load/load_spectrum.h"
#include "scene_case.h"

static void scene_spectrum_expect(rgb c, float r, float g, float b) {
    assert_true(fabsf(c.r / r - 1) < 1e-5f && fabsf(c.g / g - 1) < 1e-5f &&
                fabsf(c.b / b - 1) < 1e-5f);
}

static rgb scene_spectrum_convert(const char *text, bool light) {
    struct scene_case c;
    struct spectrum spectrum;
    struct log_place place = {"scene.xml", 1, 1};
    assert_int_equal(load_spectrum_parse(scene_case_begin(&c), place, text, &spectrum), SATIN_OK);
    rgb out = scene_spectrum_to_rgb(&spectrum, light);
    scene_spectrum_free(&spectrum);
    return out;
}

static void spectra_become_colours(void **state) {
    (void)state;
    static const char flat[] = "360:0.5, 830:0.5", slope[] = "400:0.2, 500:0.5, 550 .7,700:0.9";
    scene_spectrum_expect(scene_spectrum_convert(flat, false), .49949262f, .49943683f, .4994008f);
    scene_spectrum_expect(scene_spectrum_convert(flat, true), .60244185f, .4741141f, .4546334f);
    scene_spectrum_expect(scene_spectrum_convert(slope, false), .8484015f, .6581277f, .31988475f);
    scene_spectrum_expect(scene_spectrum_convert(slope, true), 1.0008676f, .6280136f, .2817228f);
    rgb line = scene_spectrum_convert("500:0,510:5,520:0", true);  // out of gamut
    assert_true(line.r == 0 && fabsf(line.g / .44112128f - 1) < 1e-5f);
    assert_true(rgb_black(scene_spectrum_convert("", true)));
}

// The colours are those of Mitsuba's spectral mode, summed over wavelengths against the observer.
static void black_bodies_have_their_colour(void **state) {
    (void)state;
    scene_spectrum_expect(scene_spectrum_blackbody(3000, 360, 830), 733.11077f, 349.56845f,
                          112.70958f);
    scene_spectrum_expect(scene_spectrum_blackbody(5000, 360, 830), 15263.024f, 12082.561f,
                          9592.5612f);
    assert_true(rgb_black(scene_spectrum_blackbody(1, 360, 830)));
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(spectra_become_colours),
                                       cmocka_unit_test(black_bodies_have_their_colour)};
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
