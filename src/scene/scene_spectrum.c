// SPDX-License-Identifier: Apache-2.0
// Spectra of scene files: read from text and from .spd files, and integrated against the standard
// observer. The steps of the integral and its scale are those of Mitsuba 3 (measured on its RGB
// mode), so that colours agree to the last digits and not just in principle.
#include "scene/scene_spectrum.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "base/fileio.h"
#include "base/text.h"

enum { SAMPLES_MAX = 100000, FILE_MAX_BYTES = 1 << 24, STEPS = 1000 };
// The integral of y over wavelength, so that light of one unit at all of them has luminance 1; and
// what D65 is divided by so that the luminance of white in it is 1.
static const double y_integral = 106.7502593994140625, d65_scale = 98.99741751876255;

void spectrum_free(struct spectrum *spectrum) {
    free(spectrum->wavelength);
    free(spectrum->value);
    *spectrum = (struct spectrum){0};
}

// ---- Conversion ---------------------------------------------------------------------------------

// Row of the CIE's table at a wavelength inside of it.
static void observer_at(double wavelength, double out[4]) {
    double at = (wavelength - SPECTRUM_CIE_FIRST) / SPECTRUM_CIE_STEP;
    int i = (int)fmin(fmax(at, 0.0), SPECTRUM_CIE_ROWS - 2);
    for (int k = 0; k < 4; k++) {
        double a = scene_spectrum_cie[i][k], b = scene_spectrum_cie[i + 1][k];
        out[k] = a + (at - i) * (b - a);
    }
}

static double value_at(const struct spectrum *s, double wavelength, size_t *at) {
    if (!s->count || wavelength < s->wavelength[0] || wavelength > s->wavelength[s->count - 1])
        return 0.0;
    while (*at + 2 < s->count && s->wavelength[*at + 1] < wavelength) ++*at;
    if (s->count == 1) return s->value[0];
    double a = s->wavelength[*at], b = s->wavelength[*at + 1];
    return s->value[*at] + (wavelength - a) / (b - a) * (s->value[*at + 1] - s->value[*at]);
}

// h c^2 and h c / k in SI units.
static double planck(double nanometres, double kelvin) {
    const double h = 6.62607004e-34, c = 2.99792458e8, k = 1.38064852e-23;
    double l = nanometres * 1e-9;
    return 1e-9 * 2.0 * h * c * c / (pow(l, 5.0) * expm1(h * c / (l * k * kelvin)));
}

// Of an integral by STEPS steps, or as it is.
static rgb xyz_to_rgb(const double xyz[3], double scale) {
    static const double m[3][3] = {{3.240479, -1.537150, -0.498535},
                                   {-0.969256, 1.875991, 0.041556},
                                   {0.055648, -0.204043, 1.057311}};
    float c[3];
    for (int i = 0; i < 3; i++) {
        double sum = m[i][0] * xyz[0] + m[i][1] * xyz[1] + m[i][2] * xyz[2];
        c[i] = (float)fmax(sum * scale, 0.0);
    }
    return rgb_make(c[0], c[1], c[2]);
}

static double step_wavelength(int i) {
    const double range = SPECTRUM_CIE_STEP * (SPECTRUM_CIE_ROWS - 1);
    return SPECTRUM_CIE_FIRST + range * i / (STEPS - 1);
}

// A step of the integral over that of y.
static double step_share(void) {
    const double range = SPECTRUM_CIE_STEP * (SPECTRUM_CIE_ROWS - 1);
    return range / STEPS / y_integral;
}

rgb spectrum_to_rgb(const struct spectrum *spectrum, bool light) {
    double xyz[3] = {0.0, 0.0, 0.0}, row[4];
    size_t at = 0;
    for (int i = 0; i < STEPS; i++) {
        double wavelength = step_wavelength(i), y = value_at(spectrum, wavelength, &at);
        observer_at(wavelength, row);
        if (!light) y *= row[3] / d65_scale;
        for (int k = 0; k < 3; k++) xyz[k] += row[k] * y;
    }
    return xyz_to_rgb(xyz, step_share());
}

rgb spectrum_filtered(double kelvin, double (*share)(const void *ctx, double nanometres),
                      const void *ctx) {
    double xyz[3] = {0.0, 0.0, 0.0}, row[4];
    for (int i = 0; i < STEPS; i++) {
        double wavelength = step_wavelength(i), passed = share(ctx, wavelength);
        observer_at(wavelength, row);
        for (int k = 0; k < 3; k++) xyz[k] += row[k] * planck(wavelength, kelvin) * passed;
    }
    return xyz_to_rgb(xyz, step_share());
}

// Nothing outside of two wavelengths.
static double between(const void *ctx, double wavelength) {
    const double *range = ctx;
    return wavelength >= range[0] && wavelength <= range[1] ? 1.0 : 0.0;
}

rgb spectrum_blackbody(double kelvin, double first, double last) {
    const double range[2] = {first, last};
    return spectrum_filtered(kelvin, between, range);
}

rgb spectrum_chromaticity(double x, double y, double luminance) {
    double scale = y > 0.0 ? luminance / y : 0.0;
    return xyz_to_rgb((const double[3]){x, y, 1.0 - x - y}, scale);
}

// ---- Reading ------------------------------------------------------------------------------------

satin_status spectrum_add(struct log log, struct log_place place, struct spectrum *spectrum,
                          double wavelength, double value) {
    size_t n = spectrum->count, capacity[2] = {n, n};
    if (n == SAMPLES_MAX || (n && !(wavelength > spectrum->wavelength[n - 1]))) {
        log_error_at(log, place,
                     n == SAMPLES_MAX ? "a spectrum has more than %zu samples"
                                      : "wavelengths do not ascend at sample %zu",
                     n);
        return SATIN_ERROR_INPUT;
    }
    // Room for a power of two samples: the arrays grow when their count is one.
    bool full = (n & (n - 1)) == 0;
    size_t room = n ? 2 * n : 1;
    if (full &&
        (!array_reserve((void **)&spectrum->wavelength, &capacity[0], room, sizeof(double)) ||
         !array_reserve((void **)&spectrum->value, &capacity[1], room, sizeof(double))))
        return log_fail(log, SATIN_ERROR_MEMORY, "%s: not enough memory for a spectrum",
                        place.file);
    spectrum->wavelength[n] = wavelength;
    spectrum->value[n] = value;
    spectrum->count++;
    return SATIN_OK;
}

// Cuts the next word off `*text`; false if there is none, or it is longer than a number.
static bool next_number(const char **text, const char *ends, double *out) {
    char word[64];
    size_t n = strcspn(*text, ends);
    if (!n || n >= sizeof word) return false;
    memcpy(word, *text, n);
    word[n] = 0;
    if (!text_double(word, out) || !(fabs(*out) < 1e30)) return false;
    *text += n;
    return true;
}

static satin_status add_pair(struct log log, struct log_place place, const char **text,
                             const char *between, struct spectrum *out) {
    static const char ends[] = " \t\r\n,:#";
    double wavelength, value;
    bool good = next_number(text, ends, &wavelength);
    size_t gap = good ? strspn(*text, between) : 0;
    good = good && gap;
    if (good) *text += gap;
    if (good && next_number(text, ends, &value))
        return spectrum_add(log, place, out, wavelength, value);
    log_error_at(log, place, "a spectrum is a list of pairs of wavelength and value, not '%.40s'",
                 *text);
    return SATIN_ERROR_INPUT;
}

satin_status spectrum_parse(struct log log, struct log_place place, const char *text,
                            struct spectrum *out) {
    static const char blanks[] = " \t\r\n,";
    struct spectrum spectrum = {0};
    satin_status status = SATIN_OK;
    for (text += strspn(text, blanks); *text && status == SATIN_OK; text += strspn(text, blanks))
        status = add_pair(log, place, &text, ": ", &spectrum);
    if (status == SATIN_OK)
        *out = spectrum;
    else
        spectrum_free(&spectrum);
    return status;
}

satin_status spectrum_read(struct log log, struct log_place place, const char *path, uint64_t *hash,
                           struct spectrum *out) {
    char *data;
    size_t size;
    satin_status status = fileio_read(log, place, path, FILE_MAX_BYTES, &data, &size);
    if (status != SATIN_OK) return status;
    if (hash) *hash = fileio_hash(*hash, data, size);
    struct spectrum spectrum = {0};
    struct log_place line = {path, 1, 0};
    for (const char *text = data; *text && status == SATIN_OK;) {
        text += strspn(text, " \t\r,");
        if (*text == '#') text += strcspn(text, "\n");
        if (*text == '\n') {
            line.line++;
            text++;
        } else if (*text) {
            status = add_pair(log, line, &text, " \t,:", &spectrum);
        }
    }
    free(data);
    if (status == SATIN_OK && !spectrum.count) {
        log_error_at(log, (struct log_place){path, 0, 0}, "there is no sample in it");
        status = SATIN_ERROR_INPUT;
    }
    if (status == SATIN_OK)
        *out = spectrum;
    else
        spectrum_free(&spectrum);
    return status;
}
