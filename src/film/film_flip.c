// SPDX-License-Identifier: Apache-2.0
// LDR-FLIP, the difference that a viewer sees who flips between two pictures [Andersson et al.
// 2020, "FLIP: A Difference Evaluator for Alternating Images"], for a display of 3840 pixels over
// .7 m at a distance of .7 m. Pictures are linear sRGB, clamped to [0, 1].
//
// Colours: both pictures are filtered by the contrast sensitivity of the eye, in the opponent space
// YCxCz, and compared in L*a*b* by the HyAB distance, with the chroma of dark colours reduced.
// Edges and points: the largest difference of their strength in luminance. The two are combined as
// dC^(1 - dF). Pixels beyond the border are those of the border.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "film/film.h"

// Pixels per degree of the angle of view.
static const double PIXELS_PER_DEGREE = 0.7 * (3840.0 / 0.7) * (3.14159265358979323846 / 180.0);

// The parameters of the paper: exponents of colours and features, the width of features in degrees,
// and the two points of the map from distances to errors.
static const float COLOR_EXPONENT = 0.7f, FEATURE_EXPONENT = 0.5f;
static const double FEATURE_WIDTH = 0.082;
static const float KNEE_DISTANCE = 0.4f, KNEE_ERROR = 0.95f;

// A contrast sensitivity function is a sum of two Gaussians of these weights and widths.
static const struct sensitivity {
    double a1, b1, a2, b2;
} sensitivities[3] = {
    {1.0, 0.0047, 0.0, 1e-5}, {1.0, 0.0053, 0.0, 1e-5}, {34.1, 0.04, 13.5, 0.025}};

enum { TAPS_MAX = 32 };  // on either side of the middle; the filters have 10 and 9

// ---- Colours ------------------------------------------------------------------------------------

// Linear sRGB to XYZ, as the authors' program has it, whose sums of rows are the white.
static const float XYZ[3][3] = {
    {10135552.0f / 24577794.0f, 8788810.0f / 24577794.0f, 4435075.0f / 24577794.0f},
    {2613072.0f / 12288897.0f, 8788810.0f / 12288897.0f, 887015.0f / 12288897.0f},
    {1425312.0f / 73733382.0f, 8788810.0f / 73733382.0f, 70074185.0f / 73733382.0f}};
static const float WHITE[3] = {0.950428545f, 1.0f, 1.088900371f};

static void to_xyz(const float linear[3], float xyz[3]) {
    for (int i = 0; i < 3; i++)
        xyz[i] = (XYZ[i][0] * linear[0] + XYZ[i][1] * linear[1] + XYZ[i][2] * linear[2]) / WHITE[i];
}

// The inverse of to_xyz, by Cramer's rule.
static void from_xyz(const float xyz[3], float linear[3]) {
    const float in[3] = {xyz[0] * WHITE[0], xyz[1] * WHITE[1], xyz[2] * WHITE[2]};
    double determinant = 0.0;
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        determinant +=
            (double)XYZ[0][i] * ((double)XYZ[1][j] * XYZ[2][k] - (double)XYZ[1][k] * XYZ[2][j]);
    }
    for (int i = 0; i < 3; i++) {
        double sum = 0.0;
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        for (int row = 0; row < 3; row++) {
            const int p = (row + 1) % 3, q = (row + 2) % 3;
            sum +=
                (double)in[row] * ((double)XYZ[p][j] * XYZ[q][k] - (double)XYZ[p][k] * XYZ[q][j]);
        }
        linear[i] = (float)(sum / determinant);
    }
}

static void to_opponent(const float linear[3], float out[3]) {
    float xyz[3];
    to_xyz(linear, xyz);
    out[0] = 116.0f * xyz[1] - 16.0f;
    out[1] = 500.0f * (xyz[0] - xyz[1]);
    out[2] = 200.0f * (xyz[1] - xyz[2]);
}

static float lab_f(float t) {
    const float delta = 6.0f / 29.0f;
    return t > delta * delta * delta ? cbrtf(t) : t / (3.0f * delta * delta) + 4.0f / 29.0f;
}

// L*a*b* with the chroma of dark colours reduced, after Hunt.
static void to_lab(const float linear[3], float lab[3]) {
    float xyz[3];
    to_xyz(linear, xyz);
    for (int i = 0; i < 3; i++) xyz[i] = lab_f(xyz[i]);
    lab[0] = 116.0f * xyz[1] - 16.0f;
    lab[1] = 0.01f * lab[0] * 500.0f * (xyz[0] - xyz[1]);
    lab[2] = 0.01f * lab[0] * 200.0f * (xyz[1] - xyz[2]);
}

static void opponent_to_lab(const float in[3], float lab[3]) {
    const float y = (in[0] + 16.0f) / 116.0f;
    const float xyz[3] = {y + in[1] / 500.0f, y, y - in[2] / 200.0f};
    float linear[3];
    from_xyz(xyz, linear);
    for (int i = 0; i < 3; i++) linear[i] = fminf(fmaxf(linear[i], 0.0f), 1.0f);
    to_lab(linear, lab);
}

static float color_distance(const float a[3], const float b[3]) {
    const float hyab = fabsf(a[0] - b[0]) + hypotf(a[1] - b[1], a[2] - b[2]);
    return powf(hyab, COLOR_EXPONENT);
}

// The largest distance of two colours: of green and blue.
static float largest_color_distance(void) {
    const float green[3] = {0.0f, 1.0f, 0.0f}, blue[3] = {0.0f, 0.0f, 1.0f};
    float a[3], b[3];
    to_lab(green, a);
    to_lab(blue, b);
    return color_distance(a, b);
}

static float color_error(float distance, float largest) {
    const float knee = KNEE_DISTANCE * largest;
    if (distance < knee) return KNEE_ERROR / knee * distance;
    return KNEE_ERROR + (distance - knee) / (largest - knee) * (1.0f - KNEE_ERROR);
}

// ---- Filters ------------------------------------------------------------------------------------

struct kernel {
    int radius;
    float tap[2 * TAPS_MAX + 1];
};

static int border(int i, int count) { return i < 0 ? 0 : i < count ? i : count - 1; }

// Filters the rows of a plane.
static void filter_rows(const float *in, int width, int height, const struct kernel *along,
                        float *out) {
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const float *row = in + (size_t)y * (size_t)width;
            float sum = 0.0f;
            for (int k = -along->radius; k <= along->radius; k++)
                sum += along->tap[k + along->radius] * row[border(x + k, width)];
            out[(size_t)y * (size_t)width + (size_t)x] = sum;
        }
}

// Adds `weight` times a plane whose columns are filtered to `out`.
static void add_filtered_columns(const float *in, int width, int height, const struct kernel *along,
                                 float weight, float *out) {
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            float sum = 0.0f;
            for (int k = -along->radius; k <= along->radius; k++)
                sum += along->tap[k + along->radius] *
                       in[(size_t)border(y + k, height) * (size_t)width + (size_t)x];
            out[(size_t)y * (size_t)width + (size_t)x] += weight * sum;
        }
}

// A Gaussian of the form exp(-pi^2 x^2 / b), x in degrees, of sum 1. Returns the sum before.
static double sensitivity_kernel(double b, int radius, struct kernel *out) {
    const double pi = 3.14159265358979323846;
    double sum = 0.0;
    out->radius = radius;
    for (int k = -radius; k <= radius; k++)
        sum += exp(-pi * pi * (k * k) / (PIXELS_PER_DEGREE * PIXELS_PER_DEGREE) / b);
    for (int k = -radius; k <= radius; k++)
        out->tap[k + radius] =
            (float)(exp(-pi * pi * (k * k) / (PIXELS_PER_DEGREE * PIXELS_PER_DEGREE) / b) / sum);
    return sum;
}

// Filters the plane of an opponent channel by its contrast sensitivity.
static void filter_channel(const float *in, int width, int height, int channel, float *scratch,
                           float *out) {
    const double pi = 3.14159265358979323846;
    const int radius = (int)ceil(3.0 * sqrt(0.04 / (2.0 * pi * pi)) * PIXELS_PER_DEGREE);
    const struct sensitivity *s = &sensitivities[channel];
    struct kernel first, second;
    const double sum1 = sensitivity_kernel(s->b1, radius, &first),
                 sum2 = sensitivity_kernel(s->b2, radius, &second);
    // The weights of the Gaussians, whose kernels have the sum 1 here.
    const double one = s->a1 * sqrt(pi / s->b1) * sum1 * sum1,
                 two = s->a2 * sqrt(pi / s->b2) * sum2 * sum2;
    memset(out, 0, (size_t)width * (size_t)height * sizeof *out);
    filter_rows(in, width, height, &first, scratch);
    add_filtered_columns(scratch, width, height, &first, (float)(one / (one + two)), out);
    if (!(two > 0.0)) return;
    filter_rows(in, width, height, &second, scratch);
    add_filtered_columns(scratch, width, height, &second, (float)(two / (one + two)), out);
}

// The kernels of features: a Gaussian of sum 1, and its first or second derivative, whose positive
// and negative taps each have the sum 1.
static void feature_kernels(struct kernel *gauss, struct kernel *edge, struct kernel *point) {
    const double deviation = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
    const int radius = (int)ceil(3.0 * deviation);
    double sum = 0.0, sums[2][2] = {{0.0}};
    gauss->radius = edge->radius = point->radius = radius;
    for (int pass = 0; pass < 2; pass++)
        for (int k = -radius; k <= radius; k++) {
            const double g = exp(-(k * k) / (2.0 * deviation * deviation));
            const double of[2] = {-k * g, (k * k / (deviation * deviation) - 1.0) * g};
            if (pass == 0) {
                sum += g;
                for (int i = 0; i < 2; i++) sums[i][of[i] < 0.0] += fabs(of[i]);
                continue;
            }
            gauss->tap[k + radius] = (float)(g / sum);
            edge->tap[k + radius] = (float)(of[0] / sums[0][of[0] < 0.0]);
            point->tap[k + radius] = (float)(of[1] / sums[1][of[1] < 0.0]);
        }
}

// Sets `out` to the strength of a feature in a plane of luminance: the length of the plane's
// derivatives along x and y. The three scratch planes are overwritten.
static void feature_strength(const float *luminance, int width, int height,
                             const struct kernel *derivative, const struct kernel *gauss,
                             float *const scratch[3], float *out) {
    const size_t count = (size_t)width * (size_t)height;
    memset(scratch[1], 0, count * sizeof *out);
    memset(scratch[2], 0, count * sizeof *out);
    filter_rows(luminance, width, height, derivative, scratch[0]);
    add_filtered_columns(scratch[0], width, height, gauss, 1.0f, scratch[1]);
    filter_rows(luminance, width, height, gauss, scratch[0]);
    add_filtered_columns(scratch[0], width, height, derivative, 1.0f, scratch[2]);
    for (size_t i = 0; i < count; i++) out[i] = hypotf(scratch[1][i], scratch[2][i]);
}

// ---- The difference -----------------------------------------------------------------------------

// Sets the opponent planes of a picture, and its luminance from 0 to 1.
static void set_opponent(const float *const light[3], size_t count, float *const out[3],
                         float *luminance) {
    for (size_t i = 0; i < count; i++) {
        float linear[3], opponent[3];
        for (int c = 0; c < 3; c++) linear[c] = fminf(fmaxf(light[c][i], 0.0f), 1.0f);
        to_opponent(linear, opponent);
        for (int c = 0; c < 3; c++) out[c][i] = opponent[c];
        luminance[i] = (opponent[0] + 16.0f) / 116.0f;
    }
}

// Planes of floats, `count` each.
enum {
    PLANE_OPPONENT,                   // three
    PLANE_LUMINANCE = 3,              // of both pictures
    PLANE_FILTERED = 5,               // three of each picture
    PLANE_EDGE = PLANE_FILTERED + 6,  // of each picture
    PLANE_POINT = PLANE_EDGE + 2,     // of each picture
    PLANE_SCRATCH = PLANE_POINT + 2,  // three
    FLIP_PLANES = PLANE_SCRATCH + 3
};

static void prepare_picture(const float *const light[3], int width, int height, int which,
                            float *const plane[FLIP_PLANES]) {
    const size_t count = (size_t)width * (size_t)height;
    struct kernel gauss, edge, point;
    feature_kernels(&gauss, &edge, &point);
    set_opponent(light, count, &plane[PLANE_OPPONENT], plane[PLANE_LUMINANCE + which]);
    for (int c = 0; c < 3; c++)
        filter_channel(plane[PLANE_OPPONENT + c], width, height, c, plane[PLANE_SCRATCH],
                       plane[PLANE_FILTERED + 3 * which + c]);
    feature_strength(plane[PLANE_LUMINANCE + which], width, height, &edge, &gauss,
                     &plane[PLANE_SCRATCH], plane[PLANE_EDGE + which]);
    feature_strength(plane[PLANE_LUMINANCE + which], width, height, &point, &gauss,
                     &plane[PLANE_SCRATCH], plane[PLANE_POINT + which]);
}

static float pixel_error(float *const plane[FLIP_PLANES], size_t i, float largest) {
    float lab[2][3];
    for (int which = 0; which < 2; which++) {
        float opponent[3];
        for (int c = 0; c < 3; c++) opponent[c] = plane[PLANE_FILTERED + 3 * which + c][i];
        opponent_to_lab(opponent, lab[which]);
    }
    const float color = color_error(color_distance(lab[0], lab[1]), largest);
    const float edges = fabsf(plane[PLANE_EDGE][i] - plane[PLANE_EDGE + 1][i]);
    const float points = fabsf(plane[PLANE_POINT][i] - plane[PLANE_POINT + 1][i]);
    const float feature =
        powf(fmaxf(edges, points) * (float)(1.0 / 1.41421356237309515), FEATURE_EXPONENT);
    return powf(color, 1.0f - feature);
}

satin_status film_flip(const float *const image[3], const float *const reference[3], int width,
                       int height, struct log log, float *map) {
    const size_t count = (size_t)width * (size_t)height;
    float *memory = array_new_unset(count, FLIP_PLANES * sizeof *memory);
    float *plane[FLIP_PLANES];
    if (!memory) return log_fail(log, SATIN_ERROR_MEMORY, "not enough memory to compare images");
    for (int i = 0; i < FLIP_PLANES; i++) plane[i] = memory + (size_t)i * count;
    prepare_picture(image, width, height, 0, plane);
    prepare_picture(reference, width, height, 1, plane);
    const float largest = largest_color_distance();
    for (size_t i = 0; i < count; i++) map[i] = pixel_error(plane, i, largest);
    free(memory);
    return SATIN_OK;
}
