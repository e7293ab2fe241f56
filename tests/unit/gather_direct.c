// SPDX-License-Identifier: Apache-2.0
// Direct light where irradiance is precomputed: it is right, and entries around the edge of a spot
// are not read.
#include <math.h>

#include "gather/gather.h"
#include "photon_case.h"
#include "test_scene.h"

static const float BALL = 0.06f;  // radius of a ball beside a beam

// A cube of half side 1 around a light, its photons, and the table of direct light at their
// entries.
struct lit_cube {
    struct test_scene t;
    struct photon_maps *maps;
    struct gather_direct direct;
};

// A black ball touches the wall at z = -1, .04 `beside` this point, which may be NULL.
static void lit_cube_with(struct lit_cube *cube, struct light light, int64_t photons,
                          const vec3 *beside) {
    test_scene_init(&cube->t);
    const uint32_t grey = test_diffuse(&cube->t, .5f, .5f, .5f);
    test_cube(&cube->t, mat4_identity(), true, grey);
    if (beside) {
        const vec3 centre = v3_add(*beside, v3(0.04f + BALL, 0.0f, BALL));
        test_quadric(&cube->t, SHAPE_SPHERE, test_transform(centre, v3(BALL, BALL, BALL)), false,
                     test_diffuse(&cube->t, 0, 0, 0));
    }
    test_light(&cube->t, light);
    test_scene_finish(&cube->t);
    satin_options o = satin_options_default;
    o.photons = photons;
    o.caustic_photons = 0;
    struct parallel *pool = parallel_new(2);
    struct stats stats = {0};
    assert_int_equal(photon_case_build(&cube->t.scene, &o, pool, &stats, &cube->maps), SATIN_OK);
    const struct gather g = gather_make(&cube->t.scene, &o, cube->maps);
    assert_int_equal(
        gather_direct_build(&g, (struct gather_entry_samples){64, 8}, pool, &cube->direct),
        SATIN_OK);
    assert_int_equal(cube->direct.count, photon_irradiance_count(cube->maps));
    parallel_free(pool);
}

static void lit_cube_make(struct lit_cube *cube, struct light light, int64_t photons) {
    lit_cube_with(cube, light, photons, NULL);
}

static void lit_cube_free(struct lit_cube *cube) {
    gather_direct_free(&cube->direct);
    photon_maps_free(cube->maps);
    test_scene_free(&cube->t);
}

// A point light in the middle brings cos^3 of the angle to the wall: the same in every sample, and
// so similar at all neighbours that all may be read.
static void a_point_light_is_exact(void **state) {
    (void)state;
    struct lit_cube cube = {0};
    lit_cube_make(&cube, (struct light){.kind = LIGHT_POINT, .value = rgb_grey(1.0f)}, 20000);
    assert_true(cube.direct.count > 1000);
    size_t similar = 0;
    for (size_t i = 0; i < cube.direct.count; i++) {
        vec3 p, n;
        photon_irradiance_position(cube.maps, i, &p, &n);
        const float r = v3_len(p), exact = -v3_dot(p, n) / (r * r * r);
        assert_true(fabsf(cube.direct.E[i].g / exact - 1.0f) < 1e-3f);
        similar += cube.direct.similar[i];
    }
    assert_int_equal(similar, cube.direct.count);
    lit_cube_free(&cube);
}

// A spot of full light within 20 degrees on one wall: near its edge no entry may be read, but all
// on the other walls, which it does not light.
static void edges_of_spots_are_not_read(void **state) {
    (void)state;
    const float cosine = 0.9396926f, radius = sqrtf(1.0f / (cosine * cosine) - 1.0f);
    const struct light spot = {.kind = LIGHT_SPOT,
                               .direction = v3(0, 0, -1),
                               .value = rgb_grey(1.0f),
                               .cos_cutoff = cosine,
                               .cos_beam = cosine};
    struct lit_cube cube = {0};
    lit_cube_make(&cube, spot, 100000);
    size_t dark = 0, dark_even = 0, lit = 0, edge = 0, edge_even = 0;
    for (size_t i = 0; i < cube.direct.count; i++) {
        vec3 p, n;
        photon_irradiance_position(cube.maps, i, &p, &n);
        const bool similar = cube.direct.similar[i], wall = n.z > 0.5f;
        const float aside = sqrtf(p.x * p.x + p.y * p.y) - radius;
        assert_true((cube.direct.E[i].g > 0.0f) == (wall && aside < 0.0f));
        if (!wall) dark++, dark_even += similar;
        if (wall && aside < 0.0f) lit++;
        if (wall && fabsf(aside) < 0.01f) edge++, edge_even += similar;
    }
    print_message("%zu lit, %zu of %zu at the edge and %zu of %zu of the others may be read\n", lit,
                  edge_even, edge, dark_even, dark);
    assert_true(lit > 20 && edge > 5 && edge_even == 0);
    assert_int_equal(dark_even, dark);
    lit_cube_free(&cube);
}

// Beams that are narrower than the entries' spacing.
struct beams {
    size_t points, read;  // in the lit patches: points with an entry, and those at which it is read
    size_t without;       // those whose entry has no direct photons
    size_t between;       // beams in which there is no entry
};

// One in eight directions, each with a ball beside its patch if `ball`.
static struct beams read_beams(bool ball, int64_t photons) {
    const float cosine = 0.9998f, radius = sqrtf(1.0f / (cosine * cosine) - 1.0f);
    struct beams out = {0};
    for (int beam = 0; beam < 8; beam++) {
        const vec3 centre = v3(0.05f * (float)beam - 0.2f, 0.03f * (float)beam - 0.1f, -1.0f);
        const struct light spot = {.kind = LIGHT_SPOT,
                                   .direction = v3_unit(centre),
                                   .value = rgb_grey(1000.0f),
                                   .cos_cutoff = cosine,
                                   .cos_beam = cosine};
        struct lit_cube cube = {0};
        lit_cube_with(&cube, spot, photons, ball ? &centre : NULL);
        size_t lit = 0;
        for (size_t i = 0; i < cube.direct.count; i++) lit += cube.direct.E[i].g > 0.0f;
        out.between += lit == 0;
        for (int k = 0; k < 64; k++) {
            const float r = 0.9f * radius * sqrtf(((float)k + 0.5f) / 64.0f),
                        angle = 2.4f * (float)k;
            const vec3 p = v3_add(centre, v3(r * cosf(angle), r * sinf(angle), 0.0f));
            float estimate;
            int entry;
            photon_irradiance_at(cube.maps, &cube.t.scene, p, v3(0, 0, 1), &estimate, &entry);
            out.points += entry >= 0;
            out.read += entry >= 0 && cube.direct.similar[entry];
            out.without += entry >= 0 && !(photon_direct_at(cube.maps, (size_t)entry).power > 0.0f);
        }
        lit_cube_free(&cube);
    }
    print_message(
        "%zu of 8 beams fall between entries; %zu of %zu points read, %zu without photons\n",
        out.between, out.read, out.points, out.without);
    return out;
}

// Most beams fall between entries, whose neighbours are dark, and some on one. No entry that would
// be read in a patch may be read.
static void beams_between_entries_are_found(void **state) {
    (void)state;
    const struct beams found = read_beams(false, 10000);
    assert_true(found.between >= 4 && found.points > 256);
    assert_int_equal(found.read, 0);
}

// The nearest entry may be behind the ball, and another one is read, which has the photons then.
static void beams_beside_balls_are_found(void **state) {
    (void)state;
    const struct beams found = read_beams(true, 1500);
    assert_true(found.points > 128);
    assert_int_equal(found.read, 0);
    assert_int_equal(found.without, 0);
}

// A room with a slit through which the sky is visible, and the visibility that was learnt there.
struct sky_room {
    struct lit_cube cube;
    struct guide_visibility *visibility;
    satin_options options;
    struct gather g;
    struct parallel *pool;
};

static void sky_room_make(struct sky_room *room) {
    struct test_scene *t = &room->cube.t;
    test_scene_init(t);
    test_slit_room(t, true);
    test_light(t, (struct light){.kind = LIGHT_CONSTANT, .value = rgb_grey(1.0f)});
    test_scene_finish(t);
    test_look_down(t);
    room->options = satin_options_default;
    room->options.photons = 200000;
    room->options.caustic_photons = 0;
    room->pool = parallel_new(2);
    struct stats stats = {0};
    assert_int_equal(
        photon_case_build(&t->scene, &room->options, room->pool, &stats, &room->cube.maps),
        SATIN_OK);
    const struct guide_visibility_samples rays = {
        .paths = 4096, .box_rays = 8, .bin_rays = 3, .open_bins = 1024, .light_rays = 32};
    assert_int_equal(guide_visibility_build(&t->scene, 0, rays, room->pool, &room->visibility),
                     SATIN_OK);
    room->g = gather_make(&t->scene, &room->options, room->cube.maps);
}

static void sky_room_free(struct sky_room *room) {
    guide_visibility_free(room->visibility);
    parallel_free(room->pool);
    lit_cube_free(&room->cube);
}

// Whether the cell of an entry has found some of the sky, if visibility was learnt.
static bool sky_room_known(const struct sky_room *room, vec3 p, vec3 n) {
    struct light_product product;
    const struct light_receiver at = {p, n, false};
    return !room->g.visibility || guide_visibility_at(room->g.visibility, &at, &product).product;
}

// The mean squared difference of direct light at the entries in the room by these samples from that
// by `reference`, over its mean square. Those in cells that have found nothing of the sky, as in a
// corner from which it is hidden, are left out, and have hardly any of the light.
static double sky_room_error(struct sky_room *room, struct gather_entry_samples samples,
                             struct gather_entry_samples reference) {
    struct gather_direct a, b;
    double difference = 0.0, all = 0.0;
    double light = 0.0, hidden = 0.0;
    size_t entries = 0;
    assert_int_equal(gather_direct_build(&room->g, samples, room->pool, &a), SATIN_OK);
    assert_int_equal(gather_direct_build(&room->g, reference, room->pool, &b), SATIN_OK);
    for (size_t i = 0; i < a.count; i++) {
        vec3 p, n;
        photon_irradiance_position(room->cube.maps, i, &p, &n);
        if (!(fmaxf(fabsf(p.x), fmaxf(fabsf(p.y), fabsf(p.z))) < 1.001f)) continue;
        if (!sky_room_known(room, p, n)) {
            hidden += (double)b.E[i].g;
            continue;
        }
        difference += (double)sqrf(a.E[i].g - b.E[i].g);
        all += (double)sqrf(b.E[i].g);
        light += (double)b.E[i].g;
        entries++;
    }
    print_message("%zu entries, and others with %.3f %% of the light\n", entries,
                  100.0 * hidden / light);
    assert_true(entries > 100 && hidden < 0.01 * light);
    gather_direct_free(&a);
    gather_direct_free(&b);
    return difference / all;
}

// Where what is visible of the sky is known, entries take that many samples, else the others.
static void a_sky_takes_samples_of_its_own(void **state) {
    (void)state;
    const struct gather_entry_samples few = {8, 8}, more = {64, 8}, all = {64, 64},
                                      reference = {2048, 2048};
    struct sky_room room = {.pool = NULL};
    sky_room_make(&room);
    assert_true(sky_room_error(&room, more, few) == 0.0);
    assert_true(sky_room_error(&room, all, few) > 0.0);
    room.g.visibility = room.visibility;
    assert_true(sky_room_error(&room, more, all) == 0.0);
    const double by_few = sky_room_error(&room, few, reference),
                 by_more = sky_room_error(&room, more, reference);
    print_message("squared error of 8 samples %g, of 64 %g\n", by_few, by_more);
    assert_true(by_few > 0.0 && by_more < 0.25 * by_few);
    sky_room_free(&room);
}

// Maps without photons have no entries.
static void empty_maps_have_no_entries(void **state) {
    (void)state;
    struct lit_cube cube = {0};
    lit_cube_make(&cube, (struct light){.kind = LIGHT_POINT, .value = rgb_grey(1.0f)}, 0);
    assert_int_equal(cube.direct.count, 0);
    lit_cube_free(&cube);
}

// The time of all entries is measured at some of them: no more than asked for, but half as many.
static void some_entries_are_tried(void **state) {
    (void)state;
    struct lit_cube cube;
    lit_cube_make(&cube, (struct light){.kind = LIGHT_POINT, .value = rgb_grey(1.0f)}, 4000);
    const struct gather g = gather_make(&cube.t.scene, &satin_options_default, cube.maps);
    const struct gather_entry_samples samples = {1, 1};
    struct parallel *pool = parallel_new(2);
    const size_t most[] = {1, cube.direct.count / 3, cube.direct.count, 2 * cube.direct.count};
    for (size_t i = 0; i < sizeof most / sizeof *most; i++) {
        double fraction;
        assert_int_equal(gather_direct_try(&g, samples, most[i], pool, &fraction), SATIN_OK);
        const double tried = fraction * (double)cube.direct.count;
        assert_true(tried <= (double)most[i] + 1e-6);
        assert_true(tried >= fmin(1.0, 0.5 * (double)most[i]) && fraction <= 1.0);
    }
    parallel_free(pool);
    lit_cube_free(&cube);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(some_entries_are_tried),
        cmocka_unit_test(a_point_light_is_exact),
        cmocka_unit_test(edges_of_spots_are_not_read),
        cmocka_unit_test(beams_between_entries_are_found),
        cmocka_unit_test(beams_beside_balls_are_found),
        cmocka_unit_test(a_sky_takes_samples_of_its_own),
        cmocka_unit_test(empty_maps_have_no_entries),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
