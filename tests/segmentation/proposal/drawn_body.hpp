// A small phantom on voxels of 4 mm, with its exact parts.
#pragma once

#include <gtest/gtest.h>

#include "samples/phantom_voxels.hpp"

namespace borelli::proposal_test {

struct Drawn {
  GreyVolume grey;
  LabelMap parts;
};

inline const Drawn& drawn() {
  static const Drawn one = [] {
    PhantomOptions options;
    options.stature_m = 1.3;
    const auto body = build_phantom(options);
    EXPECT_TRUE(body);
    GridOptions grid;
    grid.spacing = {4, 4, 4};
    Scan scan = voxelise(*body, phantom_grid(*body, grid));
    return Drawn{std::move(scan.grey), std::move(scan.labels)};
  }();
  return one;
}

}  // namespace borelli::proposal_test
