// Frames of an OpenSim model: bodies, the ground, and frames offset from them.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "dynamics/formats/xml_element.hpp"
#include "dynamics/numbers/pose.hpp"

namespace borelli {

/// A frame fixed in a body, or in the ground ("world").
struct OsimFrame {
  std::string solid;
  Pose X;  ///< of the frame in the body
};

/// R of OpenSim's orientations: rotations about the frame's own x, then y, then z, rad.
Eigen::Matrix3d osim_rotation(const Eigen::Vector3d& angles);

/// The text of a child as three numbers; `standard` if it is missing.
Eigen::Vector3d osim_vector(const XmlElement& element, std::string_view child,
                            const Eigen::Vector3d& standard = Eigen::Vector3d::Zero());
/// The text of a child; empty if it is missing.
std::string osim_text(const XmlElement& element, std::string_view child);
/// A child's "true" or "false".
bool osim_flag(const XmlElement& element, std::string_view child, bool standard);

/// Finds frames by the names and paths of OpenSim 4 (`/bodyset/femur_r`, `../hip_offset`) and by the bare
/// names of bodies of earlier versions. A path that leads nowhere is taken by its last name, if only one
/// frame has it, as OpenSim does.
class OsimFrames {
 public:
  explicit OsimFrames(const XmlElement& model);

  /// The frame that `element`, a component of the model, means by a name or path. Refuses a frame that is not
  /// there, and frames that are each other's parent.
  OsimFrame find(const XmlElement& element, const std::string& name) const;
  /// The frame named by the first of these children that there is. Refuses if there is none.
  OsimFrame named_by(const XmlElement& element, const std::vector<std::string_view>& children) const;

 private:
  void collect(const XmlElement& element, const std::string& path);
  OsimFrame place(const XmlElement& frame, int depth) const;
  OsimFrame look_up(const XmlElement& element, const std::string& name, int depth) const;

  std::map<std::string, const XmlElement*> by_path_;
  std::multimap<std::string, const XmlElement*> by_name_;
  std::map<const XmlElement*, std::string> paths_;  // of all components
};

}  // namespace borelli
