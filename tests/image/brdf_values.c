// SPDX-License-Identifier: Apache-2.0
// Prints BRDF values for check_brdf.py. Reads lines from stdin:
//   b MODEL DISTRIBUTION VARIANT NONLINEAR ior, then three numbers for each colour's slot and one
//   for
//     each number's, in the order of enum brdf_slot
//   e wo3 wi3     prints the three channels of f_r of all smooth lobes
//   d wo3         prints the number of delta lobes, then per lobe wi3, weight3, probability
#include <stdio.h>
#include <string.h>

#include "brdf/brdf.h"

static bool read_floats(const char **text, float *out, int n) {
    for (int i = 0; i < n; i++) {
        int used = 0;
        if (sscanf(*text, "%f%n", out + i, &used) != 1) return false;
        *text += used;
    }
    return true;
}

static bool read_brdf(const char *line, struct brdf *b, struct arena *arena) {
    char name[32];
    int distribution, variant, nonlinear, used;
    float ior;
    if (sscanf(line, "%31s %d %d %d%n", name, &distribution, &variant, &nonlinear, &used) != 4)
        return false;
    line += used;
    if (!read_floats(&line, &ior, 1)) return false;
    *b = (struct brdf){.model = brdf_find(name),
                       .ior = ior,
                       .distribution = (enum brdf_distribution)distribution,
                       .variant = (enum brdf_variant)variant,
                       .nonlinear = nonlinear != 0};
    for (enum brdf_slot i = 0; i < BRDF_SLOT_COUNT; i++) {
        float f[3];
        if (!read_floats(&line, f, i < BRDF_SLOT_NUMBERS ? 3 : 1)) return false;
        if (i < BRDF_SLOT_NUMBERS)
            *brdf_color(b, i) = rgb_make(f[0], f[1], f[2]);
        else
            *brdf_number(b, i) = f[0];
    }
    return b->model && brdf_prepare(b, arena, NULL) == SATIN_OK;
}

static void print_delta(const struct brdf *b, vec3 wo) {
    struct brdf_sample s[2];
    int n = brdf_delta(b, wo, BRDF_RADIANCE, s);
    printf("%d", n);
    for (int i = 0; i < n; i++)
        printf(" %.9g %.9g %.9g %.9g %.9g %.9g %.9g", s[i].wi.x, s[i].wi.y, s[i].wi.z,
               s[i].weight.r, s[i].weight.g, s[i].weight.b, s[i].probability);
    printf("\n");
}

int main(void) {
    char line[1024];
    struct arena arena = {0};
    struct brdf b = {0};
    bool ok = true;
    while (ok && fgets(line, sizeof line, stdin)) {
        const char *text = line + 1;
        float w[6];
        if (line[0] == 'b') {
            ok = read_brdf(text, &b, &arena);
        } else if (line[0] == 'e' && b.model && read_floats(&text, w, 6)) {
            rgb f = brdf_eval(&b, v3(w[0], w[1], w[2]), v3(w[3], w[4], w[5]), BRDF_ALL);
            printf("%.9g %.9g %.9g\n", f.r, f.g, f.b);
        } else if (line[0] == 'd' && b.model && read_floats(&text, w, 3)) {
            print_delta(&b, v3(w[0], w[1], w[2]));
        } else {
            ok = false;
        }
    }
    arena_free(&arena);
    if (!ok) fprintf(stderr, "brdf_values: cannot read: %s", line);
    return ok ? 0 : 2;
}
