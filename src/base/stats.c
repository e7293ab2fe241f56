// SPDX-License-Identifier: Apache-2.0
// Counters and timings of a render.
#include "base/stats.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

static struct stats_entry *find_entry(struct stats *stats, const char *name) {
    for (int i = 0; i < stats->count; i++)
        if (strcmp(stats->entry[i].name, name) == 0) return &stats->entry[i];
    if (stats->count == STATS_ENTRIES) return NULL;
    struct stats_entry *entry = &stats->entry[stats->count++];
    *entry = (struct stats_entry){name, 0.0};
    return entry;
}

void stats_set(struct stats *stats, const char *name, double value) {
    struct stats_entry *entry = find_entry(stats, name);
    if (entry) entry->value = value;
}

void stats_add(struct stats *stats, const char *name, double value) {
    struct stats_entry *entry = find_entry(stats, name);
    if (entry) entry->value += value;
}

double stats_get(const struct stats *stats, const char *name) {
    for (int i = 0; i < stats->count; i++)
        if (strcmp(stats->entry[i].name, name) == 0) return stats->entry[i].value;
    return 0.0;
}

static double seconds(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

double stats_wall(void) { return seconds(CLOCK_MONOTONIC); }
double stats_cpu(void) { return seconds(CLOCK_PROCESS_CPUTIME_ID); }

double stats_peak_memory(void) {
    struct rusage usage;
    if (getrusage(RUSAGE_SELF, &usage) != 0) return 0.0;
    return 1024.0 * (double)usage.ru_maxrss;
}

char *stats_json(const struct stats *stats) {
    size_t bytes = 16 + (size_t)stats->count * 128, used = 0;
    char *text = malloc(bytes);
    if (!text) return NULL;
    used += (size_t)snprintf(text, bytes, "{");
    for (int i = 0; i < stats->count; i++) {
        double v = stats->entry[i].value;
        used += (size_t)snprintf(text + used, bytes - used, "%s\n  \"%.80s\": ", i ? "," : "",
                                 stats->entry[i].name);
        if (!isfinite(v))
            used += (size_t)snprintf(text + used, bytes - used, "null");
        else if (v == floor(v) && fabs(v) < 1e15)
            used += (size_t)snprintf(text + used, bytes - used, "%.0f", v);
        else
            used += (size_t)snprintf(text + used, bytes - used, "%.9g", v);
    }
    snprintf(text + used, bytes - used, "\n}\n");
    return text;
}
