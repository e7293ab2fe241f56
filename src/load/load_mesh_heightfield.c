// SPDX-License-Identifier: Apache-2.0
// Meshes of height fields, as Mitsuba 0.6 has them: the first row of the heights is at y = -1, and
// a height is along z whatever the number of samples. Mitsuba 0.6 traces bilinear patches, here
// each is two triangles: in the middle of a cell these differ from the patch by a quarter of
// h(0, 0) - h(1, 0) - h(0, 1) + h(1, 1), which is 0 where the cell is flat.
#include "load/load_mesh.h"

// A grid of vertices, one per height.
struct height_grid {
    const struct heights *from;
    uint32_t columns, rows;
};

// The luminance, exactly that of a grey.
static float height_of_color(rgb c) { return c.r == c.g && c.g == c.b ? c.r : rgb_luminance(c); }

static float height_of(const struct height_grid *grid, uint32_t x, uint32_t y) {
    const struct heights *h = grid->from;
    const size_t width = (size_t)h->width, height = (size_t)h->height;
    const size_t i = (y < height ? y : height - 1) * width + (x < width ? x : width - 1);
    const float *value = h->value + i * (size_t)h->channels;
    const rgb color =
        h->channels == 1 ? rgb_grey(value[0]) : rgb_make(value[0], value[1], value[2]);
    return height_of_color(rgb_mul(color, h->factor));
}

static void set_vertices(const struct height_grid *grid, const struct raw_mesh *raw) {
    float *position = raw->position, *uv = raw->uv;
    for (uint32_t y = 0; y < grid->rows; y++)
        for (uint32_t x = 0; x < grid->columns; x++, position += 3, uv += 2) {
            uv[0] = (float)((double)x / (grid->columns - 1));
            uv[1] = (float)((double)y / (grid->rows - 1));
            position[0] = (float)(2.0 * x / (grid->columns - 1) - 1.0);
            position[1] = (float)(2.0 * y / (grid->rows - 1) - 1.0);
            position[2] = height_of(grid, x, y);
        }
}

static void add_normal(float *normal, float dx, float dy) {
    const vec3 n = v3_unit(v3(-dx, -dy, 1.0f));
    normal[0] += n.x;
    normal[1] += n.y;
    normal[2] += n.z;
}

// Sums at every vertex the unit normals of the bilinear patches around it, in a space in which
// cells have the size 1, as Mitsuba 0.6 weights them, and takes the sums to object space.
static void make_grid_normals(const struct height_grid *grid, const struct raw_mesh *raw) {
    const size_t columns = grid->columns;
    for (size_t y = 0; y + 1 < grid->rows; y++)
        for (size_t x = 0; x + 1 < columns; x++) {
            const size_t i = y * columns + x;
            const float *z = raw->position + 3 * i + 2, *above = z + 3 * columns;
            float *n = raw->normal + 3 * i, *n_above = n + 3 * columns;
            add_normal(n, z[3] - z[0], above[0] - z[0]);
            add_normal(n + 3, z[3] - z[0], above[3] - z[3]);
            add_normal(n_above, above[3] - above[0], above[0] - z[0]);
            add_normal(n_above + 3, above[3] - above[0], above[3] - z[3]);
        }
    for (size_t i = 0; i < raw->vertex_count; i++) {
        raw->normal[3 * i] *= 0.5f * (float)(columns - 1);
        raw->normal[3 * i + 1] *= 0.5f * (float)(grid->rows - 1);
    }
}

static void make_cells(const struct height_grid *grid, uint32_t *index) {
    for (uint32_t y = 0; y + 1 < grid->rows; y++)
        for (uint32_t x = 0; x + 1 < grid->columns; x++, index += 6) {
            const uint32_t i = y * grid->columns + x, above = i + grid->columns;
            const uint32_t corner[6] = {above, i, above + 1, above + 1, i, i + 1};
            for (int k = 0; k < 6; k++) index[k] = corner[k];
        }
}

satin_status load_mesh_heightfield(struct arena *arena, const struct mesh_request *request,
                                   const struct heights *heights, struct mesh *out) {
    const struct load_source source = {.arena = arena, .path = "shape"};
    const struct height_grid grid = {heights, heights->width > 1 ? (uint32_t)heights->width : 2,
                                     heights->height > 1 ? (uint32_t)heights->height : 2};
    struct raw_mesh raw;
    satin_status status =
        load_mesh_allocate(&source, grid.columns * grid.rows, !request->face_normals, true, &raw);
    if (status != SATIN_OK) return status;
    raw.triangle_count = 2 * (grid.columns - 1) * (grid.rows - 1);
    raw.index = arena_array(arena, (size_t)raw.triangle_count * 3, sizeof(uint32_t));
    if (!raw.index) return SATIN_ERROR_MEMORY;
    set_vertices(&grid, &raw);
    for (size_t i = 0; i < raw.vertex_count; i++)
        if (!(fabsf(raw.position[3 * i + 2]) <= SCENE_COORDINATE_MAX)) return SATIN_ERROR_INPUT;
    if (!request->face_normals) make_grid_normals(&grid, &raw);
    make_cells(&grid, raw.index);
    return load_mesh_finish(&source, request, &raw, out);
}
