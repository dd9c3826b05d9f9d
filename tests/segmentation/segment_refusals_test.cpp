// Segmentation's errors for volumes that it cannot segment.
#include <gtest/gtest.h>

#include "grids.hpp"
#include "segmentation/labelling/segment.hpp"

namespace borelli {
namespace {

TEST(SegmentRefusals, LabelMapNamesTheLabelsOption) {
  const auto refused = segment(noise_volume(oblique_grid(false, 0), Quantity::labels));
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().what.find("is a label map"), std::string::npos) << refused.error().message();
  EXPECT_NE(refused.error().what.find("--labels"), std::string::npos) << refused.error().message();
  EXPECT_EQ(refused.error().what.find("bring"), std::string::npos) << refused.error().message();
  const auto mr = segment(noise_volume(oblique_grid(false, 0), Quantity::mr));
  ASSERT_FALSE(mr);
  EXPECT_NE(mr.error().what.find("--labels"), std::string::npos) << mr.error().message();
}

}  // namespace
}  // namespace borelli
