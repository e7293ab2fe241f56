// SPDX-License-Identifier: Apache-2.0
// Counters of a render and times of its stages, printed as JSON.
#ifndef BASE_STATS_H
#define BASE_STATS_H

#include <stddef.h>
#include <stdint.h>

enum { STATS_ENTRIES = 384, STATS_NAME = 48 };

struct stats_entry {
    char name[STATS_NAME];  // "stage.quantity"; the unit ends the name (_s, _bytes), counts have
                            // none
    double value;
};

struct stats {
    struct stats_entry entry[STATS_ENTRIES];
    int count;
};

// Sets or replaces a value. Entries beyond STATS_ENTRIES are dropped, and names of STATS_NAME
// characters or more are cut.
void stats_set(struct stats *stats, const char *name, double value);
void stats_add(struct stats *stats, const char *name, double value);
double stats_get(const struct stats *stats, const char *name);  // 0 if absent

// Sets entries "parts.NAME..." for each part of the work of a pool (base/parallel.h).
struct parallel;
void stats_set_parts(struct stats *stats, struct parallel *pool);
// Sets those of one part alone, if the pool has it.
void stats_set_work(struct stats *stats, struct parallel *pool, const char *name);

// A span of time on one thread: its wall time, CPU time of the thread, and of the whole process.
struct stats_span {
    double wall_s, thread_s, process_s;
};
struct stats_span stats_span_begin(void);
// The span since `begin`, on the same thread.
struct stats_span stats_span_since(struct stats_span begin);
// Sets entries "parts.NAME..." of a span in which threads of a library may have run: their CPU time
// counts as parallel, that of this thread as serial.
void stats_set_span(struct stats *stats, const char *name, struct stats_span span);

// Seconds of a clock that never runs backwards, and CPU seconds of the process and of the thread.
double stats_wall(void);
double stats_cpu(void);
double stats_thread(void);
// Peak resident memory of the process in bytes.
double stats_peak_memory(void);

// The entries as one JSON object, in the order in which they were first set. From malloc, the
// caller frees it; NULL if there is no memory.
char *stats_json(const struct stats *stats);
// An object that stats_json made, with further entries appended. From malloc, the caller frees it;
// NULL if there is no memory.
char *stats_json_append(const char *json, const struct stats *stats);

#endif
