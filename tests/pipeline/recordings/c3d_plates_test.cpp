#include "pipeline/recordings/c3d_plates.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "tests/pipeline/recordings/c3d_trial.hpp"
#include "tests/pipeline/recordings/c3d_writer.hpp"

namespace borelli::test::c3d_plates_test {
namespace {

using Eigen::Vector3d;
using test::C3dWriter;
using test::has_warning;

// A plate of 400 by 600 mm around (1000, 500, 0) mm whose x axis is the laboratory's y, z down. On it, 100 mm
// along its x from the centre, a foot of 800 N that twists with 2 N m about the laboratory's z.
constexpr double force_n = 800, arm_mm = 100, twist_nm = 2;
const std::vector<double> corners_mm = {1300, 700, 0, 1300, 300, 0, 700, 300, 0, 700, 700, 0};

struct PlateFile {
  int type = 2;
  std::vector<double> channels;  // values to be read: N, N mm or N m, mm
  std::vector<double> origin{0, 0, -40};
  std::vector<std::string> units{"N", "N", "N", "Nmm", "Nmm", "Nmm"};
  std::vector<double> matrix;
  std::string unit = "mm";
  std::vector<int> numbers{1, 2, 3, 4, 5, 6};
};

C3dWriter writer_of(const PlateFile& plate, int frames = 3) {
  C3dWriter writer;
  const double length = plate.unit == "m" ? 0.001 : 1;
  writer.channels = static_cast<int>(plate.channels.size());
  writer.samples = 2;
  writer.frames.assign(static_cast<std::size_t>(frames), {{1000 * length, 500 * length, 900 * length, 0}});
  writer.numbers.assign(static_cast<std::size_t>(2 * frames), plate.channels);
  writer.usual_parameters({"A"}, plate.unit);
  writer.line("POINT:Y_SCREEN", "+Z");
  writer.text("ANALOG:UNITS", plate.units);
  writer.reals("ANALOG:SCALE", std::vector<double>(plate.channels.size(), 1), {writer.channels});
  writer.integer("FORCE_PLATFORM:USED", 1);
  writer.integers("FORCE_PLATFORM:TYPE", {plate.type}, {1});
  std::vector<double> corners = corners_mm, origin = plate.origin;
  for (double& x : corners) x *= length;
  for (double& x : origin) x *= length;
  writer.reals("FORCE_PLATFORM:CORNERS", corners, {3, 4, 1});
  writer.reals("FORCE_PLATFORM:ORIGIN", origin, {3, 1});
  writer.integers("FORCE_PLATFORM:CHANNEL", plate.numbers, {static_cast<int>(plate.numbers.size()), 1});
  writer.integers("FORCE_PLATFORM:ZERO", {1, 0}, {2});
  if (!plate.matrix.empty()) writer.reals("FORCE_PLATFORM:CAL_MATRIX", plate.matrix, {6, 6, 1});
  return writer;
}

// Fz is negative: z points down. M = (origin + arm) x F, in N mm.
std::vector<double> six_channels() { return {0, 0, -force_n, 0, arm_mm * force_n, -1000 * twist_nm}; }

void expect_the_foot(const C3dFile& file) {
  ASSERT_EQ(file.forces.size(), 1);
  const MeasuredForce& force = file.forces[0];
  EXPECT_EQ(force.name, "force plate 1");
  EXPECT_EQ(force.times, file.analog_times);
  ASSERT_EQ(force.force.cols(), 6);
  for (int i = 0; i < 6; ++i) {
    EXPECT_LT((force.force.col(i) - Vector3d(0, 0, force_n)).norm(), 1e-3);
    EXPECT_LT((force.point.col(i) - Vector3d(1, 0.5 + 0.1, 0)).norm(), 1e-6);
    EXPECT_LT((force.moment.col(i) - Vector3d(0, 0, twist_nm)).norm(), 1e-5);
  }
}

TEST(C3dPlates, TypeTwoIsReadInEveryUnit) {
  PlateFile plate;
  plate.channels = six_channels();
  expect_the_foot(test::read_c3d_bytes(writer_of(plate).bytes()).value());

  plate.units = std::vector<std::string>(6, "V");  // no unit of force: N and N times POINT:UNITS
  expect_the_foot(test::read_c3d_bytes(writer_of(plate).bytes()).value());

  plate.units = {"nt", "nt", "nt", "ntmm", "ntmm", "ntmm"};
  expect_the_foot(test::read_c3d_bytes(writer_of(plate).bytes()).value());

  for (int i = 3; i < 6; ++i) plate.channels[static_cast<std::size_t>(i)] /= 1000;
  plate.units = {"N", "N", "N", "N.m", "N.m", "N.m"};
  expect_the_foot(test::read_c3d_bytes(writer_of(plate).bytes()).value());

  plate.units = std::vector<std::string>(6, "");
  plate.unit = "m";
  expect_the_foot(test::read_c3d_bytes(writer_of(plate).bytes()).value());
}

TEST(C3dPlates, TypeOneGivesThePointItself) {
  PlateFile plate;
  plate.type = 1;
  plate.channels = {0, 0, -force_n, arm_mm, 0, -1000 * twist_nm};
  plate.units = {"N", "N", "N", "mm", "mm", "Nmm"};
  expect_the_foot(test::read_c3d_bytes(writer_of(plate).bytes()).value());
  plate.channels[3] = arm_mm / 10, plate.channels[5] = -twist_nm;
  plate.units = {"N", "N", "N", "cm", "cm", "Nm"};
  expect_the_foot(test::read_c3d_bytes(writer_of(plate).bytes()).value());
}

TEST(C3dPlates, TypeThreeHasEightChannels) {
  PlateFile plate;
  plate.type = 3;
  const double a = 150, b = 240;
  plate.origin = {a, b, -40};
  // x of the point: a (Fz1 + Fz4 - Fz2 - Fz3) / Fz; the twist comes from two opposite forces along x
  const double near = -force_n / 4 * (1 + arm_mm / a), far = -force_n / 4 * (1 - arm_mm / a);
  const double couple = 1000 * twist_nm / (2 * b);
  plate.channels = {couple, -couple, 0, 0, near, far, far, near};
  plate.units = std::vector<std::string>(8, "N");
  plate.numbers = {1, 2, 3, 4, 5, 6, 7, 8};
  expect_the_foot(test::read_c3d_bytes(writer_of(plate).bytes()).value());
}

TEST(C3dPlates, TypeFourIsMultipliedByItsMatrix) {
  Eigen::Matrix<double, 6, 6> matrix = Eigen::Matrix<double, 6, 6>::Identity() * 500;
  matrix(0, 1) = 3, matrix(2, 0) = -5, matrix(3, 2) = 40, matrix(4, 4) = 30000, matrix(5, 1) = -70;
  const std::vector<double> wanted = six_channels();
  const Eigen::Matrix<double, 6, 1> volts =
      matrix.inverse() * Eigen::Map<const Eigen::Matrix<double, 6, 1>>(wanted.data());
  PlateFile plate;
  plate.type = 4;
  plate.channels.assign(volts.data(), volts.data() + 6);
  plate.units = std::vector<std::string>(6, "V");
  plate.matrix.assign(matrix.data(), matrix.data() + 36);  // by columns
  expect_the_foot(test::read_c3d_bytes(writer_of(plate).bytes()).value());

  plate.matrix.clear();
  const auto file = test::read_c3d_bytes(writer_of(plate).bytes());
  EXPECT_TRUE(file->forces.empty());
  EXPECT_TRUE(has_warning(file->warnings, "force plate 1 has no CAL_MATRIX: it is left out"));

  plate.channels = wanted;
  plate.units = {"N", "N", "N", "Nmm", "Nmm", "Nmm"};
  expect_the_foot(test::read_c3d_bytes(writer_of(plate).bytes()).value());
}

TEST(C3dPlates, ZeroFramesGiveTheBaseline) {
  PlateFile plate;
  plate.channels = six_channels();
  C3dWriter writer = writer_of(plate, 8);
  for (std::size_t sample = 0; sample < 16; ++sample)
    for (std::size_t i = 0; i < 6; ++i)
      writer.numbers[sample][i] = (sample < 6 ? 0 : plate.channels[i]) + 2 + static_cast<double>(i);
  for (const int first : {0, 1}) {  // frame 0 stands for frame 1
    writer.remove("FORCE_PLATFORM", "ZERO");
    writer.integers("FORCE_PLATFORM:ZERO", {first, 3}, {2});
    const auto file = test::read_c3d_bytes(writer.bytes());
    EXPECT_LT(file->forces[0].force.col(0).norm(), 1e-3);
    EXPECT_LT((file->forces[0].force.col(7) - Vector3d(0, 0, force_n)).norm(), 1e-3);
  }
  for (const std::vector<int>& none : {std::vector<int>{0, 0}, {1, 0}, {3, 2}, {1, 500}}) {
    writer.remove("FORCE_PLATFORM", "ZERO");
    writer.integers("FORCE_PLATFORM:ZERO", none, {2});
    EXPECT_NEAR(test::read_c3d_bytes(writer.bytes())->forces[0].force(2, 0), -4, 1e-3);
  }
}

TEST(C3dPlates, ReversesAnUpThatTheMarkersContradict) {
  PlateFile plate;
  plate.channels = six_channels();
  C3dWriter writer = writer_of(plate);
  writer.remove("POINT", "Y_SCREEN");
  C3dFile file = test::read_c3d_bytes(writer.bytes()).value();
  EXPECT_EQ(file.markers.up, Vector3d(0, 0, 1)) << "the plate tells";
  expect_the_foot(file);
  writer.line("POINT:Y_SCREEN", "-Z");
  file = test::read_c3d_bytes(writer.bytes()).value();
  EXPECT_EQ(file.markers.up, Vector3d(0, 0, 1));
  EXPECT_TRUE(has_warning(file.warnings, "the upward axis was reversed"));
  expect_the_foot(file);
}

TEST(C3dPlates, LeavesOutUnreadablePlatesWithAWarning) {
  PlateFile plate;
  plate.channels = six_channels();
  const auto reason = [&](const std::string& name, const std::function<void(C3dWriter&)>& add) {
    C3dWriter writer = writer_of(plate);
    writer.remove("FORCE_PLATFORM", name);
    add(writer);
    const auto file = test::read_c3d_bytes(writer.bytes());
    EXPECT_TRUE(file->forces.empty());
    return file->warnings.empty() ? std::string{} : file->warnings.back();
  };
  EXPECT_EQ(reason("TYPE", [](C3dWriter& w) { w.integers("FORCE_PLATFORM:TYPE", {6}, {1}); }),
            "force plate 1 is of type 6, and only types 1 to 4 are read: it is left out");
  EXPECT_EQ(reason("TYPE", [](C3dWriter&) {}),
            "force plate 1 has no entry in FORCE_PLATFORM:TYPE: it is left out");
  EXPECT_EQ(reason("CORNERS", [](C3dWriter&) {}),
            "force plate 1 has no FORCE_PLATFORM:CORNERS: it is left out");
  EXPECT_EQ(reason("CORNERS",
                   [](C3dWriter& w) {
                     w.reals("FORCE_PLATFORM:CORNERS", std::vector<double>(12, 0), {3, 4, 1});
                   }),
            "force plate 1 has corners 0 m and 0 m apart, expected 0.01 to 100 m: it is left out");
  EXPECT_EQ(reason("CHANNEL",
                   [](C3dWriter& w) {
                     w.integers("FORCE_PLATFORM:CHANNEL", {1, 2, 3, 4, 5, 7}, {6, 1});
                   }),
            "force plate 1 names analog channel 7 of 6: it is left out");
  EXPECT_EQ(reason("CHANNEL",
                   [](C3dWriter& w) {
                     w.integers("FORCE_PLATFORM:CHANNEL", {1, 2, 3, 4, 5, 5}, {6, 1});
                   }),
            "force plate 1 names analog channel 5, which is taken: it is left out");
  EXPECT_EQ(reason("CHANNEL", [](C3dWriter&) {}),
            "force plate 1 has no 6 channels in FORCE_PLATFORM:CHANNEL: it is left out");

  C3dWriter writer = writer_of(plate);
  writer.remove("FORCE_PLATFORM", "USED");
  writer.integer("FORCE_PLATFORM:USED", 0);
  EXPECT_TRUE(test::read_c3d_bytes(writer.bytes())->forces.empty());
}

}  // namespace
}  // namespace borelli::test::c3d_plates_test
