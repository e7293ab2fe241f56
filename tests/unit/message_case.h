// SPDX-License-Identifier: Apache-2.0
// A log function that keeps the last message and counts them all.
#ifndef MESSAGE_CASE_H
#define MESSAGE_CASE_H

#include <string.h>

#include "satin/types.h"

struct message {
    int count;
    char text[256];
};

static void keep(void *user, satin_log_severity severity, const char *text) {
    struct message *message = user;
    (void)severity;
    message->count++;
    strncpy(message->text, text, sizeof message->text - 1);
}

#endif
