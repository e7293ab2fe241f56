// SPDX-License-Identifier: Apache-2.0
// Which edges of surfaces a time limit leaves time for, and by how many rays. The constants are
// measured in docs/experiments/edges.md.
#include <math.h>

#include "render/render_edges.h"

enum {
    EDGES_TIMED = 512,  // edges that show how long one takes
    EDGES_RUN = 32,  // of these in a row, as a single one finds nothing in the processor's caches
    TIMED_SHIFT = 2  // numbers of rays are divided by 1 << this to show the time of a ray
};

// Where there is too little time for all edges, surfaces differ more before they are corrected, up
// to this, at which half of them are left. Where that is too much, too, some edges are corrected.
static const float ALIKE_MOST = 0.8f;
// Fractions of a time limit that edges may take, and with the fewest rays. It is planned again when
// there are so many times the samples.
static const double EDGES_FRACTION = 0.1, EDGES_LONGEST = 0.15, PLAN_AGAIN = 2.0;
// With a smaller fraction of the edges there are none.
static const double EDGES_LEAST = 0.1;

static size_t timed_edges(const struct surface_edges *e) {
    return e->list.count < EDGES_TIMED ? e->list.count : EDGES_TIMED;
}

static void time_edges(void *ctx, size_t begin, size_t end, int worker) {
    const struct surface_edges *e = ctx;
    const size_t runs = (timed_edges(e) - 1) / EDGES_RUN + 1, apart = e->list.count / runs;
    for (size_t i = begin; i < end; i++) {
        const size_t at = i / EDGES_RUN * apart + i % EDGES_RUN;
        if (at < e->list.count) render_edges_change(ctx, at, at + 1, worker);
    }
}

// The mean number of rays of an edge when its pixel has `growth` times the samples.
static double mean_edge_rays(const struct surface_edges *e, double growth) {
    double sum = 0.0;
    for (size_t i = 0; i < e->list.count; i++) {
        const double samples = (double)e->r->image->pixel[e->list.pixel[i]].samples;
        sum += (double)render_edge_rays(e, growth * samples);
    }
    return sum / (double)e->list.count;
}

// Measures some edges, whose changes are not applied, with the fewest rays and with more.
static struct surface_seconds measure_edges(struct surface_edges *e) {
    const size_t timed = timed_edges(e);
    double seconds[2], rays[2];
    for (int more = 0; more < 2; more++) {
        const double before = parallel_loop_seconds(e->r->pool);
        e->ray_shift = more ? TIMED_SHIFT : RAY_SHIFT_MOST;
        parallel_for_all(e->r->pool, timed, EDGES_RUN, time_edges, e);
        seconds[more] = render_loop_seconds(e->r, before) / (double)timed;
        rays[more] = mean_edge_rays(e, 1.0);
    }
    const double more = rays[1] - rays[0],
                 ray = more > 0.0 ? fmax(seconds[1] - seconds[0], 0.0) / more : 0.0;
    return (struct surface_seconds){fmax(seconds[1] - ray * rays[1], 0.0), ray};
}

static double edges_seconds(const struct surface_edges *e, struct surface_seconds time,
                            double growth) {
    if (!e->list.count) return 0.0;
    return (double)e->list.count * (time.fixed + time.ray * mean_edge_rays(e, growth));
}

// Leaves out what does not fit into `left` seconds: rays first, as edges with few of them are
// better than none; then edges of surfaces that differ little. Returns the seconds of the others.
static double choose_edges(struct surface_edges *e, struct surface_seconds time, double growth,
                           double left) {
    const double limit = e->r->options.time;
    const double most = fmin(EDGES_FRACTION * limit, left),
                 longest = fmin(EDGES_LONGEST * limit, left);
    e->ray_shift = 0;
    double seconds = edges_seconds(e, time, growth);
    for (; seconds > most && e->ray_shift < RAY_SHIFT_MOST;
         seconds = edges_seconds(e, time, growth))
        e->ray_shift++;
    while (seconds > longest && e->alike < ALIKE_MOST) {
        e->alike *= 2.0f;
        render_edges_find(e);
        seconds = edges_seconds(e, time, growth);
    }
    return seconds;
}

void render_edges_plan(struct render *r) {
    struct render_image *image = r->image;
    struct surface_edges e;
    bool failed;
    if (!(r->options.time > 0.0) || (double)image->taken < PLAN_AGAIN * image->edges_planned)
        return;
    image->edge_time = (struct surface_seconds){0};
    image->edge_seconds = 0.0;
    image->edges_planned = image->taken;
    if (!render_edges_make(&e, r, &failed)) return;
    // Up to twice as many samples will be there at the next plan, or at the end.
    const double more = fmax(render_time_left(r), 0.0) / image->sample_seconds,
                 growth = fmin(1.0 + more / (double)image->taken, PLAN_AGAIN);
    if (e.list.count) image->edge_time = measure_edges(&e);
    const double seconds = choose_edges(&e, image->edge_time, growth, render_budget_left(r)),
                 most = fmax(fmin(EDGES_LONGEST * r->options.time, render_budget_left(r)), 0.0);
    image->edge_seconds = most < EDGES_LEAST * seconds ? 0.0 : fmin(seconds, most);
    render_edges_destroy(&e);
}

// Keeps a fraction of the edges, evenly.
static void thin_edges(struct pixel_list *list, double fraction) {
    size_t kept = 0;
    for (size_t i = 0; i < list->count; i++)
        if (floor(fraction * (double)(i + 1)) > floor(fraction * (double)i))
            list->pixel[kept++] = list->pixel[i];
    list->count = kept;
}

bool render_edges_have_time(const struct render *r) {
    const struct surface_seconds *time = &r->image->edge_time;
    if (!(r->options.time > 0.0)) return true;
    return time->fixed + time->ray > 0.0 && render_budget_for_edges(r) > 0.0;
}

void render_edges_fit(struct surface_edges *e) {
    const double left = render_budget_for_edges(e->r);
    if (!(e->r->options.time > 0.0)) return;
    const double seconds = choose_edges(e, e->r->image->edge_time, 1.0, left);
    if (left < EDGES_LEAST * seconds)
        e->list.count = 0;
    else if (left < seconds)
        thin_edges(&e->list, left / seconds);
}
