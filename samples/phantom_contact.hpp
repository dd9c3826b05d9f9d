// Limbs that touch: two roots (solids with nothing around them) that overlap. The later one takes the place.
#pragma once

#include <vector>

#include "samples/phantom.hpp"

namespace borelli {

/// Each root followed by all that is nested in it, roots in their order: then of the solids that hold a point
/// the last is the innermost of the root that has the place.
std::vector<PhantomSolid> by_root(std::vector<PhantomSolid> solids);

/// What a solid would hold, were it not for a later root's solid that has the place.
struct SharedPlace {
  std::size_t solid = 0, winner = 0;
  Eigen::Matrix4d moments = Eigen::Matrix4d::Zero();  ///< as EllipticStack::moments
};

/// All such, on a grid of 2 mm through each pair of roots whose boxes meet (mm of the nominal body): good to
/// some thousandths of what is shared, which is itself a few hundredths of a limb.
std::vector<SharedPlace> shared_places(const std::vector<PhantomSolid>& solids);

}  // namespace borelli
