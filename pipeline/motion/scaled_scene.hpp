// Scales the solids of a scene.
#pragma once

#include <string>
#include <vector>

#include "dynamics/scene/scene.hpp"

namespace borelli {

/// What masses do when a solid is scaled by s.
struct MassScaling {
  enum class Rule {
    by_volume,  ///< masses grow by s^3, tensors by s^5: the same density
    kept        ///< masses stay, tensors grow by s^2
  };
  Rule rule = Rule::by_volume;
  double factor = 1;  ///< times all masses and tensors
};

struct ScaledScene {
  Scene scene;
  std::vector<std::string> warnings;
};

/// Scales each solid about its frame's origin: inertia, shapes, markers, points of efforts and constraints.
/// `factors`: one per solid of the scene, in its order, above zero. A joint's place in its parent, its guided
/// translations and its screw's pitch scale with the parent; fixed switches after its last moving one scale
/// with the solid. Positions of coordinates do not change, nor do lengths in efforts and constraints: a
/// warning names these.
ScaledScene scaled(const Scene& scene, const std::vector<double>& factors, const MassScaling& masses);

/// Sum of all masses, kg. Errors: as inertials_of.
Result<double> total_mass(const Scene& scene);

}  // namespace borelli
