// SPDX-License-Identifier: Apache-2.0
// The harmonics in one page: project a sky, rotate it, read it, light a surface by it.
// Build: cc example_rsh.c $(pkg-config --cflags --libs rsh) -lm
#include <math.h>
#include <rsh/rsh.h>
#include <stdio.h>

enum { ORDER = 6, N = ORDER * ORDER, SAMPLES = 4096 };
static const float PI = 3.14159265f;

// Evenly spread over the sphere.
static void direction(int i, float *x, float *y, float *z) {
    *z = 1.0f - (2.0f * (float)i + 1.0f) / SAMPLES;
    float s = sqrtf(1.0f - *z * *z), phi = 2.39996323f * (float)i;
    *x = s * cosf(phi);
    *y = s * sinf(phi);
}

// A blue sky with a broad warm light around +x; the ground is dark.
static void sky_color(float x, float z, float rgb[3]) {
    float sun = powf(fmaxf(x, 0.0f), 8.0f), blue = z > 0.0f ? 0.5f : 0.1f;
    rgb[0] = 0.4f * blue + 2.0f * sun;
    rgb[1] = 0.6f * blue + 1.6f * sun;
    rgb[2] = blue + 1.0f * sun;
}

int main(void) {
    static float x[SAMPLES], y[SAMPLES], z[SAMPLES], value[3][SAMPLES];
    const float weight = 4.0f * PI / SAMPLES;
    for (int i = 0; i < SAMPLES; i++) {
        float rgb[3];
        direction(i, &x[i], &y[i], &z[i]);
        sky_color(x[i], z[i], rgb);
        for (int c = 0; c < 3; c++) value[c][i] = weight * rgb[c];
    }

    // Projection adds to the coefficients; they lie channel after channel.
    float light[3 * N] = {0}, rotated[3 * N], seen[3];
    const rsh_samples sky = {SAMPLES, x, y, z, value[0], value[1], value[2]};
    rsh_project(RSH_SPHERE, ORDER, &sky, light);

    // A rotation by 90 degrees about z brings the sun from +x to +y.
    const float quarter[9] = {0, -1, 0, 1, 0, 0, 0, 0, 1};
    rsh_rotate(ORDER, 3, quarter, light, rotated);
    const float to_x[3] = {1, 0, 0}, to_y[3] = {0, 1, 0};
    rsh_value(RSH_SPHERE, ORDER, 3, light, to_x, seen);
    printf("towards +x before: %.3f %.3f %.3f\n", (double)seen[0], (double)seen[1],
           (double)seen[2]);
    rsh_value(RSH_SPHERE, ORDER, 3, rotated, to_y, seen);
    printf("towards +y after:  %.3f %.3f %.3f\n", (double)seen[0], (double)seen[1],
           (double)seen[2]);

    // Irradiance: the convolution with max(cos theta, 0) about the normal.
    float zonal[ORDER] = {0}, irradiance[3 * N];
    for (int i = 0; i < SAMPLES; i++) {
        const float w[3] = {x[i], y[i], z[i]};
        float basis[N];
        rsh_eval(RSH_SPHERE, ORDER, w, basis);
        for (int l = 0; l < ORDER; l++) zonal[l] += weight * fmaxf(w[2], 0.0f) * basis[l * (l + 1)];
    }
    rsh_convolve(ORDER, 3, zonal, rotated, irradiance);
    rsh_value(RSH_SPHERE, ORDER, 3, irradiance, to_y, seen);
    printf("irradiance on a wall facing +y: %.3f %.3f %.3f\n", (double)seen[0], (double)seen[1],
           (double)seen[2]);

    // The coefficients of red, as other programs keep them.
    const rsh_convention geodesy = {RSH_FOUR_PI, false, RSH_COSINE_SINE};
    float other[2 * N];
    rsh_export(&geodesy, ORDER, 1, rotated, other);
    printf("mean red: %.3f\n", (double)other[0]);
    return fabsf(seen[0]) < 100.0f ? 0 : 1;
}
