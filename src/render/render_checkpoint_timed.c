// SPDX-License-Identifier: Apache-2.0
// The checkpoint of a render with a time limit. It has no results of loops, as these are made from
// what fits into the time. It has what was decided by measured times, from which a later process
// makes the photons again, and the seconds that are over, so that the later one spends the others
// on further samples of the image.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/stats.h"
#include "render/options_quality.h"
#include "render/options_table.h"
#include "render/render_image.h"

enum { WORD_SIZE = 64 };

bool render_timed_resumes(const struct render *r) {
    return r->options.integrator != SATIN_TWO_PASS;
}

void render_timed_identity(const struct render *r, satin_options *options) {
    options_quality_copy(options, r->motion.options);
    options->time = 1.0;
}

void render_timed_pack(const struct render *r, const char *chosen, struct bytes *out) {
    const double number[] = {r->first_pass.fraction, stats_wall() - r->progress.start,
                             r->image->sample_seconds};
    bytes_put_u64(out, strlen(chosen));
    bytes_put(out, chosen, strlen(chosen));
    bytes_put(out, number, sizeof number);
}

// Sets those options among the words that quality or a time limit decide, which are numbers.
static bool take_words(const char *words, satin_options *options) {
    struct identity_word word;
    char name[WORD_SIZE], value[WORD_SIZE];
    while (render_identity_next(&words, &word)) {
        snprintf(name, sizeof name, "%.*s", (int)word.name, word.at);
        const struct option *option = word.name < word.length ? options_find(name) : NULL;
        if (!option || !option->by_quality) continue;
        snprintf(value, sizeof value, "%.*s", (int)(word.length - word.name - 1),
                 word.at + word.name + 1);
        if (!option_parse(option, value, options)) return false;
    }
    return true;
}

bool render_timed_unpack(struct render *r, struct bytes_reader *in) {
    const uint64_t length = bytes_get_u64(in);
    char *words = !in->failed && length <= in->left ? calloc(1, (size_t)length + 1) : NULL;
    if (!words) return false;
    double number[3];
    satin_options options = r->options;
    bytes_get(in, words, (size_t)length);
    bytes_get(in, number, sizeof number);
    bool valid = !in->failed && take_words(words, &options);
    for (int i = 0; i < 3; i++) valid = valid && isfinite(number[i]) && number[i] >= 0.0;
    free(words);
    if (!valid || number[0] > 1.0) return false;
    r->options = options;
    r->first_pass.fraction = number[0];
    r->progress.start -= number[1];
    r->image->sample_seconds = number[2];
    return true;
}
