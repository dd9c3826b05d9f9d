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
  std::string coordinate;  ///< empty: not a scalar one
  double start = 0;        ///< its position in the model's pose: `ref`
};

/// Reads the joints of one body after the other.
///
/// A hinge turns about a line through `pos`, so its switch stands between two displacements; a `ref` that is
/// not zero adds the turn (or shift) by -ref before it. So the switch's position is MuJoCo's qpos, and the
/// velocities are its qvel: a free joint's are linear in the world, angular in the body, a ball's angular in
/// the body.
class MjcfJoints {
 public:
  /// Which passive efforts and limits the model's <option> leaves on.
  struct Acting {
    bool springs = true, dampers = true, limits = true;
  };
  MjcfJoints(const MjcfCompilers& compilers, const Acting& acting, std::vector<std::string>& notes)
      : compilers_(compilers), acting_(acting), notes_(notes) {}

  /// Takes the names that the joints of a model give, so that those made up differ from them.
  void take_names(const XmlElement& worldbody);

  /// The switches of `solid`, whose parent and place X_PS in it are known, from the body's joints; their
  /// efforts go to `efforts`. Where a ball's spring or damper must be told from other turns of the same body,
  /// solids without mass that stand before it in the chain are put into `before`, and solid.parent is
  /// changed.
  void read(const XmlElement& body, const Pose& X_PS, Solid& solid, std::vector<Solid>& before,
            std::vector<Effort>& efforts);

  /// By the name in the file.
  const std::map<std::string, MjcfJoint>& named() const { return named_; }

  /// One line on free joints that MuJoCo aligns with their body's inertia; empty: none. Their qpos here are
  /// of the body's own frame.
  std::string aligned() const;

  /// Makes up names of solids that differ from all others.
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
