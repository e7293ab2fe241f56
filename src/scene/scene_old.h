// SPDX-License-Identifier: Apache-2.0
// Private to scene/: scene files of Mitsuba 0.4 to 0.6, whose elements and parameters are spelt
// otherwise.
#ifndef SCENE_OLD_H
#define SCENE_OLD_H

#include "scene/scene_xml.h"

// The name of an element as version 3 spells it.
const char *scene_old_tag(const char *name);

// Whether <blackbody> has an attribute, which becomes a spectrum with parameters.
bool scene_old_attribute(const char *name);

// Respells an element that is about to become a child of `parent` (NULL: the root). *keep gets
// false if it has no meaning any more, or went into another child. SATIN_ERROR_INPUT is logged,
// SATIN_ERROR_MEMORY is not.
satin_status scene_old_respell(struct log log, struct arena *arena, struct xml_node *parent,
                               struct xml_node *node, bool *keep);

// Whether only what the element contains is for `parent`: a factor around the heights of a bumpmap,
// which has had it as a parameter since.
bool scene_old_dissolves(const struct xml_node *parent, const struct xml_node *node);

#endif
