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

// What a call that can fail returns. Outputs are untouched unless the status is SATIN_OK or, where
// a function says so, SATIN_CANCELLED. The details of a failure went to the log function once.
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

// One English sentence for a status; an unknown value has a sentence too. Never NULL; static
// storage, which the caller does not free. Thread-safe: any thread may call it at any time.
SATIN_API const char *satin_status_text(satin_status status);

typedef enum satin_log_severity {
    SATIN_LOG_ERROR = 0,
    SATIN_LOG_WARNING,
    SATIN_LOG_INFO
} satin_log_severity;

// Receives one message, a single line without a newline, in UTF-8 if the names of files are; errors
// of a file read `file:line:column: text`. It is called on the thread that made the call into satin
// only, during that call, so it needs no lock unless calls on several threads use one `user`.
// `message` belongs to satin and is valid until the function returns. It must not call satin_*_free
// on what the call under way uses.
typedef void (*satin_log_fn)(void *user, satin_log_severity severity, const char *message);

// A loaded scene, ready to render. It does not change, so threads may use one at the same time.
typedef struct satin_scene satin_scene;
// A rendered image: named float channels of one size. It does not change either.
typedef struct satin_film satin_film;

#ifdef __cplusplus
}
#endif
#endif
