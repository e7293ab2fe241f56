// SPDX-License-Identifier: Apache-2.0
// Reads spectra from text and from .spd files.
#include "load/load_spectrum.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "base/fileio.h"
#include "base/text.h"

enum { SAMPLES_MAX = 100000, FILE_MAX_BYTES = 1 << 24 };

satin_status load_spectrum_add(struct log log, struct log_place place, struct spectrum *spectrum,
                               double wavelength, double value) {
    size_t n = spectrum->count, capacity[2] = {n, n};
    if (n == SAMPLES_MAX || (n && !(wavelength > spectrum->wavelength[n - 1]))) {
        log_error_at(log, place,
                     n == SAMPLES_MAX ? "a spectrum has more than %zu samples"
                                      : "wavelengths do not ascend at sample %zu",
                     n);
        return SATIN_ERROR_INPUT;
    }
    // The capacity is a power of two: the arrays grow when their count is one.
    bool full = (n & (n - 1)) == 0;
    size_t enough = n ? 2 * n : 1;
    if (full &&
        (!array_reserve((void **)&spectrum->wavelength, &capacity[0], enough, sizeof(double)) ||
         !array_reserve((void **)&spectrum->value, &capacity[1], enough, sizeof(double))))
        return log_fail(log, SATIN_ERROR_MEMORY, "%s: not enough memory for a spectrum",
                        place.file);
    spectrum->wavelength[n] = wavelength;
    spectrum->value[n] = value;
    spectrum->count++;
    return SATIN_OK;
}

// Reads the next number and advances *text. False if there is none, or if the word is too long for
// a number.
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

static satin_status add_spectrum_pair(struct log log, struct log_place place, const char **text,
                                      const char *between, struct spectrum *out) {
    static const char ends[] = " \t\r\n,:#";
    double wavelength, value;
    const char *pair = *text;
    bool good = next_number(text, ends, &wavelength);
    size_t gap = good ? strspn(*text, between) : 0;
    good = good && gap;
    if (good) *text += gap;
    if (good && next_number(text, ends, &value))
        return load_spectrum_add(log, place, out, wavelength, value);
    log_error_at(log, place, "a spectrum is a list of pairs of wavelength and value, not '%.40s'",
                 pair);
    return SATIN_ERROR_INPUT;
}

satin_status load_spectrum_parse(struct log log, struct log_place place, const char *text,
                                 struct spectrum *out) {
    static const char blanks[] = " \t\r\n,";
    struct spectrum spectrum = {0};
    satin_status status = SATIN_OK;
    for (text += strspn(text, blanks); *text && status == SATIN_OK; text += strspn(text, blanks))
        status = add_spectrum_pair(log, place, &text, ": ", &spectrum);
    if (status == SATIN_OK)
        *out = spectrum;
    else
        scene_spectrum_free(&spectrum);
    return status;
}

satin_status load_spectrum_read(struct log log, struct log_place place, const char *path,
                                uint64_t *hash, struct spectrum *out) {
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
            status = add_spectrum_pair(log, line, &text, " \t,:", &spectrum);
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
        scene_spectrum_free(&spectrum);
    return status;
}
