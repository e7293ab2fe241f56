// SPDX-License-Identifier: Apache-2.0
// Texts that may not be UTF-8, such as names of files, as JSON has them.
#include "base/text.h"

// The bytes of a character of UTF-8 by its first one, of which the second has a range of its own
// [Unicode, table 3-7].
static const struct {
    unsigned char first, last;  // of first bytes
    unsigned char low, high;    // of second bytes
    size_t bytes;
} utf8_form[] = {
    {0x00, 0x7f, 0x00, 0x00, 1}, {0xc2, 0xdf, 0x80, 0xbf, 2}, {0xe0, 0xe0, 0xa0, 0xbf, 3},
    {0xe1, 0xec, 0x80, 0xbf, 3}, {0xed, 0xed, 0x80, 0x9f, 3}, {0xee, 0xef, 0x80, 0xbf, 3},
    {0xf0, 0xf0, 0x90, 0xbf, 4}, {0xf1, 0xf3, 0x80, 0xbf, 4}, {0xf4, 0xf4, 0x80, 0x8f, 4},
};

size_t text_utf8_bytes(const char *text) {
    const unsigned char *c = (const unsigned char *)text;
    for (size_t i = 0; i < sizeof utf8_form / sizeof *utf8_form; i++) {
        const size_t bytes = utf8_form[i].bytes;
        if (c[0] < utf8_form[i].first || c[0] > utf8_form[i].last) continue;
        if (bytes > 1 && (c[1] < utf8_form[i].low || c[1] > utf8_form[i].high)) return 0;
        for (size_t k = 2; k < bytes; k++)
            if (c[k] < 0x80 || c[k] > 0xbf) return 0;
        return bytes;
    }
    return 0;
}

void text_print_json(FILE *out, const char *text) {
    fputc('"', out);
    while (*text) {
        const unsigned char c = (unsigned char)*text;
        const size_t bytes = text_utf8_bytes(text);
        if (bytes == 0)
            fputs(TEXT_REPLACEMENT, out);
        else if (c < 0x20 || c == '"' || c == '\\' || c == '<' || c == 0x7f)
            fprintf(out, "\\u%04x", c);
        else
            fwrite(text, 1, bytes, out);
        text += bytes ? bytes : 1;
    }
    fputc('"', out);
}
