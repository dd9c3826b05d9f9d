// MJCF's equality constraints: connect, weld, joint.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "dynamics/formats/mjcf_joint.hpp"

namespace borelli {

/// The constraints of a model's <equality>: connect becomes a PointOnPoint, weld a WeldConstraint, joint a
/// CoordinateCoupling (a CoordinateFunction if its polynomial is curved). They are exact; MuJoCo's are soft.
/// Anchors and poses that the file leaves out are those of the initial pose of the model: `poses` holds X_WS
/// of its bodies by name, "world" among them. Constraints that are inactive or on sites are left unread (so
/// that they are listed).
std::vector<Constraint> read_mjcf_equality(const XmlElement& root, const std::map<std::string, Pose>& poses,
                                           const std::map<std::string, MjcfJoint>& joints);

}  // namespace borelli
