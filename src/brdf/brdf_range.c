// SPDX-License-Identifier: Apache-2.0
// Harmonics of a BRDF whose roughness is textured: tables at values of roughness at equal distances
// in its logarithm, called rungs, between which coefficients are interpolated. A roughness is
// represented if the tables of both rungs around it meet the error bound, so one material may be
// cached where it is rough and sampled where it is smooth.
#include <stdlib.h>

#include "base/array.h"
#include "brdf/brdf.h"
#include "rsh/rsh.h"

enum { RUNGS_MAX = 14 };

#define RANGE_STEP 1.2f    // ratio of the roughness of two rungs; for exponents its square
#define RANGE_LEAST 0.02f  // smoother lobes cannot be represented with the available orders

struct brdf_range {
    enum brdf_slot slot;  // BRDF_SLOT_COUNT: one table for all
    int count, channels;
    float first, log_step;
    struct brdf_table *rung[RUNGS_MAX];
};

// Distributes the rungs from lo to hi.
static void set_rungs(struct brdf_range *r, const struct brdf_roughness *over) {
    const bool exponent = over->slot == BRDF_SLOT_EXPONENT;
    float lo = maxf(over->lo, exponent ? 1.0f : RANGE_LEAST), hi = maxf(over->hi, lo);
    float span = logf(hi / lo), step = logf(exponent ? RANGE_STEP * RANGE_STEP : RANGE_STEP);
    int steps = (int)ceilf(span / step - 1e-3f);
    r->slot = over->slot;
    r->count = 1 + (steps < RUNGS_MAX ? steps : RUNGS_MAX - 1);
    r->first = lo;
    r->log_step = r->count > 1 ? span / (float)(r->count - 1) : 1.0f;
}

satin_status brdf_range_build(const struct brdf *b, const struct brdf_roughness *over,
                              const struct brdf_fit *fit, struct parallel *pool,
                              struct brdf_range **out) {
    struct brdf_range *r = array_new(1, sizeof *r);
    if (!r) return SATIN_ERROR_MEMORY;
    r->slot = BRDF_SLOT_COUNT;
    r->count = 1;
    if (over) set_rungs(r, over);
    satin_status status = SATIN_OK;
    for (int i = 0; i < r->count && status == SATIN_OK; i++) {
        struct brdf at = *b;
        float value = r->first * expf((float)i * r->log_step);
        if (over) *brdf_number(&at, over->slot) = value;
        if (over && over->slot == BRDF_SLOT_ALPHA_U && b->model->slots >> BRDF_SLOT_ALPHA_V & 1)
            at.alpha_v = value;
        status = brdf_table_build(&at, fit, pool, &r->rung[i]);
        if (status != SATIN_OK) break;
        int channels = brdf_table_describe(r->rung[i]).channels;
        if (channels > r->channels) r->channels = channels;
    }
    if (status != SATIN_OK)
        brdf_range_free(r);
    else
        *out = r;
    return status;
}

void brdf_range_free(struct brdf_range *range) {
    if (!range) return;
    for (int i = 0; i < range->count; i++) brdf_table_free(range->rung[i]);
    free(range);
}

// The rung below b's roughness, and the position between it and the next. False if b is outside the
// range.
static bool find_rung(const struct brdf_range *r, const struct brdf *b, int *rung, float *rest) {
    *rung = 0;
    *rest = 0.0f;
    if (r->slot == BRDF_SLOT_COUNT) return true;
    struct brdf copy = *b;
    float value = *brdf_number(&copy, r->slot);
    if (!(value >= 0.999f * r->first)) return false;
    float x = logf(value / r->first) / r->log_step, last = (float)(r->count - 1);
    if (!(x > 0.0f) || r->count == 1) return x < 0.01f;
    if (x > last + 0.01f) return false;
    *rung = x < last ? (int)x : r->count - 2;
    *rest = minf(x - (float)*rung, 1.0f);
    return true;
}

int brdf_range_order(const struct brdf_range *r, const struct brdf *b, vec3 wo) {
    int i;
    float rest;
    if (!find_rung(r, b, &i, &rest)) return 0;
    int order = brdf_table_order(r->rung[i], wo);
    if (rest == 0.0f || order == 0) return order;
    int next = brdf_table_order(r->rung[i + 1], wo);
    return next == 0 ? 0 : next > order ? next : order;
}

// Adds `weight` times the coefficients of a table, for an order and a number of channels, to c.
static void add_table(const struct brdf_table *table, vec3 wo, float weight, int order,
                      int channels, float *c) {
    float own[3 * RSH_MAX_COEFFICIENTS];
    int n = brdf_table_lookup(table, wo, own), grey = brdf_table_channels(table) == 1;
    for (int channel = 0; channel < channels; channel++)
        for (int k = 0; k < n * n; k++)
            c[channel * order * order + k] += weight * own[(grey ? 0 : channel) * n * n + k];
}

int brdf_range_lookup(const struct brdf_range *r, const struct brdf *b, vec3 wo, float *c) {
    int i;
    float rest;
    if (!find_rung(r, b, &i, &rest)) return 0;
    if (rest == 0.0f && brdf_table_channels(r->rung[i]) == r->channels)
        return brdf_table_lookup(r->rung[i], wo, c);
    int order = brdf_range_order(r, b, wo);
    for (int k = 0; k < r->channels * order * order; k++) c[k] = 0.0f;
    if (order == 0) return 0;
    add_table(r->rung[i], wo, 1.0f - rest, order, r->channels, c);
    if (rest > 0.0f) add_table(r->rung[i + 1], wo, rest, order, r->channels, c);
    return order;
}

struct brdf_table_info brdf_range_describe(const struct brdf_range *r) {
    struct brdf_table_info sum = {.channels = r->channels};
    for (int i = 0; i < r->count; i++) {
        struct brdf_table_info info = brdf_table_describe(r->rung[i]);
        if (info.order > sum.order) sum.order = info.order;
        sum.fraction += info.fraction / (float)r->count;
        sum.bytes += info.bytes;
    }
    return sum;
}
