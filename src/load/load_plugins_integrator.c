// SPDX-License-Identifier: Apache-2.0
// <integrator>: hints for the render. `satin` passes its options on by name; `aov` requests
// channels. Of every other integrator the depths and the visibility of emitters are read; `direct`
// has a fixed depth.
#include <string.h>

#include "load/load_state.h"

enum { INTEGRATOR_NESTING_MAX = 8 };

static const struct param_spec max_depth = {
    "max_depth",
    PARAM_INTEGER,
    "-1",
    0,
    0,
    NULL,
    "The length of the longest path, in segments; -1 is no limit."};
static const struct param_spec rr_depth = {"rr_depth",
                                           PARAM_INTEGER,
                                           "5",
                                           RANGE_POSITIVE,
                                           0,
                                           NULL,
                                           "The path depth at which Russian roulette starts."};
static const struct param_spec hide_emitters = {
    "hide_emitters",
    PARAM_BOOLEAN,
    "false",
    0,
    0,
    NULL,
    "If true, emitters that are seen directly are black."};

static const struct param_spec aovs = {"aovs",
                                       PARAM_STRING,
                                       NULL,
                                       0,
                                       PARAM_REQUIRED,
                                       NULL,
                                       "Pairs `name:type`, separated by commas or blanks."};

static const struct param_spec *const path_params[] = {&max_depth, &rr_depth, &hide_emitters, NULL};
static const struct param_spec *const aov_params[] = {&aovs, &hide_emitters, NULL};
static const struct param_spec *const moment_params[] = {&hide_emitters, NULL};

// Integrators of light transport of Mitsuba 3 and 0.6 that are read like `path`.
const char *const load_transport[] = {"direct",
                                      "direct_projective",
                                      "prb",
                                      "prb_basic",
                                      "prbvolpath",
                                      "prb_projective",
                                      "ptracer",
                                      "volpath",
                                      "volpathmis",
                                      "bdpt",
                                      "erpt",
                                      "mlt",
                                      "pssmlt",
                                      "ppm",
                                      "photonmapper",
                                      "sppm",
                                      "volpath_simple",
                                      "irrcache",
                                      "adaptive",
                                      "vpl",
                                      NULL};

const struct plugin_spec load_integrator_plugins[] = {
    {XML_INTEGRATOR, "satin",
     "the integrator of satin, which takes every option of `satin help options` by its name", NULL,
     0, NULL, false},
    {XML_INTEGRATOR, "path",
     "any integrator of light transport: `direct`, `volpath`, `ptracer`, `prb` and others are read "
     "alike. satin chooses its own method within these limits",
     path_params, 1u << XML_INTEGRATOR, NULL, true},
    {XML_INTEGRATOR, "aov",
     "the image of the integrator inside, with additional channels that describe the first surface "
     "that the eye ray meets: `albedo` (channels `name.R .G .B`: the diffuse reflectance), `depth` "
     "(`.T`), `position` (`.X .Y .Z`), `uv` (`.U .V`), `geo_normal` and `sh_normal` (`.X .Y .Z`; "
     "the latter without bump and normal maps), `dp_du`, `dp_dv` (`.X .Y .Z`), `duv_dx`, `duv_dy` "
     "(`.U .V`: the change over a pixel's width divided by the square root of the samples per "
     "pixel), `prim_index`, `shape_index` (`.I`: shapes are numbered from 1 in the order of the "
     "file)",
     aov_params, 1u << XML_INTEGRATOR, NULL, true},
    {XML_INTEGRATOR, "moment",
     "the image of the integrator inside, with additional channels: its light in CIE XYZ (`NAME.X "
     ".Y .Z`, where NAME is the name of the element inside), its channels (with the prefix "
     "`NAME.`), and the second moments of all of these, which are the means of the squares of "
     "their samples (`m2_NAME.X` and so on)",
     moment_params, 1u << XML_INTEGRATOR, NULL, true},
    {0}};

// Reads the options of `satin`, which are checked when they are applied.
static satin_status read_options(struct load_state *loader, const struct xml_node *node) {
    size_t count = 0;
    for (const struct xml_node *child = node->child; child; child = child->next) count++;
    struct scene_hints *hints = &loader->scene->hints;
    struct scene_option *option = arena_array(&loader->scene->arena, count, sizeof *option);
    if (!option) return load_no_memory(loader);
    count = 0;
    for (const struct xml_node *child = node->child; child; child = child->next, count++) {
        if (child->tag < XML_BOOLEAN || child->tag > XML_STRING) {
            log_error_at(loader->log, child->place, "<%s> is not an option of satin",
                         load_xml_tag_name(child->tag));
            return SATIN_ERROR_INPUT;
        }
        struct scene_option *o = &option[count];
        o->name = load_keep_text(loader, child->name);
        o->value = load_keep_text(loader, load_xml_get(child, "value"));
        o->place = child->place;
        o->place.file = load_keep_text(loader, child->place.file);
        if (!o->name || !o->value || !o->place.file) return load_no_memory(loader);
    }
    hints->option = option;
    hints->option_count = count;
    return SATIN_OK;
}

static satin_status read_bounds(struct load_state *loader, struct xml_node *node, int depth);

// If node is a `moment`, adds the channels for the integrator `inner` in it, whose own channels
// begin at `first`.
static satin_status read_moment(struct load_state *loader, const struct xml_node *node,
                                const struct xml_node *inner, int first, satin_status status) {
    if (status != SATIN_OK || strcmp(node->type, "moment") != 0) return status;
    return load_aovs_moment(loader, inner, first, &loader->scene->hints.aovs);
}

// Reads the integrator inside of another one, such as `aov`, if there is one.
static satin_status read_inner(struct load_state *loader, struct xml_node *node, int depth) {
    const int first = loader->scene->hints.aovs.count;
    struct xml_node *at = NULL, *inner = load_params_child(&loader->xml, node, XML_INTEGRATOR, &at);
    // An unknown one, such as `multichannel`, may have some that are not read.
    const bool unknown = !load_plugin_known(node);
    while (unknown && inner && load_plugin_unread(inner)) {
        log_warning_at(loader->log, at->place, "integrator '%s' has no effect here", inner->type);
        inner = load_params_child(&loader->xml, node, XML_INTEGRATOR, &at);
    }
    if (!inner) return SATIN_OK;
    struct xml_node *another = at;
    if (depth == INTEGRATOR_NESTING_MAX)
        log_error_at(loader->log, at->place, "integrators are nested too deep");
    else if (!unknown && load_params_child(&loader->xml, node, XML_INTEGRATOR, &another))
        log_error_at(loader->log, another->place, "integrator '%s': it takes one integrator",
                     node->type);
    else if (strcmp(inner->type, "satin") == 0)
        return read_moment(loader, node, at, first, read_options(loader, inner));
    else
        return read_moment(loader, node, at, first, read_bounds(loader, inner, depth + 1));
    return SATIN_ERROR_INPUT;
}

// Reads depths and visibility. Values of an integrator inside take precedence.
static satin_status read_bounds(struct load_state *loader, struct xml_node *node, int depth) {
    struct params p;
    satin_status status = load_params(loader, node, &p);
    if (status == SATIN_OK) status = read_inner(loader, node, depth);
    if (status != SATIN_OK) return status;
    struct scene_hints *hints = &loader->scene->hints;
    if (load_param(&p, "hide_emitters")->given)
        hints->hide_emitters = load_param(&p, "hide_emitters")->b;
    if (strcmp(node->type, "moment") == 0) return SATIN_OK;
    if (strcmp(node->type, "aov") == 0)
        return load_aovs(loader, load_param(&p, "aovs"), &hints->aovs);
    const struct param_value *longest = load_param(&p, "max_depth");
    if (longest->i < -1) {
        log_error_at(loader->log, longest->place, "max_depth is %d, but must be -1 or more",
                     longest->i);
        return SATIN_ERROR_INPUT;
    }
    if (strcmp(node->type, "direct") == 0) hints->max_depth = 2;
    if (longest->given) hints->max_depth = longest->i;
    if (load_param(&p, "rr_depth")->given) hints->rr_depth = load_param(&p, "rr_depth")->i;
    return SATIN_OK;
}

satin_status load_integrator(struct load_state *loader, struct xml_node *node) {
    struct scene_hints *hints = &loader->scene->hints;
    if (hints->integrator) {
        log_error_at(loader->log, node->place, "the scene has another integrator");
        return SATIN_ERROR_INPUT;
    }
    if (!(hints->integrator = load_keep_text(loader, node->type))) return load_no_memory(loader);
    return strcmp(node->type, "satin") == 0 ? read_options(loader, node)
                                            : read_bounds(loader, node, 0);
}
