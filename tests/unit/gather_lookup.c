// SPDX-License-Identifier: Apache-2.0
// Entries that are gathered anew have the light that photons bring them, with max_depth too; a ray
// of a narrow lobe reads a disc that others read too, one of a wide lobe does not.
#include <math.h>

#include "gather/gather.h"
#include "photon_case.h"
#include "test_scene.h"

enum { ENTRIES = 64 };
static const float LOOKUP_ALBEDO = 0.8f;

// The unit sphere, diffuse, around a point light that brings an irradiance of pi: after n bounces
// it is pi LOOKUP_ALBEDO^n everywhere.
static void lookup_sphere(struct test_scene *t) {
    test_scene_init(t);
    test_quadric(t, SHAPE_SPHERE, mat4_identity(), true,
                 test_diffuse(t, LOOKUP_ALBEDO, LOOKUP_ALBEDO, LOOKUP_ALBEDO));
    test_light(t, (struct light){.kind = LIGHT_POINT, .value = rgb_grey(PI_F)});
    test_scene_finish(t);
}

struct lookup_case {
    struct test_scene t;
    satin_options o;
    struct parallel *pool;
    struct stats stats;
    struct photon_maps *maps;
    struct gather g;
};

static void lookup_begin(struct lookup_case *c, int max_depth) {
    *c = (struct lookup_case){.o = satin_options_default, .pool = parallel_new(2)};
    lookup_sphere(&c->t);
    c->o.first_pass = SATIN_FIRST_PRECOMPUTED;
    c->o.photons = 40000;
    c->o.caustic_photons = 0;
    c->o.max_depth = max_depth;
    c->o.rr_depth = 100;
    assert_int_equal(photon_case_build(&c->t.scene, &c->o, c->pool, &c->stats, &c->maps), SATIN_OK);
    c->g = gather_make(&c->t.scene, &c->o, c->maps);
}

// What one ray reads, by a lobe of this density.
static struct gather_lookup lookup_along_x(const struct lookup_case *c, float pdf_w) {
    const struct ray ray = {v3(0.1f, 0, 0), 0.0f, v3(1, 0, 0), INFINITY};
    struct sampler sampler = {0, 1, 0};
    struct gather_lookup out;
    assert_true(gather_look_up(&c->g, ray, pdf_w, &sampler, &out));
    return out;
}

static void lookup_end(struct lookup_case *c) {
    photon_maps_free(c->maps);
    parallel_free(c->pool);
    test_scene_free(&c->t);
}

// An entry is two segments from the eye, and light of n bounces n + 1 from the entry. Tested at 1 %
// with one and without a limit, and at 2 % with two and three bounces, whose fraction in photons is
// that of a mean bounce.
static void entries_have_the_light_of_their_depth(void **state) {
    (void)state;
    for (int bounces = 1; bounces <= 4; bounces++) {
        struct lookup_case c;
        lookup_begin(&c, bounces < 4 ? bounces + 3 : -1);
        int entry[ENTRIES];
        rgb E[ENTRIES];
        for (int i = 0; i < ENTRIES; i++)
            entry[i] = (int)((size_t)i * photon_irradiance_count(c.maps) / ENTRIES);
        assert_int_equal(gather_entries(&c.g, entry, ENTRIES, 256, c.pool, E), SATIN_OK);
        float mean = 0.0f, sum = 0.0f, power = 1.0f;
        for (int i = 0; i < ENTRIES; i++) mean += rgb_luminance(E[i]) / (PI_F * ENTRIES);
        for (int n = 1; n <= bounces; n++) sum += power *= LOOKUP_ALBEDO;
        if (bounces == 4) sum = LOOKUP_ALBEDO / (1.0f - LOOKUP_ALBEDO);
        print_message("%d bounces: %.4f of %.4f\n", bounces, (double)mean, (double)sum);
        assert_float_equal(mean / sum, 1.0f, (bounces % 3 == 1 ? 0.01f : 0.02f));
        lookup_end(&c);
    }
}

static void narrow_lobes_read_one_disc(void **state) {
    (void)state;
    struct lookup_case c;
    lookup_begin(&c, -1);
    const struct gather_lookup narrow = lookup_along_x(&c, 1e6f), wide = lookup_along_x(&c, 0.3f);
    assert_true(narrow.common == 1.0f && wide.common > 0.0f && wide.common < 0.1f);
    assert_int_equal(narrow.entry, wide.entry);
    assert_true(narrow.L.g > 0.0f && narrow.L.g == wide.L.g);
    lookup_end(&c);
}

// Replaced light is read, and the entries around one are found.
static void replaced_entries_are_read(void **state) {
    (void)state;
    struct lookup_case c;
    lookup_begin(&c, -1);
    const struct gather_lookup before = lookup_along_x(&c, 1.0f);
    const size_t entry = (size_t)before.entry;
    photon_irradiance_replace(c.maps, entry, rgb_grey(7.0f));
    assert_float_equal(lookup_along_x(&c, 1.0f).L.r, LOOKUP_ALBEDO * 7.0f / PI_F, 1e-4f);
    int row[PHOTON_NEAR];
    float distance2[PHOTON_NEAR];
    const float radius = photon_irradiance_radius(c.maps, entry);
    const size_t near = photon_irradiance_near(c.maps, entry, radius, row, distance2);
    bool itself = false;
    assert_in_range(near, 2, PHOTON_NEAR);
    for (size_t i = 0; i < near; i++) {
        itself |= row[i] == before.entry && distance2[i] == 0.0f;
        assert_true(distance2[i] <= radius * radius);
    }
    assert_true(itself);
    lookup_end(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(entries_have_the_light_of_their_depth),
        cmocka_unit_test(narrow_lobes_read_one_disc),
        cmocka_unit_test(replaced_entries_are_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
