// SPDX-License-Identifier: Apache-2.0
// Finds and opens Open Image Denoise 2, https://www.openimagedenoise.org.
#include "film/film_oidn.h"

#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/library.h"

// ---- The library ------------------------------------------------------------------------------

// Where `./bootstrap denoiser` installs it, relative to the command and to the library in their
// build folders. Open Image Denoise finds the libraries that it loads itself beside it.
static const char *const oidn_paths[] = {
    "../../denoiser/lib/libOpenImageDenoise.so.2",
    "../denoiser/lib/libOpenImageDenoise.so.2",
};

static const char system_name[] = "libOpenImageDenoise.so.2";

static const struct {
    const char *name;
    size_t offset;
} oidn_functions[] = {
    {"oidnNewDevice", offsetof(struct oidn, NewDevice)},
    {"oidnSetDeviceInt", offsetof(struct oidn, SetDeviceInt)},
    {"oidnSetDeviceBool", offsetof(struct oidn, SetDeviceBool)},
    {"oidnGetDeviceInt", offsetof(struct oidn, GetDeviceInt)},
    {"oidnCommitDevice", offsetof(struct oidn, CommitDevice)},
    {"oidnReleaseDevice", offsetof(struct oidn, ReleaseDevice)},
    {"oidnGetDeviceError", offsetof(struct oidn, GetDeviceError)},
    {"oidnNewFilter", offsetof(struct oidn, NewFilter)},
    {"oidnSetSharedFilterImage", offsetof(struct oidn, SetSharedFilterImage)},
    {"oidnSetFilterBool", offsetof(struct oidn, SetFilterBool)},
    {"oidnSetFilterInt", offsetof(struct oidn, SetFilterInt)},
    {"oidnSetFilterProgressMonitorFunction",
     offsetof(struct oidn, SetFilterProgressMonitorFunction)},
    {"oidnCommitFilter", offsetof(struct oidn, CommitFilter)},
    {"oidnExecuteFilter", offsetof(struct oidn, ExecuteFilter)},
    {"oidnReleaseFilter", offsetof(struct oidn, ReleaseFilter)},
};

// False if a function is missing; *missing is then its name.
static bool find_functions(void *library, struct oidn *out, const char **missing) {
    for (size_t i = 0; i < sizeof oidn_functions / sizeof *oidn_functions; i++) {
        void *function = dlsym(library, oidn_functions[i].name);
        *missing = oidn_functions[i].name;
        if (!function) return false;
        // POSIX allows converting a pointer to an object to a pointer to a function.
        memcpy((char *)out + oidn_functions[i].offset, &function, sizeof function);
    }
    return true;
}

satin_status film_oidn_open(struct log log, struct oidn *out) {
    const char *named = getenv("SATIN_OIDN"), *missing;
    char found[PATH_MAX];
    const size_t paths = sizeof oidn_paths / sizeof *oidn_paths;
    const bool given = named && *named;
    const char *path = given ? named : library_find(oidn_paths, paths, found) ? found : NULL;
    void *library = library_open(path ? path : system_name);
    if (!library && !path)
        return log_fail(log, SATIN_ERROR_INPUT,
                        "option denoise: Open Image Denoise 2 is not installed: "
                        "`./bootstrap denoiser` installs it, or SATIN_OIDN names its %s",
                        system_name);
    if (!library)
        return log_fail(log, SATIN_ERROR_INPUT,
                        "option denoise: cannot open Open Image Denoise%s: %s",
                        given ? ", which SATIN_OIDN names" : "", dlerror());
    struct oidn made;
    if (!find_functions(library, &made, &missing))
        return log_fail(log, SATIN_ERROR_INPUT,
                        "option denoise: %s is not Open Image Denoise 2: it has no %s",
                        path ? path : system_name, missing);
    *out = made;
    return SATIN_OK;
}

// ---- A filter under way -------------------------------------------------------------------------

static const long ASK_NANOSECONDS = 50000000;

// The library reports progress on a thread of its own. Therefore the filter runs on another thread,
// and the caller's thread calls the caller's function.
struct filter_run {
    const struct oidn *oidn;
    struct oidn_device *device;
    struct oidn_filter *filter;
    int error;  // set before `finished`, like `text`
    char *text;
    pthread_mutex_t mutex;  // protects the following members
    pthread_cond_t changed;
    double done;
    bool stop, finished;
};

static bool on_filter_progress(void *user, double done) {
    struct filter_run *run = user;
    pthread_mutex_lock(&run->mutex);
    run->done = done;
    const bool stop = run->stop;
    pthread_mutex_unlock(&run->mutex);
    return !stop;
}

// Errors are stored per thread, so the same thread must ask for them.
static void *execute(void *user) {
    struct filter_run *run = user;
    const char *message = NULL;
    run->oidn->ExecuteFilter(run->filter);
    run->error = run->oidn->GetDeviceError(run->device, &message);
    snprintf(run->text, OIDN_TEXT, "%s", message ? message : "it does not say why");
    pthread_mutex_lock(&run->mutex);
    run->finished = true;
    pthread_cond_signal(&run->changed);
    pthread_mutex_unlock(&run->mutex);
    return NULL;
}

// Calls the caller's function until the filter has finished.
static void report_progress(struct filter_run *run, bool (*goes_on)(void *user, double done),
                            void *user) {
    pthread_mutex_lock(&run->mutex);
    while (!run->finished) {
        struct timespec until;
        const double done = run->done;
        pthread_mutex_unlock(&run->mutex);
        const bool stop = !goes_on(user, done);
        clock_gettime(CLOCK_REALTIME, &until);
        until.tv_nsec += ASK_NANOSECONDS;
        until.tv_sec += until.tv_nsec / 1000000000;
        until.tv_nsec %= 1000000000;
        pthread_mutex_lock(&run->mutex);
        run->stop |= stop;
        if (!run->finished) pthread_cond_timedwait(&run->changed, &run->mutex, &until);
    }
    pthread_mutex_unlock(&run->mutex);
}

int film_oidn_execute(const struct oidn *oidn, struct oidn_device *device,
                      struct oidn_filter *filter, bool (*goes_on)(void *user, double done),
                      void *user, char text[OIDN_TEXT]) {
    struct filter_run run = {.oidn = oidn,
                             .device = device,
                             .filter = filter,
                             .text = text,
                             .mutex = PTHREAD_MUTEX_INITIALIZER,
                             .changed = PTHREAD_COND_INITIALIZER};
    pthread_t thread;
    if (goes_on) oidn->SetFilterProgressMonitorFunction(filter, on_filter_progress, &run);
    oidn->CommitFilter(filter);
    if (goes_on && pthread_create(&thread, NULL, execute, &run) == 0) {
        report_progress(&run, goes_on, user);
        pthread_join(thread, NULL);
    } else {
        // If there is no memory for a thread, the function is not called, but the result is the
        // same.
        execute(&run);
    }
    pthread_cond_destroy(&run.changed);
    pthread_mutex_destroy(&run.mutex);
    return run.error;
}
