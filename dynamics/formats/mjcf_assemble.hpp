// Expands MJCF: includes, classes of defaults, <attach>, <replicate>, <frame>, <composite>.
#pragma once

#include "dynamics/formats/mjcf_compiler.hpp"
#include "dynamics/formats/xml_element.hpp"

namespace borelli {

struct MjcfModel {
  XmlElement root;
  MjcfCompilers compilers;
};

/// The expanded model: its bodies hold only bodies, joints, geoms and the like.
/// - Includes are expanded, names checked and default classes applied, in each model file on its own.
/// - frame: its pose moves into its children, except a free joint and the inertial.
/// - replicate: numbered copies, each displaced from the one before, with copies of the <equality> and
///   <contact> entries that refer to them.
/// - attach: a body, a frame or all of another model (or of this one), with prefixed names. Its own
///   <compiler> applies to it. Its other sections are added, except options and sizes.
/// - composite: see mjcf_cable.hpp.
/// Refuses more than a million elements (a few lines can ask for any number). Throws XmlRefusal.
MjcfModel assemble_mjcf(XmlElement root);

}  // namespace borelli
