// SPDX-License-Identifier: Apache-2.0
// Rays by the glossy lobes of a site: with them the light of a small spot, whose amount is known,
// is counted once, whether it is in the lobe or not; what the lobe reflects has a fraction of the
// variance of as many stratified rays; and gradients are of the other rays alone.
#include "gather/gather_lobe_rays.h"

#include "rsh/rsh.h"
#include "spot_room.h"

enum { ORDER = 6, N2 = ORDER * ORDER, STREAMS = 64, RAYS = 600 };

struct gather_lobe_rays_fixture {
    struct spot_room room;
    struct gather_worker *worker;  // with memory for rays by lobes
    struct brdf brdf;
    struct gather_site site;
};

// A site on the floor with a lobe of phong of this exponent, towards wo.
static void gather_lobe_rays_start(struct gather_lobe_rays_fixture *f, float half_angle,
                                   float exponent, vec3 wo) {
    satin_options options = satin_options_default;
    options.first_pass = SATIN_FIRST_NONE;
    options.max_depth = -1;
    options.photons = 0;
    spot_room_make(&f->room, half_angle, options, RAYS, ORDER);
    f->worker = gather_workers_new(NULL, 2 * gather_layout_rays(f->room.layout));
    assert_non_null(f->worker);
    f->brdf = (struct brdf){
        .model = brdf_find("phong"), .specular = rgb_grey(1.0f), .exponent = exponent};
    const vec3 n = v3(0, 1, 0);
    f->site = (struct gather_site){
        v3(-0.3f, -1.0f, 0.4f), n, frame_from_normal(n), 0, true, &f->brdf, v3(0, 0, 0)};
    f->site.wo = frame_to_local(&f->site.frame, wo);
}

static void gather_lobe_rays_stop(struct gather_lobe_rays_fixture *f) {
    gather_workers_free(f->worker, 1);
    spot_room_free(&f->room);
}

static const struct gather_hemisphere *gather_lobe_rays_trace(struct gather_lobe_rays_fixture *f,
                                                              uint64_t stream) {
    f->site.stream = stream;
    gather_hemisphere_trace(&f->room.g, f->room.layout, &f->site, f->worker->scratch,
                            f->worker->hemisphere);
    return f->worker->hemisphere;
}

// The mean over hemispheres of the light from all directions, over what the spot reflects to the
// site. One lobe holds the spot, the other does not.
static void a_spot_counts_once_in_any_lobe(void **state) {
    (void)state;
    const float half_angle = 0.03f;
    for (int in_lobe = 0; in_lobe < 2; in_lobe++) {
        struct gather_lobe_rays_fixture f;
        const vec3 p = v3(-0.3f, -1.0f, 0.4f);
        const vec3 d = v3_sub(v3(LAMP.x, 1.0f, LAMP.z), p), w = v3_unit(d);
        const vec3 wo = in_lobe ? v3(-w.x, w.y, -w.z) : v3_unit(v3(-0.8f, 0.6f, 0.1f));
        gather_lobe_rays_start(&f, half_angle, 20.0f, wo);
        const double pi = 3.14159265358979;
        const double flux = 2.0 * pi * (1.0 - (double)cosf(half_angle));
        const double wanted = (double)ALBEDO / pi * flux * (double)w.y / (double)v3_len2(d);
        double sum = 0.0;
        for (uint64_t i = 0; i < STREAMS; i++) {
            float lambda[3 * N2];
            struct gather_radiance out = {.lambda = lambda};
            const struct gather_hemisphere *h = gather_lobe_rays_trace(&f, i);
            assert_true(h->all - h->count > h->stratified / 2);
            assert_true(h->all - h->count <= h->stratified);
            gather_hemisphere_radiance(h, f.room.g.options->radiance_gradients, &out);
            assert_int_equal(out.rays, h->all);
            for (size_t k = 0; k < h->all; k++)
                sum += (double)(h->weight[k] * h->g[k]) / wanted / STREAMS;
        }
        // By the rays to clusters a hemisphere has a deviation of some 2 %.
        assert_true(fabs(sum - 1.0) < 0.01);
        gather_lobe_rays_stop(&f);
    }
}

// The variance over hemispheres of what the lobe reflects of a wide spot, and its mean.
static double reflected_variance(struct gather_lobe_rays_fixture *f, vec3 wo, double *mean) {
    double sum = 0.0, square = 0.0;
    for (uint64_t i = 0; i < STREAMS; i++) {
        const double L = (double)gather_hemisphere_reflected(gather_lobe_rays_trace(f, i), &f->brdf,
                                                             wo, BRDF_GLOSSY)
                             .g;
        sum += L / STREAMS;
        square += L * L / STREAMS;
    }
    *mean = sum;
    return square - sum * sum;
}

static void a_lobe_reflects_the_same_with_less_variance(void **state) {
    (void)state;
    struct gather_lobe_rays_fixture f;
    gather_lobe_rays_start(&f, 0.6f, 40.0f, v3_unit(v3(-0.2f, 0.9f, 0.3f)));
    f.room.options.guide_clusters = false;
    double with, without;
    const vec3 wo = f.site.wo;
    const double variance = reflected_variance(&f, wo, &with);
    gather_layout_free(f.room.layout);
    f.room.layout = gather_layout_new(2 * RAYS, SATIN_HSH, ORDER);
    f.site.glossy = NULL;
    const double before = reflected_variance(&f, wo, &without);
    assert_true(fabs(with - without) < 4.0 * sqrt((variance + before) / STREAMS));
    assert_true(variance < 0.2 * before);
    gather_lobe_rays_stop(&f);
}

// Light that is the same in all strata changes nothing at any boundary, whatever the rays of the
// lobe have found.
static void gradients_are_of_the_other_rays(void **state) {
    (void)state;
    struct gather_lobe_rays_fixture f;
    gather_lobe_rays_start(&f, 0.6f, 40.0f, v3_unit(v3(-0.2f, 0.9f, 0.3f)));
    f.room.options.guide_clusters = false;
    float lambda[3 * N2], dx[3 * N2], dy[3 * N2];
    struct gather_radiance out = {.lambda = lambda, .dx = dx, .dy = dy};
    gather_lobe_rays_trace(&f, 1);
    struct gather_hemisphere *h = f.worker->hemisphere;
    for (size_t i = 0; i < h->count; i++) h->L[i] = rgb_grey(1.0f);
    gather_hemisphere_radiance(h, f.room.g.options->radiance_gradients, &out);
    double size = 0.0;
    for (int k = 0; k < 3 * N2; k++) size += (double)(dx[k] * dx[k] + dy[k] * dy[k]);
    assert_true(size < 1e-12);
    gather_lobe_rays_stop(&f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_spot_counts_once_in_any_lobe),
        cmocka_unit_test(a_lobe_reflects_the_same_with_less_variance),
        cmocka_unit_test(gradients_are_of_the_other_rays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
