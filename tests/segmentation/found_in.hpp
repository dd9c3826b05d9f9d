// A volume, segmented.
#pragma once

#include <gtest/gtest.h>

#include "segmentation/labelling/segment.hpp"

namespace borelli::segment_test {

inline Segmentation found_in(const GreyVolume& volume, double step = 3) {
  SegmentOptions options;
  options.step = step;
  auto found = segment(volume, options);
  EXPECT_TRUE(found) << found.error().message();
  return found ? *found : Segmentation{};
}

}  // namespace borelli::segment_test
