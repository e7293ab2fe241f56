// SPDX-License-Identifier: Apache-2.0
// Reads OpenEXR files (base/exrfile.h) of three channels or one, beside which may be alpha, depth
// and layers. All others are left to the module on OpenImageIO.
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/array.h"
#include "base/exrfile.h"
#include "load/load_image_reader.h"

enum { VALUES_MOST = 4 };  // of a pixel

// The channels of an image in the order of its values: of colours or of luminance, and alpha; -1:
// there is none.
struct value_channels {
    int of[VALUES_MOST];
    int colors;
};

struct exr_image {
    struct exrfile file;
    struct value_channels from;
};

// ---- Channels -----------------------------------------------------------------------------------

static int find_channel(const exr_attr_chlist_t *channels, const char *name) {
    for (int i = 0; i < channels->num_channels; i++)
        if (strcmp(channels->entries[i].name.str, name) == 0) return i;
    return -1;
}

// Whether all channels outside of layers are those of an image, and which these are.
static bool find_channels(const exr_attr_chlist_t *channels, struct value_channels *out) {
    static const char *const rgb_names[] = {"R", "G", "B"}, *const grey_names[] = {"Y"};
    const bool grey = find_channel(channels, "Y") >= 0;
    const char *const *names = grey ? grey_names : rgb_names;
    out->colors = grey ? 1 : 3;
    for (int i = 0; i < out->colors; i++) {
        out->of[i] = find_channel(channels, names[i]);
        if (out->of[i] < 0) return false;
    }
    const int alpha = out->of[out->colors] = find_channel(channels, "A");
    int known = out->colors + (alpha >= 0) + (find_channel(channels, "Z") >= 0);
    for (int i = 0; i < channels->num_channels; i++)
        known += strchr(channels->entries[i].name.str, '.') != NULL;
    return known == channels->num_channels;
}

// The attribute by which OpenImageIO says how values are encoded.
static bool states_encoding(const struct exrfile *file) {
    const exr_attribute_t *a = NULL;
    return exr_get_attribute_by_name(file->exr, 0, "oiio:ColorSpace", &a) == EXR_ERR_SUCCESS;
}

// ---- The reader ---------------------------------------------------------------------------------

static enum reader_result exr_failure(const struct exrfile *file, satin_status status, char *error,
                                      size_t size) {
    snprintf(error, size, "%s", file->problem);
    return status == SATIN_ERROR_MEMORY ? READER_NO_MEMORY : READER_FAILED;
}

static void free_exr(struct exr_image *input) {
    exrfile_close(&input->file);
    free(input);
}

static enum reader_result open_exr(const struct image_data *file, struct opened_image *out,
                                   char *error, size_t size) {
    struct exr_image *input = calloc(1, sizeof *input);
    if (!input) {
        snprintf(error, size, "not enough memory");
        return READER_NO_MEMORY;
    }
    const satin_status status = exrfile_open(&input->file, file->path, file->data, file->size);
    if (status != SATIN_OK || !find_channels(input->file.channels, &input->from)) {
        const enum reader_result result = exr_failure(&input->file, status, error, size);
        free_exr(input);
        return result;
    }
    const int colors = input->from.colors;
    const bool alpha = file->alpha && input->from.of[colors] >= 0;
    *out = (struct opened_image){.input = input,
                                 .width = input->file.width,
                                 .height = input->file.height,
                                 .channels = colors + alpha};
    return READER_DONE;
}

static enum reader_result read_exr(struct opened_image *image, void *values, char *error,
                                   size_t size) {
    struct exr_image *input = image->input;
    float *texel = values;
    const size_t channels = (size_t)image->channels;
    struct exrfile_channel *to = array_new((size_t)input->file.channels->num_channels, sizeof *to);
    if (!to) return exr_failure(&input->file, exrfile_no_memory(&input->file), error, size);
    for (size_t c = 0; c < channels; c++)
        to[input->from.of[c]] =
            (struct exrfile_channel){texel + c, channels, channels * (size_t)image->width};
    const satin_status status = exrfile_read(&input->file, to);
    free(to);
    return status == SATIN_OK ? READER_DONE : exr_failure(&input->file, status, error, size);
}

static void close_exr(struct opened_image *image) {
    free_exr(image->input);
    image->input = NULL;
}

const struct image_reader load_image_exr = {open_exr, read_exr, close_exr};

int load_image_is_exr(const struct image_data *file) {
    struct exrfile exr;
    struct value_channels from;
    // A damaged file is refused here: OpenImageIO would believe what it states, and take gigabytes.
    const bool known = exrfile_open(&exr, file->path, file->data, file->size) == SATIN_OK
                           ? find_channels(exr.channels, &from) && !states_encoding(&exr)
                           : !exr.other;
    exrfile_close(&exr);
    return known;
}
