// SPDX-License-Identifier: Apache-2.0
// Snapshots of an image whose sums are filled in by hand, with other numbers of samples in every
// pixel: they are the film that the image would have if it ended then; a tile in the middle of a
// sample is left as it was, and a worker leaves its tile between two samples; they come when there
// is something to show, and not too often.
#include <pthread.h>
#include <sched.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "render/render_image.h"

enum { WIDTH = 37, HEIGHT = 21 };

// The snapshots of a render.
struct shown {
    struct satin_film *copy;  // of the last one; owned
    int count;
};

static void copy_snapshot(void *user, const satin_film *film) {
    struct shown *shown = user;
    const size_t bytes = (size_t)film->width * (size_t)film->height * sizeof(float);
    satin_film_free(shown->copy);
    shown->copy = film_new(film->width, film->height, (const char *const *)film->channel_name,
                           film->channel_count);
    assert_non_null(shown->copy);
    for (int i = 0; i < film->channel_count; i++)
        memcpy(shown->copy->channel[i], film->channel[i], bytes);
    shown->count++;
}

static struct render snapshot_begin(satin_integrator integrator, struct shown *shown, bool beauty) {
    struct render r = {.options = satin_options_default};
    r.options.integrator = integrator;
    r.scene.film.crop_width = WIDTH;
    r.scene.film.crop_height = HEIGHT;
    r.scene.film.alpha = true;
    r.progress = (struct render_progress){.stage = STAGE_IMAGE, .course = COURSE_TWO_PASS};
    r.callbacks = (satin_callbacks){
        .snapshot = copy_snapshot, .snapshot_user = shown, .snapshot_beauty = beauty};
    r.pool = parallel_new(2);
    r.image = render_image_new(&r.scene, &r.options);
    assert_true(r.pool && r.image && render_snapshot_memory(&r, r.image));
    r.image->state = IMAGE_SAMPLING;
    return r;
}

// Makes a snapshot, whatever the time. The image points to the AOVs of a scene that has moved
// since.
static void show(struct render *r) {
    r->image->aovs = &r->scene.hints.aovs;
    if (r->snapshot) r->snapshot->next = 0.0;
    render_snapshot_send(r);
}

static void snapshot_end(struct render *r, struct shown *shown) {
    render_snapshot_free(r->snapshot);
    render_image_free(r->image);
    parallel_free(r->pool);
    satin_film_free(shown->copy);
}

static struct image_pixel *snapshot_pixel(struct render *r, int x, int y) {
    return &r->image->pixel[y * WIDTH + x];
}

// Samples that weigh 2 each and have these values.
static void snapshot_sample(struct image_pixel *p, uint32_t samples, float L) {
    p->samples = samples;
    p->weight = 2.0f * (float)samples;
    p->beauty = rgb_make(p->weight * L, 0.5f * p->weight * L, 0.0f);
    p->layer[SHADE_DIRECT] = rgb_grey(0.25f * p->weight * L);
    p->layer[SHADE_EMISSION] = rgb_grey(0.125f * p->weight * L);
    p->depth = p->weight * (L + 1.0f);
    p->alpha = 0.5f * p->weight;
    p->used.count = 3 * samples;
}

static float snapshot_value(const struct satin_film *film, const char *channel, int x, int y) {
    const float *plane = satin_film_channel(film, channel);
    assert_non_null(plane);
    return plane[y * WIDTH + x];
}

static void a_snapshot_is_the_film_of_the_moment(void **state) {
    (void)state;
    struct shown shown = {0};
    struct render r = snapshot_begin(SATIN_TWO_PASS, &shown, false);
    for (int y = 0; y < HEIGHT; y += 16)
        for (int x = 0; x < WIDTH; x += 16)
            snapshot_sample(snapshot_pixel(&r, x, y), 1, 1.0f + (float)(x + y));
    show(&r);
    assert_float_equal(snapshot_value(shown.copy, "R", 31, 15), 17.0f, 0.0f);
    // Most pixels have samples of their own now, and no two neighbours the same number of them.
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            if ((3 * x + 5 * y) % 7)
                snapshot_sample(snapshot_pixel(&r, x, y), 1u << (3 * x + y) % 11,
                                (float)(x * y) + 0.1f);
    snapshot_pixel(&r, 9, 9)->emission =
        (struct image_emission){.sum = rgb_grey(100.0f), .weight = 3.0f};
    snapshot_pixel(&r, 0, 0)->dropped = 2;
    show(&r);
    assert_int_equal(shown.count, 2);
    bool any;
    render_image_film(&r, &any);
    const struct satin_film *film = r.image->film;
    assert_int_equal(shown.copy->channel_count, film->channel_count);
    for (int i = 0; i < film->channel_count; i++) {
        assert_string_equal(shown.copy->channel_name[i], film->channel_name[i]);
        assert_memory_equal(shown.copy->channel[i], film->channel[i],
                            WIDTH * HEIGHT * sizeof(float));
    }
    snapshot_end(&r, &shown);
}

static void the_beauty_alone_is_enough_for_a_picture(void **state) {
    (void)state;
    struct shown shown = {0};
    struct render r = snapshot_begin(SATIN_TWO_PASS, &shown, true);
    snapshot_sample(snapshot_pixel(&r, 0, 0), 4, 3.0f);
    show(&r);
    assert_int_equal(shown.copy->channel_count, 4);
    assert_float_equal(snapshot_value(shown.copy, "R", 15, 15), 3.0f, 0.0f);
    assert_float_equal(snapshot_value(shown.copy, "A", 15, 15), 0.5f, 0.0f);
    snapshot_end(&r, &shown);
}

// Worker 1 has the tile of (16, 0); the calling thread has that of (32, 0), and may read it.
static void a_tile_that_is_being_sampled_stays_as_it_was(void **state) {
    (void)state;
    struct shown shown = {0};
    struct render r = snapshot_begin(SATIN_TWO_PASS, &shown, true);
    for (int x = 0; x < WIDTH; x += 16) snapshot_sample(snapshot_pixel(&r, x, 0), 1, 1.0f);
    show(&r);
    render_tile_begin(r.image, 1, 1);
    render_tile_begin(r.image, 2, 0);
    for (int x = 0; x < WIDTH; x += 16) snapshot_sample(snapshot_pixel(&r, x, 0), 2, 2.0f);
    show(&r);
    assert_float_equal(snapshot_value(shown.copy, "R", 0, 0), 2.0f, 0.0f);
    assert_float_equal(snapshot_value(shown.copy, "R", 16, 0), 1.0f, 0.0f);
    assert_float_equal(snapshot_value(shown.copy, "R", 32, 0), 2.0f, 0.0f);
    render_tile_end(r.image, 1);
    render_tile_end(r.image, 2);
    show(&r);
    assert_float_equal(snapshot_value(shown.copy, "R", 16, 0), 2.0f, 0.0f);
    snapshot_end(&r, &shown);
}

// A worker that leaves its tile between two samples.
struct yielding {
    struct render_image *image;
    atomic_bool begun, ends;
};

static void *sample_and_yield(void *ctx) {
    struct yielding *y = ctx;
    render_tile_begin(y->image, 1, 1);
    atomic_store(&y->begun, true);
    while (!atomic_load(&y->ends)) render_tile_yield(y->image, 1, 1);
    render_tile_end(y->image, 1);
    return NULL;
}

static void a_worker_leaves_its_tile_to_a_snapshot(void **state) {
    (void)state;
    struct shown shown = {0};
    struct render r = snapshot_begin(SATIN_TWO_PASS, &shown, true);
    struct yielding y = {.image = r.image};
    pthread_t thread;
    for (int x = 0; x < WIDTH; x += 16) snapshot_sample(snapshot_pixel(&r, x, 0), 1, 1.0f);
    assert_int_equal(pthread_create(&thread, NULL, sample_and_yield, &y), 0);
    while (!atomic_load(&y.begun)) sched_yield();
    // A busy machine may leave the worker no time in some of the snapshots.
    for (int i = 0; i < 1000 && (!shown.copy || !(snapshot_value(shown.copy, "R", 16, 0) > 0.0f));
         i++)
        show(&r);
    assert_float_equal(snapshot_value(shown.copy, "R", 16, 0), 1.0f, 0.0f);
    assert_false(atomic_load(&r.image->tiles_wanted));
    atomic_store(&y.ends, true);
    pthread_join(thread, NULL);
    snapshot_end(&r, &shown);
}

static void snapshots_come_while_the_image_is_sampled(void **state) {
    (void)state;
    struct shown shown = {0};
    struct render r = snapshot_begin(SATIN_TWO_PASS, &shown, true);
    for (enum image_state before = IMAGE_EMPTY; before < IMAGE_SAMPLING; before++) {
        r.image->state = before;
        show(&r);
    }
    r.image->state = IMAGE_SAMPLING;
    r.progress.stage = STAGE_RECORDS;
    show(&r);
    r.progress.stage = STAGE_IMAGE;
    r.progress.cancelled_in = STAGE_IMAGE;
    show(&r);
    r.progress.cancelled_in = STAGE_SETUP;
    assert_int_equal(shown.count, 0);
    show(&r);
    assert_int_equal(shown.count, 1);
    render_snapshot_send(&r);
    assert_int_equal(shown.count, 1);
    snapshot_end(&r, &shown);
}

// A fiftieth of the time of all threads, a tenth of that of one, and at most once a second.
static void snapshots_are_rare_if_they_are_slow(void **state) {
    (void)state;
    assert_float_equal(render_budget_snapshot(0.001, 1), 1.0, 0.0);
    assert_float_equal(render_budget_snapshot(0.1, 1), 5.0, 1e-9);
    assert_float_equal(render_budget_snapshot(0.1, 2), 2.5, 1e-9);
    assert_float_equal(render_budget_snapshot(0.2, 64), 2.0, 1e-9);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_snapshot_is_the_film_of_the_moment),
        cmocka_unit_test(the_beauty_alone_is_enough_for_a_picture),
        cmocka_unit_test(a_tile_that_is_being_sampled_stays_as_it_was),
        cmocka_unit_test(a_worker_leaves_its_tile_to_a_snapshot),
        cmocka_unit_test(snapshots_come_while_the_image_is_sampled),
        cmocka_unit_test(snapshots_are_rare_if_they_are_slow),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
