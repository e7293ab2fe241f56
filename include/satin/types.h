// SPDX-License-Identifier: Apache-2.0
// Types that every header of satin's public interface uses: status codes, messages, opaque handles.
#ifndef SATIN_TYPES_H
#define SATIN_TYPES_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define SATIN_API __attribute__((visibility("default")))
#else
#define SATIN_API
#endif

#define SATIN_VERSION "0.1.0"

// The status of a call that can fail. Outputs are unchanged unless the status is SATIN_OK or, if
// the function says so, SATIN_CANCELLED. The details of a failure are logged once.
typedef enum satin_status {
    SATIN_OK = 0,
    SATIN_ERROR_ARGUMENT,  // an argument is outside its documented range
    SATIN_ERROR_INPUT,     // a scene, mesh, image or option is wrong; the log names the place
    SATIN_ERROR_IO,        // a file could not be read or written
    SATIN_ERROR_MEMORY,    // not enough memory
    SATIN_ERROR_INTERNAL,  // a library failed in a way other than these
    SATIN_CANCELLED,       // the progress function asked to stop; partial results are valid
    SATIN_STATUS_COUNT
} satin_status;

// One English sentence for a status, even for an unknown value. Never NULL; static storage, which
// the caller does not free. Thread-safe.
SATIN_API const char *satin_status_text(satin_status status);

typedef enum satin_log_severity {
    SATIN_LOG_ERROR = 0,
    SATIN_LOG_WARNING,
    SATIN_LOG_INFO
} satin_log_severity;

// Receives one message, a single line without a newline, in UTF-8 if the names of files are. Errors
// in a file have the form `file:line:column: text`. It is called only during a call into satin and
// on its thread, so it needs no lock unless calls on several threads have the same `user`.
// `message` is owned by satin and valid until the function returns. The function must not call
// satin_*_free for an object that the current call uses.
typedef void (*satin_log_fn)(void *user, satin_log_severity severity, const char *message);

// A loaded scene, ready to render. It is immutable, so several threads may use it at the same time.
typedef struct satin_scene satin_scene;
// A rendered image: named float channels of one size. It is immutable too.
typedef struct satin_film satin_film;

#ifdef __cplusplus
}
#endif
#endif
