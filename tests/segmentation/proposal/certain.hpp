// Probabilities of a labeller that is always certain.
#pragma once

#include <algorithm>
#include <cmath>

#include "segmentation/proposal/class_probabilities.hpp"

namespace borelli::proposal_test {

inline ClassProbabilities certain(const CoarseBody& body, const LabelMap& exact) {
  ClassProbabilities out;
  out.shares.assign(body.places.size() * voxel_class_count, 0);
  for (std::size_t n = 0; n < body.places.size(); ++n) {
    const auto o = static_cast<std::int64_t>(body.places[n]);
    const auto& size = body.grid().size;
    const Eigen::Vector3d index =
        exact.grid.index(body.grid().point(o % size[0], o / size[0] % size[1], o / (size[0] * size[1])));
    const auto i = std::lround(index[0]), j = std::lround(index[1]), k = std::lround(index[2]);
    const int part = exact.grid.holds(i, j, k) ? exact.at(i, j, k) : 0;
    out.shares[n * voxel_class_count + static_cast<std::size_t>(std::max(0, voxel_class(part)))] = 255;
  }
  return out;
}

}  // namespace borelli::proposal_test
