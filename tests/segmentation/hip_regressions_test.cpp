// Hips outside the scan: against an independent transcription of the published equations, and against heads
// in the part of a scan that was cut off.
#include "segmentation/joints/hip_regressions.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <string>

#include "tests/paths.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// The value of a sum of terms such as -0.24*PD and 7.9, with values of its names.
double value(const std::string& equation, const std::map<std::string, double>& names) {
  static const std::regex term(R"(([+-]?)([0-9.]+)(?:\*([A-Z]+))?)");
  double sum = 0;
  for (std::sregex_iterator it(equation.begin(), equation.end(), term), end; it != end; ++it)
    sum += ((*it)[1] == "-" ? -1 : 1) * std::stod((*it)[2]) *
           ((*it)[3].matched ? names.at((*it)[3].str()) : 1.0);
  return sum;
}

TEST(HipRegressions, EqualThePublishedEquations) {
  const std::string path = test::shared_folder() + "/reference/hip_centre_regressions.csv";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "the published regressions are not there: " << path;
  std::map<std::string, std::map<std::string, std::string>> published;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::istringstream in(line);
    std::string method, axis, equation;
    if (line.starts_with('#') || !std::getline(in, method, ',') || !std::getline(in, axis, ',') ||
        !std::getline(in, equation))
      continue;
    published[method][axis] = equation;
  }
  for (const PelvisSize& pelvis : {PelvisSize{236, 107, 900}, PelvisSize{180, 131, 655}})
    for (const auto& [regression, name] :
         {std::pair{HipRegression::harrington, "Harrington2007_full"},
          {HipRegression::harrington_width, "Harrington_PW_only(Sangeux2015)"},
          {HipRegression::hara, "Hara2016"},
          {HipRegression::bell, "Bell1989"}}) {
      SCOPED_TRACE(name);
      ASSERT_TRUE(published.contains(name));
      const std::map<std::string, double> names{
          {"PW", pelvis.width}, {"PD", *pelvis.depth}, {"LL", *pelvis.leg}};
      const auto centre = hip_centre(regression, pelvis);
      ASSERT_TRUE(centre);
      EXPECT_NEAR((*centre)[0], value(published[name]["X"], names), 1e-9);
      EXPECT_NEAR((*centre)[1], value(published[name]["Y"], names), 1e-9);
      EXPECT_NEAR((*centre)[2], value(published[name]["Z"], names), 1e-9);
    }
  const PelvisSize width{236, {}, {}};
  EXPECT_FALSE(hip_centre(HipRegression::harrington, width));
  EXPECT_FALSE(hip_centre(HipRegression::hara, width));
}

// The hips move with a turned and shifted pelvis; a visible hip stays.
TEST(HipRegressions, FollowThePelvisAsItLies) {
  const double deg = M_PI / 180;
  const Eigen::Matrix3d turn =
      (Eigen::AngleAxisd(20 * deg, Vector3d::UnitZ()) * Eigen::AngleAxisd(-12 * deg, Vector3d::UnitX()))
          .toRotationMatrix();
  const Vector3d shift(40, -30, 900);
  const auto at = [&](double left, double back, double up) {
    return Landmark{turn * Vector3d(left, back, up) + shift, 3, 0, "bone"};
  };
  Landmarks marks{{"asis_left", at(118, 0, 0)},
                  {"asis_right", at(-118, 0, 0)},
                  {"psis_left", at(45, 150, 0)},
                  {"psis_right", at(-45, 150, 0)},
                  {"medial_malleolus_left", at(118, 0, -880)},
                  {"medial_malleolus_right", at(-118, 0, -880)}};
  place_unseen_hips(marks);
  // Harrington, by hand: X = -.24 150 - 9.9, Y = -.16 236 - .04 880 - 7.1, Z = .28 150 + .16 236 + 7.9
  EXPECT_LT((marks.at("hip_left").point - at(87.66, 45.9, -80.06).point).norm(), 1e-9);
  EXPECT_LT((marks.at("hip_right").point - at(-87.66, 45.9, -80.06).point).norm(), 1e-9);
  EXPECT_LT((marks.at("mid_hip").point - at(0, 45.9, -80.06).point).norm(), 1e-9);
  EXPECT_EQ(marks.at("hip_left").source, "regression: Harrington 2007");
  EXPECT_GT(marks.at("hip_left").deviation, 7.9);  // 12.3 +- 5.9 mm over three coordinates

  marks["hip_left"] = at(90, 50, -75);
  place_unseen_hips(marks);
  EXPECT_EQ(marks.at("hip_left").source, "bone");
  EXPECT_TRUE(marks.at("hip_right").source.starts_with("regression"));

  Landmarks one_spine{{"asis_left", at(118, 0, 0)}};
  place_unseen_hips(one_spine);
  EXPECT_EQ(one_spine.size(), 1U);
}

// Hips beside spines 240 mm apart: 173 mm by Harrington's width, 173 by Bell's.
TEST(HipRegressions, DoubtHipsThatSpinesContradict) {
  const auto body = [](double apart, const char* source) {
    return Landmarks{{"asis_left", {Vector3d(120, 0, 80), 6, 0, "bone: foremost point of the iliac crest"}},
                     {"asis_right", {Vector3d(-120, 0, 80), 6, 0, "bone: foremost point of the iliac crest"}},
                     {"hip_left", {Vector3d(apart / 2, 50, 0), 3, 23, source}},
                     {"hip_right", {Vector3d(-apart / 2, 50, 0), 3, 23, source}},
                     {"mid_hip", {Vector3d(0, 50, 0), 3, 0, "middle of the hip centres"}}};
  };
  const char* sphere = "bone: sphere on the femoral head";
  Landmarks close = body(125, sphere), usual = body(160, sphere), mirrored = body(125, "mirror image");
  EXPECT_NEAR(misfit_of_hips(close), 125 - 2 * (0.33 * 240 + 7.3), 1e-9);
  doubt_misfit_hips(close);
  EXPECT_NEAR(close.at("hip_left").deviation, 24, 1);
  EXPECT_NEAR(close.at("hip_right").deviation, 24, 1);
  EXPECT_NEAR(close.at("mid_hip").deviation, 24, 1);
  EXPECT_TRUE(close.at("hip_right").source.ends_with(unlike_body));
  EXPECT_EQ(misfit_of_hips(usual), 0);
  EXPECT_EQ(misfit_of_hips(mirrored), 0);
}

}  // namespace
}  // namespace borelli
