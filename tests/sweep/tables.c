// SPDX-License-Identifier: Apache-2.0
// Stores the BRDF tables of a cell. Its scene is the same for all seeds, and so are the tables,
// which take most of the time of a small image. The linker calls these functions instead of
// brdf_table_build and brdf_table_free.
#include <stdlib.h>
#include <string.h>

#include "brdf/brdf.h"

satin_status __real_brdf_table_build(const struct brdf *b, const struct brdf_fit *fit,
                                     struct parallel *pool, struct brdf_table **out);
satin_status __wrap_brdf_table_build(const struct brdf *b, const struct brdf_fit *fit,
                                     struct parallel *pool, struct brdf_table **out);
void __wrap_brdf_table_free(struct brdf_table *table);

// A table and all that it depends on. The pointers in `brdf` are to what the scene owns, which
// lives as long as the cell's process.
struct stored_table {
    struct brdf brdf;
    struct brdf_fit fit;
    struct brdf_table *table;
    struct stored_table *next;
};

// This process renders on one thread, which builds them.
static struct stored_table *table_stored;

// Compares bytes: padding that differs costs time, and no more.
static bool same_table(const struct stored_table *k, const struct brdf *b,
                       const struct brdf_fit *fit) {
    return memcmp(&k->brdf, b, sizeof *b) == 0 && k->fit.basis == fit->basis &&
           k->fit.max_order == fit->max_order && k->fit.max_error == fit->max_error &&
           k->fit.always == fit->always;
}

satin_status __wrap_brdf_table_build(const struct brdf *b, const struct brdf_fit *fit,
                                     struct parallel *pool, struct brdf_table **out) {
    for (const struct stored_table *k = table_stored; k; k = k->next) {
        if (!same_table(k, b, fit)) continue;
        *out = k->table;
        return SATIN_OK;
    }
    struct stored_table *k = malloc(sizeof *k);
    if (!k) return SATIN_ERROR_MEMORY;
    const satin_status status = __real_brdf_table_build(b, fit, pool, &k->table);
    if (status != SATIN_OK) {
        free(k);
        return status;
    }
    memcpy(&k->brdf, b, sizeof *b);
    k->fit = *fit;
    k->next = table_stored;
    table_stored = k;
    *out = k->table;
    return SATIN_OK;
}

void __wrap_brdf_table_free(struct brdf_table *table) { (void)table; }
