#include "segmentation/volume/warning.hpp"

#include <gtest/gtest.h>

namespace borelli {
namespace {

TEST(Warnings, OfOneReasonAreJoinedWorstFirst) {
  const std::string differ = "left and right differ in volume";
  const std::vector<Warning> all{
      {WarningKind::joint, Severity::note, "voxels of 8.0 mm are large"},
      joined_warning(WarningKind::sides, Severity::doubt, differ, "upper arms 12 %"),
      {WarningKind::scan, Severity::note, "the body lies turned"},
      joined_warning(WarningKind::sides, Severity::doubt, differ, "hands 20 %"),
      {WarningKind::scan, Severity::note, "the body lies turned"},
      {WarningKind::body, Severity::fault, "the body has 900 l"},
  };
  EXPECT_EQ(all[1].text, "left and right differ in volume: upper arms 12 %");
  EXPECT_EQ(in_sentences(all),
            (std::vector<std::string>{"the body has 900 l",
                                      "left and right differ in volume: upper arms 12 %, hands 20 %",
                                      "the body lies turned", "voxels of 8.0 mm are large"}));
}

TEST(Warnings, ItemsOfOneReasonAreListedTogether) {
  const std::string head = "uncertain";
  std::vector<Warning> all{joined_warning(WarningKind::part, Severity::doubt, head, "head", "no neck"),
                           joined_warning(WarningKind::part, Severity::fault, head, "left hand", "too large"),
                           joined_warning(WarningKind::part, Severity::doubt, head, "trunk", "no neck")};
  EXPECT_EQ(in_sentences(all),
            std::vector<std::string>{"uncertain: left hand (too large), head, trunk (no neck)"});
  // a single one keeps its text
  all.resize(1);
  all[0].text = "the boundaries of the head are uncertain: no neck";
  EXPECT_EQ(in_sentences(all), std::vector<std::string>{all[0].text});
}

}  // namespace
}  // namespace borelli
