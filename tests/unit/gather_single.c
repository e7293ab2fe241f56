// SPDX-License-Identifier: Apache-2.0
// Guided single rays, where all light comes from a spot of light on a ceiling that few rays hit:
// the light that a point of the floor reflects has the known mean, and little noise, by eight rays.
#include "gather/gather.h"

#include "spot_room.h"

enum { PIXELS = 64, SAMPLES = 16, RAYS = 8, RAYS_HEMISPHERE = 64 };

static const float GATHER_SINGLE_HALF_ANGLE = 0.05f;

static void gather_single_start(struct spot_room *f) {
    satin_options options = satin_options_default;
    options.first_pass = SATIN_FIRST_NONE;
    options.max_depth = -1;
    options.photons = 0;
    spot_room_make(f, GATHER_SINGLE_HALF_ANGLE, options, RAYS_HEMISPHERE, 0);
}

// A point of the floor, at an offset along x.
static struct shading_point gather_single_point(const struct spot_room *f, float x) {
    const vec3 d = v3(0, -1, 0);
    struct interaction s;
    struct shading_point p;
    const struct ray ray = {.o = v3(-0.3f + x, 0.0f, 0.4f), .d = d, .tfar = INFINITY};
    assert_true(scene_intersect(&f->scene.scene, &ray, &s));
    scene_shading_point_make(&f->scene.scene, &s, d, &p);
    return p;
}

// The light that the point reflects: the flux into the spot of light is reflected as from a point.
static double gather_single_expected(const struct shading_point *p) {
    const double pi = 3.14159265358979;
    const vec3 d = v3_sub(v3(LAMP.x, 1.0f, LAMP.z), p->interaction.p);
    const double r2 = (double)v3_len2(d), cosine = (double)v3_unit(d).y;
    const double flux = 2.0 * pi * (1.0 - (double)cosf(GATHER_SINGLE_HALF_ANGLE));
    const double diffuse = (double)ALBEDO / pi;
    return diffuse * diffuse * flux * cosine * cosine / r2;
}

// The light by the rays of one sample.
static double light_of_sample(struct spot_room *f, const struct shading_point *p, uint32_t sample,
                              uint32_t seed) {
    struct gather_single_clusters *clusters =
        gather_single_find(&f->g, p, 0.01f, f->worker->singles);
    struct gather_ray ray[RAYS] = {0};
    rgb weight[RAYS], sum = rgb_grey(0.0f);
    int rays = 0;
    for (uint32_t i = 0; i < RAYS; i++) {
        struct sampler u = {RAYS * sample + i, seed, 0};
        const vec2 uv = sampler_2d(&u);
        struct brdf_sample b;
        if (!gather_single_sample(clusters, p, BRDF_DIFFUSE, sampler_1d(&u), uv, &b)) continue;
        const vec3 d = frame_to_world(&p->frame, b.wi);
        ray[rays] = (struct gather_ray){
            .ray = scene_spawn(&f->scene.scene, p->interaction.p, p->interaction.ng, d),
            .item = u.index};
        weight[rays++] = b.weight;
    }
    gather_single_rays(&f->g, f->worker->scratch, clusters, ray, (size_t)rays, seed);
    for (int i = 0; i < rays; i++) sum = rgb_fma(sum, weight[i], ray[i].L);
    return (double)sum.g / RAYS;
}

struct gather_single_errors {
    double mean, rms;  // relative
};

// The errors of single samples. Those of a pixel are within four centimetres, which is one area.
static struct gather_single_errors gather_single_errors_of(struct spot_room *f, bool guided) {
    struct gather_single_errors e = {0};
    f->options.guide_clusters = guided;
    for (uint32_t pixel = 0; pixel < PIXELS; pixel++) {
        gather_singles_begin(f->worker->singles);
        for (uint32_t i = 0; i < SAMPLES; i++) {
            const struct shading_point p = gather_single_point(f, 0.002f * (float)i);
            const double d = light_of_sample(f, &p, i, pixel) / gather_single_expected(&p) - 1.0;
            e.mean += d / (PIXELS * SAMPLES);
            e.rms += d * d / (PIXELS * SAMPLES);
        }
    }
    e.rms = sqrt(e.rms);
    print_message("mean %+.4f, rms %.4f\n", e.mean, e.rms);
    return e;
}

static void few_rays_find_a_spot_of_light(void **state) {
    (void)state;
    struct spot_room f;
    gather_single_start(&f);
    const struct gather_single_errors with = gather_single_errors_of(&f, true);
    // Four standard deviations of the mean, and what one direction for the whole spot neglects.
    assert_true(fabs(with.mean) < 4.0 * with.rms / sqrt(PIXELS * SAMPLES) + 0.005);
    // Half of the rays go to the cone of the cluster, of which the spot fills a part.
    assert_true(with.rms < 0.6);
    assert_true(gather_single_errors_of(&f, false).rms > 5.0);
    spot_room_free(&f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(few_rays_find_a_spot_of_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
