// SPDX-License-Identifier: Apache-2.0
// The library in one page: load a scene, render it with progress and a way to cancel, read the
// channels. Build: cc example.c $(pkg-config --cflags --libs satin)
#include <satin/render.h>
#include <stdio.h>
#include <stdlib.h>

// What the callbacks have in common.
struct session {
    double limit;  // seconds after which the user loses patience
};

static void on_message(void *user, satin_log_severity severity, const char *message) {
    (void)user;
    fprintf(stderr, "%s%s\n", severity == SATIN_LOG_ERROR ? "" : "note: ", message);
}

// Called about ten times a second; returning true cancels.
static bool on_progress(void *user, const satin_progress *progress) {
    const struct session *session = user;
    fprintf(stderr, "\r%s %.0f %% \033[K", progress->stage, 100.0 * progress->done);
    return progress->elapsed > session->limit;
}

static float mean(const float *channel, size_t count) {
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) sum += channel[i];
    return (float)(sum / (double)count);
}

int main(int argc, char **argv) {
    if (argc < 2) {
        fprintf(stderr, "example SCENE.xml [SECONDS]\n");
        return 2;
    }
    struct session session = {.limit = argc > 2 ? atof(argv[2]) : 3600.0};

    // A failed call has logged the reason, with its line in the scene.
    satin_scene *scene = NULL;
    if (satin_scene_load(argv[1], NULL, 0, on_message, NULL, &scene) != SATIN_OK) return 1;

    // Options are a plain struct; start from a preset and change fields.
    satin_options options = satin_options_default;
    satin_options_preset(&options, SATIN_DRAFT);
    options.width = 64;
    options.height = 48;

    satin_callbacks callbacks = {
        .log = on_message, .progress = on_progress, .progress_user = &session};
    satin_film *film = NULL;
    satin_status status = satin_render(scene, &options, &callbacks, &film);
    fprintf(stderr, "\r\033[K%s\n", satin_status_text(status));

    // A cancelled render leaves the image so far, if there is one.
    if (film) {
        int width, height;
        const char *name;
        satin_film_size(film, &width, &height);
        for (int i = 0; (name = satin_film_channel_name(film, i)); i++)
            printf("%-24s mean %g\n", name,
                   mean(satin_film_channel(film, name), (size_t)width * (size_t)height));
        satin_film_write_exr(film, "example.exr", on_message, NULL);
    }
    satin_film_free(film);
    satin_scene_free(scene);
    return status == SATIN_OK || status == SATIN_CANCELLED ? 0 : 1;
}
