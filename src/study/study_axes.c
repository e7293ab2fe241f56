// SPDX-License-Identifier: Apache-2.0
// Reads what varies in a study and makes its points: all combinations of the axes of [vary], or of
// each [[vary]], and the combinations that [[point]] lists.
#include <string.h>

#include "base/array.h"
#include "base/text.h"
#include "study/study_file.h"

enum { AXES_MAX = 16 };

// The axes of one [vary].
struct axes {
    struct study_axis axis[AXES_MAX];
    size_t count;
};

// The column of that name, which is added if it is new. SIZE_MAX if there is no memory.
static size_t column_of(struct study_reader *r, const char *name, bool is_option) {
    struct study *s = r->out;
    for (size_t i = 0; i < s->columns; i++)
        if (text_same_name(s->column[i].name, name)) return i;
    struct study_column *grown = study_array(r, s->columns + 1, sizeof *grown);
    if (!grown) return SIZE_MAX;
    if (s->columns) memcpy(grown, s->column, s->columns * sizeof *grown);
    s->column = grown;
    s->column[s->columns] = (struct study_column){.name = name, .is_option = is_option};
    return s->columns++;
}

// ---- Axes ---------------------------------------------------------------------------------------

// The label of options that change together: `name=value name=value`.
static const char *join_settings(struct study_reader *r, const struct study_settings *set) {
    size_t bytes = 1;
    for (size_t i = 0; i < set->count; i++)
        bytes += strlen(set->setting[i].name) + strlen(set->setting[i].value) + 2;
    char *text = study_array(r, bytes, 1);
    if (!text) return NULL;
    for (size_t i = 0; i < set->count; i++) {
        if (i) strcat(text, " ");
        strcat(text, set->setting[i].name);
        strcat(text, "=");
        strcat(text, set->setting[i].value);
    }
    return text;
}

// A value that is a table of options, with a label in its key `label` or made of them.
static bool take_together(struct study_reader *r, const struct toml_node *table,
                          struct study_value *out) {
    out->set.setting = study_array(r, table->count, sizeof *out->set.setting);
    if (!out->set.setting) return false;
    for (size_t i = 0; i < table->count; i++) {
        const struct toml_node *child = &table->child[i];
        if (strcmp(child->key, "label") == 0) {
            if (!study_is(r, child, TOML_TEXT, "a text")) return false;
            out->label = child->text;
        } else if (!study_take_option(r, child, true, &out->set)) {
            return false;
        }
    }
    if (!out->label) out->label = join_settings(r, &out->set);
    return out->label != NULL;
}

static bool is_option_name(const char *name) {
    satin_option_info info;
    for (int i = 0; satin_options_describe(&satin_options_default, i, &info); i++)
        if (text_same_name(info.name, name)) return true;
    return false;
}

static bool take_value(struct study_reader *r, const struct toml_node *axis,
                       const struct toml_node *value, struct study_value *out) {
    if (value->kind == TOML_TABLE) return take_together(r, value, out);
    // Errors name the axis, at the position of the value unless the axis itself is wrong.
    struct toml_node named = *value;
    named.key = axis->key;
    if (!is_option_name(axis->key)) named.at = axis->at;
    out->set.setting = study_array(r, 1, sizeof *out->set.setting);
    if (!out->set.setting || !study_take_option(r, &named, true, &out->set)) return false;
    out->label = value->text;
    return true;
}

static bool take_axis(struct study_reader *r, const struct toml_node *node, struct axes *out) {
    if (out->count == AXES_MAX) return toml_wrong(&r->toml, node, "more than %d axes", AXES_MAX);
    if (!study_is(r, node, TOML_ARRAY, "a list of values")) return false;
    if (node->count == 0) return toml_wrong(&r->toml, node, "it has no values");
    struct study_axis *axis = &out->axis[out->count++];
    const bool together = node->child[0].kind == TOML_TABLE;
    *axis = (struct study_axis){.count = node->count};
    if (together && study_columns_have(node->key))
        return toml_wrong(&r->toml, node, "study.csv has another column of this name");
    axis->value = study_array(r, node->count, sizeof *axis->value);
    if (!axis->value) return false;
    for (size_t i = 0; i < node->count; i++) {
        const struct toml_node *value = &node->child[i];
        if ((value->kind == TOML_TABLE) != together)
            return toml_wrong(&r->toml, node, "its values must all be tables of options, or none");
        if (!take_value(r, node, value, &axis->value[i])) return false;
        for (size_t k = 0; k < i && together; k++)
            if (strcmp(axis->value[k].label, axis->value[i].label) == 0)
                return toml_wrong(&r->toml, node, "two of its values are called '%s'",
                                  axis->value[i].label);
    }
    axis->column = column_of(r, node->key, !together);
    if (axis->column == SIZE_MAX) return false;
    struct study_column *column = &r->out->column[axis->column];
    if (column->is_option == together)
        return toml_wrong(&r->toml, node, "elsewhere it has %s", together ? "values" : "tables");
    column->value = axis->value;
    column->values = axis->count;
    return true;
}

// ---- Points -------------------------------------------------------------------------------------

static struct study_point *append_point(struct study_reader *r, struct log_place at,
                                        size_t settings) {
    struct study *s = r->out;
    if (s->points == STUDY_RENDERS_MAX) {
        log_error_at(r->toml.log, at, "the study has more than %d points", STUDY_RENDERS_MAX);
        r->toml.status = SATIN_ERROR_INPUT;
        return NULL;
    }
    if (s->points == s->point_capacity) {
        const size_t capacity = s->point_capacity ? 2 * s->point_capacity : 64;
        struct study_point *grown = study_array(r, capacity, sizeof *grown);
        if (!grown) return NULL;
        if (s->points) memcpy(grown, s->point, s->points * sizeof *grown);
        s->point = grown;
        s->point_capacity = capacity;
    }
    struct study_point *point = &s->point[s->points];
    // Columns may still be added; there are at most as many as the file has keys.
    *point = (struct study_point){.at = at};
    point->set.setting = study_array(r, settings, sizeof *point->set.setting);
    point->cell = study_array(r, 2 * AXES_MAX, sizeof *point->cell);
    if (!point->set.setting || !point->cell) return NULL;
    s->points++;
    return point;
}

static void append_settings(struct study_settings *to, const struct study_settings *from) {
    for (size_t i = 0; i < from->count; i++) to->setting[to->count++] = from->setting[i];
}

// All combinations; the last axis changes first.
static bool add_product(struct study_reader *r, const struct axes *axes, struct log_place at) {
    size_t total = 1, settings = 0, index[AXES_MAX] = {0};
    for (size_t a = 0; a < axes->count; a++) {
        total *= axes->axis[a].count;
        size_t most = 0;
        for (size_t i = 0; i < axes->axis[a].count; i++)
            if (axes->axis[a].value[i].set.count > most) most = axes->axis[a].value[i].set.count;
        settings += most;
        if (total > STUDY_RENDERS_MAX) {
            log_error_at(r->toml.log, at, "the study has more than %d points", STUDY_RENDERS_MAX);
            r->toml.status = SATIN_ERROR_INPUT;
            return false;
        }
    }
    for (size_t i = 0; i < total; i++) {
        struct study_point *point = append_point(r, at, settings);
        if (!point) return false;
        for (size_t a = 0; a < axes->count; a++) {
            const struct study_value *value = &axes->axis[a].value[index[a]];
            append_settings(&point->set, &value->set);
            point->cell[axes->axis[a].column] = value->label;
        }
        for (size_t a = axes->count; a-- > 0;) {
            if (++index[a] < axes->axis[a].count) break;
            index[a] = 0;
        }
    }
    return true;
}

static bool sets_any(const struct study_settings *set, const char *name) {
    for (size_t i = 0; i < set->count; i++)
        if (text_same_name(set->setting[i].name, name)) return true;
    return false;
}

// The first axis before the last one that sets this option; NULL if there is none.
static const struct study_axis *earlier_axis(const struct axes *axes, const char *option) {
    for (size_t a = 0; a + 1 < axes->count; a++)
        for (size_t i = 0; i < axes->axis[a].count; i++)
            if (sets_any(&axes->axis[a].value[i].set, option)) return &axes->axis[a];
    return NULL;
}

// Whether the last axis, of this node, sets no option that another one sets: else labels would be
// wrong.
static bool axes_agree(struct study_reader *r, const struct toml_node *node,
                       const struct axes *axes) {
    const struct study_axis *last = &axes->axis[axes->count - 1];
    for (size_t v = 0; v < last->count; v++)
        for (size_t k = 0; k < last->value[v].set.count; k++) {
            const char *name = last->value[v].set.setting[k].name;
            const struct study_axis *other = earlier_axis(axes, name);
            const struct toml_node *value = &node->child[v];
            if (other)
                return toml_wrong(&r->toml,
                                  value->kind == TOML_TABLE ? toml_find(value, name) : node,
                                  "'%s' sets this option too", r->out->column[other->column].name);
        }
    return true;
}

static bool take_table(struct study_reader *r, const struct toml_node *table) {
    struct axes axes = {.count = 0};
    if (!study_is(r, table, TOML_TABLE, "a table of options with lists of values")) return false;
    for (size_t i = 0; i < table->count; i++)
        if (!take_axis(r, &table->child[i], &axes) || !axes_agree(r, &table->child[i], &axes))
            return false;
    if (r->out->columns > AXES_MAX)
        return toml_wrong(&r->toml, table, "more than %d axes", AXES_MAX);
    return add_product(r, &axes, table->at);
}

bool study_take_vary(struct study_reader *r, const struct toml_node *node) {
    if (node->kind != TOML_ARRAY) return take_table(r, node);
    for (size_t i = 0; i < node->count; i++)
        if (!take_table(r, &node->child[i])) return false;
    return true;
}

// Takes the name of a point, which no point before it may have: tables and charts show it alone.
static bool take_point_name(struct study_reader *r, const struct toml_node *node,
                            struct study_point *point) {
    if (!study_is(r, node, TOML_TEXT, "a text")) return false;
    for (const struct study_point *p = r->out->point; p < point; p++)
        if (p->name && strcmp(p->name, node->text) == 0)
            return toml_wrong(&r->toml, node, "two points are called '%s'", node->text);
    point->name = node->text;
    return true;
}

bool study_take_points(struct study_reader *r, const struct toml_node *node) {
    if (!study_is(r, node, TOML_ARRAY, "written as [[point]]")) return false;
    for (size_t i = 0; i < node->count; i++) {
        const struct toml_node *table = &node->child[i];
        if (!study_is(r, table, TOML_TABLE, "written as [[point]]")) return false;
        struct study_point *point = append_point(r, table->at, table->count);
        if (!point) return false;
        for (size_t k = 0; k < table->count; k++) {
            const struct toml_node *child = &table->child[k];
            if (strcmp(child->key, "name") == 0) {
                if (!take_point_name(r, child, point)) return false;
                continue;
            }
            if (!study_take_option(r, child, true, &point->set)) return false;
            const size_t column = column_of(r, child->key, true);
            if (column == SIZE_MAX) return false;
            if (column >= AXES_MAX)
                return toml_wrong(&r->toml, child, "more than %d axes", AXES_MAX);
            point->cell[column] = child->text;
        }
    }
    return true;
}

// ---- Equal time and equal samples ---------------------------------------------------------------

static bool is_set_anywhere(const struct study *s, const char *name) {
    bool any = sets_any(&s->set, name);
    for (size_t i = 0; i < s->points && !any; i++) any = sets_any(&s->point[i].set, name);
    return any;
}

// Whether a value of `key`, which sets the option `name`, is one; errors name the key that the file
// has.
static bool is_equal_value(struct study_reader *r, const struct toml_node *key,
                           const struct toml_node *value, const char *name) {
    struct toml_node named = *value;
    named.key = key->key;
    if (value->kind == TOML_NUMBER && !(value->number > 0.0))
        return toml_wrong(&r->toml, &named, "%s is not more than 0", value->text);
    return study_is_option_value(r, &named, name);
}

// Gives every point each of the values of `key`, one or a list, as the option `name`.
static bool multiply_points(struct study_reader *r, const struct toml_node *node,
                            const char *name) {
    struct study *s = r->out;
    if (is_set_anywhere(s, "time") || is_set_anywhere(s, "spp"))
        return toml_wrong(&r->toml, node, "with it, neither time nor spp may be set or vary");
    struct toml_node one = *node, list = {.kind = TOML_ARRAY, .child = &one, .count = 1};
    if (node->kind == TOML_ARRAY) list = *node;
    if (list.count == 0) return toml_wrong(&r->toml, node, "it has no values");
    for (size_t i = 0; i < list.count; i++)
        if (!is_equal_value(r, node, &list.child[i], name)) return false;
    one.key = NULL;
    char *key = study_array(r, strlen(name) + 1, 1);
    if (!key) return false;
    strcpy(key, name);
    list.key = key;
    list.at = node->at;
    struct axes axes = {.count = 0};
    if (!take_axis(r, &list, &axes)) return false;
    const struct study_axis *axis = &axes.axis[0];
    const struct study_point *before = s->point;
    const size_t count = s->points;
    s->point = NULL;
    s->points = s->point_capacity = 0;
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < axis->count; k++) {
            struct study_point *point = append_point(r, before[i].at, before[i].set.count + 1);
            if (!point) return false;
            memcpy(point->cell, before[i].cell, 2 * AXES_MAX * sizeof *point->cell);
            point->name = before[i].name;
            append_settings(&point->set, &before[i].set);
            append_settings(&point->set, &axis->value[k].set);
            point->cell[axis->column] = axis->value[k].label;
        }
    return true;
}

bool study_finish_points(struct study_reader *r, const struct toml_node *root) {
    const struct toml_node *samples = toml_find(root, "equal-samples");
    const struct toml_node *time = toml_find(root, "equal-time");
    struct study *s = r->out;
    if (samples && time)
        return toml_wrong(&r->toml, time, "equal-samples and equal-time exclude each other");
    if (s->points == 0 && !append_point(r, root->at, 0)) return false;
    if (samples && !multiply_points(r, samples, "spp")) return false;
    if (time && !multiply_points(r, time, "time")) return false;
    const size_t renders = s->points * s->scenes * s->seeds;
    if (renders > STUDY_RENDERS_MAX)
        return toml_wrong(&r->toml, root, "%zu renders; the limit is %d", renders,
                          STUDY_RENDERS_MAX);
    return true;
}
