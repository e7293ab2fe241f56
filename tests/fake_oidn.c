// SPDX-License-Identifier: Apache-2.0
// A replacement for Open Image Denoise 2: every pixel becomes the mean of its image. The
// environment variable FAKE_OIDN makes it fail, once it has been tried out on a black image.
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define API __attribute__((visibility("default")))

enum { OUT_OF_MEMORY = 4, INVALID_OPERATION = 3, CANCELLED = 6 };

struct device {
    int error;
    const char *message;
    bool committed;
};

struct fake_oidn_image {
    float *data;
    size_t width, height, stride;
};

struct filter {
    struct device *device;
    struct fake_oidn_image color, albedo, normal, output;
    bool hdr, clean, committed;
    bool (*goes_on)(void *user, double done);
    void *user;
};

static bool asked_to(const char *what) {
    const char *wanted = getenv("FAKE_OIDN");
    return wanted && strcmp(wanted, what) == 0;
}

static void fake_oidn_fail(struct device *d, int error, const char *message) {
    if (d->error) return;
    d->error = error;
    d->message = message;
}

API struct device *oidnNewDevice(int type) {
    if (type != 1 || asked_to("device")) return NULL;
    static struct device only;  // no test has two filters at a time
    only = (struct device){0};
    return &only;
}

API void oidnSetDeviceInt(struct device *d, const char *name, int value) {
    if (strcmp(name, "numThreads") != 0 || value < 1)
        fake_oidn_fail(d, INVALID_OPERATION, "no such integer");
}

API void oidnSetDeviceBool(struct device *d, const char *name, bool value) {
    if (strcmp(name, "setAffinity") != 0 || value)
        fake_oidn_fail(d, INVALID_OPERATION, "no such switch");
}

API int oidnGetDeviceInt(struct device *d, const char *name) {
    return d->committed && strcmp(name, "version") == 0 ? 20103 : 0;
}

API void oidnCommitDevice(struct device *d) { d->committed = true; }

API void oidnReleaseDevice(struct device *d) { d->committed = false; }

API int oidnGetDeviceError(struct device *d, const char **message) {
    if (!d) {
        *message = "the fake has no device";
        return INVALID_OPERATION;
    }
    const int error = d->error;
    *message = d->message;
    d->error = 0;
    return error;
}

API struct filter *oidnNewFilter(struct device *d, const char *type) {
    if (!d->committed || strcmp(type, "RT") != 0) return NULL;
    static struct filter only;
    only = (struct filter){.device = d};
    return &only;
}

API void oidnSetSharedFilterImage(struct filter *f, const char *name, void *data, int format,
                                  size_t width, size_t height, size_t offset, size_t pixel_stride,
                                  size_t row_stride) {
    const struct fake_oidn_image image = {data, width, height, pixel_stride};
    if (format != 3 || offset || row_stride || pixel_stride != 3 * sizeof(float))
        fake_oidn_fail(f->device, INVALID_OPERATION, "another layout");
    if (strcmp(name, "color") == 0) f->color = image;
    if (strcmp(name, "albedo") == 0) f->albedo = image;
    if (strcmp(name, "normal") == 0) f->normal = image;
    if (strcmp(name, "output") == 0) f->output = image;
}

API void oidnSetFilterBool(struct filter *f, const char *name, bool value) {
    if (strcmp(name, "hdr") == 0) f->hdr = value;
    if (strcmp(name, "cleanAux") == 0) f->clean = value;
}

API void oidnSetFilterInt(struct filter *f, const char *name, int value) {
    if (strcmp(name, "maxMemoryMB") != 0 || value < 1)
        fake_oidn_fail(f->device, INVALID_OPERATION, "no such integer");
}

API void oidnSetFilterProgressMonitorFunction(struct filter *f,
                                              bool (*goes_on)(void *user, double done),
                                              void *user) {
    f->goes_on = goes_on;
    f->user = user;
}

API void oidnCommitFilter(struct filter *f) { f->committed = true; }

// Whether all values are what the real filter can take.
static bool in_range(const struct fake_oidn_image *image, float low, float high) {
    for (size_t i = 0; i < 3 * image->width * image->height; i++)
        if (!(image->data[i] >= low && image->data[i] <= high)) return false;
    return true;
}

static float fake_oidn_mean_of(const struct fake_oidn_image *image, size_t channel) {
    const size_t pixels = image->width * image->height;
    double sum = 0.0;
    for (size_t i = 0; i < pixels; i++) sum += (double)image->data[3 * i + channel];
    return (float)(sum / (double)pixels);
}

API void oidnExecuteFilter(struct filter *f) {
    struct device *d = f->device;
    const size_t pixels = f->color.width * f->color.height;
    bool black = true;
    for (size_t i = 0; black && i < 3 * pixels; i++) black = f->color.data[i] == 0.0f;
    if (!f->committed || !f->hdr) fake_oidn_fail(d, INVALID_OPERATION, "the filter is not ready");
    if (!in_range(&f->color, 0.0f, 0x1p26f) || !in_range(&f->albedo, 0.0f, 1.0f) ||
        !in_range(&f->normal, -1.0f, 1.0f))
        fake_oidn_fail(d, INVALID_OPERATION, "values out of range");
    if (asked_to("fail") && !black) fake_oidn_fail(d, INVALID_OPERATION, "the fake was asked to");
    if (asked_to("memory") && !black) fake_oidn_fail(d, OUT_OF_MEMORY, "the fake has no memory");
    // Takes ten seconds, so that a test can cancel it.
    for (int i = 0; i < (asked_to("slow") ? 10000 : 1) && f->goes_on && !d->error; i++) {
        if (!f->goes_on(f->user, 0.5)) fake_oidn_fail(d, CANCELLED, "it was cancelled");
        if (asked_to("slow")) usleep(1000);
    }
    if (d->error) return;
    for (size_t c = 0; c < 3; c++) {
        float mean = fake_oidn_mean_of(&f->color, c);
        if (asked_to("nan") && !black) mean = NAN;
        if (asked_to("auxiliary"))
            mean = (f->clean ? 2.0f : 1.0f) * fake_oidn_mean_of(c < 2 ? &f->albedo : &f->normal, c);
        for (size_t i = 0; i < pixels; i++) f->output.data[3 * i + c] = mean;
    }
}

API void oidnReleaseFilter(struct filter *f) { f->committed = false; }
