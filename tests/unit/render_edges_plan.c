// SPDX-License-Identifier: Apache-2.0
// A time limit takes rays from all edges before it leaves any edge out.
#include "render/render_edges.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

enum { EDGES = 100 };

// The edges of an image of that many pixels, of two samples each, so that an edge has 64 rays: with
// these all of them take 650 s, and with the fewest, 4, they take 50 s.
struct planned_edges {
    struct render r;
    struct render_image image;
    struct image_pixel pixel[EDGES];
    uint32_t at[EDGES];
    struct surface_edges edges;
};

// With a limit of 1000 s, of which so many are left.
static struct planned_edges *planned_edges_new(double left) {
    struct planned_edges *p = calloc(1, sizeof *p);
    assert_non_null(p);
    p->r.options = satin_options_default;
    p->r.options.width = EDGES;
    p->r.options.height = 1;
    p->r.options.time = 1000.0;
    p->r.options.edge_rays = 64;
    p->r.pool = parallel_new(1);
    assert_non_null(p->r.pool);
    p->r.progress.start = stats_wall() - (1000.0 - left);
    p->image.pixel = p->pixel;
    p->image.edge_time = (struct surface_seconds){.fixed = 0.1, .ray = 0.1};
    p->r.image = &p->image;
    for (uint32_t i = 0; i < EDGES; i++) {
        p->pixel[i].samples = 2;
        p->at[i] = i;
    }
    // They differ so much that none is left out as alike.
    p->edges = (struct surface_edges){.r = &p->r, .alike = 1.0f};
    p->edges.list.pixel = p->at;
    p->edges.list.count = EDGES;
    return p;
}

static void planned_edges_free(struct planned_edges *p) {
    parallel_free(p->r.pool);
    free(p);
}

static void fit_edges(double left, int ray_shift, size_t least, size_t most) {
    struct planned_edges *p = planned_edges_new(left);
    assert_true(render_edges_have_time(&p->r));
    render_edges_fit(&p->edges);
    assert_int_equal(p->edges.ray_shift, ray_shift);
    assert_in_range(p->edges.list.count, least, most);
    planned_edges_free(p);
}

static void rays_are_left_out_before_edges(void **state) {
    (void)state;
    fit_edges(1000.0, 3, EDGES, EDGES);  // in a tenth of the limit
    fit_edges(60.0, 4, EDGES, EDGES);
    fit_edges(40.0, 4, 75, 80);
    fit_edges(2.0, 4, 0, 0);
}

static void edges_without_a_limit_have_all_rays(void **state) {
    (void)state;
    struct planned_edges *p = planned_edges_new(1000.0);
    p->r.options.time = 0.0;
    p->image.edge_time = (struct surface_seconds){0};
    assert_true(render_edges_have_time(&p->r));
    render_edges_fit(&p->edges);
    assert_int_equal(p->edges.ray_shift, 0);
    assert_int_equal(p->edges.list.count, EDGES);
    planned_edges_free(p);
}

static void edges_are_not_begun_without_time(void **state) {
    (void)state;
    struct planned_edges *p = planned_edges_new(0.0);
    assert_false(render_edges_have_time(&p->r));
    planned_edges_free(p);
    p = planned_edges_new(1000.0);
    p->image.edge_time = (struct surface_seconds){0};
    assert_false(render_edges_have_time(&p->r));
    planned_edges_free(p);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_are_left_out_before_edges),
        cmocka_unit_test(edges_without_a_limit_have_all_rays),
        cmocka_unit_test(edges_are_not_begun_without_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
