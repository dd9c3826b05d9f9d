// Landmarks placed by hand, in the forms of 3D Slicer and our own.
#include "segmentation/files/given_landmarks.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "samples/phantom_voxels.hpp"
#include "scratch_folder.hpp"
#include "segmentation/labelling/segment.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

Result<GivenLandmarks> given(const std::string& name, const std::string& text) {
  const ScratchFolder folder;
  std::ofstream(folder / name, std::ios::binary) << text;
  return read_given_landmarks(folder / name);
}

// As 3D Slicer 5.6 writes a point list.
const std::string list = R"({
  "@schema": "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/markups-schema-v1.0.3.json#",
  "markups": [{"type": "Fiducial", "coordinateSystem": "FRAME", "coordinateUnits": "mm", "locked": false,
    "controlPoints": [
      {"id": "1", "label": "Hip-Left", "description": "", "associatedNodeID": "", "position": [80.5, -20.25, 900.0],
       "orientation": [-1, 0, 0, 0, -1, 0, 0, 0, 1], "selected": true, "visibility": true, "positionStatus": "defined"},
      {"id": "2", "label": "KNEE R", "position": [-90.0, 1.0, 480.0]},
      {"id": "3", "label": "ankle_left", "position": [0.0, 0.0, 0.0], "positionStatus": "undefined"},
      {"id": "4", "label": "F-4", "position": [1.0, 2.0, 3.0], "positionStatus": "defined"}]}]})";

TEST(GivenLandmarks, ReadsSlicerMarkupsInBothFrames) {
  for (const auto& [frame, sign] : {std::pair{"LPS", 1.}, {"RAS", -1.}}) {
    std::string text = list;
    text.replace(text.find("FRAME"), 5, frame);
    const auto read = given("points.mrk.json", text);
    ASSERT_TRUE(read) << read.error().message();
    ASSERT_EQ(read->landmarks.size(), 2U);
    EXPECT_EQ(read->landmarks.at("hip_left").point, Vector3d(sign * 80.5, sign * -20.25, 900));
    EXPECT_EQ(read->landmarks.at("knee_right").point, Vector3d(sign * -90, sign * 1, 480));
    EXPECT_EQ(read->landmarks.at("hip_left").deviation, 3);
    ASSERT_EQ(read->warnings.size(), 2U);
    EXPECT_NE(read->warnings[0].find("ignored points whose names are not landmarks: F-4"), std::string::npos)
        << read->warnings[0];
    EXPECT_NE(read->warnings[1].find("ignored points that have no position: ankle_left"), std::string::npos);
  }
}

TEST(GivenLandmarks, ReadsAllVersionsOfSlicerFcsv) {
  const std::string head = "# Markups fiducial file version = 5.4\r\n# CoordinateSystem = ";
  const std::string columns =
      "\r\n# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\r\n";
  const std::string points =
      "vtkMRMLMarkupsFiducialNode_0,10.5,-3e1,400,0,0,0,1,1,1,0,\"Wrist, left\",,,2,0\r\n"
      "1,0,0,0,0,0,0,1,1,1,0,neck,,,0,0\r\n";
  for (const auto& [frame, sign] : {std::pair{"0", -1.}, {"RAS", -1.}, {"1", 1.}, {"LPS", 1.}}) {
    const auto read = given("points.fcsv", head + frame + columns + points);
    ASSERT_TRUE(read) << read.error().message();
    ASSERT_EQ(read->landmarks.size(), 1U);
    EXPECT_EQ(read->landmarks.at("wrist_left").point, Vector3d(sign * 10.5, sign * -30, 400));
    EXPECT_NE(read->warnings.at(0).find("ignored points that have no position: neck"), std::string::npos);
  }
  // an older file without status, with other columns
  const auto old =
      given("points.fcsv", "# columns = label,x,y,z,sel,vis\n# CoordinateSystem = 1\nxiphion,1,2,3,1,1\n");
  ASSERT_TRUE(old) << old.error().message();
  EXPECT_EQ(old->landmarks.at("xiphion").point, Vector3d(1, 2, 3));
}

TEST(GivenLandmarks, ReportsErrors) {
  const auto expect = [](const std::string& name, const std::string& text, const std::string& said) {
    const auto read = given(name, text);
    ASSERT_FALSE(read) << text;
    EXPECT_NE(read.error().message().find(said), std::string::npos) << read.error().message();
  };
  const std::string columns = "# columns = id,x,y,z,label\n";
  expect("p.fcsv", "# CoordinateSystem = 2\n", "p.fcsv:1: CoordinateSystem is \"2\"");
  expect("p.fcsv", columns + "1,2,x,4,neck\n", "p.fcsv:2: y is 'x'");
  expect("p.fcsv", columns + "1,2,nan,4,neck\n", "p.fcsv:2: y is 'nan'");
  expect("p.fcsv", columns + "1,2,3,4,neck\n2,2,3,4,Neck\n", "two points named neck");
  expect("p.fcsv", columns + "1,2,3,4,nose\n", "found: 'nose'");
  expect("p.fcsv", "", "contains no point with");
  std::string text = list;
  expect("p.mrk.json", text, "coordinateSystem is \"FRAME\"");
  expect("p.mrk.json", R"({"markups": [{"controlPoints": [{"label": "neck", "position": [1, 2]}]}]})",
         "point \"neck\": expected \"position\"");
  expect("p.mrk.json", R"({"landmarks": {}})", "contains no \"markups\"");
  expect("p.json", R"({"markups": [{"coordinateUnits": "cm", "controlPoints": []}]})",
         "coordinateUnits is \"cm\"");
  expect("p.json", "{", "is not JSON");
}

TEST(GivenLandmarks, NamesAreMatchedByTheirWords) {
  for (const auto& [name, landmark] : {std::pair{"hip_left", "hip_left"},
                                       {"LeftHip", "hip_left"},
                                       {"hipleft", "hip_left"},
                                       {"R. Knee, medial", "knee_medial_right"},
                                       {"MID HIP", "mid_hip"},
                                       {"metacarpale-3 l", "metacarpale_3_left"},
                                       {"ASIS_R", "asis_right"},
                                       {"hip", ""},
                                       {"", ""}})
    EXPECT_EQ(landmark_of(name), landmark) << name;
  const auto body = build_phantom({});
  for (const auto& [name, landmark] : body->landmarks) EXPECT_EQ(landmark_of(name), name);
}

// A point not moved in Slicer keeps its source and deviation; a moved one counts as given by hand.
TEST(GivenLandmarks, MarkupsRoundTrip) {
  const ScratchFolder folder;
  Landmarks found;
  found["shoulder_left"] = {{150.125, -1.0 / 3, 1400}, 1.5, 24.25, "bone: sphere on the humeral head"};
  found["neck"] = {{1, 2, 1500}, 12, 0, "proportion"};
  found["knee_left"] = {{100, 20, 500}, 1, 22, "mine"};
  ASSERT_TRUE(write_markups(folder / "l.mrk.json", found, {"knee_left"}));
  const auto read = read_given_landmarks(folder / "l.mrk.json");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_TRUE(read->warnings.empty());
  ASSERT_EQ(read->unmoved.size(), 2U);
  for (const char* name : {"shoulder_left", "neck"}) {
    const Landmark& mark = read->unmoved.at(name);
    EXPECT_LT((mark.point - found.at(name).point).norm(), 1e-3) << name;
    EXPECT_EQ(mark.source, found.at(name).source);
    EXPECT_EQ(mark.deviation, found.at(name).deviation);
    EXPECT_EQ(mark.radius, found.at(name).radius);
  }
  // a point given earlier stays given
  ASSERT_EQ(read->landmarks.size(), 1U);
  EXPECT_EQ(read->landmarks.at("knee_left").source, "mine");
  EXPECT_EQ(read->landmarks.at("knee_left").deviation, 1);
  EXPECT_EQ(read->all().size(), 3U);

  // moved in Slicer, which keeps the description
  std::ifstream file(folder / "l.mrk.json");
  auto document = nlohmann::json::parse(file);
  for (auto& point : document["markups"][0]["controlPoints"])
    if (point["label"] != "shoulder_left") point["position"][0] = point["position"][0].get<double>() + 5;
  std::ofstream(folder / "m.mrk.json") << document;
  const auto moved = read_given_landmarks(folder / "m.mrk.json");
  ASSERT_TRUE(moved) << moved.error().message();
  EXPECT_EQ(moved->unmoved.size(), 1U);
  ASSERT_EQ(moved->landmarks.size(), 2U);
  EXPECT_EQ(moved->landmarks.at("neck").source, "placed by hand");
  EXPECT_EQ(moved->landmarks.at("neck").point, Vector3d(6, 2, 1500));
  EXPECT_EQ(moved->landmarks.at("neck").deviation, 3);
  EXPECT_EQ(moved->landmarks.at("knee_left").radius, 22);

  Landmarks none;
  put_given({{"shoulder_right", {{0, 0, 0}, 3, 0, "placed by hand"}}}, none);
  EXPECT_EQ(none.at("shoulder_right").radius, 24);
}

// The points of one run, one of them moved, given to a run on another grid: the moved one is used, the others
// are found again on that grid.
TEST(GivenLandmarks, FindsUnmovedPointsOfAnotherGridAgain) {
  const ScratchFolder folder;
  const auto body = build_phantom({});
  GridOptions coarse;
  coarse.spacing.setConstant(5);
  const GreyVolume scan = voxelise(*body, phantom_grid(*body, coarse)).grey;
  SegmentOptions options;
  options.step = 5;
  auto first = segment(scan, options);
  ASSERT_TRUE(first) << first.error().message();
  first->landmarks.at("knee_left").point[2] += 10;
  first->landmarks.at("knee_left").source = "placed by hand";
  ASSERT_TRUE(write_markups(folder / "l.mrk.json", first->landmarks, {"knee_left"}));
  options.step = 4;
  const auto alone = segment(scan, options);
  options.given = read_given_landmarks(folder / "l.mrk.json")->landmarks;
  const auto second = segment(scan, options);
  ASSERT_TRUE(alone && second);
  EXPECT_EQ(second->given, std::vector<std::string>{"knee_left"});
  for (const auto& [name, mark] : second->landmarks) {
    const bool by_hand = mark.source == "placed by hand";
    EXPECT_EQ(by_hand, name == "knee_left") << name << ": " << mark.source;
  }
  for (const char* name : {"hip_left", "shoulder_right", "neck", "knee_right", "wrist_left"}) {
    EXPECT_EQ(second->landmarks.at(name).point, alone->landmarks.at(name).point) << name;
    EXPECT_EQ(second->landmarks.at(name).deviation, alone->landmarks.at(name).deviation) << name;
  }
}

// Every landmark that segmentation finds has a name that users may give.
TEST(GivenLandmarks, KnowsEveryFoundLandmark) {
  const auto body = build_phantom({});
  GridOptions coarse;
  coarse.spacing.setConstant(5);
  SegmentOptions options;
  options.step = 5;
  const auto found = segment(voxelise(*body, phantom_grid(*body, coarse)).grey, options);
  ASSERT_TRUE(found) << found.error().message();
  EXPECT_GT(found->landmarks.size(), 30U);
  for (const auto& [name, landmark] : found->landmarks) EXPECT_EQ(landmark_of(name), name);
}

}  // namespace
}  // namespace borelli
