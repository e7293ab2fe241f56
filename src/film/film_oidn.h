// SPDX-License-Identifier: Apache-2.0
// Private to film/: the functions of Open Image Denoise 2 that satin uses, declared from its public
// documentation. The library is opened at run time, so it is not needed to build satin.
#ifndef FILM_OIDN_H
#define FILM_OIDN_H

#include <stdbool.h>
#include <stddef.h>

#include "base/log.h"

// The values of its constants.
enum {
    OIDN_CPU = 1,     // OIDN_DEVICE_TYPE_CPU
    OIDN_FLOAT3 = 3,  // OIDN_FORMAT_FLOAT3
    OIDN_NO_ERROR = 0,
    OIDN_UNKNOWN = 1,
    OIDN_OUT_OF_MEMORY = 4,
    OIDN_CANCELLED = 6
};

struct oidn_device;
struct oidn_filter;

// Each member X is the function oidnX of the library. Parameters take effect when the object is
// committed.
struct oidn {
    struct oidn_device *(*NewDevice)(int type);  // NULL on failure
    void (*SetDeviceInt)(struct oidn_device *, const char *name, int value);
    void (*SetDeviceBool)(struct oidn_device *, const char *name, bool value);
    int (*GetDeviceInt)(struct oidn_device *, const char *name);
    void (*CommitDevice)(struct oidn_device *);
    void (*ReleaseDevice)(struct oidn_device *);
    // Returns the first error since the last call, and clears it; if the device is NULL, that of
    // making a device. *message is valid until the next call.
    int (*GetDeviceError)(struct oidn_device *, const char **message);
    struct oidn_filter *(*NewFilter)(struct oidn_device *, const char *type);
    // Uses memory of the caller; strides of 0 mean without gaps.
    void (*SetSharedFilterImage)(struct oidn_filter *, const char *name, void *data, int format,
                                 size_t width, size_t height, size_t byte_offset,
                                 size_t pixel_stride, size_t row_stride);
    void (*SetFilterBool)(struct oidn_filter *, const char *name, bool value);
    void (*SetFilterInt)(struct oidn_filter *, const char *name, int value);
    // `goes_on` is called from time to time, on any thread, with the fraction that is done; false
    // cancels.
    void (*SetFilterProgressMonitorFunction)(struct oidn_filter *,
                                             bool (*goes_on)(void *user, double done), void *user);
    void (*CommitFilter)(struct oidn_filter *);
    void (*ExecuteFilter)(struct oidn_filter *);
    void (*ReleaseFilter)(struct oidn_filter *);
};

// Opens the library: only the file that the environment variable SATIN_OIDN names, if it is set;
// else the one that `./bootstrap denoiser` installed in the build folder, or the system's.
// SATIN_ERROR_INPUT, with one logged line, if there is none or if it is not version 2.
satin_status film_oidn_open(struct log log, struct oidn *out);

enum { OIDN_TEXT = 256 };

// Commits and executes a filter. Returns the first error since the last call of GetDeviceError,
// with its message in `text`. Meanwhile `goes_on` (may be NULL) is called on this thread with the
// fraction that is done; false cancels.
int film_oidn_execute(const struct oidn *oidn, struct oidn_device *device,
                      struct oidn_filter *filter, bool (*goes_on)(void *user, double done),
                      void *user, char text[OIDN_TEXT]);

#endif
