// A drawn body's scan and its segmentation.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>

#include "samples/phantom_voxels.hpp"
#include "segmentation/labelling/segment.hpp"

namespace borelli {

struct ScannedBody {
  Phantom body;
  LabelMap exact;
  Segmentation found;
};

/// Body `variation` with mixed voxels and a noise of 10 HU; `grid_of` gives the scan's grid and thus its part
/// of the body.
template <class GridOf>
ScannedBody scanned_body(std::uint64_t variation, Sex sex, const GridOf& grid_of,
                         const SegmentOptions& options = {}) {
  PhantomOptions of;
  of.sex = sex;
  of.variation = variation;
  auto body = build_phantom(of);
  EXPECT_TRUE(body);
  ScanOptions as;
  as.partial_volume = true, as.noise_hu = 10;
  const Scan scan = voxelise(*body, phantom_grid(*body, grid_of(*body)), as);
  auto found = segment(scan.grey, options);
  EXPECT_TRUE(found);
  return {*body, scan.labels, *found};
}

}  // namespace borelli
