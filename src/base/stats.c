// SPDX-License-Identifier: Apache-2.0
// Counters and timings of a render.
#include "base/stats.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

#include "base/parallel.h"

// A double has every integer up to 2^53; those are printed with all their digits.
#define EXACT_MOST 0x1p53

static struct stats_entry *find_entry(struct stats *stats, const char *name) {
    for (int i = 0; i < stats->count; i++)
        if (strcmp(stats->entry[i].name, name) == 0) return &stats->entry[i];
    if (stats->count == STATS_ENTRIES) return NULL;
    struct stats_entry *entry = &stats->entry[stats->count++];
    snprintf(entry->name, sizeof entry->name, "%s", name);
    entry->value = 0.0;
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
double stats_thread(void) { return seconds(CLOCK_THREAD_CPUTIME_ID); }

struct stats_span stats_span_begin(void) {
    return (struct stats_span){stats_wall(), stats_thread(), stats_cpu()};
}

struct stats_span stats_span_since(struct stats_span begin) {
    const struct stats_span now = stats_span_begin();
    return (struct stats_span){now.wall_s - begin.wall_s, now.thread_s - begin.thread_s,
                               now.process_s - begin.process_s};
}

static void set_part(struct stats *stats, const struct parallel_part *part) {
    const struct {
        const char *quantity;
        double value;
    } entry[] = {{"wall_s", part->wall_s},
                 {"serial_s", part->serial_s},
                 {"parallel_s", part->parallel_s},
                 {"imbalance_s", part->imbalance_s},
                 {"loops", part->loops}};
    for (size_t i = 0; i < sizeof entry / sizeof *entry; i++) {
        char name[STATS_NAME];
        snprintf(name, sizeof name, "parts.%s.%s", part->name, entry[i].quantity);
        stats_set(stats, name, entry[i].value);
    }
}

void stats_set_parts(struct stats *stats, struct parallel *pool) {
    int count;
    const struct parallel_part *part = parallel_parts(pool, &count);
    for (int i = 0; i < count; i++) set_part(stats, &part[i]);
}

void stats_set_work(struct stats *stats, struct parallel *pool, const char *name) {
    int count;
    const struct parallel_part *part = parallel_parts(pool, &count);
    for (int i = 0; i < count; i++)
        if (strcmp(part[i].name, name) == 0) set_part(stats, &part[i]);
}

void stats_set_span(struct stats *stats, const char *name, struct stats_span span) {
    set_part(stats,
             &(struct parallel_part){.name = name,
                                     .wall_s = span.wall_s,
                                     .serial_s = span.thread_s,
                                     .parallel_s = fmax(span.process_s - span.thread_s, 0.0)});
}

// The peak of getrusage includes that of the process from which this one was copied, before it
// began this program; /proc has its own.
static double own_peak(void) {
    FILE *file = fopen("/proc/self/status", "r");
    char line[128];
    double kilobytes = 0.0;
    while (file && fgets(line, sizeof line, file))
        if (sscanf(line, "VmHWM: %lf kB", &kilobytes) == 1) break;
    if (file) fclose(file);
    return 1024.0 * kilobytes;
}

double stats_peak_memory(void) {
    struct rusage usage;
    const double own = own_peak();
    if (own > 0.0) return own;
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
        else if (v == floor(v) && fabs(v) <= EXACT_MOST)
            used += (size_t)snprintf(text + used, bytes - used, "%.0f", v);
        else
            used += (size_t)snprintf(text + used, bytes - used, "%.9g", v);
    }
    snprintf(text + used, bytes - used, "\n}\n");
    return text;
}

char *stats_json_append(const char *json, const struct stats *stats) {
    char *more = stats_json(stats);
    const char *end = strrchr(json, '}');
    const size_t kept = end ? (size_t)(end - json) : 0;
    char *text = more ? malloc(kept + strlen(more) + 1) : NULL;
    if (text && kept > 1) {
        memcpy(text, json, kept);
        text[kept - 1] = ',';  // removes the newline before the brace
        strcpy(text + kept, more + 1);
    } else if (text) {  // it is not from stats_json
        strcpy(text, more);
    }
    free(more);
    return text;
}
