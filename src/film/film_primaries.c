// SPDX-License-Identifier: Apache-2.0
// Colours of other primaries as those of sRGB. A file says by its attribute chromaticities in which
// primaries its colours are; pictures are in those of sRGB. A colour becomes XYZ [CIE 1931], is
// adapted from the white of the file to that of sRGB by the matrix of Bradford [Lam 1985], so that
// white stays white, and becomes sRGB.
#include <math.h>
#include <stdio.h>

#include "film/film.h"

// Files round coordinates in different ways.
static const float COORDINATE_NOISE = 2e-4f;
// Primaries whose determinant is below this are almost on a line, and have no colours.
static const double DETERMINANT_LEAST = 1e-6;

// Row by row, for column vectors.
struct matrix3 {
    double m[3][3];
};

static const struct matrix3 bradford = {
    {{0.8951, 0.2664, -0.1614}, {-0.7502, 1.7135, 0.0367}, {0.0389, -0.0685, 1.0296}}};

static struct matrix3 multiply_matrices(const struct matrix3 *a, const struct matrix3 *b) {
    struct matrix3 out = {{{0.0}}};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            for (int k = 0; k < 3; k++) out.m[i][j] += a->m[i][k] * b->m[k][j];
    return out;
}

static void transform_column(const struct matrix3 *a, const double in[3], double out[3]) {
    for (int i = 0; i < 3; i++)
        out[i] = a->m[i][0] * in[0] + a->m[i][1] * in[1] + a->m[i][2] * in[2];
}

static bool invert_matrix(const struct matrix3 *a, struct matrix3 *out) {
    struct matrix3 cofactor;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            cofactor.m[i][j] = a->m[i1][j1] * a->m[i2][j2] - a->m[i1][j2] * a->m[i2][j1];
        }
    const double determinant = a->m[0][0] * cofactor.m[0][0] + a->m[0][1] * cofactor.m[0][1] +
                               a->m[0][2] * cofactor.m[0][2];
    if (!(fabs(determinant) > DETERMINANT_LEAST) || !isfinite(determinant)) return false;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) out->m[i][j] = cofactor.m[j][i] / determinant;
    return true;
}

// The XYZ of a chromaticity x y, with Y = 1. False if it has no luminance.
static bool xyz_of(const float xy[2], double out[3]) {
    const double x = (double)xy[0], y = (double)xy[1];
    if (!(y > 0.0) || !isfinite(x) || !isfinite(y)) return false;
    out[0] = x / y;
    out[1] = 1.0;
    out[2] = (1.0 - x - y) / y;
    return true;
}

// The matrix from colours of these primaries to XYZ.
static bool matrix_to_xyz(const float chromaticities[8], struct matrix3 *out) {
    struct matrix3 inverse;
    double white[3], scale[3];
    // A primary may have no luminance, so its column is x y z, which the white scales.
    for (int c = 0; c < 3; c++) {
        out->m[0][c] = (double)chromaticities[2 * c];
        out->m[1][c] = (double)chromaticities[2 * c + 1];
        out->m[2][c] = 1.0 - out->m[0][c] - out->m[1][c];
    }
    if (!xyz_of(&chromaticities[6], white) || !invert_matrix(out, &inverse)) return false;
    transform_column(&inverse, white, scale);
    for (int i = 0; i < 3; i++)
        for (int c = 0; c < 3; c++) out->m[i][c] *= scale[c];
    return true;
}

// The matrix that adapts XYZ from one white to another.
static bool matrix_of_whites(const float from[2], const float to[2], struct matrix3 *out) {
    struct matrix3 inverse, scaled = bradford;
    double a[3], b[3], cone_a[3], cone_b[3];
    if (!xyz_of(from, a) || !xyz_of(to, b) || !invert_matrix(&bradford, &inverse)) return false;
    transform_column(&bradford, a, cone_a);
    transform_column(&bradford, b, cone_b);
    for (int i = 0; i < 3; i++) {
        if (!(cone_a[i] > 0.0)) return false;
        for (int j = 0; j < 3; j++) scaled.m[i][j] *= cone_b[i] / cone_a[i];
    }
    *out = multiply_matrices(&inverse, &scaled);
    return true;
}

bool film_same_primaries(const float a[8], const float b[8]) {
    for (int i = 0; i < 8; i++)
        if (!(fabsf(a[i] - b[i]) <= COORDINATE_NOISE)) return false;
    return true;
}

static bool find_conversion(const float from[8], const float to[8], struct matrix3 *out) {
    struct matrix3 to_xyz, target, inverse, adapted;
    if (!matrix_to_xyz(from, &to_xyz) || !matrix_to_xyz(to, &target)) return false;
    if (!invert_matrix(&target, &inverse) || !matrix_of_whites(&from[6], &to[6], &adapted))
        return false;
    adapted = multiply_matrices(&adapted, &to_xyz);
    *out = multiply_matrices(&inverse, &adapted);
    return true;
}

bool film_convert_primaries(struct satin_film *film, const char *layer) {
    struct matrix3 conversion;
    float *plane[3];
    char name[256];
    if (film_same_primaries(film->chromaticities, film_srgb_chromaticities)) return true;
    if (!find_conversion(film->chromaticities, film_srgb_chromaticities, &conversion)) return false;
    for (int c = 0; c < 3; c++) {
        snprintf(name, sizeof name, "%s%s%c", layer ? layer : "", layer ? "." : "", "RGB"[c]);
        plane[c] = film_channel(film, name);
        if (!plane[c]) return false;
    }
    for (size_t i = 0; i < (size_t)film->width * (size_t)film->height; i++) {
        const double in[3] = {(double)plane[0][i], (double)plane[1][i], (double)plane[2][i]};
        double out[3];
        transform_column(&conversion, in, out);
        for (int c = 0; c < 3; c++) plane[c][i] = (float)out[c];
    }
    return true;
}
