// SPDX-License-Identifier: Apache-2.0
// Finds and reads the files that a scene names: folders of <path> and the order of the search.
#include <dirent.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/fileio.h"
#include "load/load_build.h"
#include "load/load_xml.h"

// The file beside which the names in a file are searched. Standard input and other open files have
// no folder of their own: their names are relative to the current one.
static const char *base_of(const struct load_xml *xml, const char *file) {
    return xml->stream && strcmp(file, xml->path) == 0 && strncmp(file, "/dev/", 5) == 0 ? ""
                                                                                         : file;
}

char *load_xml_resolve(const struct load_xml *xml, struct log_place place, const char *name) {
    char *first = fileio_beside(base_of(xml, place.file), name);
    if (!first || access(first, F_OK) == 0) return first;
    // The folders of <path> from the last to the first, then that of the main file.
    for (int i = xml->search_count - 1; i >= -1; i--) {
        char *path = fileio_beside(i < 0 ? base_of(xml, xml->path) : xml->search[i], name);
        if (!path || access(path, F_OK) == 0) {
            free(first);
            return path;
        }
        free(path);
    }
    return first;
}

// Replaces the name of `length` bytes that begins at `start` in a path by that of an existing file
// or folder which differs only in the case of letters.
static bool find_any_case(char *path, size_t start, size_t length) {
    char *folder = start ? strndup(path, start) : strdup("."),
         *name = strndup(path + start, length);
    DIR *dir = folder && name ? opendir(folder) : NULL;
    bool found = false;
    for (const struct dirent *entry; dir && (entry = readdir(dir));) {
        if (strcasecmp(entry->d_name, name) != 0) continue;
        if (found && memcmp(entry->d_name, path + start, length) >= 0) continue;
        memcpy(path + start, entry->d_name, length);
        found = true;
    }
    if (dir) closedir(dir);
    free(folder);
    free(name);
    return found;
}

char *load_path_any_case(const char *path) {
    if (access(path, F_OK) == 0) return NULL;
    char *out = strdup(path);
    bool found = out != NULL;
    for (char *at = out; found && *at; at++)
        if (*at == '\\') *at = '/';
    for (size_t start = 0; found && out[start];) {
        const size_t length = strcspn(out + start, "/");
        const char after = out[start + length];
        out[start + length] = 0;
        found = !length || access(out, F_OK) == 0 || find_any_case(out, start, length);
        out[start + length] = after;
        start += length + (after != 0);
    }
    if (found) return out;
    free(out);
    return NULL;
}

satin_status load_path_add(struct load_xml *xml, struct log log, const struct xml_node *node) {
    const char *name = load_xml_get(node, "value");
    if (xml->search_count == XML_SEARCH_MAX) {
        log_error_at(log, node->place, "more than %d folders", XML_SEARCH_MAX);
        return SATIN_ERROR_INPUT;
    }
    char *path = load_xml_resolve(xml, node->place, name);
    if (!path) return SATIN_ERROR_MEMORY;
    struct stat info;
    bool folder = stat(path, &info) == 0 && S_ISDIR(info.st_mode);
    // With a slash at the end, so that files are relative to the folder.
    size_t n = strlen(path);
    char *copy = arena_alloc(&xml->arena, n + 2);
    if (copy) {
        memcpy(copy, path, n);
        copy[n] = '/';
    }
    free(path);
    if (!copy) return SATIN_ERROR_MEMORY;
    if (!folder) {
        log_warning_at(log, node->place, "'%s' is not a folder, and nothing is read from it", name);
        return SATIN_OK;
    }
    xml->search[xml->search_count++] = copy;
    return SATIN_OK;
}

satin_status load_source_read(const struct load_source *source, size_t max_bytes, char **data,
                              size_t *size) {
    satin_status status =
        fileio_read(source->log, source->place, source->path, max_bytes, data, size);
    if (status == SATIN_OK && source->hash)
        *source->hash = fileio_hash_large(*source->hash, *data, *size);
    return status;
}
