// What MJCF builds a model from: includes, classes of defaults, <attach>, <replicate>, <frame>, <composite>.
#pragma once

#include "dynamics/mjcf_compiler.hpp"
#include "dynamics/xml_element.hpp"

namespace borelli {

struct MjcfModel {
  XmlElement root;
  MjcfCompilers compilers;
};

/// The model with all of these carried out, so that its bodies hold bodies, joints, geoms and the like alone.
/// - Includes are put in place, names checked, classes of defaults applied, in each model file on its own.
/// - A frame is a change of coordinates for what it holds, but for a free joint and the inertial.
/// - replicate: copies, each moved on and named with a number behind it; what of <equality> and <contact>
///   names them is copied too.
/// - attach: a body, a frame or all of another model (or of the model itself), its names with the prefix, its
///   angles and meshes read by its own <compiler>. What else it holds is added, but for options and sizes.
/// - composite: see mjcf_cable.hpp.
/// Refuses more than a million elements (a few lines can ask for any number). Throws XmlRefusal.
MjcfModel assemble_mjcf(XmlElement root);

}  // namespace borelli
