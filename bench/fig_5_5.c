// SPDX-License-Identifier: Apache-2.0
// Figure 5.5 of [K05]: the error of the series for the rotation about y, orders 5 and 8, 0 to 40
// degrees. Maximum: the largest singular value of the difference to the exact matrix, so over all
// unit vectors and not a sample of them. Mean: the mean singular value, which is what the thesis
// calls the average error; rms: the true root mean square over unit vectors. lobe: the distance for
// the coefficients of cos^7(theta) above the horizon; relative: that over their length.
// plot_rotation.py draws it.
//
// usage: fig_5_5
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "rsh/rsh.h"

enum { N_MAX = 8, SIZE = 2 * N_MAX - 1, EXPONENT = 7 };
static const double FIGURE_PI = 3.14159265358979323846;
static const char *const kinds[] = {"1", "1.5", "2"};

// Eigenvalues of the symmetric matrix a by Jacobi's rotations; they are left on its diagonal.
static void diagonalize(int size, double a[SIZE][SIZE]) {
    for (int sweep = 0; sweep < 30; sweep++)
        for (int p = 0; p < size; p++)
            for (int q = p + 1; q < size; q++) {
                if (fabs(a[p][q]) < 1e-300) continue;
                double theta = 0.5 * atan2(2 * a[p][q], a[q][q] - a[p][p]);
                double c = cos(theta), s = sin(theta);
                for (int k = 0; k < size; k++) {
                    double x = a[k][p], y = a[k][q];
                    a[k][p] = c * x - s * y;
                    a[k][q] = s * x + c * y;
                }
                for (int k = 0; k < size; k++) {
                    double x = a[p][k], y = a[q][k];
                    a[p][k] = c * x - s * y;
                    a[q][k] = s * x + c * y;
                }
            }
}

struct errors {
    double most, mean, rms, lobe, relative;
};

// The matrix of band l: the series from derivatives 0 .. 2 at angle 0, less the exact one.
static void difference_of_rotations(int l, int kind, double beta, const float *d,
                                    const float *exact, int step, double m[SIZE][SIZE]) {
    int size = 2 * l + 1, first = l * (2 * l - 1) * (2 * l + 1) / 3;
    for (int i = 0; i < size; i++)
        for (int j = 0; j < size; j++) {
            int k = first + i * size + j;
            double second = kind == 2 || (kind == 1 && i == j) ? (double)d[2 * step + k] : 0.0;
            m[i][j] = (double)d[k] + beta * (double)d[step + k] + 0.5 * beta * beta * second -
                      (double)exact[k];
        }
}

static struct errors errors_of(int order, int kind, double beta, const double *zonal) {
    static float at_zero[3 * RSH_MAX_BLOCKS], exact[RSH_MAX_BLOCKS];
    struct errors e = {0};
    double length = 0.0;
    rsh_rotation_y_derivatives(order, 0.0f, 2, at_zero);
    rsh_rotation_y_derivatives(order, (float)beta, 0, exact);
    for (int l = 0; l < order; l++) {
        double m[SIZE][SIZE], square[SIZE][SIZE] = {{0}};
        int size = 2 * l + 1;
        difference_of_rotations(l, kind, beta, at_zero, exact, rsh_blocks_size(order), m);
        for (int i = 0; i < size; i++) {
            e.lobe += m[i][l] * m[i][l] * zonal[l] * zonal[l];
            for (int j = 0; j < size; j++)
                for (int k = 0; k < size; k++) square[j][k] += m[i][j] * m[i][k];
        }
        length += zonal[l] * zonal[l];
        diagonalize(size, square);
        for (int i = 0; i < size; i++) {
            double value = sqrt(fmax(square[i][i], 0.0));
            e.most = fmax(e.most, value);
            e.mean += value / (order * order);
            e.rms += value * value / (order * order);
        }
    }
    e.rms = sqrt(e.rms);
    e.lobe = sqrt(e.lobe);
    e.relative = e.lobe / sqrt(length);
    return e;
}

// Coefficients m = 0 of cos^EXPONENT above the horizon, by the midpoint rule.
static void project_lobe(double *zonal) {
    enum { STEPS = 20000 };
    memset(zonal, 0, N_MAX * sizeof *zonal);
    for (int i = 0; i < STEPS; i++) {
        double z = (i + 0.5) / STEPS;
        float y[N_MAX * N_MAX];
        rsh_eval(RSH_SPHERE, N_MAX, (float[3]){(float)sqrt(1 - z * z), 0.0f, (float)z}, y);
        for (int l = 0; l < N_MAX; l++)
            zonal[l] += 2 * FIGURE_PI / STEPS * pow(z, EXPONENT) * (double)y[l * (l + 1)];
    }
}

int main(void) {
    double zonal[N_MAX];
    project_lobe(zonal);
    printf("n\tdegrees\torder\tmaximum\tmean\trms\tlobe\trelative\n");
    for (int n = 5; n <= 8; n += 3)
        for (int kind = 0; kind < 3; kind++)
            for (int degrees = 0; degrees <= 40; degrees++) {
                struct errors e = errors_of(n, kind, degrees * FIGURE_PI / 180, zonal);
                printf("%d\t%d\t%s\t%.4f\t%.4f\t%.4f\t%.4f\t%.4f\n", n, degrees, kinds[kind],
                       e.most, e.mean, e.rms, e.lobe, e.relative);
            }
    return 0;
}
