// SPDX-License-Identifier: Apache-2.0
// Cleans the text of a scene file of what is not XML but common in scenes by others, as Mitsuba
// reads it, and explains errors of syntax.
#include <stdlib.h>
#include <string.h>

#include "load/load_xml.h"

static bool begins(const char *at, const char *text) {
    return strncmp(at, text, strlen(text)) == 0;
}

// Whether an `&` begins a reference to an entity, whose name never begins with a digit, or to a
// character.
static bool is_entity(const char *at) {
    static const char name[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_:.-0123456789",
                      digit[] = "0123456789abcdefABCDEF";
    const bool character = at[1] == '#', hexadecimal = character && at[2] == 'x';
    const char *first = at + 1 + character + hexadecimal;
    if (!character && strspn(first, ".-0123456789") > 0) return false;
    size_t length = strspn(first, character ? digit : name);
    if (character && !hexadecimal) length = strspn(first, "0123456789");
    return length > 0 && first[length] == ';';
}

// Where the CDATA section or comment that begins before `at` ends, or the end of the text.
static const char *find_end(const char *at, const char *closing) {
    const char *end = strstr(at, closing);
    return end ? end : at + strlen(at);
}

// Overwrites the contents of comments by blanks.
static void blank_comments(char *text) {
    for (char *at = text; *at; at++) {
        if (begins(at, "<![CDATA[")) {
            at = text + (find_end(at, "]]>") - text);
        } else if (begins(at, "<!--")) {
            const char *end = find_end(at + 4, "-->");
            for (at += 4; at < end; at++)
                if (*at != '\n' && *at != '\r') *at = ' ';
        }
        if (!*at) break;
    }
}

// The next `&` that begins no reference and is in no CDATA section, or NULL.
static const char *find_stray(const char *at) {
    for (; *at; at++) {
        if (begins(at, "<![CDATA[")) {
            at = find_end(at, "]]>");
            if (!*at) break;
        } else if (*at == '&' && !is_entity(at)) {
            return at;
        }
    }
    return NULL;
}

// Moves blanks and line ends before the XML declaration to its end.
static void move_declaration(char *text) {
    const size_t blanks = strspn(text, " \t\r\n");
    const char *end = begins(text + blanks, "<?xml") && strchr(" \t\r\n", text[blanks + 5])
                          ? strstr(text + blanks, "?>")
                          : NULL;
    if (!blanks || !end) return;
    const size_t length = (size_t)(end + 2 - (text + blanks));
    char *before = strndup(text, blanks);
    if (!before) return;
    memmove(text, text + blanks, length);
    memcpy(text + length, before, blanks);
    free(before);
}

bool load_xml_clean(char **data, size_t *size) {
    char *text = *data;
    // UTF-16, or no text at all.
    if (memchr(text, 0, *size)) return true;
    move_declaration(text);
    blank_comments(text);
    size_t count = 0;
    for (const char *stray = find_stray(text); stray; stray = find_stray(stray + 1)) count++;
    if (!count) return true;
    char *out = malloc(*size + count * strlen("amp;") + 1), *to = out;
    if (!out) return false;
    const char *at = text;
    for (const char *stray = find_stray(at); stray; stray = find_stray(at)) {
        const size_t length = (size_t)(stray + 1 - at);
        memcpy(to, at, length);
        to = stpcpy(to + length, "amp;");
        at = stray + 1;
    }
    to = stpcpy(to, at);
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
