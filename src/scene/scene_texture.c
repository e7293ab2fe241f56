// SPDX-License-Identifier: Apache-2.0
// Looks textures up at surface coordinates, with Mitsuba 3's conventions: v = 0 is the top row of
// the image; texel (0, 0) has its centre at (0.5 / width, 0.5 / height); a cell of a checkerboard
// is half a unit wide, and the first one has color0.
#include "scene/scene_attribute.h"

// What an index of a texel is if the texture is 0 or 1 there.
enum { TEXEL_ZERO = -1, TEXEL_ONE = -2 };

// The texel index in [0, n), or one of these, for position i outside or inside the image.
static int wrap(float i, int n, enum texture_wrap mode) {
    float size = (float)n;
    if (mode == TEXTURE_CLAMP) return (int)clampf(i, 0.0f, size - 1.0f);
    if (mode >= TEXTURE_ZERO && !(i >= 0.0f && i < size))
        return mode == TEXTURE_ZERO ? TEXEL_ZERO : TEXEL_ONE;
    float tile = floorf(i / size);
    int inside = (int)clampf(i - tile * size, 0.0f, size - 1.0f);
    bool odd = mode == TEXTURE_MIRROR && tile - 2.0f * floorf(0.5f * tile) > 0.5f;
    return odd ? n - 1 - inside : inside;
}

static rgb texel_color(const struct image *image, size_t i) {
    const size_t at = i * (size_t)image->channels;
    if (image->channels == 1) return rgb_grey(scene_image_value(image, at));
    return rgb_make(scene_image_value(image, at), scene_image_value(image, at + 1),
                    scene_image_value(image, at + 2));
}

// Where both x and y are outside, x decides.
static rgb image_texel(const struct image *image, int x, int y) {
    if (x < 0 || y < 0) return rgb_grey((x < 0 ? x : y) == TEXEL_ONE ? 1.0f : 0.0f);
    return texel_color(image, (size_t)y * (size_t)image->width + (size_t)x);
}

// The four texels around (x, y), in texels from the centre of the first.
struct texel_cell {
    rgb upper_left, upper_right, lower_left, lower_right;
    float fx, fy;
};

static struct texel_cell cell_at(const struct texture *texture, const struct image *image, float x,
                                 float y) {
    float x0 = floorf(x), y0 = floorf(y);
    int left = wrap(x0, image->width, texture->wrap),
        right = wrap(x0 + 1.0f, image->width, texture->wrap);
    int top = wrap(y0, image->height, texture->wrap_v),
        bottom = wrap(y0 + 1.0f, image->height, texture->wrap_v);
    return (struct texel_cell){image_texel(image, left, top),
                               image_texel(image, right, top),
                               image_texel(image, left, bottom),
                               image_texel(image, right, bottom),
                               x - x0,
                               y - y0};
}

static rgb interpolate_texels(const struct texture *texture, const struct image *image, float u,
                              float v) {
    float x = u * (float)image->width, y = v * (float)image->height;
    struct texel_cell c = cell_at(texture, image, x - 0.5f, y - 0.5f);
    rgb upper = rgb_mad(rgb_scale(c.upper_left, 1.0f - c.fx), c.upper_right, c.fx);
    rgb lower = rgb_mad(rgb_scale(c.lower_left, 1.0f - c.fx), c.lower_right, c.fx);
    return rgb_mad(rgb_scale(upper, 1.0f - c.fy), lower, c.fy);
}

static rgb nearest_texel(const struct texture *texture, float u, float v) {
    const struct image *image = texture->image;
    int w = image->width, h = image->height;
    float x = floorf(u * (float)w), y = floorf(v * (float)h);
    return image_texel(image, wrap(x, w, texture->wrap), wrap(y, h, texture->wrap_v));
}

static const struct image *texture_level(const struct texture *texture, int i) {
    return i ? &texture->level[i - 1] : texture->image;
}

static rgb bitmap(const struct texture *texture, float u, float v, float width) {
    if (texture->nearest) return nearest_texel(texture, u, v);
    float texels = width * texture->unit * texture->image->side;
    if (!(texels > 1.0f) || !texture->levels)
        return interpolate_texels(texture, texture->image, u, v);
    // Interpolates between the level whose texels are just narrower than the footprint and the next
    // one [Williams 1983].
    float height = fminf(log2f(texels), (float)texture->levels);
    int low = (int)height, high = low < texture->levels ? low + 1 : low;
    rgb fine = interpolate_texels(texture, texture_level(texture, low), u, v);
    rgb coarse = interpolate_texels(texture, texture_level(texture, high), u, v);
    return rgb_mad(rgb_scale(fine, (float)(low + 1) - height), coarse, height - (float)low);
}

// Transforms uv to texture coordinates. False if these are not finite, or so large that floats do
// not resolve a texel.
static bool to_texture(const struct texture *texture, vec2 uv, float *u, float *v) {
    const float *m = texture->to_uv;
    *u = m[0] * uv.x + m[1] * uv.y + m[2];
    *v = m[3] * uv.x + m[4] * uv.y + m[5];
    return fabsf(*u) < 1e7f && fabsf(*v) < 1e7f;
}

// Which of its two textures a checkerboard or grid shows at uv, which nested textures use
// unchanged. If `exchanged`, a checkerboard begins with the second.
static int texture_choice(const struct texture *texture, vec2 uv, bool exchanged) {
    float u, v;
    if (texture->kind == TEXTURE_SCALED) return 0;
    const bool inside = to_texture(texture, uv, &u, &v);
    if (texture->kind == TEXTURE_GRID)
        return inside && (fabsf(u - floorf(u + 0.5f)) < texture->scale ||
                          fabsf(v - floorf(v + 0.5f)) < texture->scale);
    const bool second = inside && (u - floorf(u) > 0.5f) != (v - floorf(v) > 0.5f);
    return second != exchanged;
}

// The texture at uv after all checkerboards, grids and scales, and the factor of the scales.
static const struct texture *find_check(const struct texture *texture, vec2 uv, bool exchanged,
                                        rgb *factor) {
    *factor = rgb_grey(1.0f);
    while (texture->check[0]) {
        if (texture->kind == TEXTURE_SCALED) *factor = rgb_mul(*factor, texture->value);
        texture = texture->check[texture_choice(texture, uv, exchanged)];
    }
    return texture;
}

static rgb eval_unscaled(const struct texture *texture, const struct texture_lookup *at) {
    if (texture->kind == TEXTURE_CONSTANT) return texture->value;
    if (texture->kind == TEXTURE_ATTRIBUTE)
        return rgb_scale(scene_attribute_eval(texture->attribute, at), texture->scale);
    float u, v;
    if (!to_texture(texture, at->uv, &u, &v)) return texture->mean;
    return bitmap(texture, u, v, at->width);
}

rgb scene_texture_eval(const struct texture *texture, const struct texture_lookup *at) {
    rgb factor;
    texture = find_check(texture, at->uv, false, &factor);
    return rgb_mul(eval_unscaled(texture, at), factor);
}

float scene_texture_number(const struct texture *texture, const struct texture_lookup *at) {
    rgb factor;
    texture = find_check(texture, at->uv, true, &factor);
    if (texture->kind == TEXTURE_CONSTANT) return rgb_mean(rgb_mul(texture->value, factor));
    return rgb_luminance(rgb_mul(eval_unscaled(texture, at), factor));
}

vec2 scene_texture_gradient(const struct texture *texture, vec2 uv) {
    float u, v;
    rgb k;
    texture = find_check(texture, uv, true, &k);
    if (texture->kind != TEXTURE_BITMAP || texture->nearest || !to_texture(texture, uv, &u, &v))
        return (vec2){0.0f, 0.0f};
    float w = (float)texture->image->width, h = (float)texture->image->height;
    struct texel_cell c = cell_at(texture, texture->image, u * w - 0.5f, v * h - 0.5f);
    float a = rgb_luminance(rgb_mul(c.upper_left, k)), b = rgb_luminance(rgb_mul(c.upper_right, k));
    float d = rgb_luminance(rgb_mul(c.lower_left, k)), e = rgb_luminance(rgb_mul(c.lower_right, k));
    float x = w * lerpf(b - a, e - d, c.fy), y = h * lerpf(d - a, e - b, c.fx);
    const float *m = texture->to_uv;
    return (vec2){m[0] * x + m[3] * y, m[1] * x + m[4] * y};
}

static void add_to_range(enum texture_wrap outside, float *lo, float *hi) {
    if (outside == TEXTURE_ZERO) *lo = minf(*lo, 0.0f), *hi = maxf(*hi, 0.0f);
    if (outside == TEXTURE_ONE) *lo = minf(*lo, 1.0f), *hi = maxf(*hi, 1.0f);
}

// Texels that do not wait for the range of each other.
enum { RANGE_LANES = 8 };

static void bitmap_range(const struct texture *texture, float *lo, float *hi) {
    const struct image *image = texture->image;
    *lo = INFINITY, *hi = -INFINITY;
    add_to_range(texture->wrap, lo, hi);
    add_to_range(texture->wrap_v, lo, hi);
    const size_t count = (size_t)image->width * (size_t)image->height;
    float least[RANGE_LANES], most[RANGE_LANES];
    for (int k = 0; k < RANGE_LANES; k++) least[k] = *lo, most[k] = *hi;
    size_t at = 0;
    for (; at + RANGE_LANES <= count; at += RANGE_LANES)
        for (size_t k = 0; k < RANGE_LANES; k++) {
            const float value = rgb_luminance(texel_color(image, at + k));
            least[k] = minf(least[k], value), most[k] = maxf(most[k], value);
        }
    for (; at < count; at++) {
        const float value = rgb_luminance(texel_color(image, at));
        least[0] = minf(least[0], value), most[0] = maxf(most[0], value);
    }
    for (int k = 0; k < RANGE_LANES; k++) *lo = minf(*lo, least[k]), *hi = maxf(*hi, most[k]);
}

bool scene_texture_range(const struct texture *texture, float *lo, float *hi) {
    float lo_1, hi_1;
    switch (texture->kind) {
        case TEXTURE_CONSTANT:
            *lo = *hi = rgb_mean(texture->value);
            return true;
        case TEXTURE_BITMAP:
            bitmap_range(texture, lo, hi);
            return *lo <= *hi;
        case TEXTURE_CHECKERBOARD:
        case TEXTURE_GRID:
            if (!scene_texture_range(texture->check[0], lo, hi) ||
                !scene_texture_range(texture->check[1], &lo_1, &hi_1))
                return false;
            *lo = minf(*lo, lo_1), *hi = maxf(*hi, hi_1);
            return true;
        case TEXTURE_SCALED:
            // The range of a texture times a colour would be that of another weighted sum of its
            // channels.
            if (texture->value.r != texture->value.g || texture->value.r != texture->value.b)
                return false;
            if (!scene_texture_range(texture->check[0], lo, hi)) return false;
            *lo *= texture->value.r, *hi *= texture->value.r;
            return true;
        case TEXTURE_ATTRIBUTE:
            break;
    }
    return false;
}
