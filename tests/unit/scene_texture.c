// SPDX-License-Identifier: Apache-2.0
// Texture lookups: values measured with Mitsuba 3.9 on an image of 4 x 3 texels valued 0 to 11, row
// by row, and properties of every wrap mode.
#include "load/load_build.h"
#include "mesh_case.h"

static const float scene_texture_texel[12] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};
static const struct image scene_texture_image = {
    .width = 4, .height = 3, .channels = 1, .texel = scene_texture_texel, .side = 3.46410162f};

static struct texture scene_texture_bitmap(enum texture_wrap wrap, bool nearest) {
    return (struct texture){.kind = TEXTURE_BITMAP,
                            .to_uv = {1, 0, 0, 0, 1, 0},
                            .image = &scene_texture_image,
                            .wrap = wrap,
                            .wrap_v = wrap,
                            .nearest = nearest,
                            .mean = {5.5f, 5.5f, 5.5f}};
}

static rgb eval(const struct texture *texture, vec2 uv) {
    struct texture_lookup at = scene_texture_at(uv);
    return scene_texture_eval(texture, &at);
}

static float number_at(const struct texture *texture, vec2 uv) {
    struct texture_lookup at = scene_texture_at(uv);
    return scene_texture_number(texture, &at);
}

static void scene_texture_agrees_with_mitsuba(void **state) {
    (void)state;
    static const vec2 uv[10] = {
        {.01f, .01f}, {.125f, 1 / 6.f}, {.3f, .4f},    {.99f, .02f}, {.5f, .99f},
        {1.3f, .4f},  {-.3f, -.4f},     {2.3f, -1.4f}, {0, 0},       {1, 1}};
    static const float value[6][10] = {
        {0, 0, 5, 3, 10, 5, 6, 5, 0, 0},                               // nearest, repeat
        {0, 0, 5, 3, 10, 6, 5, 5, 0, 11},                              // mirror
        {0, 0, 5, 3, 10, 7, 0, 3, 0, 11},                              // clamp
        {5.14f, 0, 3.5f, 5.14f, 5.74f, 3.5f, 7.5f, 5.9f, 5.5f, 5.5f},  // bilinear, repeat
        {0, 0, 3.5f, 3, 9.5f, 5.1f, 3.5f, 5.9f, 0, 11},
        {0, 0, 3.5f, 3, 9.5f, 5.8f, 0, 3, 0, 11},
    };
    for (int k = 0; k < 6; k++) {
        struct texture t = scene_texture_bitmap((enum texture_wrap)(k % 3), k < 3);
        for (int i = 0; i < 10; i++) {
            rgb c = eval(&t, uv[i]);
            assert_float_equal(c.r, value[k][i], 1e-4f);
            assert_true(c.g == c.r && c.b == c.r);
        }
    }
}

// As Mitsuba 0.6: the image is inside [0, 1], and interpolated with the value around it.
static void zero_or_one_surrounds_the_image(void **state) {
    (void)state;
    static const vec2 uv[5] = {{.3f, .4f}, {1.3f, .4f}, {-.3f, -.4f}, {.5f, 1e9f}, {1, 1}};
    static const float value[4][5] = {
        {5, 0, 0, 5.5f, 0},         // nearest, zero
        {5, 1, 1, 5.5f, 1},         // one
        {3.5f, 0, 0, 5.5f, 2.75f},  // bilinear; far away is the mean
        {3.5f, 1, 1, 5.5f, 3.5f},
    };
    for (int k = 0; k < 4; k++) {
        const struct texture t = scene_texture_bitmap(k % 2 ? TEXTURE_ONE : TEXTURE_ZERO, k < 2);
        for (int i = 0; i < 5; i++) assert_float_equal(eval(&t, uv[i]).r, value[k][i], 1e-4f);
    }
    struct texture both = scene_texture_bitmap(TEXTURE_ZERO, true);
    both.wrap_v = TEXTURE_ONE;
    assert_true(eval(&both, (vec2){1.3f, 1.3f}).r == 0.0f);
    assert_true(eval(&both, (vec2){.3f, 1.3f}).r == 1.0f);
    const float bright[1] = {3.0f};
    const struct image texel = scene_image_make(1, 1, 1, bright);
    struct texture t = scene_texture_bitmap(TEXTURE_ONE, true);
    t.image = &texel;
    float lo, hi;
    assert_true(scene_texture_range(&t, &lo, &hi) && lo == 1.0f && hi == 3.0f);
    t.wrap_v = TEXTURE_ZERO;
    assert_true(scene_texture_range(&t, &lo, &hi) && lo == 0.0f && hi == 3.0f);
}

static void coordinates_are_transformed(void **state) {
    (void)state;
    static const vec2 uv[4] = {{.1f, .1f}, {.3f, .1f}, {.1f, .2f}, {.6f, .4f}};
    static const float to_uv[3][6] = {
        {2, 0, 0, 0, 3, 0}, {1, 0, .25f, 0, 1, 0}, {.866025404f, -.5f, 0, .5f, .866025404f, 0}};
    static const float value[3][4] = {{0, 2, 4, 0}, {1, 2, 1, 7}, {0, 0, 3, 5}};
    for (int k = 0; k < 3; k++) {
        struct texture t = scene_texture_bitmap(TEXTURE_REPEAT, true);
        memcpy(t.to_uv, to_uv[k], sizeof t.to_uv);
        for (int i = 0; i < 4; i++) assert_float_equal(eval(&t, uv[i]).r, value[k][i], 0.0f);
    }
}

static void squares_of_a_checkerboard_alternate(void **state) {
    (void)state;
    const struct texture red = {.value = {1, 0, 0}}, green = {.value = {0, 1, 0}};
    const struct texture t = {
        .kind = TEXTURE_CHECKERBOARD, .to_uv = {1, 0, 0, 0, 1, 0}, .check = {&red, &green}};
    static const vec2 uv[9] = {{.1f, .1f}, {.6f, .1f},  {.1f, .6f}, {.6f, .6f},  {-.1f, .1f},
                               {.5f, .1f}, {1.1f, .1f}, {0, 0},     {-.6f, -.2f}};
    static const int first[9] = {1, 0, 0, 1, 0, 1, 1, 1, 0};
    for (int i = 0; i < 9; i++) {
        rgb c = eval(&t, uv[i]);
        assert_true(c.r == (float)first[i] && c.g == (float)!first[i]);
        assert_true(number_at(&t, uv[i]) == rgb_mean(first[i] ? green.value : red.value));
    }
}

// Nested textures use the coordinates without change; textures of numbers are exchanged at every
// depth.
static void checkerboards_nest(void **state) {
    (void)state;
    const struct texture red = {.value = {1, 0, 0}}, green = {.value = {0, 1, 0}};
    const struct texture picture = scene_texture_bitmap(TEXTURE_REPEAT, true);
    const struct texture inner = {
        .kind = TEXTURE_CHECKERBOARD, .to_uv = {4, 0, 0, 0, 4, 0}, .check = {&red, &green}};
    const struct texture outer = {
        .kind = TEXTURE_CHECKERBOARD, .to_uv = {1, 0, 0, 0, 1, 0}, .check = {&inner, &picture}};
    assert_true(eval(&outer, (vec2){.05f, .05f}).r == 1.0f);
    assert_true(eval(&outer, (vec2){.2f, .05f}).g == 1.0f);
    assert_true(eval(&outer, (vec2){.6f, .1f}).r == 2.0f);
    assert_true(number_at(&outer, (vec2){.3f, .4f}) == 5.0f);
    assert_true(number_at(&outer, (vec2){.55f, .05f}) == rgb_mean(green.value));
    assert_true(number_at(&outer, (vec2){.7f, .05f}) == rgb_mean(red.value));
    float lo, hi;
    assert_true(scene_texture_range(&outer, &lo, &hi) && lo == 0.0f && hi == 11.0f);
    struct texture smooth = scene_texture_bitmap(TEXTURE_REPEAT, false);
    const struct texture map = {
        .kind = TEXTURE_CHECKERBOARD, .to_uv = {1, 0, 0, 0, 1, 0}, .check = {&red, &smooth}};
    vec2 at = {.3f, .2f}, own = scene_texture_gradient(&smooth, at),
         seen = scene_texture_gradient(&map, at);
    assert_true(own.x == seen.x && own.y == seen.y && own.x != 0.0f);
    assert_true(scene_texture_gradient(&map, (vec2){.6f, .2f}).x == 0.0f);
}

// Repetition has period 1, mirroring period 2 and symmetry, clamping is constant outside; and no
// coordinate, however large, reads outside of the image.
static void coordinates_wrap(void **state) {
    (void)state;
    struct rng rng = rng_make(1, RNG_TEST, 0);
    for (int i = 0; i < 20000; i++) {
        vec2 p = {rng_float(&rng), rng_float(&rng)};
        float n = (float)(rng_u32(&rng) % 9) - 4.0f;
        struct texture repeat = scene_texture_bitmap(TEXTURE_REPEAT, false);
        struct texture mirror = scene_texture_bitmap(TEXTURE_MIRROR, false);
        struct texture clamp = scene_texture_bitmap(TEXTURE_CLAMP, false);
        float r = eval(&repeat, p).r, m = eval(&mirror, p).r;
        assert_float_equal(eval(&repeat, (vec2){p.x + n, p.y - n}).r, r, 2e-4f);
        assert_float_equal(eval(&mirror, (vec2){p.x + 2 * n, -p.y}).r, m, 2e-4f);
        assert_float_equal(eval(&clamp, (vec2){p.x, -p.y}).r, eval(&clamp, (vec2){p.x, 0}).r,
                           2e-5f);
        union {
            uint32_t bits;
            float f;
        } u = {rng_u32(&rng)}, v = {rng_u32(&rng)};
        for (int k = 0; k < 6; k++) {
            struct texture t = scene_texture_bitmap((enum texture_wrap)(k % 3), k < 3);
            float wild = eval(&t, (vec2){u.f, v.f}).r;
            assert_true(wild >= 0.0f && wild <= 11.0f);
        }
    }
}

// The gradient is that of the interpolation, through the transform of coordinates.
static void gradients_agree_with_differences(void **state) {
    (void)state;
    const float h = 1e-3f;
    struct texture t = scene_texture_bitmap(TEXTURE_REPEAT, false);
    const float to_uv[6] = {2.0f, 0.5f, 0.1f, -0.3f, 1.5f, 0.2f};
    for (int i = 0; i < 6; i++) t.to_uv[i] = to_uv[i];
    int close = 0;
    for (int i = 0; i < 100; i++) {
        vec2 p = {0.013f + (float)i * 0.01f, 0.71f - (float)i * 0.007f};
        vec2 g = scene_texture_gradient(&t, p);
        float dx = eval(&t, (vec2){p.x + h, p.y}).r - eval(&t, (vec2){p.x - h, p.y}).r;
        float dy = eval(&t, (vec2){p.x, p.y + h}).r - eval(&t, (vec2){p.x, p.y - h}).r;
        close += fabsf(dx - 2 * h * g.x) < 1e-4f && fabsf(dy - 2 * h * g.y) < 1e-4f;
    }
    assert_true(close > 90);  // the others straddle the middle of a texel
    t.nearest = true;
    assert_true(scene_texture_gradient(&t, (vec2){.3f, .3f}).x == 0.0f);
}

static void textures_have_three_channels_or_one_value(void **state) {
    (void)state;
    static const float color[6] = {1, 2, 3, 4, 5, 6};
    const struct image two = scene_image_make(2, 1, 3, color);
    struct texture t = scene_texture_bitmap(TEXTURE_CLAMP, false);
    t.image = &two;
    rgb c = eval(&t, (vec2){0.5f, 0.5f});
    assert_true(c.r == 2.5f && c.g == 3.5f && c.b == 4.5f);
    struct texture constant = {.kind = TEXTURE_CONSTANT, .value = {7, 8, 9}};
    assert_true(eval(&constant, (vec2){NAN, 3}).g == 8.0f);
    float lo, hi;
    t.image = &two;
    assert_true(scene_texture_range(&t, &lo, &hi));
    assert_true(lo == rgb_luminance(rgb_make(1, 2, 3)) && hi == rgb_luminance(rgb_make(4, 5, 6)));
    assert_true(scene_texture_range(&constant, &lo, &hi) && lo == hi);
}

// Numbers and colours of corners are interpolated, those of triangles are not.
static void attributes_are_interpolated(void **state) {
    (void)state;
    static const char heat[] = "vertex_heat", tint[] = "face_color", none[] = "vertex_none";
    static const float at_corner[4] = {1, 2, 4, 8}, of_triangle[6] = {1, 2, 3, 4, 5, 6};
    static const uint32_t index[6] = {0, 1, 2, 2, 1, 3};
    const struct mesh_attribute attribute[2] = {{heat, false, 1, at_corner},
                                                {tint, true, 3, of_triangle}};
    const struct mesh mesh = {.index = index, .attribute = attribute, .attribute_count = 2};
    struct texture t = {.kind = TEXTURE_ATTRIBUTE, .attribute = heat, .scale = 2.0f};
    struct texture_lookup at = {.mesh = &mesh, .prim = 1, .bary = {0.25f, 0.5f}};
    assert_float_equal(scene_texture_number(&t, &at), 2.0f * (0.25f * 4 + 0.25f * 2 + 0.5f * 8),
                       1e-5f);
    t.attribute = tint;
    rgb c = scene_texture_eval(&t, &at);
    assert_true(c.r == 8.0f && c.g == 10.0f && c.b == 12.0f);
    t.attribute = none;
    assert_true(rgb_black(scene_texture_eval(&t, &at)));
    t.attribute = heat;
    assert_true(rgb_black(eval(&t, (vec2){0.5f, 0.5f})));
}

// Wide lookups: a texel of a smaller copy at its own width, the mean of all at the widest, and
// nothing changes below a texel's width.
static void wide_footprints_are_averaged(void **state) {
    (void)state;
    enum { W = 13, H = 6 };
    float texels[W * H];
    struct rng rng = rng_make(2, RNG_TEST, 0);
    double mean = 0.0;
    for (int i = 0; i < W * H; i++) mean += (double)(texels[i] = rng_float(&rng)) / (W * H);
    const struct image odd = scene_image_make(W, H, 1, texels);
    struct texture t = scene_texture_bitmap(TEXTURE_REPEAT, false);
    struct arena arena = {0};
    t.image = &odd;
    struct image *level;
    assert_true(load_image_levels(&arena, &odd, &level, &t.levels));
    t.level = level;
    t.unit = 1.0f;
    assert_int_equal(t.levels, 3);
    assert_true(t.level[0].width == 6 && t.level[0].height == 3);
    assert_true(t.level[2].width == 1 && t.level[2].height == 1);
    for (int i = 0; i < 3; i++) {
        double sum = 0.0;
        int count = t.level[i].width * t.level[i].height;
        for (int k = 0; k < count; k++) sum += (double)t.level[i].texel[k] / count;
        assert_float_equal(sum, mean, 1e-6);
    }
    struct texture_lookup at = scene_texture_at((vec2){0.5f / 6, 0.5f / 3});
    float sharp = scene_texture_eval(&t, &at).r;
    at.width = 1.0f / odd.side;
    assert_true(scene_texture_eval(&t, &at).r == sharp);
    at.width = 2.0f / odd.side;
    assert_float_equal(scene_texture_eval(&t, &at).r, t.level[0].texel[0], 1e-6f);
    at.width = INFINITY;
    assert_float_equal(scene_texture_eval(&t, &at).r, mean, 1e-6);
    at.width = 2.0f / odd.side * sqrtf(2.0f);  // halfway between two copies
    float half = scene_texture_eval(&t, &at).r;
    at.width = 4.0f / odd.side;
    assert_float_equal(half, 0.5f * (t.level[0].texel[0] + scene_texture_eval(&t, &at).r), 1e-5f);
    arena_free(&arena);
}

// A factor counts at every depth; a coloured one before the number is computed.
static void textures_are_scaled_at_every_depth(void **state) {
    (void)state;
    const struct texture t = scene_texture_bitmap(TEXTURE_REPEAT, false);
    const struct texture white = {.value = {1, 1, 1}};
    const struct texture a = {
        .kind = TEXTURE_SCALED, .value = {2, 3, 4}, .check = {&t, NULL}, .mean = {1, 1, 1}};
    const struct texture b = {
        .kind = TEXTURE_SCALED, .value = {.5f, .5f, .5f}, .check = {&a, NULL}};
    const struct texture checks = {
        .kind = TEXTURE_CHECKERBOARD, .to_uv = {1, 0, 0, 0, 1, 0}, .check = {&b, &white}};
    const vec2 uv = {.3f, .4f};
    const rgb c = eval(&checks, uv);
    const float e = eval(&t, uv).r;
    assert_true(c.r == e && c.g == 1.5f * e && c.b == 2.0f * e);
    assert_float_equal(number_at(&b, uv), rgb_luminance(c), 1e-6f);
    assert_true(eval(&checks, (vec2){.7f, .4f}).g == 1.0f);
    const vec2 g = scene_texture_gradient(&t, uv), h = scene_texture_gradient(&b, uv);
    const float k = rgb_luminance(rgb_make(1, 1.5f, 2));
    assert_float_equal(h.x, k * g.x, 1e-5f);
    assert_float_equal(h.y, k * g.y, 1e-5f);
    float lo, hi;
    assert_false(scene_texture_range(&b, &lo, &hi));
    const struct texture grey = {.kind = TEXTURE_SCALED, .value = {3, 3, 3}, .check = {&t, NULL}};
    assert_true(scene_texture_range(&grey, &lo, &hi) && lo == 0.0f && hi == 33.0f);
}

static void lines_of_a_grid_are_drawn(void **state) {
    (void)state;
    const struct texture black = {.value = {0, 0, 0}}, white = {.value = {1, 1, 1}};
    const struct texture grid = {
        .kind = TEXTURE_GRID, .to_uv = {1, 0, 0, 0, 1, 0}, .check = {&black, &white}, .scale = .1f};
    enum { SIDE = 400 };
    int lines = 0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        const vec2 uv = {((float)(i % SIDE) + .5f) / SIDE * 2 - 1,
                         ((float)(i / SIDE) + .5f) / SIDE * 2 - 1};
        const bool line = eval(&grid, uv).r == 1.0f;
        const float x = fabsf(uv.x), y = fabsf(uv.y);
        assert_true(line == (x < .1f || x > .9f || y < .1f || y > .9f));
        assert_true(number_at(&grid, uv) == (float)line);
        lines += line;
    }
    assert_float_equal((float)lines / (SIDE * SIDE), scene_texture_lines(&grid), 1e-6f);
}

static void each_axis_wraps_for_itself(void **state) {
    (void)state;
    struct texture t = scene_texture_bitmap(TEXTURE_REPEAT, true);
    t.wrap_v = TEXTURE_CLAMP;
    assert_true(eval(&t, (vec2){1.3f, 1.3f}).r == 9.0f && eval(&t, (vec2){-.1f, -.3f}).r == 3.0f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(textures_are_scaled_at_every_depth),
        cmocka_unit_test(lines_of_a_grid_are_drawn),
        cmocka_unit_test(each_axis_wraps_for_itself),
        cmocka_unit_test(scene_texture_agrees_with_mitsuba),
        cmocka_unit_test(zero_or_one_surrounds_the_image),
        cmocka_unit_test(coordinates_are_transformed),
        cmocka_unit_test(squares_of_a_checkerboard_alternate),
        cmocka_unit_test(checkerboards_nest),
        cmocka_unit_test(coordinates_wrap),
        cmocka_unit_test(gradients_agree_with_differences),
        cmocka_unit_test(textures_have_three_channels_or_one_value),
        cmocka_unit_test(attributes_are_interpolated),
        cmocka_unit_test(wide_footprints_are_averaged),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
