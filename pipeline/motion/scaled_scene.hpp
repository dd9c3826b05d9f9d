// Scales the solids of a scene.
#pragma once

#include <string>
#include <vector>

#include "dynamics/scene/scene.hpp"

namespace borelli {

struct ScaledScene {
  Scene scene;
  std::vector<std::string> warnings;
};

/// Scales each solid about its frame's origin: inertia, shapes, markers, points of efforts and constraints.
/// `factors`: one per solid of the scene, in its order, above zero. A joint's place in its parent, its guided
/// translations and its screw's pitch scale with the parent; fixed switches after its last moving one scale
/// with the solid. Positions of coordinates do not change, nor do lengths in efforts and constraints: a
/// warning names these. Masses grow with the cube of the factor, as at the same density, times `mass_factor`.
ScaledScene scaled(const Scene& scene, const std::vector<double>& factors, double mass_factor = 1);

/// Sum of all masses, kg. Errors: as inertials_of.
Result<double> total_mass(const Scene& scene);

}  // namespace borelli
