// SPDX-License-Identifier: Apache-2.0
// The animation of `satin render`: its camera path, which frames are rendered, and their files.
#ifndef APP_ANIMATION_H
#define APP_ANIMATION_H

#include "animation/animation.h"
#include "apps/app_render.h"

struct app_animation {
    struct animation_path path;
    satin_animation frames;  // all but the functions
    satin_pose *pose;        // of each object at rest, owned
};

// Reads the camera path of the request, and checks the arguments of the animation. Reports an error
// and returns APP_WRONG or APP_FAILED. Without an animation it only checks that there are none. To
// be freed in any case.
int app_animation_read(const struct app_render_request *r, struct app_animation *out);
// Sets which frames are rendered, when the scene is there. Reports frames that the path does not
// have and returns APP_WRONG.
int app_animation_choose(const struct app_render_request *r, const satin_scene *scene,
                         struct app_animation *animation);
void app_animation_free(struct app_animation *animation);

// The limit of memory that the arguments set [bytes], 0 for none; the scene's own is not known
// before it is read.
int64_t app_animation_memory(const struct app_render_request *r);
// Loads the scene of the request, with all objects at rest, and checks that they can move as they
// do in the first frame that is rendered.
satin_status app_animation_load(const struct app_render_request *r,
                                const struct app_animation *animation,
                                struct app_progress *progress, satin_scene **scene);
// Loads the scene of frame `number`. Only errors are reported, as the warnings are those of the
// scene at rest.
satin_status app_animation_scene(const struct app_render_request *r,
                                 const struct app_animation *animation, int number,
                                 satin_scene **scene);

// The name of an animation's checkpoint: that of the image with A-B of --frames, or `all`, for the
// number of a frame. From malloc; NULL if there is no memory.
char *app_frame_checkpoint(const struct app_render_request *r);
// Sets *out to the request with the outputs of frame `number` as its own. To be freed in any case.
// Reports lack of memory and returns APP_FAILED.
int app_frame_begin(const struct app_render_request *r, int number, struct app_render_request *out);
void app_frame_end(struct app_render_request *frame);
// Checks that no file of frame `number`, whose outputs `frame` has, is another output of one of the
// frames from `first` to `last`. Reports it and returns APP_WRONG.
int app_frame_check_names(const struct app_render_request *r, int number,
                          const struct app_render_request *frame, int first, int last);
// Sets *complete to whether the image and the statistics of frame `number` exist, made by this job;
// its PNG is then written again. SATIN_ERROR_INPUT, logged, if the image is of another job or frame
// or cannot be read.
satin_status app_frame_complete(const struct app_render_request *frame, int number, const char *job,
                                struct log log, bool *complete);

#endif
