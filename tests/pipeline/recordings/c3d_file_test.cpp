#include "pipeline/recordings/c3d_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/pipeline/recordings/c3d_trial.hpp"
#include "tests/pipeline/recordings/c3d_writer.hpp"

namespace borelli::test::c3d_file_test {
namespace {

using Eigen::Vector3d;
using test::C3dWriter;
using test::has_warning;
using test::read_c3d_bytes;

// Three points over four frames with a gap, and two channels of two samples per frame.
C3dWriter two_markers_and_an_angle(C3dWriter::Processor processor, bool real) {
  C3dWriter writer;
  writer.processor = processor, writer.real = real;
  writer.first_frame = 11;
  writer.channels = 2, writer.samples = 2;
  for (int i = 0; i < 4; ++i)
    writer.frames.push_back({{100.0 + i, -200, 1500.25, 256 * 5 + 2},
                             {1, 2, 3, i == 2 ? -1.0 : 0.0},
                             {10.0 * i, 0, 0, i == 3 ? -1.0 : 0.0}});
  for (int i = 0; i < 8; ++i) writer.numbers.push_back({100.0 + i, -30000.0 + i});
  writer.usual_parameters({"LASI", "Rod", "LKneeAngles"});
  writer.text("POINT:ANGLES", {"LKneeAngles"});
  writer.line("POINT:ANGLE_UNITS", "deg");
  writer.line("POINT:X_SCREEN", "+X");
  writer.line("POINT:Y_SCREEN", "+Z");
  writer.text("ANALOG:LABELS", {"Fx", "EMG"});
  writer.text("ANALOG:UNITS", {"N", "V"});
  writer.text("ANALOG:DESCRIPTIONS", {"force", "muscle"});
  writer.reals("ANALOG:SCALE", {0.5, 2}, {2});
  writer.integers("ANALOG:OFFSET", {100, -30000}, {2});
  writer.real_number("ANALOG:GEN_SCALE", 0.25);
  return writer;
}

class C3dFileOf : public testing::TestWithParam<std::tuple<C3dWriter::Processor, bool>> {};

TEST_P(C3dFileOf, ValuesRoundTrip) {
  const auto [processor, real] = GetParam();
  const C3dFile file = read_c3d_bytes(two_markers_and_an_angle(processor, real).bytes()).value();
  EXPECT_TRUE(file.warnings.empty()) << file.warnings[0];
  EXPECT_EQ(file.markers.names, (std::vector<std::string>{"LASI", "Rod"}));
  ASSERT_EQ(file.markers.frames.size(), 4);
  for (int i = 0; i < 4; ++i) {
    EXPECT_DOUBLE_EQ(file.markers.times[static_cast<std::size_t>(i)], (10 + i) / 100.0);
    const auto& frame = file.markers.frames[static_cast<std::size_t>(i)];
    // 1500.25 mm is a multiple of 0.05 mm; otherwise rounding of 24 bits
    EXPECT_LT((frame.col(0) - Vector3d(0.1 + i * 0.001, -0.2, 1.50025)).norm(), 1e-7);
    if (i == 2)
      EXPECT_TRUE(frame.col(1).array().isNaN().all()) << "a gap is NaN, never zero";
    else
      EXPECT_LT((frame.col(1) - Vector3d(0.001, 0.002, 0.003)).norm(), 1e-9);
    EXPECT_NEAR(file.residuals(0, i), 2 * 0.05 * 0.001, 1e-9);
  }
  EXPECT_TRUE(std::isnan(file.residuals(1, 2)));
  EXPECT_EQ(file.residuals(1, 1), 0);
  EXPECT_EQ(file.markers.up, Vector3d(0, 0, 1));

  ASSERT_EQ(file.outputs.size(), 1);
  EXPECT_EQ(file.outputs[0].name, "LKneeAngles");
  EXPECT_EQ(file.outputs[0].kind, "ANGLE");
  EXPECT_EQ(file.outputs[0].unit, "deg");
  EXPECT_EQ(file.outputs[0].values(0, 0), 0) << "an angle of zero is no gap";
  EXPECT_NEAR(file.outputs[0].values(0, 2), 20, 1e-6);
  EXPECT_TRUE(std::isnan(file.outputs[0].values(0, 3)));

  ASSERT_EQ(file.analog.size(), 2);
  EXPECT_EQ(file.analog[1].name, "EMG");
  EXPECT_EQ(file.analog[1].description, "muscle");
  EXPECT_EQ(file.analog[0].unit, "N");
  ASSERT_EQ(file.analog_times.size(), 8);
  EXPECT_DOUBLE_EQ(file.analog_times[3], 0.1 + 3 / 200.0);
  for (int i = 0; i < 8; ++i) {
    EXPECT_DOUBLE_EQ(file.analog[0].values[i], i * 0.5 * 0.25);
    EXPECT_DOUBLE_EQ(file.analog[1].values[i], i * 2 * 0.25);
  }
}
INSTANTIATE_TEST_SUITE_P(C3dFile, C3dFileOf,
                         testing::Combine(testing::Values(C3dWriter::intel, C3dWriter::dec, C3dWriter::mips),
                                          testing::Bool()));

TEST(C3dFile, UnsignedAnalogNumbersGoFromZeroTo65535) {
  for (const bool real : {false, true}) {
    C3dWriter writer;
    writer.real = real, writer.channels = 2;
    writer.frames.assign(2, {});
    writer.numbers = {{real ? 65535.0 : -1.0, 32768.0 - (real ? 0 : 65536)}, {0, 100}};
    writer.usual_parameters({});
    writer.line("ANALOG:FORMAT", "UNSIGNED");
    writer.integer("ANALOG:BITS", 16);
    writer.integers("ANALOG:OFFSET", {-32768, 100}, {2});  // the bits of 32768
    writer.reals("ANALOG:SCALE", {1, 1}, {2});
    const C3dFile file = read_c3d_bytes(writer.bytes()).value();
    EXPECT_EQ(file.analog[0].values[0], 65535 - 32768);
    EXPECT_EQ(file.analog[1].values[0], 32768 - 100);
    EXPECT_EQ(file.analog[0].values[1], -32768);
  }
}

TEST(C3dFile, LengthsAreMetresWhateverTheUnit) {
  for (const auto& [unit, metres] : std::vector<std::pair<std::string, double>>{{"mm", 0.001},
                                                                                {"cm", 0.01},
                                                                                {"dm", 0.1},
                                                                                {"m", 1},
                                                                                {"mete", 1},
                                                                                {"in", 0.0254},
                                                                                {"MM  ", 0.001}}) {
    C3dWriter writer;
    writer.frames = {{{1, 2, 4, 0}}};
    writer.usual_parameters({"A"}, unit);
    const C3dFile file = read_c3d_bytes(writer.bytes()).value();
    EXPECT_LT((file.markers.frames[0].col(0) - metres * Vector3d(1, 2, 4)).norm(), 1e-15) << unit;
  }
  C3dWriter writer;
  writer.frames = {{{1, 2, 4, 0}}};
  writer.usual_parameters({"A"}, "ell");
  EXPECT_NE(read_c3d_bytes(writer.bytes()).error().message().find("POINT:UNITS 'ell', expected mm, cm"),
            std::string::npos);
  writer.remove("POINT", "UNITS");
  const C3dFile file = read_c3d_bytes(writer.bytes()).value();
  EXPECT_DOUBLE_EQ(file.markers.frames[0](0, 0), 0.001);
  EXPECT_TRUE(has_warning(file.warnings, "POINT:UNITS is missing"));
}

TEST(C3dFile, GapsOfOtherProgramsAreNaNToo) {
  C3dWriter writer;
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               infinity = std::numeric_limits<double>::infinity();
  writer.frames = {
      {{nan, nan, nan, 0}, {1, 2, 3, nan}, {1, infinity, 3, 0}, {0, 0, 0, 0}, {0, 0, 0, 256}, {1, 2, 3, -7}}};
  writer.usual_parameters({"A", "B", "C", "D", "E", "F"});
  const C3dFile file = read_c3d_bytes(writer.bytes()).value();
  for (const int i : {0, 1, 2, 3, 5}) EXPECT_TRUE(file.markers.frames[0].col(i).array().isNaN().all()) << i;
  EXPECT_EQ(Vector3d(file.markers.frames[0].col(4)), Vector3d::Zero()) << "cameras saw this point";
}

TEST(C3dFile, MoreThan255PointsAreNamedByLabelsAndItsSequels) {
  C3dWriter writer;
  writer.frames.assign(1, std::vector<C3dWriter::Point>(600, {1, 1, 1, 0}));
  std::vector<std::string> labels;
  for (int i = 0; i < 600; ++i) labels.push_back("P" + std::to_string(i));
  writer.usual_parameters(std::vector<std::string>(labels.begin(), labels.begin() + 255));
  writer.remove("POINT", "USED");
  writer.integer("POINT:USED", 600);
  writer.text("POINT:LABELS3", std::vector<std::string>(labels.begin() + 510, labels.end()));
  writer.text("POINT:LABELS2", std::vector<std::string>(labels.begin() + 255, labels.begin() + 510));
  const C3dFile file = read_c3d_bytes(writer.bytes()).value();
  EXPECT_EQ(file.markers.names, labels);
  EXPECT_TRUE(file.warnings.empty());
}

TEST(C3dFile, MoreThan255ChannelsHaveScalesOffsetsAndUnitsOfTheirOwn) {
  C3dWriter writer;
  writer.channels = 300;
  writer.frames.assign(1, {});
  writer.numbers = {std::vector<double>(300, 10)};
  writer.usual_parameters({});
  writer.integers("ANALOG:OFFSET", std::vector<int>(255, 4), {255});
  writer.integers("ANALOG:OFFSET2", std::vector<int>(45, 7), {45});
  writer.reals("ANALOG:SCALE", std::vector<double>(255, 2), {255});
  writer.reals("ANALOG:SCALE2", std::vector<double>(45, 100), {45});
  writer.text("ANALOG:UNITS", std::vector<std::string>(255, "V"));
  writer.text("ANALOG:UNITS2", std::vector<std::string>(45, "N"));
  const C3dFile file = read_c3d_bytes(writer.bytes()).value();
  EXPECT_EQ(file.analog[254].values[0], 12);
  EXPECT_EQ(file.analog[299].values[0], 300);
  EXPECT_EQ(file.analog[255].unit, "N");
  EXPECT_EQ(file.analog[299].name, "channel_300");
}

TEST(C3dFile, NamesAreUniqueAndWithoutTheOnlySubjectsPrefix) {
  C3dWriter writer;
  writer.frames.assign(1, std::vector<C3dWriter::Point>(5, {1, 1, 1, 0}));
  writer.usual_parameters({"Anna:LASI", "A", "A", ""});
  writer.remove("POINT", "USED");
  writer.integer("POINT:USED", 5);
  writer.text("SUBJECTS:NAMES", {"Anna"});
  C3dFile file = read_c3d_bytes(writer.bytes()).value();
  EXPECT_EQ(file.markers.names, (std::vector<std::string>{"LASI", "A", "A_2", "point_4", "point_5"}));
  EXPECT_EQ(file.subjects, std::vector<std::string>{"Anna"});
  EXPECT_TRUE(has_warning(file.warnings, "1 of 5 points have no label"));
  EXPECT_TRUE(has_warning(file.warnings, "1 of 5 points repeat a label"));

  writer.remove("SUBJECTS", "NAMES");
  writer.text("SUBJECTS:NAMES", {"Anna", "Bert"});
  EXPECT_EQ(read_c3d_bytes(writer.bytes())->markers.names[0], "Anna:LASI");
}

TEST(C3dFile, TypeGroupsNameTheKindsOfOutputs) {
  C3dWriter writer;
  writer.frames.assign(1, std::vector<C3dWriter::Point>(4, {1, 1, 1, 0}));
  writer.usual_parameters({"LASI", "CentreOfMass", "Sway", "RHipMoment"});
  std::string pairs;  // 20 characters by 2 by 2
  for (const std::string word : {"SWAYS", "SWAY", "MODELED_MARKERS", "MODELED_MARKER"})
    pairs += word + std::string(20 - word.size(), ' ');
  writer.add("POINT:TYPE_GROUPS", -1, {20, 2, 2}, pairs);
  writer.text("POINT:MODELED_MARKERS", {"CentreOfMass"});
  writer.text("POINT:SWAYS", {"Sway"});
  writer.line("POINT:SWAY_UNITS", "mm");
  writer.text("POINT:MOMENTS", {"RHipMoment"});
  writer.line("POINT:MOMENT_UNITS", "Nmm");
  const C3dFile file = read_c3d_bytes(writer.bytes()).value();
  EXPECT_EQ(file.markers.names, (std::vector<std::string>{"LASI", "CentreOfMass"}));
  ASSERT_EQ(file.outputs.size(), 2);
  EXPECT_EQ(file.outputs[0].kind + " " + file.outputs[0].unit, "SWAY mm");
  EXPECT_EQ(file.outputs[1].kind + " " + file.outputs[1].unit, "MOMENT Nmm");
}

TEST(C3dFile, UpIsTheAxisOfTheScreensY) {
  for (const auto& [screen, up] : std::vector<std::pair<std::string, Vector3d>>{
           {"+Z", {0, 0, 1}}, {"-Z", {0, 0, -1}}, {"+Y", {0, 1, 0}}, {"X", {1, 0, 0}}}) {
    C3dWriter writer;
    writer.frames = {{{1, 2, 4, 0}}};
    writer.usual_parameters({"A"});
    writer.line("POINT:Y_SCREEN", screen);
    EXPECT_EQ(read_c3d_bytes(writer.bytes())->markers.up, up) << screen;
  }
  C3dWriter writer;
  writer.frames = {{{1, 2, 4, 0}}};
  writer.usual_parameters({"A"});
  EXPECT_FALSE(read_c3d_bytes(writer.bytes())->markers.up);
  writer.line("POINT:Y_SCREEN", "+Q");
  EXPECT_FALSE(read_c3d_bytes(writer.bytes())->markers.up);
}

TEST(C3dFile, RefusesFilesThatAreNotC3d) {
  const auto refusal = [](const std::string& bytes) {
    const auto file = read_c3d_bytes(bytes);
    return file ? std::string("read") : file.error().what;
  };
  const std::string good = two_markers_and_an_angle(C3dWriter::intel, true).bytes();
  EXPECT_EQ(refusal(""), "has 0 bytes, too few for a C3D file");
  EXPECT_EQ(refusal(std::string(600, 'a')), "is not a C3D file: its second byte is 97, expected 80");
  std::string bytes = good;
  bytes[0] = 1;
  EXPECT_NE(refusal(bytes).find("has its parameters in block 1"), std::string::npos);
  bytes[0] = '\xff';
  EXPECT_NE(refusal(bytes).find("has its parameters in block 255, but only"), std::string::npos);
  bytes = good;
  bytes[515] = 83;
  EXPECT_EQ(refusal(bytes), "names processor 83, expected 84 (Intel), 85 (DEC) or 86 (MIPS)");
  EXPECT_NE(refusal(good.substr(0, good.size() - 512)).find("too few for 4 frames of 3 points"),
            std::string::npos);
  EXPECT_NE(read_c3d("nowhere.c3d").error().message().find("nowhere.c3d"), std::string::npos);
  for (std::size_t size = 0; size + 512 < good.size(); size += 7)
    EXPECT_NE(refusal(good.substr(0, size)), "read") << size;
}

}  // namespace
}  // namespace borelli::test::c3d_file_test
