// The stored positions of classes in the ready mappings against independent bodies, the ICRP 110 phantoms.
#include "segmentation/files/mapping_fit.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/paths.hpp"

namespace borelli {
namespace {

TEST(MappingFit, IcrpOrgansLieAtTheirNamedPlaces) {
  for (const std::string body : {"am", "af"}) {
    const std::string file = test::shared_folder() + "/volumes/icrp_" + body + "/" +
                             (body == "am" ? "AM" : "AF") + "_labels.nii.gz";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
    const auto labels = read_numbered_labels(file);
    ASSERT_TRUE(labels) << labels.error().message();
    const auto places = places_of(*labels, nullptr);
    const MappingFit own = fit_of(places, *class_mapping("icrp110"));
    EXPECT_GT(own.judged, 50U);
    EXPECT_TRUE(own.misplaced.empty()) << own.misplaced.front();
    for (const char* other : {"totalsegmentator", "totalsegmentator_v1", "totalsegmentator_mr"}) {
      EXPECT_GT(fit_of(places, *class_mapping(other)).share(), 0.4) << other;
      std::vector<std::string> warnings;
      const auto read = fitting_mapping(file, other, places, warnings);
      ASSERT_FALSE(read);
      EXPECT_NE(read.error().message().find("; choose icrp110, which fits"), std::string::npos)
          << read.error().message();
    }
  }
}

// Every class of TotalSegmentator's tables has a stored position, and every position a class.
TEST(MappingFit, EveryClassHasAPlace) {
  for (const char* name : {"totalsegmentator", "totalsegmentator_v1", "totalsegmentator_mr"}) {
    const auto mapping = class_mapping(name);
    ASSERT_TRUE(mapping);
    for (const auto& entry : mapping->entries) {
      if (!entry.label) continue;
      // far too large at any position
      const NumberPlace place{*entry.label, 1e6, Eigen::Vector3d::Zero()};
      EXPECT_EQ(fit_of({place}, *mapping).misplaced, std::vector<std::string>{entry.name});
    }
  }
}

}  // namespace
}  // namespace borelli
