// MJCF's joints: free, ball, hinge and slide, as switches with springs and dampers.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "dynamics/formats/mjcf_compiler.hpp"
#include "dynamics/formats/unique_names.hpp"
#include "dynamics/scene/scene.hpp"

namespace borelli {

/// A joint that constraints may name.
struct MjcfJoint {
  std::string coordinate;  ///< empty: not scalar
  double start = 0;        ///< its position in the model's pose: `ref`
};

/// Reads the joints of one body after the other.
///
/// A hinge turns about a line through `pos`, so its switch stands between two displacements. A nonzero `ref`
/// adds a rotation (or shift) by -ref before the switch. So the position of the switch is MuJoCo's qpos. The
/// velocities are MuJoCo's qvel: the linear velocity of a free joint is in world axes, its angular velocity
/// and that of a ball in body axes.
class MjcfJoints {
 public:
  /// Which passive efforts and limits <option> leaves on.
  struct Acting {
    bool springs = true, dampers = true, limits = true;
  };
  MjcfJoints(const MjcfCompilers& compilers, const Acting& acting, std::vector<std::string>& notes)
      : compilers_(compilers), acting_(acting), notes_(notes) {}

  /// Registers the joint names of a model, so that generated names differ from them. Refuses duplicates.
  void take_names(const XmlElement& worldbody);

  /// Reads the joints of a body as the switches of `solid`, whose parent and pose X_PS are known. Their
  /// efforts go to `efforts`. The spring or damper of a ball must not see other rotations of the same body.
  /// Then massless solids that precede it in the chain are put into `before`, and solid.parent changes.
  void read(const XmlElement& body, const Pose& X_PS, Solid& solid, std::vector<Solid>& before,
            std::vector<Effort>& efforts);

  /// The joints by their names in the file.
  const std::map<std::string, MjcfJoint>& named() const { return named_; }

  /// One line on free joints that MuJoCo aligns with the inertia of their body; empty: none. Here their qpos
  /// refers to the frame of the body itself.
  std::string aligned() const;

  /// Generates names of solids that differ from all others.
  UniqueNames solid_names;

 private:
  void read_free(const XmlElement& joint, const Pose& X_PS, Solid& solid, std::vector<Effort>& efforts);
  void read_scalar(const XmlElement& joint, const std::string& type, Solid& solid,
                   std::vector<Effort>& efforts);
  void read_ball(const XmlElement& joint, Solid& solid, std::vector<Solid>& before,
                 std::vector<Effort>& efforts);
  void add_range(const XmlElement& joint, bool hinge, Switch& one);
  std::string name_of(const XmlElement& joint, const Solid& solid);

  struct Passive {
    double stiffness = 0, damping = 0;
    bool any() const { return stiffness != 0 || damping != 0; }
  };
  Passive passive_of(const XmlElement& joint) const;
  double linear(const XmlElement& joint, const char* key) const;
  void note_alignment(const XmlElement& body, const XmlElement& joint);

  const MjcfCompilers& compilers_;
  Acting acting_;
  std::vector<std::string>& notes_;
  std::map<std::string, MjcfJoint> named_;
  UniqueNames names_;
  int aligned_count_ = 0;
  std::string first_aligned_;  // file:line
};

}  // namespace borelli
