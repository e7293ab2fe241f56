// SPDX-License-Identifier: Apache-2.0
// Messages to the caller's log function.
#include "base/log.h"

#include <stdio.h>

enum { LOG_BYTES = 1024, KEY_BYTES = 128 };  // of a message, and of the key in it

static void send_message(struct log log, satin_log_severity severity, char *text) {
    for (unsigned char *c = (unsigned char *)text; *c; c++)
        if (*c < 32 || *c == 127) *c = '?';
    log.fn(log.user, severity, text);
}

static void log_arguments(struct log log, satin_log_severity severity, const char *format,
                          va_list args) {
    char text[LOG_BYTES];
    vsnprintf(text, sizeof text, format, args);
    send_message(log, severity, text);
}

void log_message(struct log log, satin_log_severity severity, const char *format, ...) {
    if (!log.fn) return;
    va_list args;
    va_start(args, format);
    log_arguments(log, severity, format, args);
    va_end(args);
}

static void log_at(struct log log, satin_log_severity severity, struct log_place place,
                   const char *key, const char *format, va_list args) {
    char text[LOG_BYTES];
    int n = 0;
    const char *file = place.file ? place.file : "input";
    if (place.line > 0 && place.column > 0)
        n = snprintf(text, sizeof text, "%s:%d:%d: ", file, place.line, place.column);
    else if (place.line > 0)
        n = snprintf(text, sizeof text, "%s:%d: ", file, place.line);
    else
        n = snprintf(text, sizeof text, "%s: ", file);
    if (n < 0) n = 0;
    if (n > LOG_BYTES / 2) n = LOG_BYTES / 2;
    if (key) n += snprintf(text + n, KEY_BYTES, "%.*s: ", KEY_BYTES - 3, key);
    vsnprintf(text + n, sizeof text - (size_t)n, format, args);
    send_message(log, severity, text);
}

void log_error_at(struct log log, struct log_place place, const char *format, ...) {
    if (!log.fn) return;
    va_list args;
    va_start(args, format);
    log_at(log, SATIN_LOG_ERROR, place, NULL, format, args);
    va_end(args);
}

void log_error_at_args(struct log log, struct log_place place, const char *key, const char *format,
                       va_list args) {
    if (log.fn) log_at(log, SATIN_LOG_ERROR, place, key, format, args);
}

void log_warning_at(struct log log, struct log_place place, const char *format, ...) {
    if (!log.fn) return;
    va_list args;
    va_start(args, format);
    log_at(log, SATIN_LOG_WARNING, place, NULL, format, args);
    va_end(args);
}

satin_status log_fail(struct log log, satin_status status, const char *format, ...) {
    if (!log.fn) return status;
    va_list args;
    va_start(args, format);
    log_arguments(log, SATIN_LOG_ERROR, format, args);
    va_end(args);
    return status;
}

static void pass_on(void *user, satin_log_severity severity, const char *message) {
    const struct log_spared *spared = user;
    if (severity == SATIN_LOG_ERROR)
        log_message(spared->errors, SATIN_LOG_WARNING, "%s; %s", message, spared->instead);
    else
        log_message(spared->others, severity, "%s", message);
}

struct log log_spare(struct log_spared *spared) {
    return (struct log){pass_on, spared};
}
