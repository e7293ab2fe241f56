// SPDX-License-Identifier: Apache-2.0
// Where the files are that a scene names: folders of <path>, the order of the search,
// and reading them.
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/fileio.h"
#include "scene/scene_build.h"
#include "scene/scene_xml.h"

char *scene_xml_resolve(const struct scene_xml *xml, struct log_place place, const char *name) {
    char *first = fileio_beside(place.file, name);
    if (!first || access(first, F_OK) == 0) return first;
    // The folders from the last one on, then that of the main file.
    for (int i = xml->search_count - 1; i >= -1; i--) {
        char *path = fileio_beside(i < 0 ? xml->path : xml->search[i], name);
        if (!path || access(path, F_OK) == 0) {
            free(first);
            return path;
        }
        free(path);
    }
    return first;
}

satin_status scene_path_add(struct scene_xml *xml, struct log log, const struct xml_node *node) {
    const char *name = xml_get(node, "value");
    if (xml->search_count == XML_SEARCH_MAX) {
        log_error_at(log, node->place, "more than %d folders", XML_SEARCH_MAX);
        return SATIN_ERROR_INPUT;
    }
    char *path = scene_xml_resolve(xml, node->place, name);
    if (!path) return SATIN_ERROR_MEMORY;
    struct stat info;
    bool folder = stat(path, &info) == 0 && S_ISDIR(info.st_mode);
    // With a slash at its end, so that files are beside it.
    size_t n = strlen(path);
    char *copy = arena_alloc(&xml->arena, n + 2);
    if (copy) {
        memcpy(copy, path, n);
        copy[n] = '/';
    }
    free(path);
    if (!copy) return SATIN_ERROR_MEMORY;
    if (!folder) {
        log_error_at(log, node->place, "'%s' is not a folder", name);
        return SATIN_ERROR_INPUT;
    }
    xml->search[xml->search_count++] = copy;
    return SATIN_OK;
}

satin_status scene_source_read(const struct scene_source *source, size_t max_bytes, char **data,
                               size_t *size) {
    satin_status status =
        fileio_read(source->log, source->place, source->path, max_bytes, data, size);
    if (status == SATIN_OK && source->hash)
        *source->hash = fileio_hash_large(*source->hash, *data, *size);
    return status;
}
