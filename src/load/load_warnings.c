// SPDX-License-Identifier: Apache-2.0
// Warnings of one run of the loader, counted by kind.
#include "load/load_warnings.h"

#include <stdlib.h>
#include <string.h>

#include "base/array.h"

enum { KINDS_MAX = 256, TEXT_BYTES = 1024 };  // further kinds are passed on at once

struct load_warning {
    int count;
    char kind[TEXT_BYTES], text[TEXT_BYTES], last[TEXT_BYTES];  // its kind, the first and the last
                                                                // message
};

// Copies to `kind` the message without its place, quoted text and digits. Messages of one kind are
// counted together.
static void find_warning_kind(const char *message, char kind[TEXT_BYTES]) {
    const char *after = strstr(message, ": ");
    size_t n = 0;
    bool quoted = false;
    for (const char *c = after ? after : message; *c && n + 1 < TEXT_BYTES; c++) {
        if (*c == '\'') quoted = !quoted;
        if (!quoted && !(*c >= '0' && *c <= '9')) kind[n++] = *c;
    }
    kind[n] = 0;
}

static void log_counted(struct load_warnings *warnings, const char *text, int count) {
    const satin_log_severity severity = warnings->strict ? SATIN_LOG_ERROR : SATIN_LOG_WARNING;
    if (count > 1)
        log_message(warnings->to, severity, "%s (and %d more like it)", text, count - 1);
    else
        log_message(warnings->to, severity, "%s", text);
}

static void copy_message(char to[TEXT_BYTES], const char *from) {
    const size_t n = strnlen(from, TEXT_BYTES - 1);
    memcpy(to, from, n);
    to[n] = 0;
}

// Counts a warning of a known kind, unless the last message was the same: a file that is read twice
// gives its warnings once.
static void count_warning(struct load_warning *warning, const char *message) {
    if (strncmp(warning->last, message, TEXT_BYTES - 1) == 0) return;
    warning->count++;
    copy_message(warning->last, message);
}

static void store_warning(struct load_warnings *warnings, const char *message) {
    char kind[TEXT_BYTES];
    find_warning_kind(message, kind);
    warnings->failed = warnings->failed || warnings->strict;
    for (size_t i = 0; i < warnings->count; i++)
        if (strcmp(warnings->first[i].kind, kind) == 0) {
            count_warning(&warnings->first[i], message);
            return;
        }
    void *items = warnings->first;
    if (warnings->count == KINDS_MAX ||
        !array_reserve(&items, &warnings->capacity, warnings->count + 1, sizeof *warnings->first)) {
        log_counted(warnings, message, 1);
        return;
    }
    warnings->first = items;
    struct load_warning *warning = &warnings->first[warnings->count++];
    warning->count = 1;
    memcpy(warning->kind, kind, sizeof kind);
    copy_message(warning->text, message);
    copy_message(warning->last, message);
}

void load_warnings_report(struct load_warnings *warnings) {
    for (size_t i = 0; i < warnings->count; i++)
        log_counted(warnings, warnings->first[i].text, warnings->first[i].count);
    free(warnings->first);
    warnings->first = NULL;
    warnings->count = warnings->capacity = 0;
}

static void count_message(void *user, satin_log_severity severity, const char *message) {
    struct load_warnings *warnings = user;
    if (severity == SATIN_LOG_WARNING) {
        store_warning(warnings, message);
        return;
    }
    load_warnings_report(warnings);
    log_message(warnings->to, severity, "%s", message);
}

static void on_each(void *user, satin_log_severity severity, const char *message) {
    struct load_warnings *warnings = user;
    warnings->failed = warnings->failed || warnings->strict;
    (void)severity;
    log_counted(warnings, message, 1);
}

struct log load_warnings_each(struct load_warnings *warnings) {
    return (struct log){warnings->to.fn ? on_each : NULL, warnings};
}

struct log load_warnings_log(struct load_warnings *warnings) {
    return (struct log){warnings->to.fn ? count_message : NULL, warnings};
}
