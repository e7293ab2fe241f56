// SPDX-License-Identifier: Apache-2.0
// Filters irradiance where no record is near [Kontkanen et al. 2004]: what the samples of a pixel
// gather there is averaged with what those of the pixels around it gather, with the weights that
// records of the least radius would have. So a gap between records is as smooth as they are. Of
// some kernels, each pixel has the smallest one with enough rays.
#include "base/array.h"
#include "render/render_image.h"

// The largest radius of a kernel over the longer side of the film, and a bound in pixels, which
// limits the time of the filter; and the ratio of the radii of two kernels. Where light is rare or
// parts are narrow, as on a cornice, the radius of records had a tenth of the rays. With one, two,
// three and four times that radius, half of a record's rays and 320x180 pixels, where two times is
// this fraction, diffuse indirect light of living-room had 1, .78, .84 and 1.08 times the error
// (two seeds), and all of veach-ajar 1, 1.005, 1.01 and 1.01 times.
#define RADIUS_FILM 0.0375f
#define RADIUS_MOST 32.0f
#define RATIO 0.70710678f
#define LEAST_KERNEL 0.125f  // of the largest one
enum { FILTER_ROWS = 4 };    // per chunk

// Two pixels whose connection is blocked at this fraction of their distance above their surfaces
// are in different rooms, or on both sides of a partition: without this test three of ten drafts of
// storeys had up to twice the light beside one.
#define LIFT 0.5f

// The fraction of a record's rays that suffice; records where there is little variance have it
// (option irradiance-noise). With all of them, contacts became smoother than their noise asked for:
// indirect-room at preview and vase at draft had 1.05 and 1.02 times the error, with a quarter
// 1.00.
static const float ENOUGH = 0.5f;
// The largest fraction of the light of a kernel by one sample. One that brings more is of rare
// light, and its pixel would be a bright dot. With .03, .1, .3 and 1 diffuse indirect light of
// living-room had 1.03, .94, .98 and 1 times the error, and veach-ajar 1.005, 1, 1 and 1 times.
static const float SAMPLE_MOST = 0.1f;

float render_irradiance_rays(const satin_options *o) {
    const bool filters = o->irradiance_filter && o->integrator == SATIN_TWO_PASS &&
                         o->irradiance_cache && !o->denoise;
    return filters ? ENOUGH * (float)o->irradiance_rays : 0.0f;
}

void render_irradiance_gathered(struct image_gathered *sum, const struct shade_sample *s) {
    const struct shade_gathered *from = &s->gathered;
    if (!(from->rays > 0.0f)) return;
    if (!(sum->rays > 0.0f)) {
        sum->p = from->p;
        sum->pixel = from->pixel;
    }
    sum->n = v3_add(sum->n, from->n);
    sum->light = rgb_mad(sum->light, from->light, s->weight);
    sum->most = maxf(sum->most, rgb_luminance(from->light) * s->weight);
    sum->albedo = rgb_mad(sum->albedo, from->albedo, s->weight);
    sum->rays += from->rays;
}

// ---- Kernels ------------------------------------------------------------------------------------

// Weighted sums over the pixels of a kernel.
struct irradiance_kernel {
    rgb light, albedo;
    float rays;
};

static void add_to_kernel(struct irradiance_kernel *k, const struct image_gathered *q,
                          float weight) {
    k->light = rgb_mad(k->light, q->light, weight);
    k->albedo = rgb_mad(k->albedo, q->albedo, weight);
    k->rays += weight * q->rays;
}

// The pixel in the middle of the kernels.
struct irradiance_window {
    const struct image_gathered *p;
    const struct render_image *image;
    int x, y;
    float radius;  // of the largest kernel, in pixels
    float a;       // accuracy
};

// The largest kernel is at least as wide as the least records, as the image reads them.
float render_irradiance_radius(const struct render_image *image, const satin_options *o) {
    const float film = (float)(image->width > image->height ? image->width : image->height);
    const float records = o->irradiance_min_pixels * o->irradiance_widen;
    return fminf(fmaxf(records, RADIUS_FILM * film), RADIUS_MOST);
}

static struct irradiance_window window_at(const struct render_image *image, const satin_options *o,
                                          float radius, int x, int y) {
    return (struct irradiance_window){
        .p = &image->gathered[(size_t)y * (size_t)image->width + (size_t)x],
        .image = image,
        .x = x,
        .y = y,
        .radius = radius,
        .a = o->irradiance_a * o->irradiance_widen};
}

// The weight of pixel q in the kernel of this radius: 1 - d / radius - r.
static float kernel_weight(const struct irradiance_window *w, const struct image_gathered *q,
                           float radius) {
    const float d = v3_len(v3_sub(q->p, w->p->p)) / w->p->pixel;
    if (d >= radius) return 0.0f;
    const float lengths = v3_len(w->p->n) * v3_len(q->n);
    const float cosine = lengths > 0.0f ? v3_dot(w->p->n, q->n) / lengths : -1.0f;
    return 1.0f - d / radius - sqrtf(fmaxf(1.0f - cosine, 0.0f)) / w->a;
}

// What is done with a pixel q != p of a kernel, which has this weight.
typedef void kernel_fn(void *ctx, const struct irradiance_window *w, const struct image_gathered *q,
                       float weight);

static void visit_kernel(const struct irradiance_window *w, float radius, kernel_fn *visit,
                         void *ctx) {
    const struct render_image *image = w->image;
    const int side = (int)radius;
    const int x0 = w->x > side ? w->x - side : 0, y0 = w->y > side ? w->y - side : 0;
    const int x1 = w->x + side < image->width ? w->x + side : image->width - 1;
    const int y1 = w->y + side < image->height ? w->y + side : image->height - 1;
    for (int row = y0; row <= y1; row++) {
        const struct image_gathered *of_row = image->gathered + (size_t)row * (size_t)image->width;
        for (int column = x0; column <= x1; column++) {
            const struct image_gathered *q = &of_row[column];
            if (q == w->p || !(q->rays > 0.0f)) continue;
            const float weight = kernel_weight(w, q, radius);
            if (weight > 0.0f) visit(ctx, w, q, weight);
        }
    }
}

// What decides whether a kernel is large enough.
struct irradiance_evidence {
    float rays, Y, most;  // Y: luminance of the light; most: that of its brightest sample
};

static void add_evidence(void *ctx, const struct irradiance_window *w,
                         const struct image_gathered *q, float weight) {
    struct irradiance_evidence *sum = ctx;
    (void)w;
    sum->rays += weight * q->rays;
    sum->Y += weight * rgb_luminance(q->light);
    sum->most = maxf(sum->most, weight * q->most);
}

static bool is_enough(const struct irradiance_evidence *sum, float wanted) {
    return sum->rays >= wanted && !(sum->most > SAMPLE_MOST * sum->Y);
}

// The radius of the smallest kernel of which this number of rays is known; 0: the pixel alone.
static float choose_radius(const struct irradiance_window *w, float wanted) {
    const struct irradiance_evidence alone = {w->p->rays, rgb_luminance(w->p->light), w->p->most};
    if (alone.rays >= wanted) return 0.0f;
    for (float radius = w->radius * LEAST_KERNEL; radius < w->radius; radius /= RATIO) {
        struct irradiance_evidence sum = alone;
        visit_kernel(w, radius, add_evidence, &sum);
        if (is_enough(&sum, wanted)) return radius;
    }
    return w->radius;
}

struct summing {
    const struct satin_scene *scene;
    struct irradiance_kernel kernel;
};

// Whether no wall is between two pixels. What is lower than LIFT times their distance is no wall.
static bool is_open(const struct satin_scene *scene, const struct image_gathered *p,
                    const struct image_gathered *q) {
    const float lift = LIFT * v3_len(v3_sub(q->p, p->p));
    const vec3 from = v3_mad(p->p, lift, v3_unit(p->n)), to = v3_mad(q->p, lift, v3_unit(q->n));
    const struct ray ray = scene_spawn_to(scene, from, v3(0, 0, 0), to, v3(0, 0, 0));
    return !scene_occluded(scene, &ray);
}

static void add_pixel_to_sum(void *ctx, const struct irradiance_window *w,
                             const struct image_gathered *q, float weight) {
    struct summing *sum = ctx;
    if (is_open(sum->scene, w->p, q)) add_to_kernel(&sum->kernel, q, weight);
}

// What `albedo` reflects of the irradiance of a kernel, in one channel.
static float filtered(float light, float of, float albedo, float unfiltered) {
    return of > 0.0f && light >= 0.0f ? albedo * (light / of) : unfiltered;
}

rgb render_irradiance_change(const struct render_image *image, const struct satin_scene *scene,
                             const satin_options *o, float radius_most, int x, int y) {
    const struct irradiance_window w = window_at(image, o, radius_most, x, y);
    const struct image_gathered *p = w.p;
    if (!(p->rays > 0.0f)) return rgb_grey(0.0f);
    struct summing sum = {.scene = scene};
    add_to_kernel(&sum.kernel, p, 1.0f);
    const float radius = choose_radius(&w, render_irradiance_rays(o));
    if (radius > 0.0f) visit_kernel(&w, radius, add_pixel_to_sum, &sum);
    const struct irradiance_kernel *k = &sum.kernel;
    const rgb to = {filtered(k->light.r, k->albedo.r, p->albedo.r, p->light.r),
                    filtered(k->light.g, k->albedo.g, p->albedo.g, p->light.g),
                    filtered(k->light.b, k->albedo.b, p->albedo.b, p->light.b)};
    const size_t at = (size_t)(p - image->gathered);
    const rgb change = rgb_scale(rgb_sub(to, p->light), render_image_scale(&image->pixel[at]));
    return rgb_finite(change) ? change : rgb_grey(0.0f);
}

struct irradiance_filtering {
    struct render *r;
    float radius;  // of the largest kernel
};

static void filter_irradiance_rows(void *ctx, size_t begin, size_t end, int worker) {
    const struct irradiance_filtering *f = ctx;
    const struct render *r = f->r;
    const size_t width = (size_t)r->image->width;
    (void)worker;
    for (size_t at = begin * width; at < end * width; at++)
        r->image->irradiance[at] = render_irradiance_change(
            r->image, &r->scene, &r->options, f->radius, (int)(at % width), (int)(at / width));
}

bool render_irradiance_filter(struct render *r) {
    struct render_image *image = r->image;
    struct irradiance_filtering f = {r, 0.0f};
    if (!image->gathered) return true;
    image->irradiance = array_new_unset(render_pixel_count(image), sizeof *image->irradiance);
    if (!image->irradiance) return false;
    parallel_begin_part(r->pool, "irradiance_filter");
    f.radius = render_budget_filter_radius(r);
    parallel_for_all(r->pool, (size_t)image->height, FILTER_ROWS, filter_irradiance_rows, &f);
    return true;
}
