// SPDX-License-Identifier: Apache-2.0
// Private to load/: a scene file as a tree of elements. Parameters are substituted, included files
// are inserted, aliases are resolved, and it is checked that each element may stand in its parent
// and has valid attributes. The functions that build objects interpret the elements.
#ifndef LOAD_XML_H
#define LOAD_XML_H

#include <stdbool.h>
#include <stddef.h>

#include "base/arena.h"
#include "base/fileio_files.h"
#include "base/log.h"
#include "satin/scene.h"

// Limits, so that a short hostile file cannot take all memory or time.
enum {
    XML_DEPTH_MAX = 64,           // depth of nested elements, across includes
    XML_INCLUDE_DEPTH_MAX = 15,   // as in Mitsuba
    XML_FILES_MAX = 1000,         // files read in all
    XML_SEARCH_MAX = 64,          // number of folders of <path>
    XML_TREE_BYTES_MAX = 1 << 30  // of the tree in memory
};

// Elements. The order matters: objects first, then values, then steps of a transform.
enum xml_tag {
    XML_SCENE = 0,
    XML_SHAPE,
    XML_BSDF,
    XML_TEXTURE,
    XML_EMITTER,
    XML_SENSOR,
    XML_FILM,
    XML_RFILTER,
    XML_SAMPLER,
    XML_INTEGRATOR,
    XML_BOOLEAN,
    XML_INTEGER,
    XML_FLOAT,
    XML_STRING,
    XML_POINT,
    XML_VECTOR,
    XML_RGB,
    XML_SPECTRUM,
    XML_TRANSFORM,
    XML_TRANSLATE,
    XML_ROTATE,
    XML_SCALE,
    XML_LOOKAT,
    XML_MATRIX,
    XML_REF,
    // The next four are not in the tree.
    XML_ALIAS,
    XML_DEFAULT,
    XML_INCLUDE,
    XML_PATH,
    XML_UNREAD,  // an element that satin does not read, to which a <ref> may refer: its type is the
                 // element's name
    XML_TAG_COUNT
};

struct texture;

struct xml_node {
    enum xml_tag tag;
    struct log_place place;
    const char *type, *id, *name;          // attributes that most elements have, or NULL
    const char *const *attribute;          // all attributes: name, value, ..., NULL
    struct xml_node *child, *last, *next;  // first and last child, next sibling
    size_t number;                         // index of the element in the order of reading
    bool mitsuba06;                        // whether it has the names of version 0.6
    bool encoded;                          // <srgb> of version 0.6: its numbers are not linear
    bool library;                          // OBJ: its <bsdf>s are from files that it names
    bool medium;                           // a <medium> is in it or referred to
    bool animated;                         // <animation>, and the number of
    int keys;                              // transforms in it that were met
    const struct texture *texture;         // what was built from it, for further
    uint32_t material;                     // references: NULL if nothing; 1 + index
    uint32_t group;
};

struct xml_id {
    const char *id;
    struct xml_node *node;
    const char *source;  // of an alias: the id to which it refers; else NULL
    struct log_place place;
    size_t number;
};

struct load_xml {
    struct arena arena;     // owns nodes and texts
    struct xml_node *root;  // the <scene>
    struct xml_id *id;      // sorted
    size_t id_count, id_capacity;
    struct fileio_files *read;           // the files that were read, owned
    const char *path;                    // of the main file
    bool stream;                         // whether the main file may be a pipe or a device
    const char *search[XML_SEARCH_MAX];  // folders of <path>, in order
    int search_count;
};

// Reads `path` and the files that it includes, with the defines and by the flags of the request. In
// `each` it lists included files that are missing, if it is lenient. Continues *hash over all bytes
// and over the defines. The caller frees *out with load_xml_free.
satin_status load_xml_read(struct log log, struct log each, const char *path,
                           const satin_scene_request *request, uint64_t *hash,
                           struct load_xml *out);
void load_xml_free(struct load_xml *xml);

// ---- load_xml_text.c
// Changes the text of a file, from malloc and with a 0 at its end, so that expat reads two errors
// that Mitsuba accepts: comments may contain `--` and bytes that are not UTF-8, and an `&` that
// begins no entity is itself. Lines stay as they are. False if there is no memory.
bool load_xml_clean(char **data, size_t *size);
// Logs what is not XML: NULL is an empty file. `at` is the text in question, `open` the element
// that is not closed; either may be NULL.
void load_xml_log_syntax(struct log log, struct log_place place, const char *what, const char *at,
                         const struct xml_node *open);

// ---- load_path.c
// The path of a file that the element at `place` names: relative to the file of that place, to the
// folders of <path> (the last one first), or to the main file. If there is no such file, it is the
// first of these. From malloc, the caller frees it; NULL if there is no memory.
char *load_xml_resolve(const struct load_xml *xml, struct log_place place, const char *name);

// The file whose name differs from that of a missing one only in the case of letters, or has `/`
// for its `\`; the first in byte order if there are several. From malloc, the caller frees it. NULL
// if `path` exists, if there is no such file or no memory.
char *load_path_any_case(const char *path);

// Adds the folder of a <path>. SATIN_ERROR_MEMORY is not logged.
satin_status load_path_add(struct load_xml *xml, struct log log, const struct xml_node *node);

// ---- load_ids.c
// Adds an id to the table. SATIN_ERROR_MEMORY is not logged.
satin_status load_ids_add(struct load_xml *xml, struct xml_id id);
// Sorts the table, refuses duplicates and resolves aliases. If `lenient`, the first of several
// objects with one id counts, and an alias of an unknown id is unknown too, with a warning each.
satin_status load_ids_resolve(struct load_xml *xml, struct log log, bool lenient);
// The object with that id, or NULL.
struct xml_node *load_xml_find(const struct load_xml *xml, const char *id);
// The object to which a <ref> refers, or the node itself if it is not a <ref>. If there is no such
// object, logs an error and returns NULL.
struct xml_node *load_xml_target(const struct load_xml *xml, struct log log, struct xml_node *node);

// Makes `child` the last child of `parent`.
static inline void load_xml_append(struct xml_node *parent, struct xml_node *child) {
    if (parent->last)
        parent->last->next = child;
    else
        parent->child = child;
    parent->last = child;
}

// ---- load_tags.c
const char *load_xml_tag_name(enum xml_tag tag);
// The value of an attribute, or NULL.
const char *load_xml_get(const struct xml_node *node, const char *attribute);
static inline bool load_xml_is_object(enum xml_tag tag) { return tag <= XML_INTEGRATOR; }
// Whether elements can be referred to by their id: objects and colours.
static inline bool load_xml_is_shared(enum xml_tag tag) {
    return load_xml_is_object(tag) || tag == XML_RGB || tag == XML_SPECTRUM;
}

// Whether `child` may stand inside `parent`.
bool load_xml_may_contain(enum xml_tag parent, enum xml_tag child);
// Whether this is an element that Mitsuba has and satin does not read.
bool load_xml_tag_unread(const char *name);
// Whether the image can be made without an element that satin does not read, if it stands in
// `parent`.
bool load_xml_tag_spared(enum xml_tag parent, const char *name);
// The tag of an element name. If satin does not read it, logs the reason and returns XML_TAG_COUNT.
enum xml_tag load_xml_tag_find(struct log log, struct log_place place, const char *name);
// Checks the attributes of an element; the root of a file needs a version. Logs errors.
bool load_xml_attributes_valid(struct log log, const struct xml_node *node, bool root);
// Whether a version, an attribute of the root element, has the names of version 0.6.
bool load_xml_version_mitsuba06(const char *version);

#endif
