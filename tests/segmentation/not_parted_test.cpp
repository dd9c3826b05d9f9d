// What is said of limbs whose joints were not found, on a body that holds them all.
#include <gtest/gtest.h>

#include "samples/phantom_voxels.hpp"
#include "segmentation/segment.hpp"

namespace borelli {
namespace {

TEST(NotParted, NoPartIsWholeThatHoldsItsNeighbourNorIsThatOneAbsent) {
  const auto phantom = build_phantom({});
  ASSERT_TRUE(phantom);
  GridOptions options;
  options.spacing = {9, 9, 9};
  GreyVolume scan = voxelise(*phantom, phantom_grid(*phantom, options)).grey;
  scan.grid.size[2] = scan.grid.size[2] * 85 / 100;  // without the head
  scan.voxels.resize(scan.grid.count());
  const auto found = segment(scan, {.step = 4});
  ASSERT_TRUE(found) << found.error().message();
  int not_parted = 0;
  for (std::size_t n = 5; n < parts.size(); ++n) {
    const PartFinding& finding = found->part[n];
    EXPECT_NE(finding.coverage, Coverage::absent)
        << parts[n].name;  // the whole phantom below the neck is there
    if (finding.volume > 0) continue;
    ++not_parted;
    EXPECT_EQ(finding.coverage, Coverage::cut) << parts[n].name;
    EXPECT_NE(finding.note.find("not told apart from the "), std::string::npos) << finding.note;
    for (std::size_t p = 5; p < parts.size(); ++p)
      if (parts[p].name == parts[n].parent && found->part[p].volume > 0) {
        EXPECT_EQ(found->part[p].coverage, Coverage::cut) << parts[p].name;
        EXPECT_LE(found->part[p].confidence, 0.2) << parts[p].name;
        EXPECT_TRUE(found->part[p].note.starts_with("holds ")) << found->part[p].note;
      }
  }
  if (not_parted == 0) GTEST_SKIP() << "every joint was found: nothing is left to be said of";
}

}  // namespace
}  // namespace borelli
