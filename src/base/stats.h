// SPDX-License-Identifier: Apache-2.0
// What a render counted and how long its stages took; printed as JSON.
#ifndef BASE_STATS_H
#define BASE_STATS_H

#include <stddef.h>
#include <stdint.h>

enum { STATS_ENTRIES = 128 };

struct stats_entry {
    const char *name;  // static storage, "stage.quantity"; the unit ends the name (_s, _bytes),
                       // counts have none
    double value;
};

struct stats {
    struct stats_entry entry[STATS_ENTRIES];
    int count;
};

// Sets a value, or replaces it; entries beyond STATS_ENTRIES are dropped.
void stats_set(struct stats *stats, const char *name, double value);
void stats_add(struct stats *stats, const char *name, double value);
double stats_get(const struct stats *stats, const char *name);  // 0 if absent

// Seconds of a clock that never runs backwards, and CPU seconds of the process.
double stats_wall(void);
double stats_cpu(void);
// Peak resident memory of the process in bytes.
double stats_peak_memory(void);

// The entries as one JSON object, in the order of their first setting, names as keys; malloc, the
// caller frees; NULL without memory.
char *stats_json(const struct stats *stats);

#endif
