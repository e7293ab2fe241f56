// SPDX-License-Identifier: Apache-2.0
// Lookups of the entry of irradiance near a point by voxels.
#include "photon_case.h"
#include "test_scene.h"

#include <math.h>

#include "base/sampling.h"
#include "photon/photon_map.h"

enum { POINTS = 8192, AT_ONCE = 512 };

// A box that emits and reflects light, and photons in it.
struct voxel_case {
    struct test_scene t;
    struct parallel *pool;
    struct photon_maps *maps;
    vec3 p[POINTS], n[POINTS];  // points on its walls
};

static struct photon_maps *build_box_maps(struct voxel_case *c) {
    satin_options o = satin_options_default;
    o.photons = 100000;
    o.caustic_photons = 0;
    o.photon_k = 50;
    struct stats stats = {0};
    struct photon_maps *maps = NULL;
    assert_int_equal(photon_case_build(&c->t.scene, &o, c->pool, &stats, &maps), SATIN_OK);
    assert_non_null(maps->irradiance.voxels.scale);
    return maps;
}

static int voxel_case_begin(void **state) {
    static struct voxel_case c;
    test_scene_init(&c.t);
    const uint32_t grey = test_diffuse(&c.t, 0.5f, 0.5f, 0.5f);
    test_area_light(&c.t, test_cube(&c.t, mat4_identity(), true, grey), rgb_grey(1.0f));
    test_scene_finish(&c.t);
    c.pool = parallel_new(2);
    c.maps = build_box_maps(&c);
    for (uint32_t i = 0; i < POINTS; i++) {
        const vec2 u = sample_sobol2(i, 0);
        const float a = 2.0f * u.x - 1.0f, b = 2.0f * u.y - 1.0f, h = i & 1 ? 1.0f : -1.0f;
        c.p[i] = i % 3 == 0 ? v3(h, a, b) : i % 3 == 1 ? v3(a, h, b) : v3(a, b, h);
        c.n[i] = i % 3 == 0 ? v3(-h, 0, 0) : i % 3 == 1 ? v3(0, -h, 0) : v3(0, 0, -h);
    }
    *state = &c;
    return 0;
}

static int voxel_case_end(void **state) {
    struct voxel_case *c = *state;
    photon_maps_free(c->maps);
    parallel_free(c->pool);
    test_scene_free(&c->t);
    return 0;
}

static int nearest_entry(const struct photon_irradiance *r, vec3 p, vec3 n) {
    float query[6], distance2;
    int entry;
    photon_entry_row_set(query, p, n, r->position.scale);
    photon_index_nearest(r->index, query, 1, 1, INFINITY, &entry, &distance2);
    return entry;
}

// The entry of a voxel is the nearest one to its centre, so it is farther from a point in it than
// the nearest one by a diagonal at most, and on the same wall even at an edge.
static void entries_are_near(void **state) {
    const struct voxel_case *c = *state;
    const struct photon_irradiance *r = &c->maps->irradiance;
    int entry[POINTS], others = 0;
    for (size_t i = 0; i < POINTS; i += AT_ONCE)
        photon_voxel_find(r, c->p + i, c->n + i, AT_ONCE, entry + i);
    for (int i = 0; i < POINTS; i++) {
        const int nearest = nearest_entry(r, c->p[i], c->n[i]);
        const vec3 at = photon_entry_position(&r->position, (size_t)entry[i]);
        const float least =
            sqrtf(v3_dist2(c->p[i], photon_entry_position(&r->position, (size_t)nearest)));
        // Voxels are at most as wide as the spacing, which varies by half within a region.
        const float spacing = sqrtf(48.0f / 2.0f / (float)r->count);
        assert_true(sqrtf(v3_dist2(c->p[i], at)) <= least + 1.5f * sqrtf(3.0f) * spacing);
        assert_true(fabsf(v3_dot(v3_sub(at, c->p[i]), c->n[i])) < 1e-6f);
        others += entry[i] != nearest;
    }
    assert_in_range(others, POINTS / 20, POINTS / 2);  // voxels are used, and are narrow
}

// Several entries near a point are those nearest to its voxel's centre, so they are no farther than
// as many that are nearest to the point but for two half diagonals.
static void several_entries_are_near(void **state) {
    const struct voxel_case *c = *state;
    const struct photon_irradiance *r = &c->maps->irradiance;
    const float spacing = sqrtf(48.0f / 2.0f / (float)r->count);
    for (int i = 0; i < POINTS; i++) {
        int entry[PHOTON_VOXEL_NEAR], nearest[PHOTON_VOXEL_NEAR];
        float query[6], distance2[PHOTON_VOXEL_NEAR], most = 0.0f;
        photon_voxel_find_near(r, c->p[i], c->n[i], entry);
        photon_entry_row_set(query, c->p[i], c->n[i], r->position.scale);
        photon_index_nearest(r->index, query, 1, PHOTON_VOXEL_NEAR, INFINITY, nearest, distance2);
        for (int k = 0; k < PHOTON_VOXEL_NEAR; k++) most = fmaxf(most, distance2[k]);
        for (int k = 0; k < PHOTON_VOXEL_NEAR; k++) {
            const vec3 at = photon_entry_position(&r->position, (size_t)entry[k]);
            assert_true(sqrtf(v3_dist2(c->p[i], at)) <= sqrtf(most) + 1.5f * sqrtf(3.0f) * spacing);
            for (int j = 0; j < k; j++) assert_int_not_equal(entry[j], entry[k]);
        }
    }
}

// What a lookup finds does not depend on those before it, nor on the thread.
struct lookups {
    struct voxel_case *c;
    int entry[POINTS], near[POINTS][PHOTON_VOXEL_NEAR];
};

static void look_up_range(void *ctx, size_t begin, size_t end, int worker) {
    struct lookups *l = ctx;
    (void)worker;
    const struct photon_irradiance *r = &l->c->maps->irradiance;
    for (size_t i = begin; i < end; i++) {
        photon_voxel_find(r, l->c->p + i, l->c->n + i, 1, l->entry + i);
        photon_voxel_find_near(r, l->c->p[i], l->c->n[i], l->near[i]);
    }
}

static void order_does_not_matter(void **state) {
    struct voxel_case *c = *state;
    struct photon_maps *first = c->maps;
    static struct lookups forwards, parallel;
    forwards.c = parallel.c = c;
    c->maps = build_box_maps(c);
    for (size_t i = POINTS; i-- > 0;) look_up_range(&forwards, i, i + 1, 0);
    photon_maps_free(c->maps);
    c->maps = build_box_maps(c);
    assert_true(parallel_for(c->pool, POINTS, 16, look_up_range, &parallel));
    assert_memory_equal(forwards.entry, parallel.entry, sizeof forwards.entry);
    assert_memory_equal(forwards.near, parallel.near, sizeof forwards.near);
    photon_maps_free(c->maps);
    c->maps = first;
}

// Points far outside are searched, and points that are not finite find nothing.
static void strange_points(void **state) {
    const struct voxel_case *c = *state;
    const vec3 p[] = {v3(0, 0, 1e6f), v3(-1e30f, 0, 0), v3(NAN, 0, 0), v3(0, INFINITY, 0)};
    const vec3 n[] = {v3(0, 0, -1), v3(1, 0, 0), v3(0, 0, 1), v3(0, 1, 0)};
    int entry[4];
    photon_voxel_find(&c->maps->irradiance, p, n, 4, entry);
    assert_int_equal(entry[0], nearest_entry(&c->maps->irradiance, p[0], n[0]));
    assert_int_equal(entry[2], -1);
    assert_int_equal(entry[3], -1);
    int near[PHOTON_VOXEL_NEAR];
    photon_voxel_find_near(&c->maps->irradiance, p[2], n[2], near);
    assert_int_equal(near[0], -1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(entries_are_near),
        cmocka_unit_test(several_entries_are_near),
        cmocka_unit_test(order_does_not_matter),
        cmocka_unit_test(strange_points),
    };
    return cmocka_run_group_tests(tests, voxel_case_begin, voxel_case_end);
}
