// SPDX-License-Identifier: Apache-2.0
// Direct light where irradiance is precomputed: the right amount of it, and no word of the entries
// around the edge of a spot.
#include <math.h>

#include "gather/gather.h"
#include "test_scene.h"

static struct photon_maps *build_maps(const struct test_scene *t, const satin_options *o,
                                      struct parallel *pool) {
    struct photon_maps *maps = NULL;
    struct stats stats = {0};
    assert_int_equal(photon_maps_build(&t->scene, o, pool, (struct log){0}, &stats, &maps),
                     SATIN_OK);
    return maps;
}

// A cube of half side 1 around a light of the kind.
static void lit_cube(struct test_scene *t, struct light light) {
    test_scene_init(t);
    test_cube(t, mat4_identity(), true, test_diffuse(t, .5f, .5f, .5f));
    test_light(t, light);
    test_scene_finish(t);
}

// A point light in the middle brings cos^3 of the angle to the wall: the same in every sample, and
// so much the same at all neighbours that all may be read.
static void a_point_light_is_exact(void **state) {
    (void)state;
    struct test_scene t;
    lit_cube(&t, (struct light){.kind = LIGHT_POINT, .value = rgb_grey(1.0f)});
    satin_options o = satin_options_default;
    o.photons = 20000;
    o.caustic_photons = 0;
    struct parallel *pool = parallel_new(2);
    struct photon_maps *maps = build_maps(&t, &o, pool);
    const struct gather g = gather_make(&t.scene, &o, maps);
    struct gather_direct_table table;
    assert_int_equal(gather_direct_table_build(&g, pool, &table), SATIN_OK);
    assert_int_equal(table.count, photon_irradiance_count(maps));
    assert_true(table.count > 1000);
    size_t even = 0;
    for (size_t i = 0; i < table.count; i++) {
        vec3 p, n;
        photon_irradiance_position(maps, i, &p, &n);
        const float r = v3_len(p), exact = -v3_dot(p, n) / (r * r * r);
        assert_true(fabsf(table.E[i].g / exact - 1.0f) < 1e-3f);
        even += table.even[i];
    }
    assert_int_equal(even, table.count);
    gather_direct_table_free(&table);
    photon_maps_free(maps);
    parallel_free(pool);
    test_scene_free(&t);
}

// A spot of full light within 20 degrees on one wall: within some neighbours' distance of its edge
// no entry may be read, but most on the other walls, which it does not light at all.
static void edges_of_spots_are_not_read(void **state) {
    (void)state;
    const float cosine = 0.9396926f;
    struct test_scene t;
    lit_cube(&t, (struct light){.kind = LIGHT_SPOT,
                                .direction = v3(0, 0, -1),
                                .value = rgb_grey(1.0f),
                                .cos_cutoff = cosine,
                                .cos_beam = cosine});
    satin_options o = satin_options_default;
    o.photons = 100000;
    o.caustic_photons = 0;
    struct parallel *pool = parallel_new(2);
    struct photon_maps *maps = build_maps(&t, &o, pool);
    const struct gather g = gather_make(&t.scene, &o, maps);
    struct gather_direct_table table;
    assert_int_equal(gather_direct_table_build(&g, pool, &table), SATIN_OK);
    const float radius = sqrtf(1.0f / (cosine * cosine) - 1.0f);
    size_t dark = 0, dark_even = 0, lit = 0, edge = 0, edge_even = 0;
    for (size_t i = 0; i < table.count; i++) {
        vec3 p, n;
        photon_irradiance_position(maps, i, &p, &n);
        const bool spot = n.z > 0.5f && sqrtf(p.x * p.x + p.y * p.y) < radius;
        if (n.z < 0.5f) dark++, dark_even += table.even[i];
        if (spot) lit++;
        assert_true((table.E[i].g > 0.0f) == spot);
        const float aside = fabsf(sqrtf(p.x * p.x + p.y * p.y) - radius);
        if (n.z > 0.5f && aside < 0.01f) edge++, edge_even += table.even[i];
    }
    print_message("%zu lit, %zu of %zu at the edge and %zu of %zu of the others may be read\n", lit,
                  edge_even, edge, dark_even, dark);
    assert_true(lit > 20 && edge > 5 && edge_even == 0);
    assert_int_equal(dark_even, dark);
    gather_direct_table_free(&table);
    photon_maps_free(maps);
    parallel_free(pool);
    test_scene_free(&t);
}

// Maps without photons have no entries.
static void empty_maps_have_no_entries(void **state) {
    (void)state;
    struct test_scene t;
    lit_cube(&t, (struct light){.kind = LIGHT_POINT, .value = rgb_grey(1.0f)});
    satin_options o = satin_options_default;
    o.photons = o.caustic_photons = 0;
    struct parallel *pool = parallel_new(1);
    struct photon_maps *maps = build_maps(&t, &o, pool);
    const struct gather g = gather_make(&t.scene, &o, maps);
    struct gather_direct_table table;
    assert_int_equal(gather_direct_table_build(&g, pool, &table), SATIN_OK);
    assert_int_equal(table.count, 0);
    gather_direct_table_free(&table);
    photon_maps_free(maps);
    parallel_free(pool);
    test_scene_free(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_point_light_is_exact),
        cmocka_unit_test(edges_of_spots_are_not_read),
        cmocka_unit_test(empty_maps_have_no_entries),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
