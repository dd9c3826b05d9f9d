// Limbs that touch: two overlapping roots (solids nested in none). The later root owns the common volume.
#pragma once

#include <vector>

#include "samples/phantom.hpp"

namespace borelli {

/// Sorts each root before all solids nested in it, roots in their order. Then the last of the solids that
/// hold a point is the innermost solid of the root that owns the point.
std::vector<PhantomSolid> by_root(std::vector<PhantomSolid> solids);

/// The part of a solid that a solid of a later root owns.
struct SharedPlace {
  std::size_t solid = 0, winner = 0;
  Eigen::Matrix4d moments = Eigen::Matrix4d::Zero();  ///< as EllipticStack::moments
};

/// All such parts, on a grid of 2 mm through each pair of roots whose boxes overlap (mm of the nominal body).
/// Accurate to about thousandths of the shared volume, which is itself a few hundredths of a limb.
std::vector<SharedPlace> shared_places(const std::vector<PhantomSolid>& solids);

}  // namespace borelli
