// SPDX-License-Identifier: Apache-2.0
// Messages to the caller's log function. `struct log` is passed by value; a zero struct drops
// messages.
#ifndef BASE_LOG_H
#define BASE_LOG_H

#include <stdarg.h>

#include "satin/types.h"

struct log {
    satin_log_fn fn;
    void *user;
};

// A place in a text file; line and column count from 1, 0 means unknown. `file` is not owned.
struct log_place {
    const char *file;
    int line, column;
};

// Formats one line (cut at 1023 bytes, control characters shown as '?') and passes it on.
void log_message(struct log log, satin_log_severity severity, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

// Logs at SATIN_LOG_ERROR with the prefix `file:line:column: `, without the numbers that are
// unknown.
void log_error_at(struct log log, struct log_place place, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

// Does what log_error_at does, for functions that take the arguments of a message themselves. `key`
// stands before the message, as `key: `; NULL: nothing does.
void log_error_at_args(struct log log, struct log_place place, const char *key, const char *format,
                       va_list args) __attribute__((format(printf, 4, 0)));

// Does what log_error_at does, at SATIN_LOG_WARNING.
void log_warning_at(struct log log, struct log_place place, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

// Logs at SATIN_LOG_ERROR and returns `status`, so that a caller can report and fail in one
// line.
satin_status log_fail(struct log log, satin_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

// Where messages go about what is left out: errors in it are warnings.
struct log_spared {
    struct log others, errors;
    const char *instead;  // what is done, which follows each error
};

// A log that passes errors on to `errors` as warnings, and other messages to `others`. *spared must
// be valid as long as the log.
struct log log_spare(struct log_spared *spared);

#endif
