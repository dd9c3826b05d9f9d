#include "inertia/compare_tables.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "inertia/csv.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3d, Eigen::Vector3d;

// a thigh of the given mass in a body of the given mass; a ball of 0.1 m about its gravity centre
NamedTable body(double thigh, double mass, double stature) {
  InertiaRow row;
  row.part = "thigh_left";
  row.volume = thigh / 1000;
  row.inertial = {thigh, {0.1, 0, 0.7}, 0.4 * thigh * 0.01 * Matrix3d::Identity()};
  SegmentFrame frame;
  frame.segment = "thigh", frame.from = "HJC", frame.to = "KJC", frame.cuts = "zatsiorsky";
  frame.from_point = {0.1, 0, 0.9}, frame.to_point = {0.1, 0, 0.5}, frame.long_axis = -Vector3d::UnitZ();
  frame.R_WA << 0, 0, -1, -1, 0, 0, 0, 1, 0;
  row.frame = frame;
  InertiaRow rest = row;
  rest.part = "rest", rest.frame.reset(), rest.inertial.mass = mass - thigh;
  InertiaSource source;
  source.cuts = "deleva1996", source.frames = "joints", source.sex = "male", source.stature_m = stature;
  source.density_curve = "schneider2000";
  return {"body.json", make_table(source, {row, rest})};
}

const GroupEntry& entry(const GroupTable& group, const std::string& name) {
  return *std::ranges::find_if(
      group.entries, [&](const GroupEntry& e) { return e.part == "thigh_left" && e.entry == name; });
}

// y = 5 + 2 stature + 0.1 mass + e at the corners of a square of statures and masses, twice. e = +-0.3 by the
// square's diagonals is orthogonal to both, so least squares must find the plane and a residual of 0.3
// sqrt(8/5).
TEST(CompareTables, RegressionFindsThePlaneAndItsResiduals) {
  std::vector<NamedTable> bodies;
  double sum = 0, squares = 0;
  for (int twice = 0; twice < 2; ++twice)
    for (const double s : {-1, 1})
      for (const double m : {-1, 1}) {
        const double y = 5 + 2 * (1.7 + 0.1 * s) + 0.1 * (70 + 10 * m) + 0.3 * s * m;
        sum += y, squares += y * y;
        bodies.push_back(body(y, 70 + 10 * m, 1.7 + 0.1 * s));
      }
  const GroupTable group = group_of(bodies);
  EXPECT_EQ(group.no_regression, "");
  const GroupEntry& mass = entry(group, "mass_kg");
  EXPECT_EQ(mass.bodies, 8);
  EXPECT_NEAR(mass.mean, sum / 8, 1e-12);
  EXPECT_NEAR(mass.sd, std::sqrt((squares - sum * sum / 8) / 7), 1e-12);
  ASSERT_TRUE(mass.regression);
  EXPECT_NEAR(mass.regression->intercept, 5, 1e-9);
  EXPECT_NEAR(mass.regression->per_metre, 2, 1e-9);
  EXPECT_NEAR(mass.regression->per_kilogram, 0.1, 1e-11);
  EXPECT_NEAR(mass.regression->residual_sd, 0.3 * std::sqrt(8. / 5), 1e-9);
  // of the variance 0.2^2 + 1^2 + 0.3^2 the last term remains
  EXPECT_NEAR(mass.regression->r2, 1 - 0.09 / (0.04 + 1 + 0.09), 1e-9);
  // the body's mass is not regressed on itself, and its share of itself is omitted
  for (const GroupEntry& e : group.entries)
    if (e.part == "body") {
      EXPECT_NE(e.entry, "mass_pct");
      if (e.entry == "mass_kg") {
        EXPECT_FALSE(e.regression);
      }
    }
  // the same in the files
  const auto csv = parse_csv(comparison_csv(bodies), "csv");
  ASSERT_TRUE(csv) << csv.error().message();
  bool found = false;
  for (std::size_t row = 0; row < csv->rows.size(); ++row)
    if (csv->field(row, "part") == "thigh_left" && csv->field(row, "entry") == "mass_kg") {
      found = true;
      EXPECT_NEAR(csv->number(row, "per_metre"), 2, 1e-8);
    }
  EXPECT_TRUE(found);
  EXPECT_EQ(nlohmann::json::parse(comparison_json(bodies)).at("tables").size(), 8u);
}

TEST(CompareTables, SaysWhyThereIsNoRegression) {
  std::vector<NamedTable> bodies{body(10, 70, 1.7), body(11, 75, 1.8), body(10, 72, 1.75)};
  EXPECT_NE(group_of(bodies).no_regression.find("five whole bodies"), std::string::npos);
  // collinear stature and mass cannot be separated
  bodies.clear();
  for (int n = 0; n < 6; ++n) bodies.push_back(body(10 + 0.1 * n * n, 60 + 2 * n, 1.6 + 0.02 * n));
  EXPECT_NE(group_of(bodies).no_regression.find("vary only together"), std::string::npos);
  EXPECT_FALSE(entry(group_of(bodies), "mass_kg").regression);
}

TEST(CompareTables, TwoTablesAreComparedInStandardDeviations) {
  NamedTable a = body(10, 70, 1.7), b = body(10.5, 70, 1.7);
  a.table.rows[0].deviations = {{"mass_kg", 0.3, {}}};
  b.table.rows[0].deviations = {{"mass_kg", 0.4, {}}};
  const auto all = differences(a.table, b.table);
  const auto mass = std::ranges::find_if(
      all, [](const TableDifference& d) { return d.part == "thigh_left" && d.entry == "mass_kg"; });
  ASSERT_NE(mass, all.end());
  EXPECT_NEAR(mass->percent(), 5, 1e-12);
  ASSERT_TRUE(mass->deviation);
  EXPECT_NEAR(*mass->deviation, 0.5, 1e-12);
  for (const TableDifference& d : all) EXPECT_FALSE(d.part == "body" && d.entry == "mass_pct");
  // the body's position is not compared
  for (const TableDifference& d : all) EXPECT_FALSE(d.entry.starts_with("centre_x")) << d.entry;
  // a cut part is not compared
  b.table.rows[0].completeness = Completeness::cut;
  for (const TableDifference& d : differences(a.table, b.table)) EXPECT_NE(d.part, "thigh_left");
}

TEST(CompareTables, RefusesOtherConventions) {
  NamedTable a = body(10, 70, 1.7), b = body(8, 70, 1.7);
  b.name = "bone.json", b.table.source.cuts = "bone";
  const auto refused = check_comparable({a, b});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, Error::Kind::use);
  EXPECT_EQ(refused.error().where, "bone.json");
  EXPECT_NE(refused.error().what.find("its cuts follow bone, those of body.json follow deleva1996"),
            std::string::npos)
      << refused.error().what;
  b.table.source.cuts = "deleva1996", b.table.source.frames = "isb";
  EXPECT_NE(check_comparable({a, b}).error().what.find("frames"), std::string::npos);
  EXPECT_FALSE(check_comparable({a}));
  b.table.source.frames = "joints", b.table.source.density_curve = "geant4";
  EXPECT_TRUE(check_comparable({a, b}));
  ASSERT_EQ(remarks_on({a, b}).size(), 1u);
  EXPECT_NE(remarks_on({a, b})[0].find("geant4, schneider2000"), std::string::npos);
  // the same table under another name
  b = a, b.name = "again.json";
  ASSERT_EQ(remarks_on({a, b}).size(), 1u);
  EXPECT_NE(remarks_on({a, b})[0].find("one body counts twice"), std::string::npos);
}

}  // namespace
}  // namespace borelli
