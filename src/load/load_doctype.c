// SPDX-License-Identifier: Apache-2.0
// What a scene file declares of its document's type: nothing of it is read, as in Mitsuba. It is
// taken out before the parser sees it, because entities can grow without bound and read other
// files. In UTF-16 it is not found, and refused by the parser's handler (load_xml.c).
#include "load/load_doctype.h"

#include <string.h>

static bool begins(const char *at, const char *end, const char *text) {
    size_t n = strlen(text);
    return (size_t)(end - at) >= n && memcmp(at, text, n) == 0;
}

// Beyond the next `text`; `end` if there is none.
static char *beyond(char *at, char *end, const char *text) {
    for (; at < end; at++)
        if (begins(at, end, text)) return at + strlen(text);
    return end;
}

// Beyond what stands at `at`: a comment, an instruction, a quoted text; else one character.
static char *next(char *at, char *end) {
    if (begins(at, end, "<!--")) return beyond(at + 4, end, "-->");
    if (begins(at, end, "<?")) return beyond(at + 2, end, "?>");
    if (*at == '"' || *at == '\'') return beyond(at + 1, end, *at == '"' ? "\"" : "'");
    return at + 1;
}

void load_doctype_blank(char *data, size_t size) {
    char *at = data, *const end = data + size;
    if (begins(at, end, "\xef\xbb\xbf")) at += 3;
    while (at < end && (strchr(" \t\r\n", *at) || begins(at, end, "<?") || begins(at, end, "<!--")))
        at = next(at, end);
    if (!begins(at, end, "<!DOCTYPE")) return;
    char *const first = at;
    bool inside = false;  // of [ ]
    while (at < end && (inside || *at != '>')) {
        inside = inside ? *at != ']' : *at == '[';
        at = next(at, end);
    }
    if (at == end) return;  // never closed, which the parser will tell
    for (char *c = first; c <= at; c++)
        if (*c != '\n' && *c != '\r') *c = ' ';
}

size_t load_entity_find(const char *text, size_t size, const char **name) {
    static const char *const known[] = {"#", "amp;", "lt;", "gt;", "quot;", "apos;"};
    const char *const end = text + size;
    for (; text < end; text++) {
        if (*text != '&') continue;
        bool is_known = false;
        for (size_t i = 0; i < sizeof known / sizeof *known; i++)
            is_known = is_known || begins(text + 1, end, known[i]);
        const char *close = is_known ? NULL : memchr(text, ';', (size_t)(end - text));
        if (!close) continue;
        *name = text;
        return (size_t)(close - text) + 1;
    }
    return 0;
}
