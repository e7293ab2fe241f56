// SPDX-License-Identifier: Apache-2.0
// Numbers and words of text meshes. A mesh has millions of numbers; strtod reads them five times
// slower, and depends on the locale.
#include "load/load_mesh_text.h"

#include <math.h>
#include <string.h>

static bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}
static bool is_digit(char c) { return c >= '0' && c <= '9'; }

void load_mesh_text_skip_blanks(struct mesh_text *text) {
    while (text->at < text->end) {
        if (is_blank(*text->at)) {
            text->at++;
            continue;
        }
        if (*text->at != '\\') return;
        const char *next = text->at + 1;
        if (next < text->end && *next == '\r') next++;
        if (next >= text->end || *next != '\n') return;
        text->at = next + 1;
        text->line++;
    }
}

void load_mesh_text_skip_space(struct mesh_text *text) {
    for (; text->at < text->end; text->at++) {
        if (*text->at == '\n')
            text->line++;
        else if (!is_blank(*text->at))
            return;
    }
}

void load_mesh_text_next_line(struct mesh_text *text) {
    const char *found = memchr(text->at, '\n', (size_t)(text->end - text->at));
    text->at = found ? found + 1 : text->end;
    if (found) text->line++;
}

size_t load_mesh_text_word(struct mesh_text *text, const char **word) {
    *word = text->at;
    while (text->at < text->end && !is_blank(*text->at) && *text->at != '\n') text->at++;
    return (size_t)(text->at - *word);
}

bool load_mesh_text_is(const char *word, size_t length, const char *name) {
    return strlen(name) == length && memcmp(word, name, length) == 0;
}

// Computes 10^exponent * mantissa.
static double scale_decimal(uint64_t mantissa, int exponent) {
    static const double power[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                   1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                   1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    double m = (double)mantissa;
    if (exponent >= 0 && exponent <= 22) return m * power[exponent];
    if (exponent < 0 && exponent >= -22) return m / power[-exponent];
    return mantissa ? m * pow(10.0, exponent) : 0.0;
}

// Reads an exponent: e, sign, digits. An `e` without digits is not read.
static const char *read_exponent(const char *at, const char *end, int *exponent) {
    if (at >= end || (*at != 'e' && *at != 'E')) return at;
    const char *p = at + 1;
    bool negative = p < end && *p == '-';
    if (p < end && (*p == '-' || *p == '+')) p++;
    if (p >= end || !is_digit(*p)) return at;
    int value = 0;
    for (; p < end && is_digit(*p); p++)
        if (value < 100000) value = value * 10 + (*p - '0');
    *exponent += negative ? -value : value;
    return p;
}

bool load_mesh_text_number(struct mesh_text *text, double *out) {
    const char *p = text->at, *end = text->end;
    bool negative = p < end && *p == '-';
    if (p < end && (*p == '-' || *p == '+')) p++;
    uint64_t mantissa = 0;
    int exponent = 0, digits = 0;
    bool point = false;
    for (; p < end && (is_digit(*p) || (*p == '.' && !point)); p++) {
        if (*p == '.') {
            point = true;
            continue;
        }
        digits++;
        if (mantissa < 1000000000000000000u) {
            mantissa = mantissa * 10 + (uint64_t)(*p - '0');
            if (point) exponent--;
        } else if (!point) {
            exponent++;  // a digit beyond the precision of a double
        }
        if (digits > 100000) return false;
    }
    if (!digits) return false;
    p = read_exponent(p, end, &exponent);
    if (p < end && !is_blank(*p) && *p != '\n' && *p != '#') return false;
    double value = scale_decimal(mantissa, exponent);
    *out = negative ? -value : value;
    text->at = p;
    return true;
}

bool load_mesh_text_integer(struct mesh_text *text, int64_t *out) {
    const char *p = text->at, *end = text->end;
    bool negative = p < end && *p == '-';
    if (p < end && (*p == '-' || *p == '+')) p++;
    if (p >= end || !is_digit(*p)) return false;
    int64_t value = 0;
    for (; p < end && is_digit(*p); p++)
        if (value < 100000000000000000) value = value * 10 + (*p - '0');
    *out = negative ? -value : value;
    text->at = p;
    return true;
}
