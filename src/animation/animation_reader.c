// SPDX-License-Identifier: Apache-2.0
// Values of the files of animations.
#include "animation/animation_reader.h"

#include <math.h>

#include "base/text.h"

enum { NUMBER_MAX = 999999 };  // of a frame
// Coordinates beyond this are not passed to the ray tracer either.
static const double COORDINATE_MAX = 1e18;
// The largest angle in degrees or factor: its products with coordinates and lights are in the range
// of float.
static const double VALUE_MAX = 1e9;

bool animation_no_memory(struct toml_reader *r) {
    r->status = log_fail(r->log, SATIN_ERROR_MEMORY, "not enough memory for the camera path");
    return false;
}

bool animation_check_keys(struct toml_reader *r, const struct toml_node *table,
                          const char *const *known) {
    const char *meant;
    const struct toml_node *unknown = toml_find_unknown(table, known, &meant);
    return !unknown || toml_unknown_key(r, unknown, meant);
}

bool animation_take_frame(struct toml_reader *r, const struct toml_node *node, double *out) {
    if (node->kind != TOML_NUMBER || isnan(node->number))
        return toml_wrong(r, node, "it must be a number");
    if (!(node->number >= 0.0 && node->number <= NUMBER_MAX) || node->number != floor(node->number))
        return toml_wrong(r, node, "%s is not a whole number in 0..%d", node->text, NUMBER_MAX);
    *out = node->number;
    return true;
}

bool animation_take_vector(struct toml_reader *r, const struct toml_node *table, const char *key,
                           const double *otherwise, double out[3]) {
    const struct toml_node *node = toml_find(table, key);
    if (!node && !otherwise) return toml_wrong(r, table, "it needs the key '%s'", key);
    for (int k = 0; k < 3 && !node; k++) out[k] = otherwise[k];
    if (!node) return true;
    if (node->kind != TOML_ARRAY || node->count != 3)
        return toml_wrong(r, node, "it must be three numbers, as in [0, 1, 0]");
    for (size_t k = 0; k < 3; k++) {
        const struct toml_node *number = &node->child[k];
        if (number->kind != TOML_NUMBER || isnan(number->number))
            return toml_wrong(r, number, "it must be a number");
        if (!(fabs(number->number) <= COORDINATE_MAX))
            return toml_wrong(r, number, "%s is too large", number->text);
        out[k] = number->number;
    }
    return true;
}

bool animation_take_value(struct toml_reader *r, const struct toml_node *table, const char *key,
                          double otherwise, bool negative, double *out) {
    const struct toml_node *node = toml_find(table, key);
    *out = otherwise;
    if (!node) return true;
    if (node->kind != TOML_NUMBER || isnan(node->number))
        return toml_wrong(r, node, "it must be a number");
    if (!negative && node->number < 0.0) return toml_wrong(r, node, "%s is negative", node->text);
    if (!(fabs(node->number) <= VALUE_MAX))
        return toml_wrong(r, node, "%s is too large", node->text);
    *out = node->number;
    return true;
}
