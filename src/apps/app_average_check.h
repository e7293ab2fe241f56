// SPDX-License-Identifier: Apache-2.0
// What satin average knows of the images that it has read.
#ifndef APP_AVERAGE_CHECK_H
#define APP_AVERAGE_CHECK_H

// The texts are NULL if the image does not have them.
struct averaged_image {
    const char *path;
    char *scene, *options;  // its attributes satin:scene_hash and satin:options
};

// Warns if the last image is not an independent render of the image that those before it show: of
// another scene, with the seed of one of them, or with other options than the first one.
void app_average_check(const struct averaged_image *image, int count);

// Leaves of a text of options, words `name=value`, those that the other text has too.
void app_average_common_options(char *options, const char *other);

#endif
