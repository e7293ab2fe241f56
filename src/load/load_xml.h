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

// Bounds that keep a short hostile file from asking for all memory or time.
enum {
    XML_DEPTH_MAX = 64,           // of nested elements, over includes
    XML_INCLUDE_DEPTH_MAX = 15,   // as in Mitsuba
    XML_FILES_MAX = 1000,         // files read in all
    XML_SEARCH_MAX = 64,          // folders of <path>
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
    XML_ALIAS,    // these four
    XML_DEFAULT,  // are not in
    XML_INCLUDE,  // the tree
    XML_PATH,
    XML_TAG_COUNT
};

struct texture;

struct xml_node {
    enum xml_tag tag;
    struct log_place place;
    const char *type, *id, *name;          // attributes that most elements have, or NULL
    const char *const *attribute;          // all of them: name, value, ..., NULL
    struct xml_node *child, *last, *next;  // first and last child, next sibling
    size_t number;                         // counts elements in order of reading
    bool mitsuba06;                        // spelt as in version 0.6
    bool encoded;                          // <srgb> of those: its numbers are not linear
    const struct texture *texture;         // what the builders made of it, for further
    uint32_t material;                     // references: NULL if nothing; 1 + index
    uint32_t group;
};

struct xml_id {
    const char *id;
    struct xml_node *node;
    const char *source;  // of an alias: the id that it stands for; else NULL
    struct log_place place;
    size_t number;
};

struct load_xml {
    struct arena arena;     // owns nodes and texts
    struct xml_node *root;  // the <scene>
    struct xml_id *id;      // sorted
    size_t id_count, id_capacity;
    struct fileio_files *read;           // the files that were read so far, owned
    const char *path;                    // of the main file
    const char *search[XML_SEARCH_MAX];  // folders of <path>, in order
    int search_count;
};

// Reads `path` and what it includes; continues *hash over all bytes read and over the defines.
// The caller frees *out with load_xml_free.
satin_status load_xml_read(struct log log, const char *path, const satin_define *defines,
                           size_t define_count, uint64_t *hash, struct load_xml *out);
void load_xml_free(struct load_xml *xml);

// Where a file that the element at `place` names is: beside the file of that place, in the folders
// of <path> (the last one first), beside the main file; if nowhere, then what the first would be.
// malloc, the caller frees; NULL without memory.
char *load_xml_resolve(const struct load_xml *xml, struct log_place place, const char *name);

// The file whose name differs from a missing one's in the case of letters alone, the first in the
// order of bytes; malloc, the caller frees. NULL if `path` exists, or there is none, or no memory.
char *load_path_any_case(const char *path);

// Takes a <path>; SATIN_ERROR_MEMORY is not logged.
satin_status load_path_add(struct load_xml *xml, struct log log, const struct xml_node *node);

// The object with that id, or NULL.
struct xml_node *load_xml_find(const struct load_xml *xml, const char *id);
// The object that a <ref> names, or the node itself if it is none. Logs and returns NULL if there
// is no such object.
struct xml_node *load_xml_target(const struct load_xml *xml, struct log log, struct xml_node *node);

const char *xml_tag_name(enum xml_tag tag);
// The value of an attribute, or NULL.
const char *xml_get(const struct xml_node *node, const char *attribute);
static inline bool xml_is_object(enum xml_tag tag) { return tag <= XML_INTEGRATOR; }
// Whether an element may be referred to by its id: objects and colours.
static inline bool xml_is_shared(enum xml_tag tag) {
    return xml_is_object(tag) || tag == XML_RGB || tag == XML_SPECTRUM;
}

// Whether `child` may stand inside `parent`.
bool xml_may_contain(enum xml_tag parent, enum xml_tag child);
// The tag of an element name: XML_TAG_COUNT if satin does not read it, with the reason logged.
enum xml_tag xml_tag_find(struct log log, struct log_place place, const char *name);
// Checks the attributes of an element; the root of a file needs a version. Logs what is wrong.
bool xml_attributes_valid(struct log log, const struct xml_node *node, bool root);
// Whether the version of a file (its root element's attribute) has the names of 0.6.
bool xml_version_mitsuba06(const char *version);

// Fills the table of ids; SATIN_ERROR_MEMORY is not logged.
satin_status load_ids_add(struct load_xml *xml, struct xml_id id);
// Sorts the table, refuses duplicates, resolves aliases.
satin_status load_ids_resolve(struct load_xml *xml, struct log log);

#endif
