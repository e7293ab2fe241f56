// SPDX-License-Identifier: Apache-2.0
// Samples textured faces of area lights by the emission of the cells of a grid over them, mixed
// with sampling without the texture. If one texel in a thousand is bright, sampling by area gives
// noise that a few samples do not reveal, which misleads adaptive sampling.
#include "base/sampling.h"
#include "light/light_kinds.h"

enum {
    TEXELS_GRID = 64,  // cells per side of the face
    LOOKS = 8  // texture lookups per side of a cell, which hit each texel of images up to 512 wide
};
// The largest fraction of samples by the grid: its lookups may have missed emission of a cell.
#define GRID_MOST 0.9f

static float cell_luminance(const struct light *light, const struct mesh *mesh,
                            const struct light_face *face, int column, int row) {
    float sum = 0.0f;
    for (int k = 0; k < LOOKS * LOOKS; k++) {
        const float s = ((float)column + ((float)(k % LOOKS) + 0.5f) / LOOKS) / TEXELS_GRID;
        const float t = ((float)row + ((float)(k / LOOKS) + 0.5f) / LOOKS) / TEXELS_GRID;
        const struct texture_lookup at = scene_texture_at(light_face_uv(face, mesh, s, t));
        sum += rgb_luminance(scene_texture_eval(light->texture, &at));
    }
    return sum / (LOOKS * LOOKS);
}

// The fraction of the variance of sampling by area that the grid removes.
static float contrast(const float *cell) {
    double sum = 0.0, squares = 0.0;
    for (int i = 0; i < TEXELS_GRID * TEXELS_GRID; i++) {
        sum += (double)cell[i];
        squares += (double)cell[i] * (double)cell[i];
    }
    return squares > 0.0 ? (float)fmax(1.0 - sum * sum / (TEXELS_GRID * TEXELS_GRID * squares), 0.0)
                         : 0.0f;
}

satin_status light_texels_build(struct satin_scene *scene, const struct light *light,
                                struct light_face *face) {
    const struct mesh *mesh = &scene->shape[light->shape].mesh;
    float *row_cdf = arena_array(&scene->arena, TEXELS_GRID + 1, sizeof *row_cdf);
    float *column_cdf =
        arena_array(&scene->arena, TEXELS_GRID * (TEXELS_GRID + 1), sizeof *column_cdf);
    float *cell = arena_array(&scene->arena, TEXELS_GRID * TEXELS_GRID, sizeof *cell);
    if (!row_cdf || !column_cdf || !cell) return SATIN_ERROR_MEMORY;
    float sum[TEXELS_GRID];
    for (int row = 0; row < TEXELS_GRID; row++) {
        float *line = cell + (size_t)row * TEXELS_GRID;
        for (int i = 0; i < TEXELS_GRID; i++) line[i] = cell_luminance(light, mesh, face, i, row);
        sum[row] = (float)sample_cdf_build(line, TEXELS_GRID,
                                           column_cdf + (size_t)row * (TEXELS_GRID + 1));
    }
    sample_cdf_build(sum, TEXELS_GRID, row_cdf);
    face->grid = fminf(contrast(cell), GRID_MOST);
    face->row_cdf = row_cdf;
    face->column_cdf = column_cdf;
    return SATIN_OK;
}

vec2 light_texels_sample(const struct light_face *face, float u, float v) {
    const size_t row = sample_cdf(face->row_cdf, TEXELS_GRID, v, &v);
    const size_t column =
        sample_cdf(face->column_cdf + row * (TEXELS_GRID + 1), TEXELS_GRID, u, &u);
    return (vec2){((float)column + u) / TEXELS_GRID, ((float)row + v) / TEXELS_GRID};
}

static size_t grid_index(float x) { return (size_t)clampf(x * TEXELS_GRID, 0.0f, TEXELS_GRID - 1); }

float light_texels_density(const struct light_face *face, vec2 st) {
    const size_t row = grid_index(st.y), column = grid_index(st.x);
    const float *cdf = face->column_cdf + row * (TEXELS_GRID + 1);
    return (face->row_cdf[row + 1] - face->row_cdf[row]) * (cdf[column + 1] - cdf[column]) *
           (TEXELS_GRID * TEXELS_GRID);
}
