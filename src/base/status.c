// SPDX-License-Identifier: Apache-2.0
// The sentence of each status code.
#include "satin/types.h"

const char *satin_status_text(satin_status status) {
    static const char *const text[SATIN_STATUS_COUNT] = {
        [SATIN_OK] = "The call succeeded.",
        [SATIN_ERROR_ARGUMENT] = "An argument is outside its documented range.",
        [SATIN_ERROR_INPUT] = "The input is wrong; the log names the place.",
        [SATIN_ERROR_IO] = "A file could not be read or written.",
        [SATIN_ERROR_MEMORY] = "There is not enough memory.",
        [SATIN_ERROR_INTERNAL] = "A library that satin uses failed.",
        [SATIN_CANCELLED] = "The work was cancelled; what was finished is valid.",
    };
    if ((int)status < 0 || status >= SATIN_STATUS_COUNT) return "The status is unknown.";
    return text[status];
}
