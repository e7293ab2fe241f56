// SPDX-License-Identifier: Apache-2.0
// The network protocol of the viewer tev (its README and the packets of its Ipc.cpp): a TCP
// connection, on which only the renderer sends. All integers are little-endian; a text ends with a
// byte of 0; a flag is a byte of 0 or 1. A packet:
//   u32        bytes of the packet, with these four
//   u8         its kind
// and, if the kind is 4, which makes an image of that name or replaces it by a black one:
//   flag       whether the viewer selects it
//   text       its name
//   i32 i32    width, height
//   i32        number of channels
//   text ...   their names
// or, if it is 6, which changes a box of pixels of some channels:
//   flag text  as above
//   i32        number of channels, n
//   n texts    their names
//   i32 ...    first column and row, width and height of the box
//   n i64      index of the first value of each channel in the data
//   n i64      step from one of its values to the next
//   f32 ...    the data, box by box, row by row from the top
// A film is sent layer by layer, the beauty first, each in bands of rows.
#include "apps/app_display.h"

#include <errno.h>
#include <poll.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/stats.h"

enum {
    KIND_CREATE = 4,
    KIND_UPDATE = 6,
    // Bytes of the pixels of a packet, unless a row has more. The viewer reads packets of 1 MiB
    // into the memory that it has; small packets also mix well with other senders'.
    PACKET_MOST = 1 << 18,
    // Bytes that are sent at a time: 2 ms for the loopback of a machine that copies 2 GB/s.
    SEND_MOST = 1 << 22
};

// At the end of a render: for how long the viewer may take nothing, and the rest of the image in
// all.
static const double STALL_SECONDS = 1.0, FINISH_SECONDS = 10.0;

int app_display_read(const char *value, struct app_display *display) {
    const char *host = "127.0.0.1", *port = "14158";
    *display = (struct app_display){.wanted = true, .socket = -1};
    if (strncmp(value, "tev", 3) != 0 || (value[3] && value[3] != ':')) goto wrong;
    size_t length = strlen(host), digits = strlen(port);
    if (value[3]) {
        const bool bracket = value[4] == '[';
        host = value + 4 + bracket;
        length = strcspn(host, bracket ? "]" : ":");
        const char *rest = host + length;
        if (bracket && *rest++ != ']') goto wrong;
        if (*rest && *rest != ':') goto wrong;
        if (*rest) {
            port = rest + 1;
            digits = strlen(port);
        }
    }
    if (!length || length >= sizeof display->host || !digits || digits >= sizeof display->port ||
        strspn(port, "0123456789") != digits || atoi(port) < 1 || atoi(port) > 65535)
        goto wrong;
    memcpy(display->host, host, length);
    memcpy(display->port, port, digits);
    return APP_DONE;
wrong:
    return app_wrong("--display needs tev, tev:HOST or tev:HOST:PORT, not '%s'", value);
}

// ---- The connection -----------------------------------------------------------------------------

static void close_socket(struct app_display *d) {
    if (d->socket >= 0) close(d->socket);
    d->socket = -1;
    d->connected = false;
}

static void give_up(struct app_display *d, const char *problem) {
    char message[512];
    snprintf(message, sizeof message, "tev at %s, port %s: %s; it does not show the image%s",
             d->host, d->port, problem, d->connected ? " any more" : "");
    app_log(d->progress, SATIN_LOG_WARNING, message);
    close_socket(d);
    d->address = NULL;
}

// Begins to connect to the present address or, if that fails at once, to the next ones.
static void connect_address(struct app_display *d, int error) {
    for (; d->address; d->address = d->address->ai_next) {
        const struct addrinfo *a = d->address;
        d->socket =
            socket(a->ai_family, a->ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, a->ai_protocol);
        if (d->socket >= 0 && (connect(d->socket, a->ai_addr, a->ai_addrlen) == 0 ||
                               errno == EINPROGRESS || errno == EINTR))
            return;
        error = errno;
        close_socket(d);
    }
    give_up(d, strerror(error));
}

void app_display_open(struct app_display *d, const char *name, struct app_progress *progress) {
    const struct addrinfo hints = {.ai_family = AF_UNSPEC, .ai_socktype = SOCK_STREAM};
    if (!d->wanted) return;
    d->name = name;
    d->progress = progress;
    const int problem = getaddrinfo(d->host, d->port, &hints, &d->addresses);
    d->address = problem ? NULL : d->addresses;
    if (problem)
        give_up(d, gai_strerror(problem));
    else
        connect_address(d, 0);
}

// Whether the connection is made by now.
static bool is_connected(struct app_display *d) {
    struct pollfd wait = {.fd = d->socket, .events = POLLOUT};
    int error = 0;
    socklen_t size = sizeof error;
    if (d->connected || !d->address) return d->connected;
    if (poll(&wait, 1, 0) < 1) return false;
    if (getsockopt(d->socket, SOL_SOCKET, SO_ERROR, &error, &size) != 0) error = errno;
    d->connected = error == 0;
    if (error) {
        close_socket(d);
        d->address = d->address->ai_next;
        connect_address(d, error);
    }
    return d->connected;
}

// ---- Packets ------------------------------------------------------------------------------------

static void add_bytes(struct app_display *d, const void *data, size_t size) {
    memcpy(d->packet + d->size, data, size);
    d->size += size;
}

static void add_int(struct app_display *d, uint64_t value, size_t bytes) {
    for (size_t i = 0; i < bytes; i++) d->packet[d->size++] = (unsigned char)(value >> 8 * i);
}

static void add_text(struct app_display *d, const char *text) {
    add_bytes(d, text, strlen(text) + 1);
}

// Begins a packet of at most `size` bytes besides its first fields. False if there is no memory.
static bool begin_packet(struct app_display *d, int kind, bool select, size_t size) {
    const size_t all = size + strlen(d->name) + 64;
    if (all > d->capacity) {
        unsigned char *grown = realloc(d->packet, all);
        if (!grown) return false;
        d->packet = grown;
        d->capacity = all;
    }
    d->size = d->sent = 0;
    add_int(d, 0, 4);
    add_int(d, (uint64_t)kind, 1);
    add_int(d, select, 1);
    add_text(d, d->name);
    return true;
}

static void end_packet(struct app_display *d) {
    const size_t size = d->size;
    d->size = 0;
    add_int(d, size, 4);
    d->size = size;
}

static size_t names_bytes(const satin_film *film, int first, int end) {
    size_t bytes = 0;
    for (int i = first; i < end; i++) bytes += strlen(satin_film_channel_name(film, i)) + 1;
    return bytes;
}

static bool make_create(struct app_display *d) {
    int width, height, count = 0;
    satin_film_size(d->film, &width, &height);
    while (satin_film_channel_name(d->film, count)) count++;
    if (!begin_packet(d, KIND_CREATE, true, names_bytes(d->film, 0, count))) return false;
    add_int(d, (uint64_t)width, 4);
    add_int(d, (uint64_t)height, 4);
    add_int(d, (uint64_t)count, 4);
    for (int i = 0; i < count; i++) add_text(d, satin_film_channel_name(d->film, i));
    end_packet(d);
    d->created = true;
    d->channels = count;
    d->channel = d->row = 0;
    d->newer = false;
    return true;
}

static size_t layer_bytes(const char *channel) {
    const char *point = strrchr(channel, '.');
    return point ? (size_t)(point - channel) : 0;
}

// The end of the channels of one layer that begin with `first`.
static int layer_end(const satin_film *film, int first) {
    const char *name = satin_film_channel_name(film, first), *next;
    const size_t bytes = layer_bytes(name);
    int end = first + 1;
    while ((next = satin_film_channel_name(film, end)) && layer_bytes(next) == bytes &&
           strncmp(next, name, bytes) == 0)
        end++;
    return end;
}

static bool make_update(struct app_display *d) {
    int width, height;
    satin_film_size(d->film, &width, &height);
    const int first = d->channel, end = layer_end(d->film, first), count = end - first;
    const size_t row_bytes = (size_t)width * sizeof(float);
    const size_t fitting = PACKET_MOST / (row_bytes * (size_t)count);
    int rows = height - d->row;
    if (fitting < (size_t)rows) rows = fitting ? (int)fitting : 1;
    const size_t values = (size_t)rows * (size_t)width;
    const size_t head = names_bytes(d->film, first, end) + 16 * (size_t)count;
    if (!begin_packet(d, KIND_UPDATE, false, head + (size_t)count * values * sizeof(float)))
        return false;
    add_int(d, (uint64_t)count, 4);
    for (int i = first; i < end; i++) add_text(d, satin_film_channel_name(d->film, i));
    add_int(d, 0, 4);
    add_int(d, (uint64_t)d->row, 4);
    add_int(d, (uint64_t)width, 4);
    add_int(d, (uint64_t)rows, 4);
    for (int i = 0; i < count; i++) add_int(d, (uint64_t)i * values, 8);
    for (int i = 0; i < count; i++) add_int(d, 1, 8);
    for (int i = first; i < end; i++) {
        const float *plane = satin_film_channel(d->film, satin_film_channel_name(d->film, i));
        add_bytes(d, plane + (size_t)d->row * (size_t)width, values * sizeof(float));
    }
    end_packet(d);
    d->row += rows;
    if (d->row < height) return true;
    d->row = 0;
    d->channel = end;
    return true;
}

// Makes the next packet. False if there is nothing to send, or no memory for it.
static bool next_packet(struct app_display *d) {
    if (!d->film) return false;
    if (!d->created) return make_create(d);
    if (d->channel == d->channels) {
        if (!d->newer) return false;
        d->channel = 0;
        d->newer = false;
    }
    return make_update(d);
}

// ---- Sending ------------------------------------------------------------------------------------

// What the viewer sends is of no interest, but that it has closed is. False then.
static bool read_away(struct app_display *d) {
    char away[4096];
    ssize_t n;
    do n = recv(d->socket, away, sizeof away, 0);
    while (n > 0);
    if (n == 0) give_up(d, "the viewer has closed the connection");
    if (n < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR)
        give_up(d, strerror(errno));
    return d->connected;
}

// Sends at most `most` bytes, as long as the viewer takes them. Returns the number.
static size_t send_some(struct app_display *d, size_t most) {
    size_t all = 0;
    if (!is_connected(d) || !read_away(d)) return 0;
    while (all < most && (d->sent < d->size || next_packet(d))) {
        const ssize_t n =
            send(d->socket, d->packet + d->sent, d->size - d->sent, MSG_NOSIGNAL | MSG_DONTWAIT);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) break;
        if (n < 0) {
            give_up(d, strerror(errno));
            break;
        }
        d->sent += (size_t)n;
        all += (size_t)n;
    }
    return all;
}

void app_display_send(struct app_display *d) {
    if (d->address) send_some(d, SEND_MOST);
}

void app_display_show(struct app_display *d, const satin_film *film) {
    d->film = film;
    d->newer = true;
    app_display_send(d);
}

// Whether all of the film was sent.
static bool is_sent(const struct app_display *d) {
    return d->sent == d->size && d->created && d->channel == d->channels && !d->newer;
}

static void send_rest(struct app_display *d) {
    const double begin = stats_wall();
    double last = begin;
    while (d->address && !is_sent(d)) {
        const double now = stats_wall();
        if (now - last > STALL_SECONDS || now - begin > FINISH_SECONDS) {
            give_up(d, d->connected ? "the viewer does not read" : "no answer");
            return;
        }
        if (send_some(d, SEND_MOST)) {
            last = now;
            continue;
        }
        struct pollfd wait = {.fd = d->socket, .events = POLLOUT};
        if (d->address) poll(&wait, 1, 50);
    }
}

void app_display_finish(struct app_display *d, const satin_film *film) {
    if (!d->wanted) return;
    int count = 0;
    while (film && satin_film_channel_name(film, count)) count++;
    d->film = film;
    if (d->created && d->channels != count) d->created = false;
    // The rounds of snapshots end where they are.
    d->channel = d->row = 0;
    d->newer = false;
    if (film) send_rest(d);
    if (d->connected) shutdown(d->socket, SHUT_WR);
    close_socket(d);
    if (d->addresses) freeaddrinfo(d->addresses);
    free(d->packet);
    *d = (struct app_display){.socket = -1};
}
