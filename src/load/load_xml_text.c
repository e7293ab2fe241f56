// SPDX-License-Identifier: Apache-2.0
// Cleans the text of a scene file of what is not XML but common in scenes by others, as Mitsuba
// reads it, and explains errors of syntax.
#include <stdlib.h>
#include <string.h>

#include "load/load_xml.h"

// Where the CDATA section or comment that begins at `at` ends, or the end of the text.
static char *end_of(char *at, const char *closing) {
    char *end = strstr(at, closing);
    return end ? end : at + strlen(at);
}

static bool begins(const char *at, const char *text) {
    return strncmp(at, text, strlen(text)) == 0;
}

// Whether an `&` begins a reference to an entity or a character.
static bool is_entity(const char *at) {
    static const char name[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._:-";
    const char *first = at + 1 + (at[1] == '#');
    const size_t length = strspn(first, name);
    return length > 0 && first[length] == ';';
}

// Overwrites the contents of comments by blanks, and counts the `&` that begin no reference.
static size_t blank_comments(char *text) {
    size_t count = 0;
    for (char *at = text; *at; at++) {
        if (begins(at, "<![CDATA[")) {
            at = end_of(at, "]]>");
        } else if (begins(at, "<!--")) {
            char *end = end_of(at + 4, "-->");
            for (at += 4; at < end && *end; at++)
                if (*at != '\n' && *at != '\r') *at = ' ';
            at = end;
        } else if (*at == '&' && !is_entity(at)) {
            count++;
        }
        if (!*at) break;
    }
    return count;
}

bool load_xml_clean(char **data, size_t *size) {
    char *text = *data;
    // UTF-16, or no text at all.
    if (memchr(text, 0, *size)) return true;
    const size_t count = blank_comments(text);
    if (!count) return true;
    char *out = malloc(*size + count * strlen("amp;") + 1), *to = out;
    if (!out) return false;
    for (const char *at = text; *at;) {
        if (begins(at, "<![CDATA["))
            for (const char *end = strstr(at, "]]>"); *at && at != end;) *to++ = *at++;
        const bool stray = *at == '&' && !is_entity(at);
        if (*at) *to++ = *at++;
        if (stray) to = stpcpy(to, "amp;");
    }
    *to = 0;
    *size = (size_t)(to - out);
    free(text);
    *data = out;
    return true;
}

void load_xml_log_syntax(struct log log, struct log_place place, const char *what, const char *at,
                         const struct xml_node *open) {
    const int length = at ? (int)strcspn(at, "\r\n") : 0;
    if (!what)
        log_error_at(log, place, "the file is empty");
    else if (open)
        log_error_at(log, place, "not XML: %s: <%s> of line %d is not closed", what,
                     load_xml_tag_name(open->tag), open->place.line);
    else if (!at)
        log_error_at(log, place, "not XML: %s", what);
    else if ((unsigned char)*at >= 0x80)
        log_error_at(log, place,
                     "not XML: the byte 0x%02x is not UTF-8; another encoding is named by "
                     "<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>",
                     (unsigned)(unsigned char)*at);
    else
        log_error_at(log, place, "not XML: %s at '%.*s'", what, length < 20 ? length : 20, at);
}
