// SPDX-License-Identifier: Apache-2.0
// Messages and progress on stderr: on a terminal a bar that is redrawn in place, elsewhere a line
// per finished stage. The function that prints the progress also ends a render after a signal.
#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

#include "apps/app.h"
#include "base/stats.h"

static const double REDRAW_SECONDS = 0.1;
enum { LINE_MAX_BYTES = 512, BAR_MAX = 40 };

// `timeout` sends a signal to a process and then to its group; a closing terminal sends one to the
// group and then to its foreground. Signals within this time after the first one, in ns, count as
// one.
static const long long SAME_WISH_NS = 1000000000;

// The time of the first signal on the monotonic clock, in ns; 0 if there was none. This and
// `reading` are the only state that signal handlers access.
static atomic_llong first_signal;

// Whether the scene is being read. No progress function is called then, and there is no image yet.
static atomic_bool reading;

// A second after the first signal. A scene that has not been read by then would delay the end for
// as long as that takes.
static void on_alarm(int number) {
    static const char message[] = "satin: error: cancelled while the scene was read\n";
    (void)number;
    if (!atomic_load(&reading)) return;
    // The message is lost if no process reads standard error.
    if (write(STDERR_FILENO, message, sizeof message - 1) < 0) _exit(APP_CANCELLED);
    _exit(APP_CANCELLED);
}

static void on_signal(int number) {
    struct timespec time;
    const int error = errno;
    clock_gettime(CLOCK_MONOTONIC, &time);
    const long long now = 1000000000ll * time.tv_sec + time.tv_nsec;
    long long first = 0;
    if (atomic_compare_exchange_strong(&first_signal, &first, now > 0 ? now : 1)) {
        alarm(1);
    } else if (now - first > SAME_WISH_NS) {
        signal(number, SIG_DFL);
        raise(number);
    }
    errno = error;
}

void app_catch_signals(void) {
    static const int stop[] = {SIGINT, SIGTERM, SIGHUP, SIGUSR1};
    struct sigaction before, action = {.sa_handler = on_signal, .sa_flags = SA_RESTART};
    struct sigaction timer = {.sa_handler = on_alarm, .sa_flags = SA_RESTART};
    sigemptyset(&action.sa_mask);
    sigemptyset(&timer.sa_mask);
    sigaction(SIGALRM, &timer, NULL);
    for (size_t i = 0; i < sizeof stop / sizeof *stop; i++) {
        // Under nohup, SIGHUP from a closing terminal is ignored.
        const bool ignored = sigaction(stop[i], NULL, &before) == 0 && before.sa_handler == SIG_IGN;
        if (stop[i] != SIGHUP || !ignored) sigaction(stop[i], &action, NULL);
    }
}

void app_ignore_closed_pipes(void) { signal(SIGPIPE, SIG_IGN); }

void app_set_reading(bool scene_is_read) {
    atomic_store(&reading, scene_is_read);
    if (scene_is_read && app_interrupted()) alarm(1);  // the first one was before there was a scene
}

bool app_interrupted(void) { return atomic_load(&first_signal) != 0; }

// Whether messages are not printed, the last error that was not, and whether one was.
static bool is_silent, is_error_printed;
static char silenced[1024];

void app_begin_silence(void) { is_silent = true; }

void app_end_silence(const char *prefix, int number) {
    is_silent = false;
    if (!*silenced) return;
    char before[64];
    snprintf(before, sizeof before, prefix, number);
    fprintf(stderr, "%s%s\n", before, silenced);  // in one piece, as others print too
    is_error_printed = true;
    *silenced = 0;
}

bool app_has_error(void) { return is_error_printed || *silenced; }

static void erase_bar(struct app_progress *progress) {
    if (!progress || !progress->bar) return;
    fputs("\r\033[K", stderr);
    progress->bar = false;
}

static void print(struct app_progress *progress, const char *prefix, const char *message) {
    if (is_silent) return;
    erase_bar(progress);
    fprintf(stderr, "%s%s\n", prefix, message);
    fflush(stderr);
}

static void print_error(struct app_progress *progress, const char *prefix, const char *message) {
    if (is_silent)
        snprintf(silenced, sizeof silenced, "%s", message);
    else
        is_error_printed = true;
    print(progress, prefix, message);
}

void app_log_file(void *user, satin_log_severity severity, const char *message) {
    struct app_progress *progress = user;
    if (severity == SATIN_LOG_ERROR)
        print_error(progress, "", message);
    else if (severity == SATIN_LOG_WARNING && !(progress && progress->quiet))
        print(progress, "satin: warning: ", message);
}

void app_log_file_errors(void *user, satin_log_severity severity, const char *message) {
    if (severity == SATIN_LOG_ERROR) app_log_file(user, severity, message);
}

void app_log(void *user, satin_log_severity severity, const char *message) {
    if (severity == SATIN_LOG_ERROR)
        print_error(user, "satin: error: ", message);
    else
        app_log_file(user, severity, message);
}

// Formats a positive number with three digits and a prefix: 12.3 M.
static void print_rate(char *out, size_t bytes, double rate) {
    static const char *const prefix[] = {"", " k", " M", " G", " T"};
    int i = 0;
    while (rate >= 999.5 && i < 4) {
        rate /= 1000.0;
        i++;
    }
    int decimals = rate >= 99.95 || (i == 0 && rate >= 10.0) ? 0 : 1;
    snprintf(out, bytes, "%.*f%s", decimals, rate, prefix[i]);
}

static void print_time(char *out, size_t bytes, double seconds) {
    long s = seconds < 1e7 ? lround(seconds) : 9999999;
    if (s >= 3600)
        snprintf(out, bytes, "%ld:%02ld:%02ld", s / 3600, s / 60 % 60, s % 60);
    else
        snprintf(out, bytes, "%ld:%02ld", s / 60, s % 60);
}

static int terminal_columns(void) {
    struct winsize size;
    if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
    return 80;
}

// Prints `stage [####----] 45 %  1.2 M rays/s  0:12 left`, with the time until the whole render
// ends, cut to one column less than the terminal has, because writing to the last column would
// wrap.
static void draw_bar(struct app_progress *p, const satin_progress *now) {
    char tail[128], rate[32], left[32], line[LINE_MAX_BYTES];
    double done = fmin(fmax(now->done, 0.0), 1.0);
    int n = snprintf(tail, sizeof tail, "%3.0f %%", 100.0 * done);
    if (now->rate > 0.0) {
        print_rate(rate, sizeof rate, now->rate);
        n += snprintf(tail + n, sizeof tail - (size_t)n, "  %s %.24s/s", rate, now->unit);
    }
    if (now->left >= 0.0) {
        print_time(left, sizeof left, now->left);
        snprintf(tail + n, sizeof tail - (size_t)n, "  %s left", left);
    }
    int columns = terminal_columns() - 1;
    if (columns > LINE_MAX_BYTES - 1) columns = LINE_MAX_BYTES - 1;
    int width = columns - 15 - 3 - (int)strlen(tail);
    if (width > BAR_MAX) width = BAR_MAX;
    char name[32];
    if (now->frame > 0)
        snprintf(name, sizeof name, "frame %d/%d", now->frame, now->frames);
    else
        snprintf(name, sizeof name, "%s", now->stage);
    n = snprintf(line, sizeof line, "%-14.14s ", name);
    if (width >= 4) {
        line[n++] = '[';
        for (int i = 0; i < width; i++) line[n++] = i < (int)(done * width + 0.5) ? '#' : '-';
        line[n++] = ']';
        line[n++] = ' ';
    }
    snprintf(line + n, sizeof line - (size_t)n, "%s", tail);
    line[columns > 0 ? columns : 0] = 0;
    fprintf(stderr, "\r%s\033[K", line);
    fflush(stderr);
    p->bar = true;
}

static void finish_stage(struct app_progress *p) {
    if (!p->stage) return;
    if (!p->quiet && !p->terminal) {
        char rate[32];
        print_rate(rate, sizeof rate, p->rate);
        fprintf(stderr, "%s: %.2f s", p->stage, p->last - p->stage_start);
        if (p->rate > 0.0) fprintf(stderr, ", %s %s/s", rate, p->unit);
        fputc('\n', stderr);
    }
    p->stage = NULL;
}

void app_progress_start(struct app_progress *progress, bool quiet) {
    // A terminal that cannot move the cursor gets lines instead of a bar.
    const char *kind = getenv("TERM");
    bool dumb = kind && strcmp(kind, "dumb") == 0;
    *progress =
        (struct app_progress){.quiet = quiet, .terminal = isatty(STDERR_FILENO) == 1 && !dumb};
}

bool app_progress_update(void *user, const satin_progress *now) {
    struct app_progress *p = user;
    double time = stats_wall();
    // A change of the stage, which is one static text during all of it, ends the line of the stage
    // before.
    if (p->stage != now->stage) {
        finish_stage(p);
        p->stage = now->stage;
        p->stage_start = p->last;
        p->last_draw = 0.0;
    }
    p->last = now->elapsed;
    p->rate = now->rate;
    snprintf(p->unit, sizeof p->unit, "%s", now->unit ? now->unit : "items");
    if (app_progress_bar(p) && time - p->last_draw >= REDRAW_SECONDS) {
        draw_bar(p, now);
        p->last_draw = time;
    }
    return app_interrupted();
}

void app_progress_end(struct app_progress *progress) {
    erase_bar(progress);
    finish_stage(progress);
    fflush(stderr);
}
