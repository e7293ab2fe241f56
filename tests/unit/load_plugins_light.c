// SPDX-License-Identifier: Apache-2.0
// Environment maps of few rows, and under transforms that stretch.
#include "light/light.h"
#include "scene_case.h"

// An image of one channel, `rows` x 2, whose rows from the top are 1, 2, ...
static void write_image(int rows) {
    char bytes[64];
    float texel[8];
    const int head = snprintf(bytes, sizeof bytes, "Pf\n2 %d\n-1\n", rows);
    for (int row = 0; row < rows; row++)  // a PFM begins with the lowest row
        texel[2 * row] = texel[2 * row + 1] = (float)(rows - row);
    memcpy(bytes + head, texel, (size_t)rows * 2 * sizeof *texel);
    scene_case_bytes("a.pfm", bytes, (size_t)head + (size_t)rows * 2 * sizeof *texel);
}

static satin_scene *load_envmap(struct scene_case *c, const char *steps) {
    char text[512];
    snprintf(text, sizeof text,
             SCENE_TEXT("<emitter type='envmap'><string name='filename' value='a.pfm'/>"
                        "<transform name='to_world'>%s</transform></emitter>"),
             steps);
    satin_scene *scene = scene_case_load(c, text);
    assert_non_null(scene);
    return scene;
}

static void the_last_of_two_rows_is_repeated(void **state) {
    (void)state;
    for (int rows = 1; rows <= 4; rows++) {
        struct scene_case c;
        write_image(rows);
        satin_scene *scene = load_envmap(&c, "");
        const struct image *image = scene->light[scene->environment].image;
        assert_int_equal(image->height, rows == 2 ? 3 : rows);
        for (int i = 0; i < image->height * 2; i++)
            assert_true(image->texel[i] == (float)(i / 2 < rows ? i / 2 + 1 : rows));
        satin_scene_free(scene);
    }
}

static void stretched_maps_are_only_rotated(void **state) {
    (void)state;
    write_image(3);
    struct scene_case c;
    satin_scene *stretched = load_envmap(&c, "<scale x='-3' y='2'/><rotate x='1' angle='90'/>");
    assert_int_equal(c.warnings, 1);
    satin_scene *rotated = load_envmap(&c, "<scale x='-1'/><rotate x='1' angle='90'/>");
    assert_int_equal(c.warnings, 0);
    const struct mat4 *a = &stretched->light[0].to_world, *b = &rotated->light[0].to_world;
    for (int i = 0; i < 16; i++) assert_float_equal(a->m[i / 4][i % 4], b->m[i / 4][i % 4], 1e-6f);
    satin_scene_free(stretched);
    satin_scene_free(rotated);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_last_of_two_rows_is_repeated),
        cmocka_unit_test(stretched_maps_are_only_rotated),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
