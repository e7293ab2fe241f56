// SPDX-License-Identifier: Apache-2.0
// The ids of a scene file, which are collected while it is read, then sorted, checked and looked
// up.
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "base/text.h"
#include "load/load_xml.h"

satin_status load_ids_add(struct load_xml *xml, struct xml_id id) {
    void *items = xml->id;
    if (!array_reserve(&items, &xml->id_capacity, xml->id_count + 1, sizeof id))
        return SATIN_ERROR_MEMORY;
    xml->id = items;
    xml->id[xml->id_count++] = id;
    return SATIN_OK;
}

static int by_id_then_order(const void *a, const void *b) {
    const struct xml_id *x = a, *y = b;
    int order = strcmp(x->id, y->id);
    if (order) return order;
    return (x->number > y->number) - (x->number < y->number);
}

static struct xml_id *find_id(const struct load_xml *xml, const char *id) {
    size_t lo = 0, hi = xml->id_count;
    while (lo < hi) {
        size_t mid = lo + (hi - lo) / 2;
        if (strcmp(xml->id[mid].id, id) < 0)
            lo = mid + 1;
        else
            hi = mid;
    }
    return lo < xml->id_count && strcmp(xml->id[lo].id, id) == 0 ? &xml->id[lo] : NULL;
}

enum { ALIAS_STEPS_MAX = 16 };

// Follows an alias to its object. An alias refers to an earlier id, so there are no cycles.
static struct xml_node *resolve_alias(const struct load_xml *xml, struct log log,
                                      struct xml_id *alias) {
    struct xml_id *step = alias;
    for (int steps = 0; !step->node; steps++) {
        struct xml_id *source = find_id(xml, step->source);
        if (!source || source->number >= step->number || steps == ALIAS_STEPS_MAX) {
            log_error_at(log, step->place, "alias of '%s', which is not defined before it",
                         step->source);
            return NULL;
        }
        step = source;
    }
    return alias->node = step->node;
}

// Logs an id that another one of the table repeats. `spared`: as a warning, since the first counts.
static void report_duplicate(struct log log, const struct xml_id *first, const struct xml_id *id,
                             bool spared) {
    const struct log_place at = first->place;
    if (spared)
        log_warning_at(log, id->place, "duplicate id '%s': the one at %s:%d:%d counts", id->id,
                       at.file, at.line, at.column);
    else
        log_error_at(log, id->place, "duplicate id '%s' (first at %s:%d:%d)", id->id, at.file,
                     at.line, at.column);
}

satin_status load_ids_resolve(struct load_xml *xml, struct log log, bool lenient) {
    if (xml->id_count > 1) qsort(xml->id, xml->id_count, sizeof *xml->id, by_id_then_order);
    size_t kept = xml->id_count ? 1 : 0;
    for (size_t i = 1; i < xml->id_count; i++) {
        const struct xml_id *first = &xml->id[kept - 1], *id = &xml->id[i];
        if (strcmp(first->id, id->id) != 0) {
            xml->id[kept++] = *id;
            continue;
        }
        report_duplicate(log, first, id, lenient);
        if (!lenient) return SATIN_ERROR_INPUT;
    }
    xml->id_count = kept;
    for (size_t i = 0; i < xml->id_count; i++)
        if (!resolve_alias(xml, log, &xml->id[i]) && !lenient) return SATIN_ERROR_INPUT;
    size_t known = 0;
    for (size_t i = 0; i < xml->id_count; i++)
        if (xml->id[i].node) xml->id[known++] = xml->id[i];
    xml->id_count = known;
    return SATIN_OK;
}

struct xml_node *load_xml_find(const struct load_xml *xml, const char *id) {
    const struct xml_id *entry = find_id(xml, id);
    return entry ? entry->node : NULL;
}

struct xml_node *load_xml_target(const struct load_xml *xml, struct log log,
                                 struct xml_node *node) {
    if (node->tag != XML_REF) return node;
    struct xml_node *target = load_xml_find(xml, node->id);
    if (target) return target;
    struct text_nearest nearest = {.word = node->id};
    for (size_t i = 0; i < xml->id_count; i++) text_nearest_try(&nearest, xml->id[i].id);
    if (nearest.best)
        log_error_at(log, node->place, "reference to unknown id '%s' (did you mean '%s'?)",
                     node->id, nearest.best);
    else
        log_error_at(log, node->place, "reference to unknown id '%s'", node->id);
    return NULL;
}
