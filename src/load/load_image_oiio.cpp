// SPDX-License-Identifier: Apache-2.0
// The module on OpenImageIO: C functions for its C++ classes. It is a separate shared library, so
// that the libraries of OpenImageIO are loaded only when a scene has an image.
#include "load/load_image_reader.h"

#include <OpenImageIO/imageio.h>

#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <string>

namespace {

// Copies the first line of the text. It allocates nothing, as it may be called when memory has run
// out.
reader_result fail(char *error, size_t size, const char *text) {
    std::snprintf(error, size, "%.*s", static_cast<int>(std::strcspn(text, "\r\n")), text);
    return READER_FAILED;
}

// Calls f and converts exceptions to messages.
template <typename F>
reader_result guarded(char *error, size_t size, F f) noexcept {
    try {
        return f();
    } catch (const std::bad_alloc &) {
        std::snprintf(error, size, "not enough memory");
        return READER_NO_MEMORY;
    } catch (const std::exception &e) {
        return fail(error, size, e.what());
    } catch (...) {
        return fail(error, size, "unknown failure");
    }
}

// Integers count as encoded unless the file says that they are linear, and floats as linear unless
// it says that they are not. The names of colour spaces changed from OpenImageIO 2 to 3.
bool is_srgb(const OIIO::ImageSpec &spec) {
    std::string space = OIIO::Strutil::lower(spec.get_string_attribute("oiio:ColorSpace"));
    if (space.find("srgb") == 0) return true;
    bool linear = space.find("lin") == 0 || space == "raw" || space == "data";
    return !linear && !spec.format.is_floating_point();
}

reader_result open(const struct image_data *file, struct opened_image *out, char *error,
                   size_t size) {
    return guarded(error, size, [&] {
        OIIO::ImageSpec config;
        config["oiio:UnassociatedAlpha"] = 1;
        auto input = OIIO::ImageInput::open(file->path, &config);
        if (!input) return fail(error, size, OIIO::geterror().c_str());
        const OIIO::ImageSpec &spec = input->spec();
        if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || spec.nchannels < 1 || spec.deep)
            return fail(error, size, "it is not a flat image");
        out->width = spec.width;
        out->height = spec.height;
        out->channels = spec.nchannels < 3 ? 1 : 3;
        if (file->alpha && spec.alpha_channel == out->channels) out->channels++;
        out->bytes = spec.format == OIIO::TypeDesc::UINT8 && spec.channelformats.empty();
        out->srgb = is_srgb(spec);
        out->input = input.release();
        return READER_DONE;
    });
}

// Rows that are read at once, a multiple of those that compressed EXR files have together. Whole
// images would be in memory twice, once as they are in the file.
enum { BAND_ROWS = 256 };

bool read_bands(OIIO::ImageInput &input, const struct opened_image &image, char *values) {
    const OIIO::ImageSpec spec = input.spec();
    const auto type = image.bytes ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc::FLOAT;
    if (spec.tile_width > 0) return input.read_image(0, 0, 0, image.channels, type, values);
    const size_t row = static_cast<size_t>(image.width) * static_cast<size_t>(image.channels) *
                       (image.bytes ? 1 : sizeof(float));
    bool done = true;
    for (int y = 0; y < image.height && done; y += BAND_ROWS)
        done = input.read_scanlines(0, 0, spec.y + y,
                                    spec.y + std::min(y + +BAND_ROWS, image.height), spec.z, 0,
                                    image.channels, type, values + static_cast<size_t>(y) * row);
    return done;
}

reader_result read(struct opened_image *image, void *values, char *error, size_t size) {
    return guarded(error, size, [&] {
        auto *input = static_cast<OIIO::ImageInput *>(image->input);
        bool done = read_bands(*input, *image, static_cast<char *>(values));
        // Readers report truncated files and still claim success. But they also report JPEGs with a
        // few bytes too many, which are common and harmless.
        std::string complaint = input->geterror();
        if (done && (complaint.empty() || complaint.find("extraneous") != std::string::npos))
            return READER_DONE;
        return fail(error, size, complaint.c_str());
    });
}

void close(struct opened_image *image) {
    try {
        OIIO::ImageInput::unique_ptr input(static_cast<OIIO::ImageInput *>(image->input));
    } catch (...) {
    }
    image->input = nullptr;
}

}  // namespace

extern "C" __attribute__((visibility("default")))
const struct image_reader satin_oiio_module = {open, read, close};
