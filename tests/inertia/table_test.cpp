#include "inertia/table.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "inertia/csv.hpp"
#include "inertia/table_file.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// A thigh as a cylinder of 1000 kg/m^3, radius 8 cm, from the hip at (0.1, 0, 0.9) straight down 0.4 m to the
// knee, which lies in the patient's axes: X anterior is -y, Y proximal z, Z right -x.
constexpr double radius = 0.08, length = 0.4;

SegmentFrame thigh_frame() {
  SegmentFrame frame;
  frame.segment = "thigh";
  frame.from = "HJC", frame.to = "KJC";
  frame.from_point << 0.1, 0, 0.9;
  frame.to_point << 0.1, 0, 0.9 - length;
  frame.long_axis << 0, 0, -1;
  frame.R_WA << 0, 0, -1, -1, 0, 0, 0, 1, 0;
  frame.axes = "Z along the epicondyles";
  frame.cuts = "zatsiorsky";
  return frame;
}

InertiaRow thigh_row() {
  InertiaRow row;
  row.part = "thigh_left";
  row.volume = std::numbers::pi * radius * radius * length;
  const double m = 1000 * row.volume, about_axis = m * radius * radius / 2,
               across = m * (3 * radius * radius + length * length) / 12;
  row.inertial = {m, {0.1, 0, 0.7}, Vector3d(across, across, about_axis).asDiagonal()};
  row.frame = thigh_frame();
  row.notes = {"made by hand, \"exactly\""};
  return row;
}

InertiaRow trunk_row() {
  InertiaRow row;
  row.part = "lower_trunk";
  row.volume = 0.011;
  Matrix3d tensor;
  tensor << 0.0713, 0.001, -0.0021, 0.001, 0.0912, 1. / 3e3, -0.0021, 1. / 3e3, 0.1017;
  row.inertial = {11.3, {0.01, -0.05, 1.02}, tensor};
  return row;
}

InertiaSource source() {
  InertiaSource s;
  s.volume = "body.nii.gz", s.quantity = "CT numbers, as asked", s.density_curve = "schneider2000";
  s.density_source = "Schneider et al", s.sampling = "points", s.sex = "female", s.pose = "standing",
  s.cuts = "deleva1996";
  return s;
}

TEST(Table, MassesSumToTheWhole) {
  const InertiaTable table = make_table(source(), {thigh_row(), trunk_row()});
  EXPECT_EQ(table.whole.part, "body");
  EXPECT_NEAR(table.whole.inertial.mass, thigh_row().inertial.mass + 11.3, 1e-13);
  EXPECT_NEAR(table.share(table.rows[0]) + table.share(table.rows[1]), 1, 1e-15);
  EXPECT_NEAR(table.whole.volume, thigh_row().volume + 0.011, 1e-16);
  // about the origin, tensors simply add
  const Matrix3d sum = table.rows[0].inertial.tensor_about(Vector3d::Zero()) +
                       table.rows[1].inertial.tensor_about(Vector3d::Zero());
  EXPECT_LT((table.whole.inertial.tensor_about(Vector3d::Zero()) - sum).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(Table, GivesNumbersAboutAnatomicalAxes) {
  const auto numbers = anatomical_numbers(thigh_row());
  ASSERT_TRUE(numbers);
  EXPECT_NEAR(numbers->length, length, 1e-15);
  EXPECT_NEAR(numbers->centre_along, 0.5, 1e-15);
  // radii of gyration of a cylinder: across sqrt(r^2/4 + l^2/12), about its axis, here Y, r / sqrt(2)
  EXPECT_NEAR(numbers->radii[0], std::sqrt(radius * radius / 4 + length * length / 12) / length, 1e-15);
  EXPECT_NEAR(numbers->radii[1], radius / std::sqrt(2) / length, 1e-15);
  EXPECT_NEAR(numbers->radii[2], numbers->radii[0], 1e-15);
  EXPECT_NEAR(numbers->tensor(1, 1), thigh_row().inertial.mass * radius * radius / 2, 1e-15);
  EXPECT_FALSE(anatomical_numbers(trunk_row()));
}

TEST(Table, RotatesProductsIntoAnatomicalAxes) {
  InertiaRow row = thigh_row();
  row.inertial.tensor(0, 2) = row.inertial.tensor(2, 0) = 0.003;  // of patient x (left) and z (up)
  row.inertial.tensor(0, 1) = row.inertial.tensor(1, 0) = 0.001;  // of x (left) and y (back)
  const auto numbers = anatomical_numbers(row);
  EXPECT_NEAR(numbers->tensor(1, 2), -0.003, 1e-15);  // of Y (up) and Z (right): the sign turns with left
  EXPECT_NEAR(numbers->tensor(0, 2), 0.001, 1e-15);   // of X (front) and Z (right): both turn
}

TEST(Table, ShowsPublishedValuesOnlyIfComparable) {
  InertiaTable table = make_table(source(), {thigh_row(), trunk_row()});
  const Comparison deleva = compare(table, table.rows[0], "deleva1996");
  ASSERT_TRUE(deleva.published);
  EXPECT_NEAR(deleva.published->centre_along, 0.3612, 1e-12);
  EXPECT_TRUE(deleva.mass);
  EXPECT_NE(compare(table, table.rows[0], "dumas2007").why_not.find("not comparable"), std::string::npos);
  EXPECT_NE(compare(table, table.rows[1], "deleva1996").why_not.find("endpoints"), std::string::npos);

  table.source.sex.clear();
  EXPECT_EQ(compare(table, table.rows[0], "deleva1996").why_not, "the sex is not stated");

  InertiaRow cut = trunk_row();
  cut.completeness = Completeness::cut;
  const InertiaTable partial = make_table(source(), {thigh_row(), cut});
  EXPECT_EQ(compare(partial, partial.rows[1], "deleva1996").why_not, "the part is cut");
  // shares of mass are not compared unless the scan holds the whole body
  EXPECT_FALSE(compare(partial, partial.rows[0], "deleva1996").mass);
  EXPECT_TRUE(compare(partial, partial.rows[0], "deleva1996").published);

  InertiaRow by_bone = thigh_row();
  by_bone.frame->cuts = "bone";
  const InertiaTable other = make_table(source(), {by_bone});
  EXPECT_FALSE(compare(other, other.rows[0], "deleva1996").published);
}

TEST(Table, FlagsImpossibleTensorsWithTheirNumbers) {
  InertiaRow row = trunk_row();
  row.inertial.tensor = Vector3d(1, 2, 3.5).asDiagonal();
  InertiaRow absent;
  absent.part = "head";
  absent.completeness = Completeness::absent;
  const InertiaTable table = make_table(source(), {row, thigh_row(), absent});
  EXPECT_NE(table.rows[0].flaw.find("triangle"), std::string::npos);
  EXPECT_EQ(table.rows[1].flaw, "");
  EXPECT_EQ(table.rows[2].flaw, "");
  EXPECT_EQ(table.whole.completeness, Completeness::cut);
  EXPECT_NE(to_csv(table).find("triangle inequality"), std::string::npos);
}

TEST(Table, DeviationsRoundTrip) {
  InertiaTable table = make_table(source(), {thigh_row(), trunk_row()});
  table.causes = {"density_curve", "noise"};
  table.rows[0].deviations = {{"mass_kg", 0.5, {0.3, 0.4}}, {"length_m", 0.002, {0, 0.002}}};
  table.whole.deviations = {{"mass_kg", 0.7, {0.7, 0}}};
  const auto read = table_from_json(to_json(table), "table.json");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->causes, table.causes);
  ASSERT_EQ(read->rows[0].deviations.size(), 2u);
  EXPECT_EQ(read->rows[0].deviations[0].entry, "mass_kg");
  EXPECT_EQ(read->rows[0].deviations[0].total, 0.5);
  EXPECT_EQ(read->rows[0].deviations[0].by_cause, (std::vector{0.3, 0.4}));
  EXPECT_EQ(to_json(*read), to_json(table));
  const auto csv = parse_csv(to_csv(table), "table.csv");
  ASSERT_TRUE(csv) << csv.error().message();
  EXPECT_EQ(csv->number(0, "mass_kg_sd"), 0.5);
  EXPECT_EQ(csv->number(0, "mass_sd_noise_kg"), 0.4);
  EXPECT_EQ(csv->number(0, "length_m_sd"), 0.002);
  EXPECT_TRUE(std::isnan(csv->number(1, "mass_kg_sd")));
}

void expect_same(const InertiaTable& a, const InertiaTable& b) {
  EXPECT_EQ(a.source.volume, b.source.volume);
  EXPECT_EQ(a.source.quantity, b.source.quantity);
  EXPECT_EQ(a.source.sex, b.source.sex);
  EXPECT_EQ(a.source.cuts, b.source.cuts);
  ASSERT_EQ(a.rows.size(), b.rows.size());
  for (std::size_t n = 0; n < a.rows.size(); ++n) {
    const InertiaRow &r = a.rows[n], &s = b.rows[n];
    EXPECT_EQ(r.part, s.part);
    EXPECT_EQ(r.completeness, s.completeness);
    EXPECT_EQ(r.volume, s.volume);
    EXPECT_EQ(r.inertial.mass, s.inertial.mass);
    EXPECT_EQ(r.inertial.centre, s.inertial.centre);
    EXPECT_EQ(r.inertial.tensor, s.inertial.tensor);
    EXPECT_EQ(r.notes, s.notes);
    EXPECT_EQ(r.flaw, s.flaw);
    ASSERT_EQ(r.frame.has_value(), s.frame.has_value());
    if (!r.frame) continue;
    EXPECT_EQ(r.frame->from, s.frame->from);
    EXPECT_EQ(r.frame->to_point, s.frame->to_point);
    EXPECT_EQ(r.frame->long_axis, s.frame->long_axis);
    EXPECT_EQ(r.frame->R_WA, s.frame->R_WA);
    EXPECT_EQ(r.frame->cuts, s.frame->cuts);
  }
}

TEST(Table, JsonRoundTripsBitForBit) {
  InertiaRow absent;
  absent.part = "head";
  absent.completeness = Completeness::absent;
  const InertiaTable table = make_table(source(), {thigh_row(), trunk_row(), absent});
  const auto path =
      std::filesystem::temp_directory_path() / ("borelli_table_" + std::to_string(::getpid()) + ".json");
  ASSERT_TRUE(write_table(path, table));
  const auto back = read_table(path);
  std::filesystem::remove(path);
  ASSERT_TRUE(back) << back.error().message();
  expect_same(table, *back);
  EXPECT_EQ(back->whole.inertial.tensor, table.whole.inertial.tensor);
}

TEST(Table, CsvHasTheSameNumbersWithUnits) {
  const InertiaTable table = make_table(source(), {thigh_row(), trunk_row()});
  const auto csv = parse_csv(to_csv(table), "csv");
  ASSERT_TRUE(csv) << csv.error().message();
  ASSERT_EQ(csv->rows.size(), 3u);
  EXPECT_EQ(csv->field(2, "part"), "body");
  EXPECT_EQ(csv->field(0, "notes"), "made by hand, \"exactly\"");
  EXPECT_EQ(csv->field(0, "pose"), "standing");
  EXPECT_NEAR(csv->number(0, "mass_kg"), table.rows[0].inertial.mass, 1e-8);  // nine digits
  EXPECT_NEAR(csv->number(1, "patient_Ixz_kgm2"), -0.0021, 1e-11);
  EXPECT_NEAR(csv->number(0, "anatomical_Iyy_kgm2"), table.rows[0].inertial.tensor(2, 2), 1e-10);
  EXPECT_NEAR(csv->number(0, "centre_pct"), 50, 1e-7);
  EXPECT_NEAR(csv->number(0, "deleva1996_mass_pct"), 14.78, 1e-9);
  EXPECT_TRUE(std::isnan(csv->number(0, "dumas2007_mass_pct")));
  EXPECT_NE(csv->field(0, "dumas2007_why_not").find("not comparable"), std::string::npos);
  EXPECT_NEAR(csv->number(0, "mass_pct") + csv->number(1, "mass_pct"), 100, 1e-6);
  EXPECT_NEAR(csv->number(2, "mass_pct"), 100, 1e-9);
  bool stated = false;
  for (const auto& comment : csv->comments) stated |= comment == "quantity: CT numbers, as asked";
  EXPECT_TRUE(stated);
}

TEST(Table, RefusesDamagedJsonWithTheFault) {
  const auto json = nlohmann::json::parse(to_json(make_table(source(), {thigh_row()})));
  const auto expect_refused = [&](const char* pointer, const nlohmann::json& value, const std::string& word) {
    auto damaged = json;
    if (value.is_discarded())
      damaged = damaged.patch({{{"op", "remove"}, {"path", pointer}}});
    else
      damaged[nlohmann::json::json_pointer(pointer)] = value;
    const auto answer = table_from_json(damaged.dump(), "table.json");
    ASSERT_FALSE(answer) << pointer;
    EXPECT_NE(answer.error().message().find(word), std::string::npos) << answer.error().message();
  };
  const nlohmann::json removed(nlohmann::json::value_t::discarded);
  expect_refused("/parts/0/mass_kg", removed, "thigh_left has no \"mass_kg\"");
  expect_refused("/parts/0/mass_kg", "heavy", "\"mass_kg\" of thigh_left must be a finite number");
  expect_refused("/parts/0/tensor_kgm2/1", {1, 2}, "\"tensor_kgm2\" of thigh_left");
  expect_refused("/parts/0/completeness", "half", "\"half\"");
  expect_refused("/parts/0/frame/anatomical_axes_in_patient/0", {2, 0, 0}, "orthonormal");
  expect_refused("/format", "something else", "something else");
  expect_refused("/source", removed, "\"source\"");
  const auto cut_off = table_from_json("{\"format\": ", "table.json");
  ASSERT_FALSE(cut_off);
  EXPECT_NE(cut_off.error().message().find("ends too early"), std::string::npos) << cut_off.error().message();
  const auto spoilt = table_from_json("{\"format\"; 1}", "table.json");
  ASSERT_FALSE(spoilt);
  EXPECT_NE(spoilt.error().message().find("table.json:1: is not JSON: found ';'"), std::string::npos)
      << spoilt.error().message();
  EXPECT_FALSE(read_table("/no/such/table.json"));
  EXPECT_FALSE(write_table("/no/such/folder/table.json", make_table(source(), {thigh_row()})));
  EXPECT_FALSE(write_table("table.txt", make_table(source(), {thigh_row()})));
}

}  // namespace
}  // namespace borelli
