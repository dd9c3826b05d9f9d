#include "segmentation/labelling/verdict.hpp"

#include <gtest/gtest.h>

#include "samples/phantom.hpp"
#include "segmentation/labelling/body_doubts.hpp"

namespace borelli {
namespace {

// The phantom's exact parts and landmarks as a segmentation.
Segmentation exact_body(const PhantomOptions& options = {}) {
  const auto body = build_phantom(options);
  EXPECT_TRUE(body);
  Segmentation found;
  found.landmarks = body->landmarks;
  for (auto& [name, mark] : found.landmarks) mark.deviation = 2;
  for (std::size_t n = 1; n < parts.size(); ++n)
    found.part[n] = {Coverage::whole, 1e9 * body->volume[n], 0.9, ""};
  return found;
}

SegmentationVerdict verdict_on(Segmentation found) {
  warn_of_parts(found);
  warn_of_joints({{400, 400, 900}, Eigen::Matrix3d::Identity() * 2, Eigen::Vector3d::Zero()}, found);
  return verdict_of(found);
}

std::size_t label(std::string_view part) { return static_cast<std::size_t>(part_label(part)); }

TEST(Verdict, IsGoodForEverySampleBody) {
  for (const bool child : {false, true})
    for (const double mass : {0.0, child ? 19.0 : 60.0, child ? 24.0 : 110.0}) {
      PhantomOptions options;
      options.child = child;
      if (mass > 0) options.mass_kg = mass;
      const auto verdict = verdict_on(exact_body(options));
      EXPECT_EQ(verdict.verdict, Verdict::good) << in_words(verdict) << mass;
      EXPECT_TRUE(verdict.reasons.empty());
    }
}

TEST(Verdict, StatureMatchesTheBody) {
  for (const double stature : {1.5, 1.741, 1.95}) {
    PhantomOptions options;
    options.stature_m = stature;
    // segment lengths relative to stature differ between the sexes by about 3 % (de Leva 1996)
    EXPECT_NEAR(*stature_of(build_phantom(options)->landmarks), 1e3 * stature, 30 * stature);
  }
  EXPECT_FALSE(stature_of({}));
}

TEST(Verdict, StatureIsThatOfTheJointsThatAreSure) {
  const Landmarks exact = build_phantom({})->landmarks;
  Landmarks found = exact;
  for (const std::string side : {"_left", "_right"})
    for (const std::string joint : {"elbow", "wrist"}) {
      found[joint + side].point = exact.at("shoulder" + side).point - Eigen::Vector3d(0, 0, 60);
      found[joint + side].deviation = 150;
    }
  EXPECT_NEAR(*stature_of(found), *stature_of(exact), 0.03 * *stature_of(exact));
}

TEST(Verdict, DoubtsEveryCaseOfItsDocstring) {
  Segmentation found = exact_body();
  found.part[label("thigh_left")].confidence = 0.49;
  EXPECT_EQ(in_words(verdict_on(found)), "doubtful: the boundaries of the left thigh are uncertain");

  found = exact_body();
  found.part[label("hand_left")].volume *= 1.3;
  EXPECT_EQ(in_words(verdict_on(found)), "doubtful: left and right differ in volume: hands 30 %");
  found.part[label("foot_right")].volume *= 1.3;
  EXPECT_EQ(in_words(verdict_on(found)), "doubtful: left and right differ in volume: hands 30 %, feet 30 %");
  found.part[label("hand_left")].coverage = Coverage::cut;  // a cut part is not compared
  EXPECT_EQ(in_words(verdict_on(found)), "doubtful: left and right differ in volume: feet 30 %");

  found = exact_body();
  found.landmarks.at("knee_left").deviation = 16;
  EXPECT_EQ(in_words(verdict_on(found)),
            "doubtful: these joints and boundaries may lie far off: left knee by 16 mm");
  found.landmarks.at("knee_left").deviation = 15;
  EXPECT_EQ(verdict_on(found).verdict, Verdict::good);

  found = exact_body();
  found.part[label("head")].volume = 80.5e6;
  EXPECT_EQ(verdict_on(found).reasons.front(),
            "the boundaries of the head are uncertain: 80.5 l is impossible for a head (17 l in a man of 250 "
            "kg): check that the air around the body is -1000 HU");

  // a thigh of 33 l on a body of 1.2 m; a man of 250 kg has 35 l
  PhantomOptions child;
  child.child = true;
  found = exact_body(child);
  found.part[label("thigh_left")].volume = 33e6;
  EXPECT_NE(in_words(verdict_on(found)).find("33 l is impossible for a thigh ("), std::string::npos)
      << in_words(verdict_on(found));
}

TEST(Verdict, NamesTheWorstReasonFirstAndRefusesWithoutParts) {
  Segmentation found = exact_body();
  found.part[label("hand_left")].volume *= 1.3;
  found.part[label("head")].volume = 80.5e6;
  const auto verdict = verdict_on(found);
  ASSERT_EQ(verdict.reasons.size(), 2U);
  EXPECT_NE(verdict.reasons[0].find("impossible for a head"), std::string::npos);
  const auto nothing = verdict_of({});
  EXPECT_EQ(nothing.verdict, Verdict::refused);
  EXPECT_EQ(nothing.reasons.size(), 1U);
}

}  // namespace
}  // namespace borelli
