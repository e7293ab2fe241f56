// SPDX-License-Identifier: Apache-2.0
// Shows films in the viewer tev, by its network protocol. Nothing waits for the viewer but
// app_display_finish: a viewer that is missing, closes or does not read costs one warning.
#ifndef APP_DISPLAY_H
#define APP_DISPLAY_H

#include <netdb.h>

#include "apps/app.h"

// A viewer; all fields are private. A zero struct is none.
struct app_display {
    bool wanted;
    char host[256], port[8];
    const char *name;               // of the image in the viewer
    struct app_progress *progress;  // for messages
    struct addrinfo *addresses;     // of the host, from getaddrinfo
    struct addrinfo *address;       // the one that is tried or connected; NULL: none
    int socket;
    bool connected;
    // What is shown, and how far it was sent: from the first row of the first channel to the last
    // one of the last.
    const satin_film *film;  // NULL: there is nothing to send
    bool created;            // whether the viewer knows the image
    bool newer;              // whether the film has changed since its first row was sent
    int channels;            // of the created image
    int channel, row;        // the next ones to be sent
    unsigned char *packet;   // of PACKET_MOST bytes and a row
    size_t capacity, size, sent;
};

// Reads the value of --display: tev, tev:HOST or tev:HOST:PORT, where an IPv6 address is in
// brackets. Reports a wrong one and returns APP_WRONG.
int app_display_read(const char *value, struct app_display *display);
// Finds the viewer's host and begins to connect. `name` and `progress` must stay valid.
void app_display_open(struct app_display *display, const char *name, struct app_progress *progress);
// Shows this film from now on, which must not change or be freed until the next call of a function
// but app_display_send. NULL: none.
void app_display_show(struct app_display *display, const satin_film *film);
// Sends as much as the viewer takes now, at most for some milliseconds.
void app_display_send(struct app_display *display);
// Shows the finished film, which may be NULL, waits for a viewer that reads it, and closes.
void app_display_finish(struct app_display *display, const satin_film *film);

#endif
