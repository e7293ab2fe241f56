// SPDX-License-Identifier: Apache-2.0
// Looking a texture up at surface coordinates, with Mitsuba 3's conventions: v = 0 is the image's
// top row; texel (0, 0) has its centre at (0.5 / width, 0.5 / height); a checkerboard's cell is
// half a unit wide and the first one has color0.
#include "scene/scene.h"

// The texel index in [0, n) for position i outside or inside the image.
static int wrap(float i, int n, enum texture_wrap mode) {
    float size = (float)n;
    if (mode == TEXTURE_CLAMP) return (int)clampf(i, 0.0f, size - 1.0f);
    float tile = floorf(i / size);
    int inside = (int)clampf(i - tile * size, 0.0f, size - 1.0f);
    bool odd = mode == TEXTURE_MIRROR && tile - 2.0f * floorf(0.5f * tile) > 0.5f;
    return odd ? n - 1 - inside : inside;
}

static rgb texel(const struct image *image, int x, int y) {
    const float *t =
        image->texel + ((size_t)y * (size_t)image->width + (size_t)x) * (size_t)image->channels;
    return image->channels == 1 ? rgb_grey(t[0]) : rgb_make(t[0], t[1], t[2]);
}

static rgb bitmap(const struct texture *texture, float u, float v) {
    const struct image *image = texture->image;
    int w = image->width, h = image->height;
    float x = u * (float)w, y = v * (float)h;
    if (texture->nearest)
        return texel(image, wrap(floorf(x), w, texture->wrap), wrap(floorf(y), h, texture->wrap));
    x -= 0.5f;
    y -= 0.5f;
    float x0 = floorf(x), y0 = floorf(y), fx = x - x0, fy = y - y0;
    int left = wrap(x0, w, texture->wrap), right = wrap(x0 + 1.0f, w, texture->wrap);
    int top = wrap(y0, h, texture->wrap), bottom = wrap(y0 + 1.0f, h, texture->wrap);
    rgb upper = rgb_scale(texel(image, left, top), 1.0f - fx);
    rgb lower = rgb_scale(texel(image, left, bottom), 1.0f - fx);
    upper = rgb_mad(upper, texel(image, right, top), fx);
    lower = rgb_mad(lower, texel(image, right, bottom), fx);
    return rgb_mad(rgb_scale(upper, 1.0f - fy), lower, fy);
}

rgb texture_eval(const struct texture *texture, vec2 uv) {
    if (texture->kind == TEXTURE_CONSTANT) return texture->value;
    const float *m = texture->to_uv;
    float u = m[0] * uv.x + m[1] * uv.y + m[2];
    float v = m[3] * uv.x + m[4] * uv.y + m[5];
    // Coordinates that are not finite, or so large that a float no longer resolves a texel.
    if (!(fabsf(u) < 1e7f && fabsf(v) < 1e7f)) return texture->mean;
    if (texture->kind == TEXTURE_BITMAP) return bitmap(texture, u, v);
    bool right = u - floorf(u) > 0.5f, lower = v - floorf(v) > 0.5f;
    return right == lower ? texture->color0 : texture->color1;
}
