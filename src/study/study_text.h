// SPDX-License-Identifier: Apache-2.0
// Private to study/: text that grows, and values as CSV and JSON have them.
#ifndef STUDY_TEXT_H
#define STUDY_TEXT_H

#include <stdbool.h>
#include <stddef.h>

// Starts as zero. After lack of memory it stays as it was, and `failed` is true.
struct study_text {
    char *data;  // ends with 0; from malloc, the owner frees it; NULL while it is empty
    size_t size, capacity;
    bool failed;
};

void study_text_add(struct study_text *text, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
void study_text_bytes(struct study_text *text, const void *data, size_t size);
// A JSON string, in quotes. `<` is escaped, so that it may stand in a page, and bytes that are not
// UTF-8 are U+FFFD.
void study_text_json(struct study_text *text, const char *value);
// A field of a CSV file, in quotes if it needs them.
void study_text_csv(struct study_text *text, const char *value);
// An argument of a shell, in quotes if it needs them.
void study_text_shell(struct study_text *text, const char *value);
// A number with nine digits: null in JSON, empty in CSV if it is not finite.
void study_text_json_number(struct study_text *text, double value);
void study_text_csv_number(struct study_text *text, double value);
// Bytes in base 64 [RFC 4648].
void study_text_base64(struct study_text *text, const void *data, size_t size);

#endif
