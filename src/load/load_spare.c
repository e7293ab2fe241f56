// SPDX-License-Identifier: Apache-2.0
// What is wrong with a thing without which the image can be made: one that is not used, or, if the
// loader is lenient, a file that is missing or damaged, and an unknown plugin.
#include "load/load_state.h"

bool load_left_out(struct load_state *loader, const struct xml_node *node, const char *instead) {
    if (!loader->lenient || load_plugin_find((struct log){0}, node)) return false;
    log_warning_at(loader->each, node->place, "unknown %s '%s': %s", load_plugin_noun(node->tag),
                   node->type, instead);
    return true;
}

bool load_ref_missing(const struct load_state *loader, const struct xml_node *node) {
    for (struct xml_node *child = node->child; loader->lenient && child; child = child->next)
        if (!load_xml_target(&loader->xml, (struct log){0}, child)) return true;
    return false;
}

static void begin_spared(struct load_state *loader, struct log errors, const char *instead,
                         struct load_spared *spared) {
    spared->used = true;
    spared->log = (struct log_spared){loader->log, errors, instead};
    loader->log = log_spare(&spared->log);
}

void load_spare_unused(struct load_state *loader, struct load_spared *spared) {
    begin_spared(loader, loader->log, "it is not used", spared);
}

void load_spare_file(struct load_state *loader, const struct params *p, const char *instead,
                     struct load_spared *spared) {
    spared->used = false;
    if (loader->lenient && load_params_has(p, "filename") && load_param(p, "filename")->given)
        begin_spared(loader, loader->each, instead, spared);
}

bool load_spare_end(struct load_state *loader, const struct load_spared *spared,
                    satin_status *status) {
    if (!spared->used) return false;
    loader->log = spared->log.others;
    if (*status == SATIN_OK || *status == SATIN_ERROR_MEMORY) return false;
    *status = SATIN_OK;
    return true;
}
