// SPDX-License-Identifier: Apache-2.0
// Text that grows, and values as CSV, JSON, shells and data URIs have them.
#include "study/study_text.h"

#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "base/text.h"

// Makes space for `more` bytes and a 0.
static bool reserve_text(struct study_text *text, size_t more) {
    void *data = text->data;
    if (text->failed || more > SIZE_MAX / 2 - text->size ||
        !array_reserve(&data, &text->capacity, text->size + more + 1, 1)) {
        text->failed = true;
        return false;
    }
    text->data = data;
    return true;
}

void study_text_bytes(struct study_text *text, const void *data, size_t size) {
    if (!reserve_text(text, size)) return;
    if (size) memcpy(text->data + text->size, data, size);
    text->size += size;
    text->data[text->size] = 0;
}

void study_text_add(struct study_text *text, const char *format, ...) {
    va_list args, again;
    va_start(args, format);
    va_copy(again, args);
    const int n = vsnprintf(NULL, 0, format, args);
    if (n >= 0 && reserve_text(text, (size_t)n)) {
        vsnprintf(text->data + text->size, (size_t)n + 1, format, again);
        text->size += (size_t)n;
    }
    va_end(again);
    va_end(args);
}

void study_text_json(struct study_text *text, const char *value) {
    study_text_add(text, "\"");
    while (*value) {
        const unsigned char c = (unsigned char)*value;
        const size_t bytes = text_utf8_bytes(value);
        if (bytes == 0)
            study_text_add(text, TEXT_REPLACEMENT);
        else if (c == '"' || c == '\\')
            study_text_add(text, "\\%c", c);
        else if (c < 0x20 || c == '<' || c == 0x7f)
            study_text_add(text, "\\u%04x", c);
        else
            study_text_bytes(text, value, bytes);
        value += bytes ? bytes : 1;
    }
    study_text_add(text, "\"");
}

void study_text_csv(struct study_text *text, const char *value) {
    if (!strpbrk(value, ",\"\r\n")) {
        study_text_add(text, "%s", value);
        return;
    }
    study_text_add(text, "\"");
    for (; *value; value++) study_text_add(text, *value == '"' ? "\"%c" : "%c", *value);
    study_text_add(text, "\"");
}

void study_text_shell(struct study_text *text, const char *value) {
    static const char plain[] =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_=./,:+@%";
    if (*value && value[strspn(value, plain)] == 0) {
        study_text_add(text, "%s", value);
        return;
    }
    study_text_add(text, "'");
    for (; *value; value++) study_text_add(text, *value == '\'' ? "'\\%c'" : "%c", *value);
    study_text_add(text, "'");
}

// Integers up to 2^53, of which a double has every one, with all their digits, as counts of
// photons.
static void add_finite(struct study_text *text, double value) {
    const bool exact = value == floor(value) && fabs(value) <= 0x1p53;
    study_text_add(text, exact ? "%.0f" : "%.9g", value);
}

void study_text_json_number(struct study_text *text, double value) {
    if (isfinite(value))
        add_finite(text, value);
    else
        study_text_add(text, "null");
}

void study_text_csv_number(struct study_text *text, double value) {
    if (isfinite(value)) add_finite(text, value);
}

void study_text_base64(struct study_text *text, const void *data, size_t size) {
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const unsigned char *in = data;
    if (!reserve_text(text, size / 3 * 4 + 4)) return;
    for (size_t i = 0; i < size; i += 3) {
        const size_t left = size - i;
        const uint32_t bits = (uint32_t)in[i] << 16 | (left > 1 ? (uint32_t)in[i + 1] << 8 : 0u) |
                              (left > 2 ? in[i + 2] : 0u);
        char *out = text->data + text->size;
        out[0] = digit[bits >> 18];
        out[1] = digit[bits >> 12 & 63];
        out[2] = left > 1 ? digit[bits >> 6 & 63] : '=';
        out[3] = left > 2 ? digit[bits & 63] : '=';
        text->size += 4;
    }
    text->data[text->size] = 0;
}
