// SPDX-License-Identifier: Apache-2.0
// Environments: a constant radiance, or a latitude-longitude image with bilinear lookup. Texels are
// where Mitsuba 3.9 has them (measured): the direction (sin phi sin theta, cos theta, -cos phi sin
// theta) in light space is at x = width phi / 2 pi - 1/2, wrapped, and y = (height - 1) theta / pi.
// Directions are drawn in proportion to the interpolated luminance times sin theta: first a cell
// between four texels by its mean, then a point of the cell by bilinear interpolation. A sun is a
// disc of light on top of the image, which gets a fraction of the samples.
#include "base/sampling.h"
#include "light/light_kinds.h"

// A point between four texels: column and row of the first one, and the weights of the next column
// and row.
struct texel_lookup {
    int column, row;
    float fx, fy;
    float sin_theta;
};

static int cell_rows(const struct image *image) {
    return image->height > 1 ? image->height - 1 : 1;
}

static rgb texel(const struct image *image, int column, int row) {
    if (column >= image->width) column -= image->width;
    if (row >= image->height) row = image->height - 1;
    const float *t = image->texel + ((size_t)row * (size_t)image->width + (size_t)column) *
                                        (size_t)image->channels;
    return image->channels == 3 ? rgb_make(t[0], t[1], t[2]) : rgb_grey(t[0]);
}

static struct texel_lookup texel_lookup_at(const struct light *light, vec3 w) {
    const struct image *image = light->image;
    vec3 l = v3_unit(mat4_vector(&light->to_local, w));
    float s = sqrtf(l.x * l.x + l.z * l.z);
    float x = atan2f(l.x, -l.z) * (0.5f / PI_F) * (float)image->width - 0.5f;
    float y = atan2f(s, l.y) * (1.0f / PI_F) * (float)cell_rows(image);
    float column = floorf(x), row = clampf(floorf(y), 0.0f, (float)(cell_rows(image) - 1));
    int c = (int)column;
    if (c < 0) c += image->width;
    return (struct texel_lookup){c, (int)row, x - column, clampf(y - row, 0.0f, 1.0f), s};
}

// The four texels around a point.
struct texels {
    rgb c00, c10, c01, c11;
};

static struct texels texels_of(const struct light *light, int column, int row) {
    const struct image *image = light->image;
    if (light->lit_rows > 0 && row >= light->lit_rows) return (struct texels){0};
    return (struct texels){texel(image, column, row), texel(image, column + 1, row),
                           texel(image, column, row + 1), texel(image, column + 1, row + 1)};
}

static rgb interpolate(const struct light *light, const struct texels *t, float fx, float fy) {
    rgb c = rgb_scale(t->c00, (1.0f - fx) * (1.0f - fy));
    c = rgb_mad(c, t->c10, fx * (1.0f - fy));
    c = rgb_mad(c, t->c01, (1.0f - fx) * fy);
    c = rgb_mad(c, t->c11, fx * fy);
    return rgb_mul(c, light->value);
}

// The factor of a row of texels in the density. The poles have an eighth of their neighbours' sine
// instead of 0, so that the light of an image of two rows has a density too.
static float row_weight(const struct image *image, int row) {
    float step = PI_F / (float)cell_rows(image);
    return fmaxf(sinf(step * (float)row), sinf(0.125f * step));
}

struct cell {
    float w00, w10, w01, w11;  // sampling weights of the four texels
};

static struct cell cell_of(const struct light *light, const struct texels *t, int row) {
    const float low = light->row_weight[row], high = light->row_weight[row + 1];
    return (struct cell){
        maxf(rgb_luminance(t->c00), 0.0f) * low, maxf(rgb_luminance(t->c10), 0.0f) * low,
        maxf(rgb_luminance(t->c01), 0.0f) * high, maxf(rgb_luminance(t->c11), 0.0f) * high};
}

static float cell_mean(const struct cell *c) { return 0.25f * (c->w00 + c->w10 + c->w01 + c->w11); }

// Draws x in [0, 1] with a density that is linear from a to b.
static float sample_linear(float u, float a, float b) {
    float root = a + sqrtf(lerpf(a * a, b * b, u));
    return root > 0.0f ? fminf(u * (a + b) / root, 1.0f) : u;
}

// The density of drawing the point by the cdfs, which are of the means of the cells. Computed from
// the texels, it does not wait for the cdfs in memory, and rounding of these does not matter.
static float texel_pdf(const struct light *light, const struct texel_lookup *at,
                       const struct cell *c) {
    if (!(at->sin_theta > 0.0f) || !(light->cell_mean > 0.0f)) return 0.0f;
    const float low = lerpf(c->w00, c->w10, at->fx), high = lerpf(c->w01, c->w11, at->fx);
    return lerpf(low, high, at->fy) / light->cell_mean / (2.0f * PI_F * PI_F * at->sin_theta);
}

struct sky_angle {
    float sine, cosine;
};

static struct sky_angle sky_angle_of(float x) { return (struct sky_angle){sinf(x), cosf(x)}; }

static vec3 sky_direction(const struct light *light, struct sky_angle phi, struct sky_angle theta) {
    const float s = theta.sine;
    return v3_unit(mat4_vector(&light->to_world, v3(s * phi.sine, theta.cosine, -s * phi.cosine)));
}

static vec3 direction_at(const struct light *light, float x, float y) {
    return sky_direction(light, sky_angle_of(2.0f * PI_F * x), sky_angle_of(PI_F * y));
}

// ---- The sun ------------------------------------------------------------------------------------

static bool in_sun(const struct light *light, vec3 w) {
    return light->sun_fraction > 0.0f && v3_dist2(w, light->sun) <= sqrf(light->sun_chord);
}

static float sun_solid_angle(const struct light *light) { return PI_F * sqrf(light->sun_chord); }

// Limits of the fraction of samples for the sun, so that neither sun nor sky gets too few.
#define SUN_FRACTION_MIN 0.2f
#define SUN_FRACTION_MAX 0.7f

static void add_sun(const struct satin_scene *scene, struct light *light) {
    float facing = rgb_luminance(light->sun_value) * sun_solid_angle(light);
    if (!(facing > 0.0f)) return;
    float power = facing * light_bounds_projected_area(scene, light->sun);
    light->sun_fraction =
        clampf(power / (power + light->power), SUN_FRACTION_MIN, SUN_FRACTION_MAX);
    light->strength += 0.25f * facing;
    light->power += power;
    if (rgb_black(light->value)) light->sun_fraction = 1.0f;
}

static vec3 sun_direction(const struct light *light, float u, float v) {
    float versine = 0.5f * u * sqrf(light->sun_chord), phi = 2.0f * PI_F * v;
    float s = safe_sqrtf(versine * (2.0f - versine));
    struct frame f = frame_from_normal(light->sun);
    return frame_to_world(&f, v3(s * cosf(phi), s * sinf(phi), 1.0f - versine));
}

// ---- The light ----------------------------------------------------------------------------------

// A power of two such that a range between two cuts has about eight items.
static size_t cuts_of(size_t items) {
    size_t cuts = 1;
    while (cuts * 16 <= items) cuts *= 2;
    return cuts;
}

static satin_status prepare_image(struct satin_scene *scene, struct light *light) {
    const struct image *image = light->image;
    size_t rows = (size_t)cell_rows(image), columns = (size_t)image->width;
    float *row_cdf = arena_array(&scene->arena, rows + 1, sizeof *row_cdf);
    float *row_sum = arena_array(&scene->arena, rows, sizeof *row_sum);
    float *line = arena_array(&scene->arena, columns, sizeof *line);
    float *weight = arena_array(&scene->arena, rows + 1, sizeof *weight);
    float *column_cdf = arena_array(&scene->arena, rows * (columns + 1), sizeof *column_cdf);
    const size_t row_cuts = cuts_of(rows), column_cuts = cuts_of(columns);
    uint32_t *row_cut = arena_array(&scene->arena, row_cuts + 1, sizeof *row_cut);
    uint32_t *column_cut = arena_array(&scene->arena, rows * (column_cuts + 1), sizeof *column_cut);
    struct sky_angle *phi = arena_array(&scene->arena, columns, sizeof *phi);
    if (!row_cdf || !row_sum || !line || !weight || !column_cdf || !row_cut || !column_cut || !phi)
        return SATIN_ERROR_MEMORY;
    for (size_t c = 0; c < columns; c++)
        phi[c] = sky_angle_of(2.0f * PI_F * (((float)c + 1.0f) / (float)columns));
    for (size_t r = 0; r <= rows; r++) weight[r] = row_weight(image, (int)r);
    light->row_weight = weight;
    double cell_area = 2.0 * M_PI * M_PI / (double)(rows * columns), flux = 0.0, power = 0.0;
    for (size_t r = 0; r < rows; r++) {
        const struct sky_angle theta = sky_angle_of(PI_F * (((float)r + 0.5f) / (float)rows));
        for (size_t c = 0; c < columns; c++) {
            const struct texels t = texels_of(light, (int)c, (int)r);
            const struct cell cell = cell_of(light, &t, (int)r);
            line[c] = cell_mean(&cell);
            const vec3 d = sky_direction(light, phi[c], theta);
            flux += line[c] * cell_area;
            power += line[c] * cell_area * light_bounds_projected_area(scene, d);
        }
        float *cdf = column_cdf + r * (columns + 1);
        row_sum[r] = (float)sample_cdf_build(line, columns, cdf);
        sample_cuts_build(cdf, columns, column_cuts, column_cut + r * (column_cuts + 1));
    }
    const double all = sample_cdf_build(row_sum, rows, row_cdf);
    light->cell_mean = (float)(all / (double)(rows * columns));
    sample_cuts_build(row_cdf, rows, row_cuts, row_cut);
    light->row_cut = row_cut;
    light->column_cut = column_cut;
    light->row_cuts = (uint32_t)row_cuts;
    light->column_cuts = (uint32_t)column_cuts;
    light->row_cdf = row_cdf;
    light->column_cdf = column_cdf;
    float scale = rgb_luminance(light->value);
    light->strength = 0.25f * scale * (float)flux;  // mean irradiance over all orientations
    light->power = scale * (float)power;
    add_sun(scene, light);
    return SATIN_OK;
}

satin_status light_environment_prepare(struct satin_scene *scene, struct light *light) {
    if (light->kind == LIGHT_ENVMAP) return prepare_image(scene, light);
    light->strength = PI_F * rgb_luminance(light->value);
    light->power = light->strength * light_bounds_area(scene);
    return SATIN_OK;
}

// The density of drawing a direction, in the sun or not, given its densities by radiance and by the
// bins of the product.
static float mixed_pdf(const struct light *light, const struct light_product *product, bool sun,
                       float by_radiance, float by_bins) {
    float pdf_w = product ? lerpf(by_radiance, by_bins, product->fraction) : by_radiance;
    pdf_w *= 1.0f - light->sun_fraction;
    return sun ? pdf_w + light->sun_fraction / sun_solid_angle(light) : pdf_w;
}

static float bins_pdf(const struct light_product *product, vec3 wi) {
    return product && product->fraction > 0.0f ? light_product_pdf(product, wi) : 0.0f;
}

// The density of drawing a direction by radiance. *L, if not NULL, is set to the radiance there.
static float radiance_pdf(const struct light *light, vec3 wi, rgb *L) {
    if (light->kind == LIGHT_CONSTANT) {
        if (L) *L = light->value;
        return 0.25f / PI_F;
    }
    const struct texel_lookup at = texel_lookup_at(light, wi);
    const struct texels t = texels_of(light, at.column, at.row);
    const struct cell cell = cell_of(light, &t, at.row);
    if (L) *L = interpolate(light, &t, at.fx, at.fy);
    return texel_pdf(light, &at, &cell);
}

// Whether u < probability. In both cases u is then rescaled to [0, 1).
static bool choose_with(float probability, float *u) {
    const bool yes = *u < probability;
    *u = yes ? *u / probability : sample_rest(*u, probability);
    return yes;
}

// The environment's radiance without its sun.
static rgb sky_radiance(const struct light *light, vec3 w) {
    if (light->kind == LIGHT_CONSTANT) return light->value;
    const struct texel_lookup at = texel_lookup_at(light, w);
    const struct texels t = texels_of(light, at.column, at.row);
    return interpolate(light, &t, at.fx, at.fy);
}

// Draws a direction by radiance; sets its density and radiance.
static vec3 sample_radiance(const struct light *light, float u, float v, float *pdf_w, rgb *L) {
    if (light->kind == LIGHT_CONSTANT) {
        *pdf_w = 0.25f / PI_F;
        *L = light->value;
        return sample_uniform_sphere(u, v);
    }
    const struct image *image = light->image;
    int row = (int)sample_cdf_cut(light->row_cdf, light->row_cut, light->row_cuts, v, &v);
    const float *columns = light->column_cdf + (size_t)row * (size_t)(image->width + 1);
    const uint32_t *cut = light->column_cut + (size_t)row * (light->column_cuts + 1);
    int column = (int)sample_cdf_cut(columns, cut, light->column_cuts, u, &u);
    const struct texels t = texels_of(light, column, row);
    const struct cell c = cell_of(light, &t, row);
    struct texel_lookup at = {.column = column, .row = row};
    at.fy = sample_linear(v, c.w00 + c.w10, c.w01 + c.w11);
    at.fx = sample_linear(u, lerpf(c.w00, c.w01, at.fy), lerpf(c.w10, c.w11, at.fy));
    float y = ((float)row + at.fy) / (float)cell_rows(image);
    at.sin_theta = sinf(PI_F * y);
    *pdf_w = texel_pdf(light, &at, &c);
    *L = interpolate(light, &t, at.fx, at.fy);
    return direction_at(light, ((float)column + at.fx + 0.5f) / (float)image->width, y);
}

// Near texels that are almost black the interpolated density can be too small to divide by. Below
// this such a sample is dropped; its contribution is as small.
#define PDF_LEAST 1e-18f

// Sets L and the density of a sample, whose pdf_w is that by the bins, given the radiance without
// the sun and the density by it. False if the sample contributes nothing.
static bool set_radiance(const struct light *light, const struct light_product *product,
                         float by_radiance, rgb L, struct light_sample *s) {
    s->L = s->in_sun ? rgb_add(L, light->sun_value) : L;
    s->pdf_w = mixed_pdf(light, product, s->in_sun, by_radiance, s->pdf_w);
    return s->pdf_w > PDF_LEAST && !rgb_black(s->L);
}

bool light_environment_draw(const struct satin_scene *scene, const struct light_product *product,
                            float u, float v, struct light_sample *out) {
    const struct light *light = &scene->light[scene->environment];
    const bool to_sun = light->sun_fraction > 0.0f && choose_with(light->sun_fraction, &u);
    const bool to_bins = !to_sun && product && choose_with(product->fraction, &u);
    float by_radiance = 0.0f, by_bins = 0.0f;
    *out =
        (struct light_sample){.dist = INFINITY, .L = rgb_grey(1.0f), .unread = to_sun || to_bins};
    if (to_sun)
        out->wi = sun_direction(light, u, v);
    else if (to_bins)
        out->wi = light_product_sample(product, u, v, &by_bins);
    else
        out->wi = sample_radiance(light, u, v, &by_radiance, &out->L);
    if (!to_bins) by_bins = bins_pdf(product, out->wi);
    // At the edge of the sun, rounding may move the direction outside.
    out->in_sun = to_sun || in_sun(light, out->wi);
    out->pdf_w = by_bins;
    return out->unread || set_radiance(light, product, by_radiance, out->L, out);
}

bool light_environment_read(const struct satin_scene *scene, const struct light_product *product,
                            struct light_sample *s) {
    const struct light *light = &scene->light[scene->environment];
    const rgb T = s->L;
    rgb L;
    const float by_radiance = radiance_pdf(light, s->wi, &L);
    if (!set_radiance(light, product, by_radiance, L, s)) return false;
    s->L = rgb_mul(s->L, T);
    return true;
}

float light_environment_pdf(const struct satin_scene *scene, const struct light_product *product,
                            vec3 wi) {
    const struct light *light = &scene->light[scene->environment];
    return mixed_pdf(light, product, in_sun(light, wi), radiance_pdf(light, wi, NULL),
                     bins_pdf(product, wi));
}

rgb light_environment(const struct satin_scene *scene, vec3 w) {
    if (scene->environment < 0) return rgb_grey(0.0f);
    const struct light *light = &scene->light[scene->environment];
    rgb L = sky_radiance(light, w);
    return in_sun(light, w) ? rgb_add(L, light->sun_value) : L;
}
