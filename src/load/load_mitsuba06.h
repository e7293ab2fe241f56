// SPDX-License-Identifier: Apache-2.0
// Private to load/: scene files of Mitsuba 0.4 to 0.6, whose elements and parameters have other
// names.
#ifndef LOAD_MITSUBA06_H
#define LOAD_MITSUBA06_H

#include "load/load_xml.h"

// The name of an element in version 3.
const char *load_mitsuba06_tag(const char *name);

// Whether an element has this attribute besides those of version 3: of <blackbody>, which becomes a
// spectrum with parameters, and `intent` of a colour, which says whether it is a reflectance and
// does not change it.
bool load_mitsuba06_attribute(enum xml_tag tag, const char *name);

// Translates an element before it becomes a child of `parent` (NULL: the root). *keep is set to
// false if it has no meaning in version 3 or was merged into another child. SATIN_ERROR_INPUT is
// logged, SATIN_ERROR_MEMORY is not.
satin_status load_mitsuba06_respell(struct log log, struct arena *arena, struct xml_node *parent,
                                    struct xml_node *node, bool *keep);

// Whether the children of an element are to become those of `parent`: a scale texture around the
// heights of a bumpmap, for which version 3 has a parameter.
bool load_mitsuba06_dissolves(const struct xml_node *parent, const struct xml_node *node);

#endif
