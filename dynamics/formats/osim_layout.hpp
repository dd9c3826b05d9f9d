// The two layouts of OpenSim models as one list of bodies and joints.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynamics/formats/osim_frames.hpp"

namespace borelli {

struct OsimJoint {
  std::string name;
  const XmlElement* element;  ///< its name is the joint's type
  /// The joint moves `child` in `parent`: X_PC = X(q).
  OsimFrame parent, child;
  /// Layout of OpenSim 3, <reverse>: X_PC is the inverse of X(q).
  bool inverted = false;
  std::vector<const XmlElement*> coordinates;  ///< <Coordinate>, in the file's order
};

struct OsimLayout {
  std::vector<const XmlElement*> bodies;  ///< without the ground
  std::vector<OsimJoint> joints;
};

/// The children of <objects> in a set of the model, such as BodySet; marks both as read. Refuses a set that
/// another file holds.
std::vector<const XmlElement*> osim_objects(const XmlElement& parent, std::string_view set);

/// The objects in the <components> (OpenSim 4) and <ComponentSet> of a <Model>. They may be of any kind.
std::vector<const XmlElement*> osim_components(const XmlElement& model);

/// Bodies and joints of a <Model>: with each joint inside its child's <Body> (OpenSim 2 and 3), or in a
/// <JointSet> with sockets (OpenSim 4). Throws XmlRefusal.
OsimLayout read_osim_layout(const XmlElement& model, const OsimFrames& frames);

}  // namespace borelli
