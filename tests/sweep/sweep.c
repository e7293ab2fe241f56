// SPDX-License-Identifier: Apache-2.0
// Renders scenes x seeds x presets x first passes, small, and flags deviations: see cell.h, and
// docs/experiments/sweep.md for how to read what it prints.
//
//     sweep [--seeds A:B] [--presets NAME,...] [--first NAME,...] [--size N] [--jobs N] [--limit S]
//           [--threshold T] [--worst] [--out DIR] [-D NAME=VALUE] [--set NAME=VALUE] SCENE.xml ...
//
// A process of its own renders a cell, that is one scene with one preset and one first pass, so
// that a crash or a hang ends that cell alone. Exit status: 0 no flag, 1 flags, 2 wrong arguments.
#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "blocks.h"
#include "cell.h"

enum { NAMES = 8, JOBS = 64, DEFINES = 16 };

struct sweep {
    struct plan plan;
    satin_define define[DEFINES];
    const char *preset[NAMES], *first[NAMES];
    int presets, firsts, jobs;
    char **scene;
    int scenes;
};

struct sweep_job {
    pid_t process;  // 0: none
    int cell;
    FILE *out;
};

static void sweep_fail(const char *what, const char *value) {
    fprintf(stderr, "sweep: %s '%s'\n", what, value);
    exit(2);
}

// ---- Arguments ----------------------------------------------------------------------------------

// Splits a list at its commas, in place.
static int split(char *list, const char **name) {
    int count = 0;
    for (char *at = strtok(list, ","); at; at = strtok(NULL, ",")) {
        if (count == NAMES) sweep_fail("too many names at", at);
        name[count++] = at;
    }
    return count;
}

static int sweep_number(const char *name, const char *text, int least, int most) {
    char *end;
    long value = strtol(text, &end, 10);
    if (*end || end == text || value < least || value > most) sweep_fail(name, text);
    return (int)value;
}

static void read_seeds(struct plan *plan, const char *text) {
    int end, read = 0;
    if (sscanf(text, "%d:%d%n", &plan->seed_first, &end, &read) != 2 || text[read] ||
        plan->seed_first < 0 || end - plan->seed_first < BLOCK_SEEDS_LEAST ||
        end - plan->seed_first > 64)
        sweep_fail("--seeds wants FIRST:END, 5 to 64 of them, not", text);
    plan->seed_count = end - plan->seed_first;
}

// Splits NAME=VALUE in place.
static char *cut(char *text) {
    char *at = strchr(text, '=');
    if (!at) sweep_fail("NAME=VALUE is wanted, not", text);
    *at = '\0';
    return at + 1;
}

static void read_pair(struct sweep *sweep, char name, char *text) {
    struct plan *plan = &sweep->plan;
    const char *value = cut(text);
    if (name == 'D') {
        if (plan->define_count == DEFINES) sweep_fail("too many -D at", text);
        sweep->define[plan->define_count++] = (satin_define){text, value};
    } else {
        if (plan->setting_count == CELL_SETTINGS) sweep_fail("too many --set at", text);
        plan->setting[plan->setting_count++] = (satin_setting){text, value};
    }
}

static void read_argument(struct sweep *sweep, const char *name, char *value) {
    struct plan *plan = &sweep->plan;
    if (strcmp(name, "--seeds") == 0) {
        read_seeds(plan, value);
    } else if (strcmp(name, "--presets") == 0) {
        sweep->presets = split(value, sweep->preset);
    } else if (strcmp(name, "--first") == 0) {
        sweep->firsts = split(value, sweep->first);
    } else if (strcmp(name, "--size") == 0) {
        plan->size = sweep_number("--size wants a multiple of 8, not", value, 8, 1024);
        if (plan->size % BLOCK_SIZE) sweep_fail("--size wants a multiple of 8, not", value);
    } else if (strcmp(name, "--jobs") == 0) {
        sweep->jobs = sweep_number("--jobs wants 1 to 64, not", value, 1, JOBS);
    } else if (strcmp(name, "--limit") == 0) {
        plan->limit = sweep_number("--limit wants seconds, not", value, 0, 1000000);
    } else if (strcmp(name, "--threshold") == 0) {
        plan->threshold = sweep_number("--threshold wants whole sigmas, not", value, 1, 1000);
    } else if (strcmp(name, "--out") == 0) {
        plan->folder = value;
    } else if (strcmp(name, "-D") == 0) {
        read_pair(sweep, 'D', value);
    } else if (strcmp(name, "--set") == 0) {
        read_pair(sweep, 's', value);
    } else {
        sweep_fail("unknown argument", name);
    }
}

static void read_arguments(struct sweep *sweep, int argc, char **argv) {
    int at = 1;
    for (; at < argc && argv[at][0] == '-'; at++) {
        if (strcmp(argv[at], "--worst") == 0) {
            sweep->plan.worst = true;
        } else {
            if (at + 1 == argc) sweep_fail("a value is missing after", argv[at]);
            read_argument(sweep, argv[at], argv[at + 1]);
            at++;
        }
    }
    sweep->scene = argv + at;
    sweep->scenes = argc - at;
    sweep->plan.define = sweep->define;
    if (!sweep->scenes) sweep_fail("no scene after", argv[argc - 1]);
}

// ---- Processes ----------------------------------------------------------------------------------

// Cells are counted with the first pass fastest, then the preset, then the scene.
static struct test_cell sweep_cell_at(const struct sweep *sweep, int i) {
    return (struct test_cell){sweep->scene[i / (sweep->presets * sweep->firsts)],
                              sweep->preset[i / sweep->firsts % sweep->presets],
                              sweep->first[i % sweep->firsts]};
}

static void sweep_start(const struct sweep *sweep, struct sweep_job *job, int i,
                        struct cell_tally *tally) {
    const struct test_cell cell = sweep_cell_at(sweep, i);
    job->out = tmpfile();
    if (!job->out) sweep_fail("no temporary file:", strerror(errno));
    fflush(stdout);
    job->cell = i;
    job->process = fork();
    if (job->process < 0) sweep_fail("no process:", strerror(errno));
    if (job->process) return;
    struct timespec begin, end;
    clock_gettime(CLOCK_MONOTONIC, &begin);
    cell_run(&sweep->plan, &cell, tally, job->out);
    clock_gettime(CLOCK_MONOTONIC, &end);
    tally->seconds =
        (double)(end.tv_sec - begin.tv_sec) + 1e-9 * (double)(end.tv_nsec - begin.tv_nsec);
    fflush(job->out);
    _exit(0);
}

static void sweep_print_file(FILE *file) {
    char buffer[4096];
    rewind(file);
    for (size_t n; (n = fread(buffer, 1, sizeof buffer, file)) > 0;)
        (void)fwrite(buffer, 1, n, stdout);
    fclose(file);
}

// Prints what the child has found, and how it ended if not well.
static void sweep_finish(const struct sweep *sweep, struct sweep_job *job, int status,
                         struct cell_tally *tally) {
    const struct test_cell cell = sweep_cell_at(sweep, job->cell);
    sweep_print_file(job->out);
    job->process = 0;
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
        const bool late = WIFSIGNALED(status) && WTERMSIG(status) == SIGALRM;
        cell_line(&cell, "flag", late ? "late" : "crash", tally->seed, stdout);
        if (late)
            printf(" not done in %d s\n", sweep->plan.limit);
        else if (WIFSIGNALED(status))
            printf(" %s\n", strsignal(WTERMSIG(status)));
        else
            printf(" exit status %d\n", WEXITSTATUS(status));
        cell_command(&sweep->plan, &cell, tally->seed, stdout);
        tally->flags++;
    }
    fflush(stdout);
}

// Waits for one child.
static void wait_one(const struct sweep *sweep, struct sweep_job *job, struct cell_tally *tallies) {
    int status;
    pid_t process = wait(&status);
    for (int j = 0; j < sweep->jobs; j++)
        if (job[j].process && job[j].process == process)
            sweep_finish(sweep, &job[j], status, &tallies[job[j].cell]);
}

static void sweep_run(const struct sweep *sweep, int cells, struct cell_tally *tallies) {
    struct sweep_job job[JOBS] = {0};
    int running = 0;
    for (int next = 0; next < cells || running; running--) {
        for (int j = 0; j < sweep->jobs && next < cells; j++) {
            if (job[j].process) continue;
            sweep_start(sweep, &job[j], next, &tallies[next]);
            next++;
            running++;
        }
        wait_one(sweep, job, tallies);
    }
}

// ---- Totals -------------------------------------------------------------------------------------

static int print_totals(const struct cell_tally *tallies, int cells) {
    struct cell_tally all = {0};
    for (int i = 0; i < cells; i++) {
        const struct cell_tally *t = &tallies[i];
        all.renders += t->renders;
        all.flags += t->flags;
        all.blocks += t->blocks;
        all.few += t->few;
        all.few_blocks += t->few_blocks;
        all.records += t->records;
        all.seconds += t->seconds;
        all.worst = t->worst > all.worst ? t->worst : all.worst;
        for (int k = 0; k < CELL_HISTOGRAM; k++) all.histogram[k] += t->histogram[k];
    }
    long evaluated = 0;
    for (int k = 0; k < CELL_HISTOGRAM; k++) evaluated += all.histogram[k];
    printf("renders %d  cells %d  seconds %.0f  blocks evaluated %ld\n", all.renders, cells,
           all.seconds, evaluated);
    printf("flags %d  blocks %d  refused or not finite %.0f  worst score %.1f\n", all.flags,
           all.blocks, all.records, all.worst);
    printf("few %d  blocks %d\n", all.few, all.few_blocks);
    printf("blocks by score:");
    for (int k = 0; k < CELL_HISTOGRAM; k++)
        if (all.histogram[k]) printf(" %d:%ld", k, all.histogram[k]);
    printf("\n");
    return all.flags;
}

int main(int argc, char **argv) {
    struct sweep sweep = {.plan = {.seed_count = 10, .size = 64, .limit = 300, .threshold = 6},
                          .preset = {"draft"},
                          .first = {"precomputed"},
                          .presets = 1,
                          .firsts = 1,
                          .jobs = 1};
    read_arguments(&sweep, argc, argv);
    const int cells = sweep.scenes * sweep.presets * sweep.firsts;
    const size_t bytes = (size_t)cells * sizeof(struct cell_tally);
    struct cell_tally *tallies =
        mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (tallies == MAP_FAILED) sweep_fail("no memory:", strerror(errno));
    sweep_run(&sweep, cells, tallies);
    int flags = print_totals(tallies, cells);
    munmap(tallies, bytes);
    return flags > 0;
}
