// SPDX-License-Identifier: Apache-2.0
// Guided rays, where all light comes from a spot of light on a ceiling, so small that irradiance,
// radiance and their gradients are known: with guided rays all of these are right within the noise
// of a few hundred rays; without them most hemispheres miss the spot.
#include "gather/gather_cluster_rays.h"

#include "rsh/rsh.h"
#include "spot_room.h"

enum { ORDER = 6, N2 = ORDER * ORDER, STREAMS = 32, RAYS = 600 };

struct gather_cluster_rays_fixture {
    float half_angle;  // of the beam that makes the spot
    struct spot_room room;
};

static void gather_cluster_rays_start(struct gather_cluster_rays_fixture *f, int order,
                                      float half_angle) {
    satin_options options = satin_options_default;
    options.first_pass = SATIN_FIRST_NONE;
    options.max_depth = -1;
    options.photons = 0;
    f->half_angle = half_angle;
    spot_room_make(&f->room, half_angle, options, RAYS, order);
}

static struct gather_site gather_cluster_rays_floor_site(uint64_t stream) {
    vec3 n = v3(0, 1, 0);
    return (struct gather_site){
        v3(-0.3f, -1.0f, 0.4f), n, frame_from_normal(n), stream, true, NULL, {0, 0, 0}};
}

// The flux into the spot, reflected, comes to p from one direction: E over the cosine at p.
static double arrives(const struct gather_cluster_rays_fixture *f, vec3 p, vec3 *w) {
    const vec3 d = v3_sub(v3(LAMP.x, 1.0f, LAMP.z), p);
    const double r = (double)v3_len(d),
                 flux = 2.0 * 3.14159265358979 * (1.0 - (double)cosf(f->half_angle));
    *w = v3_unit(d);
    return (double)ALBEDO / 3.14159265358979 * flux * (double)w->y / (r * r);
}

static void check_irradiance(float half_angle, double tolerance) {
    struct gather_cluster_rays_fixture f;
    gather_cluster_rays_start(&f, 0, half_angle);
    const struct gather_site first = gather_cluster_rays_floor_site(0);
    vec3 w;
    const double E = arrives(&f, first.p, &w) * (double)w.y;
    // The irradiance is const * height^2 / r^4.
    const vec3 d = v3_sub(v3(LAMP.x, 1.0f, LAMP.z), first.p);
    const vec3 moved = v3_mul(v3(d.x, 0.0f, d.z), 4.0f * (float)E / v3_len2(d));
    double sum = 0.0, square = 0.0, gradient = 0.0, rotation = 0.0;
    for (uint64_t i = 0; i < STREAMS; i++) {
        const struct gather_site site = gather_cluster_rays_floor_site(i);
        const struct cache_irradiance_value value = spot_room_irradiance(&f.room, &site);
        assert_true(value.rays > RAYS && value.rays <= RAYS * 3 / 2 + 3);
        const double x = (double)value.E.g / E;
        sum += x / STREAMS;
        square += (x - 1.0) * (x - 1.0) / STREAMS;
        gradient += (double)v3_len(v3_sub(value.grad_t[1], moved)) / STREAMS;
        // The change by a rotation of the normal by a small angle: E / cos(theta) * w . n'.
        const vec3 tilted = v3_unit(v3(0.02f, 1.0f, -0.01f));
        const double wanted = E / (double)w.y * (double)v3_dot(w, tilted) - E;
        const double given = (double)v3_dot(v3_cross(site.frame.n, tilted), value.grad_r[1]);
        rotation += fabs(given - wanted) / fabs(wanted) / STREAMS;
    }
    assert_true(fabs(sum - 1.0) < tolerance);
    assert_true(sqrt(square) < 0.05);
    assert_true(gradient < 0.05 * (double)v3_len(moved));
    assert_true(rotation < 0.05);
    // Without guided rays, one hemisphere in nine hits the spot.
    f.room.options.guide_clusters = false;
    int dark = 0;
    for (uint64_t i = 0; i < STREAMS; i++) {
        const struct gather_site site = gather_cluster_rays_floor_site(i);
        const struct cache_irradiance_value value = spot_room_irradiance(&f.room, &site);
        assert_int_equal(value.rays, gather_layout_rays(f.room.layout));
        dark += value.E.g == 0.0f;
    }
    assert_true(dark > STREAMS / 2);
    spot_room_free(&f.room);
}

// The spot subtends down to ten minutes of arc.
static void irradiance_with_cluster_rays_is_right(void **state) {
    (void)state;
    check_irradiance(0.03f, 0.01);
    check_irradiance(0.003f, 0.03);  // the cosine of the light's angle has two digits left
}

// The mean of Lambda and of its derivative along the frame's u, against those of light from one
// direction.
static void radiance_with_cluster_rays_is_right(void **state) {
    (void)state;
    struct gather_cluster_rays_fixture f;
    gather_cluster_rays_start(&f, ORDER, 0.03f);
    double sum[3][N2] = {{0}};
    struct gather_site site = gather_cluster_rays_floor_site(0);
    for (uint64_t i = 0; i < STREAMS; i++) {
        float lambda[3 * N2], dx[3 * N2], dy[3 * N2], noise[N2];
        struct gather_radiance out = {.lambda = lambda, .dx = dx, .dy = dy, .noise = noise};
        site.stream = i;
        gather_hemisphere_trace(&f.room.g, f.room.layout, &site, f.room.worker->scratch,
                                f.room.worker->hemisphere);
        gather_hemisphere_radiance(f.room.worker->hemisphere, f.room.g.options->radiance_gradients,
                                   &out);
        for (int k = 0; k < N2; k++) {
            sum[0][k] += (double)lambda[N2 + k] / STREAMS;
            sum[1][k] += (double)dx[N2 + k] / STREAMS;
            sum[2][k] += (double)dy[N2 + k] / STREAMS;
        }
    }
    double wanted[3][N2] = {{0}}, error[3] = {0}, size[3] = {0};
    const float h = 0.01f;
    for (int at = -2; at <= 2; at++) {
        const int axis = at < 0 ? -at : at;
        const float step = at < 0 ? -h : h;
        vec3 w, p = site.p;
        if (axis) p = v3_mad(p, step, axis == 1 ? site.frame.u : site.frame.v);
        const double L = arrives(&f, p, &w) * (axis ? 1.0 / (2.0 * (double)step) : 1.0);
        const vec3 local = frame_to_local(&site.frame, w);
        float H[N2];
        rsh_eval(RSH_HEMISPHERE, ORDER, (const float[3]){local.x, local.y, local.z}, H);
        for (int k = 0; k < N2; k++) wanted[axis][k] += L * (double)H[k];
    }
    for (int axis = 0; axis < 3; axis++) {
        for (int k = 0; k < N2; k++) {
            double d = sum[axis][k] - wanted[axis][k];
            error[axis] += d * d;
            size[axis] += wanted[axis][k] * wanted[axis][k];
        }
        assert_true(sqrt(error[axis] / size[axis]) < 0.02);
    }
    spot_room_free(&f.room);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(irradiance_with_cluster_rays_is_right),
        cmocka_unit_test(radiance_with_cluster_rays_is_right),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
