// SPDX-License-Identifier: Apache-2.0
// Reads the arguments of `satin render`. Errors in them are found before the scene is read.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "apps/app.h"
#include "apps/app_render.h"

enum {
    FLAG_OUTPUT,
    FLAG_PNG,
    FLAG_PREVIEW,
    FLAG_STATS,
    FLAG_LOAD,
    FLAG_SAVE,
    FLAG_CHECKPOINT,
    FLAG_CHECKPOINT_EVERY,
    FLAG_RESUME,
    FLAG_DEFINE,
    FLAG_SET,
    FLAG_SENSOR,
    FLAG_ANIMATION,
    FLAG_FRAMES,
    FLAG_DISPLAY,
    FLAG_CROP,
    FLAG_EXPOSURE,
    FLAG_TONEMAP,
    FLAG_FLOAT,
    FLAG_COMPRESSION,
    FLAG_STRICT,
    FLAG_LENIENT,
    FLAG_QUIET,
    FLAG_HELP,
    FLAG_FIRST_OPTION  // from here on --name is the option of that name; a Boolean without a value
                       // is on
};

const struct app_flag app_render_flags[] = {
    {"--output", "-o", "OUT.exr",
     "The image, an OpenEXR file with all layers; or OUT.png, the beauty alone."},
    {"--png", NULL, "[FILE.png]", "The beauty as a PNG too, beside the image if no name is given."},
    {"--preview", NULL, "FILE.png",
     "The beauty so far, written again about every second while the image is rendered."},
    {"--stats", NULL, "FILE.json", "Statistics as JSON; - for standard output."},
    {"--load-cache", NULL, "FILE",
     "Begins with the cache records of a render of the same scene, with any sensor."},
    {"--save-cache", NULL, "FILE",
     "Writes the cache records to FILE, which may be the file that is loaded."},
    {"--checkpoint", NULL, "FILE",
     "Writes to FILE what is done, so that --resume can go on if the render is interrupted."},
    {"--checkpoint-every", NULL, "SECONDS",
     "How often the state of the image is written to the checkpoint; 60 if not given."},
    {"--resume", NULL, NULL,
     "Goes on from the checkpoint, if there is one: OUT.checkpoint if no other is named. With a "
     "larger --spp, samples are added to a complete image. Of an animation, leaves out frames that "
     "are complete, and goes on with photons and records."},
    {"--define", "-D", "NAME=VALUE", "Replaces a default of the scene file; may be repeated."},
    {"--set", NULL, "OPTION=VALUE", "Sets any option of `satin help options`; may be repeated."},
    {"--sensor", NULL, "INDEX|ID",
     "Renders the view of this sensor of the scene, by its id or counted from 0."},
    {"--animation", NULL, "PATH.toml",
     "Renders the frames of a camera path, with photons and records that all of them have in "
     "common. In the names of the image and of other files of a frame, #### is its number."},
    {"--frames", NULL, "A-B",
     "Renders these frames of the animation alone; their images are the same as with all."},
    {"--display", NULL, "tev[:HOST[:PORT]]",
     "Shows the image and its layers in the viewer tev while they are rendered."},
    {"--crop", NULL, "X,Y,W,H",
     "Renders W x H pixels of the film, from column X and row Y on, instead of the scene's crop."},
    {"--exposure", NULL, "STOPS|auto", APP_EXPOSURE_DOC},
    {"--tonemap", NULL, "clip|filmic|agx", APP_TONEMAP_DOC},
    {"--float", NULL, NULL,
     "Writes 32-bit floats in all channels; otherwise channels of colours have 16 bits."},
    {"--compression", NULL, "zip|zips|piz|rle|none", "How the OpenEXR file is compressed."},
    {"--strict", NULL, NULL, "Treats warnings about the scene as errors."},
    {"--lenient", NULL, NULL,
     "Renders a scene with missing or damaged files, unknown plugins or names, without them or "
     "grey."},
    {"--quiet", "-q", NULL, "Prints errors only."},
    {"--help", "-h", NULL, "Prints this."},
    {"--quality", NULL, "draft|preview|production", "Preset; single options override it."},
    {"--integrator", NULL, "two-pass|path|direct|photons|sppm", "How light is computed."},
    {"--first-pass", NULL, "precomputed|photons|path|none|recursive|reverse",
     "What gather rays read where they hit a surface."},
    {"--spp", NULL, "N", "Samples per pixel."},
    {"--width", NULL, "W", "Width of the whole film in pixels; a crop shows the same region."},
    {"--height", NULL, "H", "Height of the whole film in pixels."},
    {"--seed", NULL, "S", "Seed of all random numbers."},
    {"--layers", NULL, "NAME,...", "The layers beside the beauty; `none`: the beauty alone."},
    {"--threads", NULL, "T", "The number of threads; 0 is one per core."},
    {"--time", NULL, "SECONDS", "Stops with the best image so far when the time is up."},
    {"--memory", NULL, "SIZE",
     "Limits memory, such as 4G: fewer photons, coarser textures; refuses what cannot fit."},
    {"--denoise", NULL, NULL,
     "Denoises the light that no record carries; needs Open Image Denoise."},
    {NULL, NULL, NULL, NULL},
};

// Adds the four options of --crop. They point into `value`, which is split in place.
static int take_crop(struct app_render_request *r, char *value) {
    static const char *const names[4] = {"crop-x", "crop-y", "crop-width", "crop-height"};
    int box[4];
    if (!app_take_box(value, box))
        return app_wrong("--crop needs X,Y,W,H in pixels, such as 10,20,64,48, not '%s'", value);
    for (int i = 0; i < 4; i++) {
        r->setting[r->setting_count++] = (satin_setting){names[i], value};
        value += strcspn(value, ",");
        if (i < 3) *value++ = 0;
    }
    return APP_DONE;
}

// Where the text of a flag is kept that is nothing but a text; NULL of other flags.
static const char **text_of(struct app_render_request *r, int flag) {
    switch (flag) {
        case FLAG_OUTPUT:
            return &r->output;
        case FLAG_PREVIEW:
            return &r->preview;
        case FLAG_STATS:
            return &r->stats;
        case FLAG_LOAD:
            return &r->load;
        case FLAG_SAVE:
            return &r->save;
        case FLAG_CHECKPOINT:
            return &r->checkpoint;
        case FLAG_SENSOR:
            return &r->sensor;
        case FLAG_ANIMATION:
            return &r->animation;
        case FLAG_FRAMES:
            return &r->frames;
        default:
            return NULL;
    }
}

// Takes a flag without a value. False if it has one.
static bool take_switch(struct app_render_request *r, int flag) {
    switch (flag) {
        case FLAG_FLOAT:
            r->format.full_float = true;
            return true;
        case FLAG_RESUME:
            r->resume = true;
            return true;
        case FLAG_STRICT:
            r->scene_flags |= SATIN_SCENE_STRICT;
            return true;
        case FLAG_LENIENT:
            r->scene_flags |= SATIN_SCENE_LENIENT;
            return true;
        case FLAG_QUIET:
            r->quiet = true;
            return true;
        case FLAG_HELP:
            r->help = true;
            return true;
        default:
            return false;
    }
}

static int take_compression(struct app_render_request *r, const char *value) {
    static const char *const names[] = {"zip", "zips", "piz", "rle", "none"};
    for (int i = 0; i <= SATIN_EXR_NONE; i++) {
        r->format.compression = (satin_exr_compression)i;
        if (strcmp(value, names[i]) == 0) return APP_DONE;
    }
    return app_wrong("--compression needs zip, zips, piz, rle or none, not '%s'", value);
}

static int take_checkpoint_seconds(struct app_render_request *r, const char *value) {
    char *end;
    r->checkpoint_seconds = strtod(value, &end);
    if (end != value && !*end && r->checkpoint_seconds > 0.0 && r->checkpoint_seconds <= 1e6)
        return APP_DONE;
    return app_wrong("--checkpoint-every needs a number of seconds, not '%s'", value);
}

static int take_flag(struct app_render_request *r, int flag, char *value) {
    satin_define *define = &r->define[r->define_count];
    satin_setting *setting = &r->setting[r->setting_count];
    const char **text = text_of(r, flag);
    if (text) *text = value;
    if (text || take_switch(r, flag)) return APP_DONE;
    switch (flag) {
        case FLAG_COMPRESSION:
            return take_compression(r, value);
        case FLAG_CHECKPOINT_EVERY:
            return take_checkpoint_seconds(r, value);
        case FLAG_CROP:
            return take_crop(r, value);
        case FLAG_DISPLAY:
            return app_display_read(value, &r->display);
        case FLAG_EXPOSURE:
            r->toned = true;
            return app_take_exposure(value, &r->tonemap);
        case FLAG_TONEMAP:
            r->toned = true;
            return app_take_tonemap(value, &r->tonemap);
        case FLAG_PNG:
            r->want_png = true;
            r->png = value;
            return APP_DONE;
        case FLAG_DEFINE:
            if (!app_args_split(value, &define->name, &define->value))
                return app_wrong("-D needs NAME=VALUE, not '%s'", value);
            r->define_count++;
            return APP_DONE;
        case FLAG_SET:
            if (!app_args_split(value, &setting->name, &setting->value))
                return app_wrong("--set needs OPTION=VALUE, not '%s'", value);
            r->setting_count++;
            return APP_DONE;
        default:
            *setting = (satin_setting){app_render_flags[flag].name + 2, value ? value : "on"};
            r->setting_count++;
            return APP_DONE;
    }
}

// Whether a name has the ending of an image format, even of one that is not written. Decides
// whether the argument after --png is its value.
static bool is_image(const char *name) {
    static const char *const ending[] = {".png", ".exr",  ".jpg", ".jpeg", ".tif", ".tiff",
                                         ".hdr", ".webp", ".bmp", ".pfm",  ".tga"};
    for (size_t i = 0; i < sizeof ending / sizeof *ending; i++)
        if (app_ends_in(name, ending[i])) return true;
    return false;
}

int app_render_read(int argc, char **argv, struct app_render_request *r) {
    struct app_args args = {.argc = argc, .argv = argv};
    char *value;
    for (;;) {
        int flag = app_args_next(&args, app_render_flags, is_image, &value), status = APP_DONE;
        if (flag == APP_END) break;
        if (flag == APP_BAD) return APP_WRONG;
        if (flag != APP_POSITIONAL)
            status = take_flag(r, flag, value);
        else if (r->scene)
            status = app_wrong("one scene at a time: '%s' and '%s'", r->scene, value);
        else
            r->scene = value;
        if (status != APP_DONE) return status;
    }
    if (r->help) return APP_DONE;
    if (r->scene && strcmp(r->scene, "-") == 0) r->scene = APP_STDIN;
    if (!r->scene) return app_wrong("no scene: satin render SCENE.xml -o OUT.exr");
    if (!r->output || !*r->output)
        return app_wrong("no output: satin render %s -o OUT.exr", r->scene);
    if (r->toned && !r->want_png && !r->preview && !app_ends_in(r->output, ".png"))
        return app_wrong("--exposure and --tonemap are those of a picture: add --png or --preview");
    if (r->checkpoint_seconds > 0.0 && !r->checkpoint && !r->resume)
        return app_wrong(
            "--checkpoint-every is that of a checkpoint: add --resume or --checkpoint");
    satin_options checked;
    return app_exit_of(
        satin_options_resolve(NULL, r->setting, r->setting_count, app_log, NULL, &checked));
}
