// SPDX-License-Identifier: Apache-2.0
// What a render counted and how long its stages took; printed as JSON.
#ifndef BASE_STATS_H
#define BASE_STATS_H

#include <stddef.h>
#include <stdint.h>

enum { STATS_ENTRIES = 256, STATS_NAME = 48 };

struct stats_entry {
    char name[STATS_NAME];  // "stage.quantity"; the unit ends the name (_s, _bytes), counts have
                            // none
    double value;
};

struct stats {
    struct stats_entry entry[STATS_ENTRIES];
    int count;
};

// Sets a value, or replaces it; entries beyond STATS_ENTRIES are dropped. Names of STATS_NAME
// characters or more are cut.
void stats_set(struct stats *stats, const char *name, double value);
void stats_add(struct stats *stats, const char *name, double value);
double stats_get(const struct stats *stats, const char *name);  // 0 if absent

// Sets entries "parts.NAME..." for each part of the pool's work (base/parallel.h).
struct parallel;
void stats_set_parts(struct stats *stats, struct parallel *pool);

// A span of time on one thread: its wall time, CPU time of the thread, and of the whole process.
struct stats_span {
    double wall_s, thread_s, process_s;
};
struct stats_span stats_span_begin(void);
// The time since it began, on the same thread.
struct stats_span stats_span_since(struct stats_span begin);
// Sets entries "parts.NAME..." of a span in which threads of a library may have helped: what they
// did is parallel, what this thread did is serial.
void stats_set_span(struct stats *stats, const char *name, struct stats_span span);

// Seconds of a clock that never runs backwards, and CPU seconds of the process and of the thread.
double stats_wall(void);
double stats_cpu(void);
double stats_thread(void);
// Peak resident memory of the process in bytes.
double stats_peak_memory(void);

// The entries as one JSON object, in the order of their first setting, names as keys; malloc, the
// caller frees; NULL without memory.
char *stats_json(const struct stats *stats);
// The entries appended to an object that stats_json made; malloc, the caller frees; NULL without
// memory.
char *stats_json_append(const char *json, const struct stats *stats);

#endif
