// MJCF's equality constraints: connect, weld, joint.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "dynamics/formats/mjcf_joint.hpp"

namespace borelli {

/// The constraints of a model's <equality>: connect becomes a PointOnPoint, weld a WeldConstraint, joint a
/// CoordinateCoupling, exact where MuJoCo's are soft. Anchors and poses that the file leaves out are those of
/// the model's pose: `poses` X_WS of its bodies by name, "world" among them. What is not active, stands on
/// sites, or couples by a curve is left unread (so that it is listed).
std::vector<Constraint> read_mjcf_equality(const XmlElement& root, const std::map<std::string, Pose>& poses,
                                           const std::map<std::string, MjcfJoint>& joints);

}  // namespace borelli
