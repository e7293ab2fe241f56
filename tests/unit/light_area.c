// SPDX-License-Identifier: Apache-2.0
// Area lights of any size: products of lengths neither overflow nor vanish. Textured ones are
// sampled by their emission.
#include "base/sampling.h"
#include "light/light_kinds.h"

#include "test_scene.h"

// The solid angle is that of the unit square.
static void solid_angles_of_rectangles_of_any_size_are_right(void **state) {
    (void)state;
    static const float size[] = {1.0f, 1e-7f, 1e5f, 1e7f, 1e-11f, 1e12f};
    float first = 0.0f;
    for (int i = 0; i < 6; i++) {
        struct test_scene t;
        test_scene_init(&t);
        struct mat4 scale = test_transform(v3(0, 0, 0), v3(size[i], size[i], size[i]));
        uint32_t shape = test_rectangle(&t, scale, test_diffuse(&t, 0.5f, 0.5f, 0.5f));
        test_area_light(&t, shape, rgb_grey(1.0f));
        test_scene_finish(&t);
        struct light_sample s;
        vec3 p = v3_mul(v3(0.2f, 0.1f, 0.7f), size[i]);
        assert_true(light_sample_wi(&t.scene, 0, p, 0.3f, 0.6f, &s));
        if (i == 0) first = s.pdf_w;
        assert_true(fabsf(s.pdf_w - first) <= 1e-5f * first);
        test_scene_free(&t);
    }
}

// Normals and densities where the square of the area leaves the range of float.
static void solid_angles_of_triangles_of_any_size_are_right(void **state) {
    (void)state;
    static const uint32_t index[3] = {0, 1, 2};
    static const float size[] = {1.0f, 1e-11f, 1e12f}, u[4] = {0.3f, 0.6f, 0.2f, 0.7f};
    for (int i = 0; i < 3; i++) {
        const float position[10] = {0, 0, 0, size[i], 0, 0, 0, size[i], 0, 0};
        struct test_scene t;
        test_scene_init(&t);
        struct shape s = {.kind = SHAPE_MESH, .material = test_diffuse(&t, 0, 0, 0)};
        s.mesh = (struct mesh){3, 1, position, NULL, NULL, index, NULL, 0};
        test_area_light(&t, test_add_shape(&t, s), rgb_grey(1.0f));
        test_scene_finish(&t);
        struct light_ray photon;
        struct light_sample sample;
        vec3 p = v3_mul(v3(0.2f, 0.1f, 0.7f), size[i]);
        assert_true(light_sample_wi(&t.scene, 0, p, 0.3f, 0.6f, &sample));
        assert_true(v3_dist2(sample.n, v3(0, 0, 1)) < 1e-10f);
        // The solid angle is about that of the triangle from the front.
        assert_true(sample.pdf_w > 0.5f && sample.pdf_w < 10.0f);
        assert_true(light_emit(&t.scene, 0, NULL, u, &photon));
        float power = 0.5f * PI_F * size[i] * size[i];
        assert_true(fabsf(photon.power.r / power - 1.0f) < 1e-4f && photon.ray.d.z > 0.0f);
        test_scene_free(&t);
    }
}

// ---- A rectangle with one bright texel --------------------------------------------------------

enum { TEXELS = 16, BRIGHT = 5 * TEXELS + 11, DRAWS = 256, FINE = 512 };

struct textured {
    struct test_scene t;
    float texel[TEXELS * TEXELS];
    struct image image;
    struct texture texture;
};

static void make_textured(struct textured *l) {
    for (int i = 0; i < TEXELS * TEXELS; i++) l->texel[i] = i == BRIGHT ? 100.0f : 0.1f;
    l->image = scene_image_make(TEXELS, TEXELS, 1, l->texel);
    l->texture = (struct texture){.kind = TEXTURE_BITMAP,
                                  .to_uv = {1, 0, 0, 0, 1, 0},
                                  .image = &l->image,
                                  .mean = rgb_grey(0.1f + 99.9f / (TEXELS * TEXELS))};
    test_scene_init(&l->t);
    uint32_t shape = test_rectangle(&l->t, mat4_identity(), test_diffuse(&l->t, 0, 0, 0));
    l->t.scene.light[test_area_light(&l->t, shape, rgb_grey(1.0f))].texture = &l->texture;
    test_scene_finish(&l->t);
}

// Returns the irradiance from the light at p, which faces it, by a fine grid.
static double light_area_irradiance(const struct textured *l, vec3 p) {
    double sum = 0.0;
    for (int i = 0; i < FINE * FINE; i++) {
        const float u = ((float)(i % FINE) + 0.5f) / FINE, v = ((float)(i / FINE) + 0.5f) / FINE;
        const struct ray down = {v3(2 * u - 1, 2 * v - 1, 1), 0.0f, v3(0, 0, -1), INFINITY};
        struct interaction hit;
        assert_true(scene_intersect(&l->t.scene, &down, &hit));
        const float L = light_emitted(&l->t.scene, &hit, v3(0, 0, 1)).r;
        const float d2 = v3_dist2(p, hit.p);
        sum += (double)(L * p.z * p.z / (d2 * d2)) * 4.0 / (FINE * FINE);
    }
    return sum;
}

// Random samples, which by area would be 160 % off, as one in 256 finds the texel that brings four
// fifths of the light. MIS uses the density of the samples.
static void a_bright_texel_is_found(void **state) {
    (void)state;
    enum { RUNS = 64, FEW = 64 };
    static const vec3 position[] = {{0.5f, -0.2f, 0.3f}, {-0.4f, 0.7f, 5.0f}};
    struct textured l;
    make_textured(&l);
    for (int k = 0; k < 2 * RUNS; k++) {
        const vec3 p = position[k % 2];
        static double squares[2], expected[2];
        struct rng rng = rng_make(3, RNG_TEST, (uint64_t)k);
        if (k < 2) expected[k] = light_area_irradiance(&l, p);
        double sum = 0.0;
        for (int i = 0; i < FEW; i++) {
            const float u = rng_float(&rng), v = rng_float(&rng);
            struct light_sample s;
            assert_true(light_sample_wi(&l.t.scene, 0, p, u, v, &s));
            sum += (double)(s.L.r * -s.wi.z / s.pdf_w) / FEW;
            const struct ray ray = {p, 0.0f, s.wi, INFINITY};
            struct interaction hit;
            assert_true(scene_intersect(&l.t.scene, &ray, &hit));
            // In float a sample at the boundary of two cells may be found in the other.
            const float x = 32.0f * (hit.p.x + 1.0f), y = 32.0f * (hit.p.y + 1.0f);
            const float pdf = light_pdf(&l.t.scene, p, s.wi, &hit);
            if (fabsf(x - roundf(x)) > 1e-3f && fabsf(y - roundf(y)) > 1e-3f)
                assert_true(fabsf(pdf - s.pdf_w) <= 1e-3f * pdf);
        }
        squares[k % 2] += pow(sum / expected[k % 2] - 1.0, 2) / RUNS;
        if (k >= 2 * RUNS - 2) assert_true(sqrt(squares[k % 2]) < 0.15);  // .076 and .042
    }
    test_scene_free(&l.t);
}

// The photons' mean power is the light's, and none is far above it.
static void photons_leave_a_bright_texel(void **state) {
    (void)state;
    struct textured l;
    make_textured(&l);
    const double power = 4.0 * M_PI * (0.1 + 99.9 / (TEXELS * TEXELS));
    double sum = 0.0, most = 0.0;
    for (uint32_t i = 0; i < DRAWS; i++) {
        struct sampler sampler = {i, 5, 0};
        const vec2 a = sampler_2d(&sampler), b = sampler_2d(&sampler);
        const float u[4] = {a.x, a.y, b.x, b.y};
        struct light_ray photon;
        assert_true(light_emit(&l.t.scene, 0, NULL, u, &photon));
        sum += (double)photon.power.r / DRAWS;
        most = fmax(most, (double)photon.power.r);
    }
    assert_true(fabs(sum / power - 1.0) < 0.05);
    assert_true(most < 3.0 * power);
    test_scene_free(&l.t);
}

// ---- A mesh of many triangles -------------------------------------------------------------------

enum { AROUND = 24, ALONG = 12, POINTS = AROUND * (ALONG + 1), TRIANGLES = 2 * AROUND * ALONG };

// A ball with radii of 1, 1 and 2; its poles are degenerate.
static void make_ball(float position[3 * POINTS + 1], uint32_t index[3 * TRIANGLES]) {
    for (int i = 0; i < POINTS; i++) {
        const double phi = 2.0 * M_PI * (i % AROUND) / AROUND;
        const double theta = M_PI * (double)(i / AROUND) / ALONG;
        position[3 * i] = (float)(sin(theta) * cos(phi));
        position[3 * i + 1] = (float)(sin(theta) * sin(phi));
        position[3 * i + 2] = (float)(2.0 * cos(theta));
    }
    for (uint32_t i = 0; i < AROUND * ALONG; i++) {
        const uint32_t next = i % AROUND == AROUND - 1 ? i + 1 - AROUND : i + 1;
        const uint32_t corner[6] = {i, i + AROUND, next + AROUND, i, next + AROUND, next};
        memcpy(index + 6 * (size_t)i, corner, sizeof corner);
    }
}

// The solid angle of a convex mesh: of its triangles that face p, each at its middle.
static double ball_solid_angle(const struct shape *shape, vec3 p) {
    double sum = 0.0;
    for (uint32_t i = 0; i < TRIANGLES; i++) {
        const uint32_t *index = shape->mesh.index + 3 * (size_t)i;
        vec3 d = v3(0, 0, 0);
        for (int k = 0; k < 3; k++)
            d = v3_add(d, v3_sub(p, scene_mesh_vertex(&shape->mesh, index[k])));
        d = v3_mul(d, 1.0f / 3.0f);
        const float facing = 0.5f * v3_dot(light_triangle_normal(shape, i), d);
        if (facing > 0.0f) sum += (double)facing / pow((double)v3_len(d), 3.0);
    }
    return sum;
}

// Samples of a closed mesh from far away are of its visible side; the mean of 1 / density is
// the solid angle, and rays that find the mesh report the same density.
static void samples_of_a_mesh_face_the_point(void **state) {
    (void)state;
    enum { SAMPLES = 1 << 14 };
    static const vec3 position[] = {{0, 0, 25}, {15, 1, 0}, {-20, -30, 25}, {3, 2, -1}};
    static float corner[3 * POINTS + 1];
    static uint32_t index[3 * TRIANGLES];
    struct test_scene t;
    test_scene_init(&t);
    make_ball(corner, index);
    struct shape s = {.kind = SHAPE_MESH, .material = test_diffuse(&t, 0, 0, 0)};
    s.mesh = (struct mesh){POINTS, TRIANGLES, corner, NULL, NULL, index, NULL, 0};
    const uint32_t shape = test_add_shape(&t, s);
    test_area_light(&t, shape, rgb_grey(1.0f));
    test_scene_finish(&t);
    for (size_t k = 0; k < sizeof position / sizeof *position; k++) {
        const vec3 p = position[k];
        double sum = 0.0;
        int facing = 0;
        for (uint32_t i = 0; i < SAMPLES; i++) {
            const vec2 u = sample_sobol2(i, 0);
            struct light_sample sample;
            struct interaction hit;
            if (!light_sample_wi(&t.scene, 0, p, u.x, u.y, &sample)) continue;
            facing++;
            sum += 1.0 / (double)sample.pdf_w / SAMPLES;
            const struct ray ray = {p, 0.0f, sample.wi, INFINITY};
            if (!scene_intersect(&t.scene, &ray, &hit)) continue;  // between two triangles
            const float pdf = light_pdf(&t.scene, p, sample.wi, &hit);
            if (v3_dist2(hit.p, sample.p) < 1e-8f)
                assert_true(fabsf(pdf - sample.pdf_w) <= 2e-3f * pdf);
        }
        const double expected = ball_solid_angle(&t.scene.shape[shape], p);
        const double far = (double)v3_len(p) / sqrt(6.0);  // radius of the bounds
        print_message("%.1f radii: solid angle %.4f, %+.2f %%, %.1f %% face the point\n", far,
                      expected, 100.0 * (sum / expected - 1.0), 100.0 * facing / SAMPLES);
        assert_true(fabs(sum / expected - 1.0) < 0.005);
        if (far > 3.0) assert_true(facing > 0.7 * SAMPLES);
    }
    test_scene_free(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(solid_angles_of_rectangles_of_any_size_are_right),
        cmocka_unit_test(solid_angles_of_triangles_of_any_size_are_right),
        cmocka_unit_test(a_bright_texel_is_found), cmocka_unit_test(photons_leave_a_bright_texel),
        cmocka_unit_test(samples_of_a_mesh_face_the_point)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
