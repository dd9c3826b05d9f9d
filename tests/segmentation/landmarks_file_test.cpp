#include "segmentation/files/landmarks_file.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/segmentation/scratch_folder.hpp"

namespace borelli {
namespace {

std::string with_text(const std::string& path, const std::string& text) {
  std::ofstream(path) << text;
  return path;
}

TEST(LandmarksFile, RoundTripsEveryNumber) {
  const ScratchFolder folder;
  Landmarks landmarks;
  landmarks["hip_left"] = {{88.125, -1.0 / 3, 912.7}, 1.5, 24.1, "bone: sphere on the femoral head"};
  landmarks["neck"] = {{0, 1e-7, 1500}, 12, 0, "proportion"};
  ASSERT_TRUE(write_landmarks(folder / "l.json", landmarks));
  const auto read = read_landmarks(folder / "l.json");
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_EQ(read->size(), 2U);
  for (const auto& [name, landmark] : landmarks) {
    EXPECT_EQ(read->at(name).point, landmark.point);
    EXPECT_EQ(read->at(name).deviation, landmark.deviation);
    EXPECT_EQ(read->at(name).radius, landmark.radius);
    EXPECT_EQ(read->at(name).source, landmark.source);
  }
}

TEST(LandmarksFile, ReadsRasAndBareLandmarks) {
  const ScratchFolder folder;
  const auto read = read_landmarks(
      with_text(folder / "l.json", R"({"frame": "RAS", "landmarks": {"neck": {"point": [1, 2, 3]}}})"));
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->at("neck").point, Eigen::Vector3d(-1, -2, 3));
  EXPECT_EQ(read->at("neck").source, "given");
}

TEST(LandmarksFile, ReportsDamage) {
  const ScratchFolder folder;
  const std::pair<const char*, const char*> cases[] = {
      {"{", "not JSON"},
      {"[]", "no \"landmarks\""},
      {R"({"frame": "XYZ", "landmarks": {}})", "LPS or RAS"},
      {R"({"unit": "cm", "landmarks": {}})", "expected mm"},
      {R"({"landmarks": {"neck": {"point": [1, 2]}}})", "landmark neck"},
      {R"({"landmarks": {"neck": {"point": [1, 2, "x"]}}})", "three finite numbers"},
      {R"({"landmarks": {"neck": {"point": [1, 2, 3], "deviation": -1}}})", "deviation"}};
  for (const auto& [text, expected] : cases) {
    const auto read = read_landmarks(with_text(folder / "l.json", text));
    ASSERT_FALSE(read) << text;
    EXPECT_NE(read.error().message().find(expected), std::string::npos) << read.error().message();
  }
  const auto missing = read_landmarks(folder / "none.json");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().kind, Error::Kind::use);
}

}  // namespace
}  // namespace borelli
