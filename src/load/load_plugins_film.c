// SPDX-License-Identifier: Apache-2.0
// <film>, <rfilter> and <sampler>: the size of the image, its filter, the samples per pixel. Names
// and defaults are Mitsuba 3's.
#include "base/text.h"
#include "load/load_state.h"

// Limits of the film: its width and height, so that products are far from overflow, and its pixels.
enum { FILM_SIDE_MAX = 1 << 20, SCENE_PIXELS_MAX = 1 << 28 };

static const struct param_spec width = {"width",
                                        PARAM_INTEGER,
                                        "768",
                                        RANGE_POSITIVE,
                                        0,
                                        NULL,
                                        "The width of the whole film, in pixels."};
static const struct param_spec height = {"height",
                                         PARAM_INTEGER,
                                         "576",
                                         RANGE_POSITIVE,
                                         0,
                                         NULL,
                                         "The height of the whole film, in pixels."};
static const struct param_spec crop_offset_x = {"crop_offset_x",
                                                PARAM_INTEGER,
                                                "0",
                                                RANGE_NOT_NEGATIVE,
                                                0,
                                                NULL,
                                                "The first column that is rendered."};
static const struct param_spec crop_offset_y = {"crop_offset_y",
                                                PARAM_INTEGER,
                                                "0",
                                                RANGE_NOT_NEGATIVE,
                                                0,
                                                NULL,
                                                "The first row that is rendered."};
static const struct param_spec crop_width = {
    "crop_width",
    PARAM_INTEGER,
    NULL,
    RANGE_POSITIVE,
    0,
    NULL,
    "The width of what is rendered, in pixels. If it is not given, it is the whole width."};
static const struct param_spec crop_height = {
    "crop_height",
    PARAM_INTEGER,
    NULL,
    RANGE_POSITIVE,
    0,
    NULL,
    "The height of what is rendered, in pixels. If it is not given, it is the whole height."};
static const struct param_spec file_format = {
    "file_format",
    PARAM_STRING,
    "openexr",
    0,
    0,
    NULL,
    "It has no effect: the name of the output file chooses the format."};
static const struct param_spec pixel_format = {
    "pixel_format",
    PARAM_STRING,
    "rgb",
    0,
    0,
    NULL,
    "A format with alpha, such as rgba, adds a channel of coverage. Images are RGB in any case."};
static const struct param_spec component_format = {"component_format",
                                                   PARAM_STRING,
                                                   "float16",
                                                   0,
                                                   0,
                                                   NULL,
                                                   "With float32, all channels of an OpenEXR file "
                                                   "have 32 bits."};
static const struct param_spec sample_border = {
    "sample_border",
    PARAM_BOOLEAN,
    "false",
    0,
    0,
    NULL,
    "It has no effect: filters end at the image's border."};
static const struct param_spec compensate = {
    "compensate",
    PARAM_BOOLEAN,
    "false",
    0,
    0,
    NULL,
    "It has no effect: sums are accurate enough without it."};

static const struct param_spec tent_radius = {
    "radius", PARAM_FLOAT, "1", RANGE_POSITIVE, 0, NULL, "The radius, in pixels."};
static const struct param_spec stddev = {
    "stddev", PARAM_FLOAT, ".5", RANGE_POSITIVE, 0, NULL, "The standard deviation, in pixels."};

static const struct param_spec cubic_b = {
    "B",
    PARAM_FLOAT,
    "0.3333333",
    RANGE_UNIT,
    0,
    NULL,
    "The parameter B of Mitchell and Netravali: more is blurrier."};
static const struct param_spec cubic_c = {
    "C",
    PARAM_FLOAT,
    "0.3333333",
    RANGE_UNIT,
    0,
    NULL,
    "The parameter C of Mitchell and Netravali: more rings more."};
static const struct param_spec lanczos_lobes = {
    "lobes", PARAM_FLOAT, "3", RANGE_POSITIVE, 0, NULL, "The radius, in pixels."};

static const struct param_spec sample_count = {"sample_count",
                                               PARAM_INTEGER,
                                               "4",
                                               RANGE_POSITIVE,
                                               0,
                                               NULL,
                                               "The number of samples per pixel."};
static const struct param_spec seed = {
    "seed", PARAM_INTEGER, "0", 0, 0, NULL, "It has no effect: see the option `seed`."};
static const struct param_spec jitter = {
    "jitter", PARAM_BOOLEAN, "true", 0, 0, NULL, "It has no effect: Mitsuba uses it for sampling."};
static const struct param_spec strength = {
    "strength", PARAM_INTEGER, "2", 0, 0, NULL, "It has no effect: Mitsuba uses it for sampling."};

typedef const struct param_spec *const param_list[];
static param_list film_params = {
    &width,       &height,       &crop_offset_x,    &crop_offset_y, &crop_width, &crop_height,
    &file_format, &pixel_format, &component_format, &sample_border, &compensate, NULL};
static param_list tent_params = {&tent_radius, NULL};
static param_list gaussian_params = {&stddev, NULL};
static param_list mitchell_params = {&cubic_b, &cubic_c, NULL};
static param_list lanczos_params = {&lanczos_lobes, NULL};
static param_list random_params = {&sample_count, &seed, NULL};
static param_list jitter_params = {&sample_count, &seed, &jitter, NULL};
static param_list orthogonal_params = {&sample_count, &seed, &jitter, &strength, NULL};

// Checks a width, height or offset of the film or its crop window.
static satin_status check_side(struct load_state *loader, const struct params *p,
                               const char *name) {
    const struct param_value *value = load_param(p, name);
    if (value->i <= FILM_SIDE_MAX) return SATIN_OK;
    log_error_at(loader->log, value->place, "%s is %d, but at most %d pixels are supported", name,
                 value->i, FILM_SIDE_MAX);
    return SATIN_ERROR_INPUT;
}

// Reads the formats of pixels and of their components, in any case of letters, as in Mitsuba.
static void read_formats(struct load_state *loader, const struct params *p,
                         struct scene_film *film) {
    static const char *const plain[] = {"luminance", "rgb", "xyz", "multichannel", NULL};
    static const char *const alpha[] = {"luminance_alpha", "luminancealpha", "rgba", "xyza", NULL};
    static const char *const component[] = {"float16", "float32", "uint32", NULL};
    const struct param_value *pixel = load_param(p, "pixel_format"),
                             *size = load_param(p, "component_format");
    film->alpha = text_is_one_of(pixel->s, alpha);
    film->full_float = text_same_name(size->s, "float32");
    if (!film->alpha && !text_is_one_of(pixel->s, plain))
        log_warning_at(loader->log, pixel->place, "the pixel_format '%.40s' is unknown: it is rgb",
                       pixel->s);
    if (!text_is_one_of(size->s, component))
        log_warning_at(loader->log, size->place,
                       "the component_format '%.40s' is unknown: it is float16", size->s);
}

static satin_status build_film(struct load_state *loader, const struct params *p, void *object) {
    struct scene_film *film = object;
    const char *const sides[] = {"width",         "height",     "crop_offset_x",
                                 "crop_offset_y", "crop_width", "crop_height"};
    for (int i = 0; i < 6; i++) {
        satin_status status = check_side(loader, p, sides[i]);
        if (status != SATIN_OK) return status;
    }
    film->width = load_param(p, "width")->i;
    film->height = load_param(p, "height")->i;
    film->crop_x = load_param(p, "crop_offset_x")->i;
    film->crop_y = load_param(p, "crop_offset_y")->i;
    const struct param_value *w = load_param(p, "crop_width"), *h = load_param(p, "crop_height");
    film->crop_width = w->given ? w->i : film->width;
    film->crop_height = h->given ? h->i : film->height;
    if (film->crop_x + film->crop_width > film->width ||
        film->crop_y + film->crop_height > film->height)
        return load_refuse(loader, p, "its crop window is not inside of it");
    if ((int64_t)film->crop_width * film->crop_height > SCENE_PIXELS_MAX) {
        log_error_at(loader->log, p->node->place,
                     "film '%s': it has %d x %d pixels, but at most %d are supported",
                     load_xml_get(p->node, "type"), film->crop_width, film->crop_height,
                     SCENE_PIXELS_MAX);
        return SATIN_ERROR_INPUT;
    }
    read_formats(loader, p, film);
    return SATIN_OK;
}

static satin_status build_box(struct load_state *loader, const struct params *p, void *object) {
    (void)loader, (void)p;
    struct scene_film *film = object;
    film->filter = FILTER_BOX;
    film->radius = 0.5f;
    return SATIN_OK;
}

// Larger filters would cover the whole image.
#define FILTER_RADIUS_MAX 100.0f

static satin_status check_radius(struct load_state *loader, const struct params *p,
                                 const struct scene_film *film) {
    if (film->radius >= 1e-3f && film->radius <= FILTER_RADIUS_MAX) return SATIN_OK;
    return load_refuse(loader, p, "it is too narrow or too wide");
}

static satin_status build_tent(struct load_state *loader, const struct params *p, void *object) {
    struct scene_film *film = object;
    film->filter = FILTER_TENT;
    film->radius = load_param(p, "radius")->f;
    return check_radius(loader, p, film);
}

static satin_status build_gaussian(struct load_state *loader, const struct params *p,
                                   void *object) {
    struct scene_film *film = object;
    film->filter = FILTER_GAUSSIAN;
    film->stddev = load_param(p, "stddev")->f;
    film->radius = 4.0f * film->stddev;
    return check_radius(loader, p, film);
}

static satin_status build_cubic(struct scene_film *film, float b, float c) {
    film->filter = FILTER_CUBIC;
    film->radius = 2.0f;
    film->b = b;
    film->c = c;
    return SATIN_OK;
}

static satin_status build_mitchell(struct load_state *loader, const struct params *p,
                                   void *object) {
    (void)loader;
    return build_cubic(object, load_param(p, "B")->f, load_param(p, "C")->f);
}

static satin_status build_catmullrom(struct load_state *loader, const struct params *p,
                                     void *object) {
    (void)loader, (void)p;
    return build_cubic(object, 0.0f, 0.5f);
}

static satin_status build_lanczos(struct load_state *loader, const struct params *p, void *object) {
    struct scene_film *film = object;
    film->filter = FILTER_LANCZOS;
    film->radius = load_param(p, "lobes")->f;
    if (film->radius >= 1.0f && film->radius <= FILTER_RADIUS_MAX) return SATIN_OK;
    return load_refuse(loader, p, "it has less than one lobe, or over 100");
}

static satin_status build_sampler(struct load_state *loader, const struct params *p, void *object) {
    (void)object;
    if (load_param(p, "sample_count")->given)
        loader->scene->hints.spp = load_param(p, "sample_count")->i;
    return SATIN_OK;
}

const struct plugin_spec load_film_plugins[] = {
    {XML_FILM, "hdrfilm", "the size and the crop of the image", film_params, 1u << XML_RFILTER,
     build_film, false},
    {XML_RFILTER, "box", "a box filter of one pixel", NULL, 0, build_box, false},
    {XML_RFILTER, "tent", "a filter that falls linearly to zero", tent_params, 0, build_tent,
     false},
    {XML_RFILTER, "gaussian", "a Gaussian, cut off at four standard deviations", gaussian_params, 0,
     build_gaussian, false},
    {XML_RFILTER, "mitchell", "a cubic filter with negative lobes, which is sharper and noisier",
     mitchell_params, 0, build_mitchell, false},
    {XML_RFILTER, "catmullrom", "a cubic filter that is sharper than `mitchell`", NULL, 0,
     build_catmullrom, false},
    {XML_RFILTER, "lanczos", "a windowed sinc, which may ring", lanczos_params, 0, build_lanczos,
     false},
    {XML_SAMPLER, "independent", "The number of samples per pixel.", random_params, 0,
     build_sampler, false},
    {XML_SAMPLER, "stratified", "The number of samples per pixel.", jitter_params, 0, build_sampler,
     false},
    {XML_SAMPLER, "multijitter", "The number of samples per pixel.", jitter_params, 0,
     build_sampler, false},
    {XML_SAMPLER, "orthogonal", "The number of samples per pixel.", orthogonal_params, 0,
     build_sampler, false},
    {XML_SAMPLER, "ldsampler", "The number of samples per pixel.", random_params, 0, build_sampler,
     false},
    {0}};
