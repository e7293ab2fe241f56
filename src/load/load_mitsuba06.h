// SPDX-License-Identifier: Apache-2.0
// Private to load/: scene files of Mitsuba 0.4 to 0.6, whose elements and parameters are spelt
// otherwise.
#ifndef LOAD_MITSUBA06_H
#define LOAD_MITSUBA06_H

#include "load/load_xml.h"

// The name of an element as version 3 spells it.
const char *load_mitsuba06_tag(const char *name);

// Whether <blackbody> has an attribute, which becomes a spectrum with parameters.
bool load_mitsuba06_attribute(const char *name);

// Respells an element that is about to become a child of `parent` (NULL: the root). *keep gets
// false if it has no meaning any more, or went into another child. SATIN_ERROR_INPUT is logged,
// SATIN_ERROR_MEMORY is not.
satin_status load_mitsuba06_respell(struct log log, struct arena *arena, struct xml_node *parent,
                                    struct xml_node *node, bool *keep);

// Whether only what the element contains is for `parent`: a factor around the heights of a bumpmap,
// which has had it as a parameter since.
bool load_mitsuba06_dissolves(const struct xml_node *parent, const struct xml_node *node);

#endif
