// A scene with its solids made larger or smaller.
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

/// Scales each solid about the origin of its frame by its factor (in the order of the scene's solids, above
/// zero): inertias, shapes, markers and points of efforts and constraints. A joint's place in its parent, its
/// guided translations and its screw's pitch grow with the parent; what stands behind its last moving switch grows with the
/// solid. Positions of coordinates stay. Lengths of efforts and constraints stay, and are told.
ScaledScene scaled(const Scene& scene, const std::vector<double>& factors, const MassScaling& masses);

/// Sum of all masses, kg. Errors: as inertials_of.
Result<double> total_mass(const Scene& scene);

}  // namespace borelli
