// SPDX-License-Identifier: Apache-2.0
// Any bytes given as a spectrum. The first one selects: 0 the text of an attribute, 1 an .spd file.
// A colour that is finite, or one logged line; no crash, memory in proportion to the input.
#include "fuzz_case.h"
#include "load/load_spectrum.h"

static satin_status fuzz_spectrum_read_text(struct log log, const uint8_t *data, size_t size,
                                            struct spectrum *out) {
    char *text = calloc(size + 1, 1);
    if (!text) abort();
    if (size) memcpy(text, data, size);
    satin_status status = load_spectrum_parse(log, (struct log_place){"fuzz.xml", 1, 1}, text, out);
    free(text);
    return status;
}

static satin_status read_file(struct log log, const uint8_t *data, size_t size,
                              struct spectrum *out) {
    uint64_t hash = 0;
    char path[FUZZ_PATH];
    int file = fuzz_file(data, size, path);
    satin_status status = load_spectrum_read(log, (struct log_place){0}, path, &hash, out);
    close(file);
    return status;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (!size) return 0;
    int lines = 0;
    struct log log = {fuzz_count, &lines};
    struct spectrum spectrum = {0};
    satin_status status = data[0] & 1 ? read_file(log, data + 1, size - 1, &spectrum)
                                      : fuzz_spectrum_read_text(log, data + 1, size - 1, &spectrum);
    if (lines != (status != SATIN_OK) || (status && status != SATIN_ERROR_INPUT)) abort();
    if (status != SATIN_OK && spectrum.count) abort();
    for (int light = 0; light < 2; light++) {
        rgb c = scene_spectrum_to_rgb(&spectrum, light);
        if (!rgb_finite(c) || c.r < 0.0f || c.g < 0.0f || c.b < 0.0f) abort();
    }
    scene_spectrum_free(&spectrum);
    return 0;
}
