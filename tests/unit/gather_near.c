// SPDX-License-Identifier: Apache-2.0
// Bounces of gather rays that continue, where all light comes from a small spot of light on
// a ceiling and the site is on that ceiling, from which it is not visible: irradiance there is
// known by integration over the walls and the floor, which the spot lights.
#include "gather/gather_near.h"
#include "brdf/brdf_models.h"
#include "gather/gather_layout.h"

#include "beam_shower.h"
#include "spot_room.h"

enum { STREAMS = 64, RAYS = 600, POINTS = 1 << 16 };

static const float GATHER_NEAR_HALF_ANGLE = 0.02f;

// `walls` is the largest number of diffuse surfaces between the site and the spot of light. Without
// photons every hit is near.
static void gather_near_start(struct spot_room *f, int walls, int photons) {
    satin_options options = satin_options_default;
    options.max_depth = 3 + walls;  // the eye, the site, the walls, the spot of light, the lamp
    options.photons = photons;
    spot_room_make(f, GATHER_NEAR_HALF_ANGLE, options, RAYS, 0);
}

static struct gather_site ceiling_site(uint64_t stream) {
    const vec3 n = v3(0, -1, 0);
    return (struct gather_site){
        v3(0.9f, 1.0f, 0.3f), n, frame_from_normal(n), stream, true, NULL, {0, 0, 0}};
}

// Draws the surface point y that is seen from p by the cosine.
static struct interaction draw_wall(const struct spot_room *f, vec3 p, vec3 n, vec2 u) {
    const struct frame frame = frame_from_normal(n);
    const vec3 d = frame_to_world(&frame, sample_cosine_hemisphere(u.x, u.y));
    const struct ray ray = scene_spawn(&f->scene.scene, p, n, d);
    struct interaction y;
    assert_true(scene_intersect(&f->scene.scene, &ray, &y));
    if (v3_dot(y.ng, d) > 0.0f) y.ng = v3_neg(y.ng);
    return y;
}

// Irradiance at y from the spot, over its flux and its albedo over pi.
static double from_spot(const struct interaction *y) {
    const vec3 offset = v3_sub(v3(LAMP.x, 1.0f, LAMP.z), y->p);
    const float r2 = v3_len2(offset);
    return (double)(fmaxf(v3_dot(offset, y->ng), 0.0f) * offset.y / (r2 * r2));
}

// Irradiance at the site: the flux into the spot is reflected to y as from a point, then to the
// site, or over z if there are two walls.
static double gather_near_expected(const struct spot_room *f, int walls) {
    const struct gather_site site = ceiling_site(0);
    const double flux = 2.0 * 3.14159265358979 * (1.0 - (double)cosf(GATHER_NEAR_HALF_ANGLE));
    double sum = 0.0;
    for (uint32_t i = 0; i < POINTS; i++) {
        const struct interaction y = draw_wall(f, site.p, site.ng, sample_sobol2(i, 7));
        sum += from_spot(&y) / POINTS;
        if (walls < 2) continue;
        const struct interaction z = draw_wall(f, y.p, y.ng, sample_sobol2(i, 8));
        sum += (double)ALBEDO * from_spot(&z) / POINTS;
    }
    const double diffuse = (double)ALBEDO / 3.14159265358979;
    return 3.14159265358979 * diffuse * diffuse * flux * sum;
}

struct gather_near_errors {
    double mean, rms, most;  // relative
};

static struct gather_near_errors gather_near_errors_of(struct spot_room *f, bool guided, double E) {
    struct gather_near_errors e = {0};
    f->options.guide_clusters = guided;
    for (uint64_t i = 0; i < STREAMS; i++) {
        const struct gather_site site = ceiling_site(i);
        const struct cache_irradiance_value value = spot_room_irradiance(f, &site);
        const double d = (double)value.E.g / E - 1.0;
        e.mean += d / STREAMS;
        e.rms += d * d / STREAMS;
        e.most = fmax(e.most, d);
    }
    e.rms = sqrt(e.rms);
    print_message("mean %+.4f, rms %.4f, most %+.4f\n", e.mean, e.rms, e.most);
    return e;
}

// The bound of the mean is four standard deviations. A run by the BRDF alone shows the noise
// without clusters.
static void assert_even(struct spot_room *f, double E, double rms) {
    const struct gather_near_errors with = gather_near_errors_of(f, true, E);
    assert_true(fabs(with.mean) < 4.0 * with.rms / sqrt(STREAMS));
    assert_true(with.rms < rms);
    assert_true(gather_near_errors_of(f, false, E).rms > 1.0);
}

static void positions_hidden_from_the_site_are_sampled(void **state) {
    (void)state;
    struct spot_room f;
    gather_near_start(&f, 1, 0);
    assert_even(&f, gather_near_expected(&f, 1), 0.15);
    spot_room_free(&f);
}

// Paths that continue by more than one bounce.
static void second_bounces_find_the_spot(void **state) {
    (void)state;
    struct spot_room f;
    gather_near_start(&f, 2, 0);
    assert_even(&f, gather_near_expected(&f, 2), 0.15);
    spot_room_free(&f);
}

// Hits that are not near, but whose lookups are too large to be reliable.
static void bounces_from_large_lookups_find_the_spot(void **state) {
    (void)state;
    struct spot_room f;
    gather_near_start(&f, 1, 2000);
    f.g.lookup_max = 0.01f;
    const vec3 p = v3(0.3f, -1.0f, 0.3f), n = v3(0, 1, 0);
    float radius;
    photon_irradiance_at(f.maps, &f.scene.scene, p, n, &radius, NULL);
    assert_true(f.g.lookup_max < radius && !gather_is_near(&f.g, 2.0f, radius, 2.0f));
    assert_even(&f, gather_near_expected(&f, 1), 0.15);
    spot_room_free(&f);
}

// Traces a hemisphere from a site on the ceiling, whose hits complete clusters->near.
static void probe_clusters(struct spot_room *f, struct gather_cluster_rays *clusters) {
    gather_near_start(f, 1, 0);
    const struct gather_site site = ceiling_site(0);
    struct gather_hemisphere *h = f->worker->hemisphere;
    gather_hemisphere_begin(h, f->layout, &site.frame);
    gather_cluster_rays_add(&f->g, &site, h, clusters);
    for (uint32_t i = 0; i < RAYS; i++) {
        const vec2 u = sample_sobol2(i, 5);
        const vec3 d = frame_to_world(&site.frame, sample_cosine_hemisphere(u.x, u.y));
        h->ray[i] =
            (struct gather_ray){.ray = scene_spawn(&f->scene.scene, site.p, site.ng, d), .item = i};
    }
    gather_rays_guided(&f->g, f->worker->scratch, h->ray, RAYS, 0, &clusters->near);
    assert_true(clusters->near.state == NEAR_PROBED && clusters->near.cones.count > 0);
}

// The point that is seen from the site along d.
static struct shading_point point_along(const struct spot_room *f, vec3 d) {
    const struct gather_site site = ceiling_site(0);
    const struct ray ray = scene_spawn(&f->scene.scene, site.p, site.ng, d);
    struct interaction s;
    struct shading_point y;
    assert_true(scene_intersect(&f->scene.scene, &ray, &s));
    scene_shading_point_make(&f->scene.scene, &s, d, &y);
    return y;
}

// Whether a direction from y leads to the spot of light.
static bool leads_to_spot(const struct shading_point *y, vec3 wi) {
    const vec3 w = frame_to_world(&y->frame, wi), spot = v3(LAMP.x, 1.0f, LAMP.z);
    const vec3 at = v3_mad(y->interaction.p, (1.0f - y->interaction.p.y) / w.y, w);
    return w.y > 0.0f && v3_dist2(at, spot) < sqrf(tanf(GATHER_NEAR_HALF_ANGLE));
}

// The mean weight is that by the BRDF alone: over all directions the albedo, over those to the spot
// their part of it.
static void weights_are_unbiased(void **state) {
    (void)state;
    struct spot_room f;
    struct gather_cluster_rays clusters;
    probe_clusters(&f, &clusters);
    for (int wall = 0; wall < 2; wall++) {
        const vec3 d = wall ? v3_unit(v3(1.0f, -2.0f, 0.2f)) : v3(0, -1, 0);
        const vec3 spot = v3(LAMP.x, 1.0f, LAMP.z);
        const float r = tanf(GATHER_NEAR_HALF_ANGLE);
        const struct shading_point y = point_along(&f, d);
        double sum = 0.0, hits = 0.0;
        for (uint32_t i = 0; i < POINTS; i++) {
            struct sampler u = {i, 3, 0};
            struct brdf_sample next;
            const float u_lobe = sampler_1d(&u);
            if (!gather_near_bounce(&clusters.near.cones, &y, BRDF_DIFFUSE, 1e-4f, u_lobe,
                                    sampler_2d(&u), &next))
                continue;
            sum += (double)next.weight.g / POINTS;
            if (leads_to_spot(&y, next.wi)) hits += (double)next.weight.g / POINTS;
        }
        const vec3 offset = v3_sub(spot, y.interaction.p);
        const double r2 = (double)v3_len2(offset),
                     cosines = (double)(offset.y * v3_dot(offset, y.frame.n));
        const double wanted = (double)(ALBEDO * r * r) * cosines / (r2 * r2);
        print_message("%.4f of %.4f, %.3e of %.3e\n", sum, (double)ALBEDO, hits, wanted);
        assert_true(fabs(sum / (double)ALBEDO - 1.0) < 0.01);
        assert_true(fabs(hits / wanted - 1.0) < 0.02);
    }
    spot_room_free(&f);
}

// A BRDF that transmits has a frame that keeps the side of its surface. Seen from the other side,
// its bounces go to the clusters on the viewer's side, as many as from the first side, by the same
// weights.
static void clusters_get_bounces_on_both_sides(void **state) {
    (void)state;
    struct spot_room f;
    struct gather_cluster_rays clusters;
    probe_clusters(&f, &clusters);
    struct shading_point y = point_along(&f, v3(0, -1, 0));
    y.brdf.model = &brdf_model_principledthin;
    int found[2] = {0};
    double sum[2] = {0};
    for (int side = 0; side < 2; side++) {
        const vec3 wo = frame_to_world(&y.frame, y.wo_l);
        y.frame = frame_from_normal(v3(0, side ? -1.0f : 1.0f, 0));
        y.wo_l = frame_to_local(&y.frame, wo);
        assert_true(side ? y.wo_l.z < 0.0f : y.wo_l.z > 0.0f);
        for (uint32_t i = 0; i < POINTS; i++) {
            struct sampler u = {i, 3, 0};
            struct brdf_sample next;
            const float u_lobe = sampler_1d(&u);
            if (!gather_near_bounce(&clusters.near.cones, &y, BRDF_DIFFUSE, 1e-4f, u_lobe,
                                    sampler_2d(&u), &next))
                continue;
            assert_true(next.wi.z * y.wo_l.z > 0.0f);
            sum[side] += (double)next.weight.g / POINTS;
            found[side] += leads_to_spot(&y, next.wi);
        }
    }
    print_message("%d and %d bounces, weights %.4f and %.4f\n", found[0], found[1], sum[0], sum[1]);
    assert_true(found[0] > POINTS / 8 && abs(found[1] - found[0]) < POINTS / 64);
    assert_true(fabs(sum[1] / sum[0] - 1.0) < 0.01);
    spot_room_free(&f);
}

// A metal reflects light by its lobe from the spot too: bounces to it are many, and the weights are
// those of the lobe alone, also in the direction of the spot.
static void glossy_bounces_find_the_spot(void **state) {
    (void)state;
    struct spot_room f;
    struct gather_cluster_rays clusters;
    probe_clusters(&f, &clusters);
    struct shading_point y = point_along(&f, v3_unit(v3(-0.6f, -2.0f, 0.2f)));
    y.brdf = (struct brdf){.model = &brdf_model_phong, .specular = rgb_grey(0.8f), .exponent = 4};
    assert_true(gather_aims_bounce(BRDF_GLOSSY, BRDF_GLOSSY));
    assert_false(gather_aims_bounce(BRDF_GLOSSY | BRDF_DIFFUSE, BRDF_GLOSSY));
    double sum[2] = {0}, hits = 0.0;
    int found = 0;
    for (uint32_t i = 0; i < POINTS; i++) {
        struct brdf_sample next;
        struct sampler u = {i, 3, 0};
        const float u_lobe = sampler_1d(&u);
        const vec2 uv = sampler_2d(&u);
        if (brdf_sample_wi(&y.brdf, y.wo_l, u_lobe, uv, BRDF_GLOSSY, BRDF_RADIANCE, &next))
            sum[0] += (double)next.weight.g / POINTS;
        if (!gather_near_bounce(&clusters.near.cones, &y, BRDF_GLOSSY, 1e-4f, u_lobe, uv, &next))
            continue;
        sum[1] += (double)next.weight.g / POINTS;
        if (!leads_to_spot(&y, next.wi)) continue;
        hits += (double)next.weight.g / POINTS;
        found++;
    }
    const vec3 offset = v3_sub(v3(LAMP.x, 1.0f, LAMP.z), y.interaction.p);
    const double r2 = (double)v3_len2(offset), r = (double)tanf(GATHER_NEAR_HALF_ANGLE);
    const vec3 wi = frame_to_local(&y.frame, v3_unit(offset));
    const double reflected =
        (double)(brdf_eval(&y.brdf, y.wo_l, wi, BRDF_GLOSSY).g * wi.z * offset.y);
    const double wanted = 3.14159265358979 * r * r * reflected / (r2 * sqrt(r2));
    print_message("%d bounces, weights %.4f of %.4f, %.3e of %.3e\n", found, sum[1], sum[0], hits,
                  wanted);
    assert_true(found > POINTS / 8);
    assert_true(fabs(sum[1] / sum[0] - 1.0) < 0.01);
    assert_true(fabs(hits / wanted - 1.0) < 0.02);
    spot_room_free(&f);
}

// A site where photons show a beam sends rays to it.
static void beams_get_rays(void **state) {
    (void)state;
    const struct beam_shower shower = {v3_unit(v3(0.6f, -0.2f, 1.0f)), 0.4f, true};
    const vec3 up = v3(0, 0, 1);
    struct spot_room f;
    gather_near_start(&f, 1, 2000);
    struct photon_maps maps = *f.maps;
    beam_shower_build(&shower, &maps);
    for (int beam = 0; beam < 2; beam++) {
        if (beam) f.g.maps = &maps;
        const struct gather_site site = {v3(0, 0, 0), up,       frame_from_normal(up), 1, true,
                                         NULL,        {0, 0, 0}};
        struct gather_hemisphere *h = f.worker->hemisphere;
        struct gather_cluster_rays clusters;
        gather_hemisphere_begin(h, f.layout, &site.frame);
        gather_cluster_rays_add(&f.g, &site, h, &clusters);
        int rays = 0;
        for (int c = 0; c < clusters.to.count; c++)
            if (guide_cone_holds(&clusters.to.cone[c], shower.axis) &&
                clusters.to.cone[c].versine < sqrf(2.0f * BEAM_SHOWER_HALF_ANGLE))
                rays += clusters.to.rays[c];
        assert_true(beam ? rays >= 32 : rays == 0);
    }
    photon_map_free(&maps.global);
    spot_room_free(&f);
}

// Hits within a radius are near, and those within a few, unless that is beyond the largest reliable
// radius.
static void hits_within_a_few_radii_are_near(void **state) {
    (void)state;
    const struct gather g = {.lookup_max = 3.0f};
    assert_true(gather_is_near(&g, 0.99f, 0.5f, 2.0f) && !gather_is_near(&g, 1.01f, 0.5f, 2.0f));
    assert_true(gather_is_near(&g, 2.9f, 1.0f, 4.0f) && !gather_is_near(&g, 3.1f, 1.0f, 4.0f));
    assert_true(gather_is_near(&g, 4.9f, 5.0f, 2.0f) && !gather_is_near(&g, 5.1f, 5.0f, 2.0f));
    assert_true(gather_is_near(&g, 1e30f, INFINITY, 2.0f));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hits_within_a_few_radii_are_near),
        cmocka_unit_test(positions_hidden_from_the_site_are_sampled),
        cmocka_unit_test(second_bounces_find_the_spot),
        cmocka_unit_test(bounces_from_large_lookups_find_the_spot),
        cmocka_unit_test(weights_are_unbiased),
        cmocka_unit_test(clusters_get_bounces_on_both_sides),
        cmocka_unit_test(glossy_bounces_find_the_spot),
        cmocka_unit_test(beams_get_rays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
