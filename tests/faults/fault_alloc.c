// SPDX-License-Identifier: Apache-2.0
// An allocator to preload (LD_PRELOAD) that counts allocations by call stack and fails chosen ones.
//
// A site is the set of the innermost DEPTH distinct return addresses of an allocation, relative to
// their modules, so that it has one name in every run and recursion does not multiply it.
//   FAULT_SITES=FILE  at exit, writes a line per site: its name, the number of its allocations, and
//                     the stack, innermost first, as MODULE+OFFSET or MODULE+OFFSET:SYMBOL
//   FAULT_SITE=NAME   the site whose allocation number FAULT_NTH (from 1) fails
//   FAULT_ALL=1       and so does every allocation after it, wherever it is made
//   FAULT_FIRED=FILE  is made when an allocation fails
// Memory comes from glibc by its internal names, which need no look-up that would allocate.
#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <fcntl.h>
#include <inttypes.h>
#include <link.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define EXPORT __attribute__((visibility("default")))

void *__libc_malloc(size_t bytes);
void *__libc_calloc(size_t count, size_t bytes);
void *__libc_realloc(void *old, size_t bytes);
void *__libc_memalign(size_t alignment, size_t bytes);

enum {
    RAW = 36,     // frames that are unwound to be listed
    NAMING = 20,  // frames that are unwound to name a site: fewer, for speed
    LISTED = 24,  // distinct frames that are listed
    DEPTH = 10,   // frames of these that name the site
    SKIP = 2,     // of this file
    SITES = 1 << 16
};

struct site {
    uint64_t name;  // 0: the slot is empty
    uint64_t count;
    void *frame[LISTED];
};

static struct {
    pthread_mutex_t mutex;
    bool armed, all;
    uint64_t target, nth;
    bool fired;
    const char *sites, *fired_name;
    struct site site[SITES];
} fault_alloc_fault = {.mutex = PTHREAD_MUTEX_INITIALIZER};

// Unwinding may allocate, and so may the list at the end.
static __thread bool inside __attribute__((tls_model("initial-exec")));

static uint64_t fault_alloc_mix(uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
}

static const char *base_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

// The main program has no name among the loaded objects.
static const char *module_of(const struct dl_find_object *object) {
    const char *name = object->dlfo_link_map->l_name;
    return name && *name ? base_name(name) : "satin";
}

static uint64_t address_name(void *address) {
    struct dl_find_object object;
    if (_dl_find_object(address, &object) != 0) return 1;
    uint64_t hash = (uintptr_t)address - object.dlfo_link_map->l_addr;
    for (const char *c = module_of(&object); *c; c++)
        hash = fault_alloc_mix(hash + (unsigned char)*c);
    return fault_alloc_mix(hash);
}

static bool contains(void *const *frame, int count, const void *address) {
    for (int i = 0; i < count; i++)
        if (frame[i] == address) return true;
    return false;
}

static struct site *fault_alloc_find_site(void *const *raw, int count) {
    struct site made = {.name = 0};
    int frames = 0;
    for (int i = SKIP; i < count && frames < LISTED; i++) {
        if (contains(made.frame, frames, raw[i])) continue;
        if (frames < DEPTH && i < NAMING) made.name += address_name(raw[i]);
        made.frame[frames++] = raw[i];
    }
    if (made.name == 0) made.name = 1;
    size_t at = made.name % SITES;
    while (fault_alloc_fault.site[at].name != 0 && fault_alloc_fault.site[at].name != made.name)
        at = (at + 1) % SITES;
    if (fault_alloc_fault.site[at].name == 0) fault_alloc_fault.site[at] = made;
    return &fault_alloc_fault.site[at];
}

static void report_fired(void) {
    fault_alloc_fault.fired = true;
    int fd = fault_alloc_fault.fired_name
                 ? open(fault_alloc_fault.fired_name, O_WRONLY | O_CREAT | O_CLOEXEC, 0666)
                 : -1;
    if (fd >= 0) close(fd);
}

// Counts an allocation; true if it shall fail.
static __attribute__((noinline)) bool fails(void) {
    if (!fault_alloc_fault.armed || inside) return false;
    inside = true;
    const int error = errno;
    void *raw[RAW];
    const int count = backtrace(raw, fault_alloc_fault.sites ? RAW : NAMING);
    pthread_mutex_lock(&fault_alloc_fault.mutex);
    struct site *site = fault_alloc_find_site(raw, count);
    site->count++;
    bool fail = fault_alloc_fault.fired && fault_alloc_fault.all;
    if (!fault_alloc_fault.fired && site->name == fault_alloc_fault.target &&
        site->count == fault_alloc_fault.nth) {
        report_fired();
        fail = true;
        // No later allocation is of interest, nor what unwinding it would cost.
        fault_alloc_fault.armed = fault_alloc_fault.all || fault_alloc_fault.sites;
    }
    pthread_mutex_unlock(&fault_alloc_fault.mutex);
    errno = fail ? ENOMEM : error;
    inside = false;
    return fail;
}

static void write_frame(FILE *out, void *address) {
    struct dl_find_object object;
    Dl_info info;
    if (_dl_find_object(address, &object) != 0) {
        fprintf(out, "\t?");
        return;
    }
    fprintf(out, "\t%s+%" PRIxPTR, module_of(&object),
            (uintptr_t)address - object.dlfo_link_map->l_addr);
    if (dladdr(address, &info) && info.dli_sname) fprintf(out, ":%s", info.dli_sname);
}

static void write_sites(void) {
    FILE *out = fopen(fault_alloc_fault.sites, "w");
    if (!out) return;
    for (size_t i = 0; i < SITES; i++) {
        const struct site *site = &fault_alloc_fault.site[i];
        if (site->name == 0) continue;
        fprintf(out, "%016" PRIx64 "\t%" PRIu64, site->name, site->count);
        for (int k = 0; k < LISTED && site->frame[k]; k++) write_frame(out, site->frame[k]);
        fprintf(out, "\n");
    }
    fclose(out);
}

static __attribute__((constructor)) void start(void) {
    void *raw[RAW];
    inside = true;
    backtrace(raw, RAW);  // loads the library that unwinding needs
    const char *target = getenv("FAULT_SITE"), *nth = getenv("FAULT_NTH");
    fault_alloc_fault.sites = getenv("FAULT_SITES");
    fault_alloc_fault.fired_name = getenv("FAULT_FIRED");
    fault_alloc_fault.all = getenv("FAULT_ALL") != NULL;
    fault_alloc_fault.target = target ? strtoull(target, NULL, 16) : 0;
    fault_alloc_fault.nth = nth ? strtoull(nth, NULL, 10) : 0;
    fault_alloc_fault.armed = target || fault_alloc_fault.sites;
    inside = false;
}

static __attribute__((destructor)) void end(void) {
    inside = true;
    fault_alloc_fault.armed = false;
    if (fault_alloc_fault.sites) write_sites();
}

EXPORT void *malloc(size_t bytes) { return fails() ? NULL : __libc_malloc(bytes); }

EXPORT void *calloc(size_t count, size_t bytes) {
    return fails() ? NULL : __libc_calloc(count, bytes);
}

EXPORT void *realloc(void *old, size_t bytes) {
    return bytes && fails() ? NULL : __libc_realloc(old, bytes);
}

EXPORT void *aligned_alloc(size_t alignment, size_t bytes) {
    return fails() ? NULL : __libc_memalign(alignment, bytes);
}

EXPORT void *memalign(size_t alignment, size_t bytes) {
    return fails() ? NULL : __libc_memalign(alignment, bytes);
}

EXPORT int posix_memalign(void **out, size_t alignment, size_t bytes) {
    void *made = fails() ? NULL : __libc_memalign(alignment, bytes);
    if (!made) return ENOMEM;
    *out = made;
    return 0;
}
