// SPDX-License-Identifier: Apache-2.0
// Fills the cache with one kind of records. Sites are processed in their order. A batch consists of
// sites that no record covers and that are far apart; it is gathered on all threads while the cache
// does not change, and inserted in order. So the records depend on the sites alone, not on the
// threads.
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "fill/fill_member.h"

enum {
    ATTEMPTS = 3,        // at a record that is not finite; after them its site has none
    TESTED_MOST = 1024,  // sites that are tested together before batch members are selected
    BATCH_SITES = 128,   // these three are explained at batch_size
    BATCH_LEAST = 128,
    BATCH_MOST = 1024
};

struct batch {
    struct fill_making making;
    const struct fill_functions *records;  // functions of its kind
    struct fill_member *member;
    int count, size;      // number of members, at most `size`
    float *coefficients;  // of radiance members: 10 * order^2 for each
    // Sites from `next` to `last` are not covered, or not tested yet.
    const struct fill_site **waiting;
    size_t next, last;
    const struct fill_site **tested;  // the sites that are tested
    bool covered[TESTED_MOST];        // results of the tests
};

// ---- Choosing the sites of a batch --------------------------------------------------------------

// The number of members of a batch. Large batches use many threads, but members are chosen without
// each other's records, so more records are made. The size is one site in BATCH_SITES, independent
// of the threads, as the records depend on it. Compared to batches of BATCH_LEAST it made .5 to 3 %
// more records at 200x200 (draft and preview of cornell-glossy, indirect-room and vase, three seeds
// each), whose images had .96 to 1.01 times the relative squared error, and 11 % more at 400x400
// (draft, indirect-room). 512 at all levels made up to 30 % more. One thread tests all pairs of
// members, which limits their number to BATCH_MOST: with it, this takes .1 % of the time of 64
// cores (indirect-room, production, 400x400, by the model of bench/scaling.py), and grows as its
// square.
static int batch_size(size_t sites) {
    const size_t size = sites / BATCH_SITES;
    if (size < BATCH_LEAST) return BATCH_LEAST;
    return size > BATCH_MOST ? BATCH_MOST : (int)size;
}

static void test_coverage(void *ctx, size_t begin, size_t end, int worker) {
    (void)worker;
    struct batch *b = ctx;
    for (size_t i = begin; i < end; i++)
        b->covered[i] =
            fill_is_covered(b->making.fill, b->making.kind, b->making.sites, b->tested[i]);
}

// Whether a site is far enough from all members of the batch.
static bool lies_apart(const struct batch *b, const struct fill_site *site) {
    const float least = b->making.sites->spacing * site->pixel;
    for (int i = 0; i < b->count; i++) {
        const struct fill_site *other = b->member[i].site;
        if (v3_dist2(other->p, site->p) < least * least &&
            v3_dot(other->frame.n, site->frame.n) > 0.5f)
            return false;
    }
    return true;
}

static void add_member(struct batch *b, const struct fill_site *site) {
    const size_t n2 = (size_t)(b->making.store->order * b->making.store->order), n = 3 * n2;
    float *block = b->coefficients + 10 * n2 * (size_t)b->count;
    struct fill_member *member = &b->member[b->count++];
    *member = (struct fill_member){.site = site};
    member->radiance = (struct gather_radiance){
        .lambda = block, .dx = block + n, .dy = block + 2 * n, .noise = block + 3 * n};
}

// Selects the next members from the waiting sites. Covered sites are dropped; those too close to a
// member are moved to the front of the remaining ones. False if cancelled.
static bool choose_batch(struct batch *b) {
    const struct parallel_results tests = {.slot = {{b->covered, sizeof *b->covered}}};
    const size_t start = b->next;
    size_t kept = 0, i = start;
    b->count = 0;
    while (i < b->last && b->count < b->size) {
        const size_t n = b->last - i < TESTED_MOST ? b->last - i : TESTED_MOST;
        b->tested = b->waiting + i;
        if (!parallel_for_results(b->making.fill->pool, n, 64, test_coverage, b, &tests))
            return false;
        for (size_t j = 0; j < n && b->count < b->size; j++, i++) {
            const struct fill_site *site = b->waiting[i];
            if (b->covered[j]) continue;
            if (!lies_apart(b, site))
                b->waiting[start + kept++] = site;
            else
                add_member(b, site);
        }
    }
    b->next = i - kept;
    memmove(&b->waiting[b->next], &b->waiting[start], kept * sizeof *b->waiting);
    return true;
}

// ---- Gathering ----------------------------------------------------------------------------------

// Allocates the values of a batch's records. False if there is no memory. Values of records that
// stay invalid are not used.
static bool allocate_values(struct batch *b) {
    if (!b->making.store->order) return true;
    for (struct fill_member *member = b->member; member < b->member + b->count; member++) {
        member->value = cache_value_new(b->making.cache);
        if (!member->value) return false;
    }
    return true;
}

// Gathers the members [begin, end) of a batch. A record that is not finite or out of range is
// gathered again with other random numbers.
static void make_records(void *ctx, size_t begin, size_t end, int worker) {
    struct batch *b = ctx;
    const struct fill *f = b->making.fill;
    const struct gather_worker *w = &f->worker[worker];
    for (struct fill_member *member = b->member + begin; member < b->member + end; member++) {
        const struct fill_site *s = member->site;
        const struct gather_layout *layout = fill_rays_layout(
            f, b->making.kind, s, b->making.sites->a * b->making.sites->factor_max);
        struct gather_site site = {s->p, s->ng, s->frame, s->stream, true, NULL, s->glossy.wo};
        if (fill_rays_glossy(f, b->making.kind, s)) site.glossy = &s->glossy.brdf;
        for (int attempt = 0; attempt < ATTEMPTS && !member->found.valid; attempt++) {
            gather_hemisphere_trace(f->g, layout, &site, w->scratch, w->hemisphere);
            b->records->find(&b->making, member, w->hemisphere);
            b->records->add_rays(&b->making, member, &site, w);
            member->found.valid = b->records->make(&b->making, member);
            if (!member->found.valid) member->found.refused++;
            site.stream = rng_mix(site.stream + RNG_GOLDEN);
        }
    }
}

// ---- Results of a member as bytes ---------------------------------------------------------------

static size_t value_bytes(const struct batch *b) {
    return (size_t)(b->making.store->order * b->making.store->order * CACHE_LANES) * sizeof(float);
}

// The member's pointers are set by choose_batch.
static void pack_members(void *ctx, size_t begin, size_t end, struct bytes *out) {
    const struct batch *b = ctx;
    for (const struct fill_member *member = b->member + begin; member < b->member + end; member++) {
        bytes_put(out, &member->found, sizeof member->found);
        if (member->value) bytes_put(out, member->value, value_bytes(b));
    }
}

static bool unpack_members(void *ctx, size_t begin, size_t end, struct bytes_reader *in) {
    const struct batch *b = ctx;
    for (struct fill_member *member = b->member + begin; member < b->member + end; member++) {
        bytes_get(in, &member->found, sizeof member->found);
        if (member->value) bytes_get(in, member->value, value_bytes(b));
    }
    return true;
}

static const struct parallel_results members_results = {
    .pack = pack_members, .unpack = unpack_members, .journaled = true};

// ---- All batches --------------------------------------------------------------------------------

satin_status fill_records(struct fill *fill, enum cache_kind kind, const struct fill_sites *sites) {
    if (!fill->cache->store[kind].filled) return SATIN_OK;
    satin_status status = SATIN_ERROR_MEMORY;
    struct batch *b = calloc(1, sizeof *b);
    if (!b) return status;
    const char *part = parallel_begin_part(fill->pool, "insert");
    b->making = (struct fill_making){fill, fill->cache, &fill->cache->store[kind], kind, sites};
    b->records = &fill_functions_of[kind];
    b->waiting = array_new(sites->count, sizeof *b->waiting);
    b->size = batch_size(sites->count);
    b->member = array_new((size_t)b->size, sizeof *b->member);
    b->coefficients = array_new(
        (size_t)(b->size * 10 * b->making.store->order * b->making.store->order), sizeof(float));
    if (b->waiting && b->member && b->coefficients) status = SATIN_OK;
    for (size_t i = 0; i < sites->count && status == SATIN_OK; i++)
        if (sites->site[i].kinds >> kind & 1u) b->waiting[b->last++] = &sites->site[i];
    while (b->next < b->last && status == SATIN_OK && !cache_full(fill->cache)) {
        parallel_begin_part(fill->pool, "choose");
        bool whole = choose_batch(b);
        parallel_begin_part(fill->pool, "gather");
        if (whole && !allocate_values(b)) status = SATIN_ERROR_MEMORY;
        if (status != SATIN_OK) break;
        whole = whole && parallel_for_results(fill->pool, (size_t)b->count, 1, make_records, b,
                                              &members_results);
        parallel_begin_part(fill->pool, "insert");
        if (!whole) status = SATIN_CANCELLED;
        for (struct fill_member *member = b->member;
             member < b->member + b->count && status == SATIN_OK; member++) {
            fill->refused += (uint64_t)member->found.refused;
            assert(member->found.refused == 0);
            // A record that stayed invalid is left out, and gathering replaces it at its site.
            if (member->found.valid && !b->records->insert(&b->making, member))
                status = SATIN_ERROR_MEMORY;
        }
    }
    parallel_begin_part(fill->pool, part);
    free(b->waiting);
    free(b->coefficients);
    free(b->member);
    free(b);
    return status;
}
