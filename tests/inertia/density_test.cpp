#include "inertia/density.hpp"
#include "tests/paths.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include "inertia/csv.hpp"
#include "tests/inertia/checksum.hpp"

namespace borelli {
namespace data {
extern const char* const hu_density;
}
namespace {

std::string read_file(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

TEST(Density, DataHaveTheirProofreadChecksum) { EXPECT_EQ(checksum(data::hu_density), 1884766384293099931u); }

TEST(Density, DataEqualTheSharedFile) {
  const std::string shared = read_file(test::shared_folder() + "/reference/hu_density.csv");
  if (shared.empty()) GTEST_SKIP() << "no reference/hu_density.csv beside the checkout";
  const std::map<std::string, std::string> names{{"schneider2000_opengate", "schneider2000"},
                                                 {"schneider1996_kwave", "schneider1996"},
                                                 {"mcsquare_default", "mcsquare"},
                                                 {"geant4_dicom_CT2D", "geant4"},
                                                 {"oncentra_slide", "oncentra"}};
  const auto table = parse_csv(shared, "shared");
  ASSERT_TRUE(table) << table.error().message();
  std::map<std::string, std::vector<Eigen::Vector2d>> knots;
  for (std::size_t row = 0; row < table->rows.size(); ++row)
    if (const auto name = names.find(table->field(row, "table")); name != names.end())
      knots[name->second].emplace_back(table->number(row, "hu"), 1000 * table->number(row, "density_g_cm3"));
  ASSERT_EQ(knots.size(), names.size());
  for (const auto& curve : density_curves()) {
    ASSERT_EQ(curve.knots.size(), knots[curve.name].size()) << curve.name;
    for (std::size_t n = 0; n < curve.knots.size(); ++n)
      EXPECT_LT((curve.knots[n] - knots[curve.name][n]).norm(), 1e-9) << curve.name << " " << n;  // rounding
  }
}

TEST(Density, CurvesRiseInHuAndNameTheirPublication) {
  EXPECT_EQ(density_curves().size(), 5u);
  for (const auto& curve : density_curves()) {
    EXPECT_GT(curve.source.size(), 40u) << curve.name;
    for (std::size_t n = 1; n < curve.knots.size(); ++n) {
      EXPECT_GT(curve.knots[n][0], curve.knots[n - 1][0]) << curve.name;
      // densities fall only where two fits of schneider2000 meet
      const bool falls = curve.knots[n][1] < curve.knots[n - 1][1];
      EXPECT_EQ(falls, curve.name == "schneider2000" && curve.knots[n][0] == 101) << curve.name << " " << n;
    }
  }
}

TEST(Density, InterpolatesBetweenAtAndOutsideTheKnots) {
  const auto curve = density_curve("schneider2000");
  ASSERT_TRUE(curve);
  EXPECT_EQ(curve->name, default_density_curve);
  // the paper's fits: soft tissue 1003 + 1.169 HU in 23..100, bone 1017 + 0.592 HU above 100; the file's
  // knots are rounded to 0.1
  EXPECT_NEAR(curve->at(60), 1003 + 1.169 * 60, 1.5);
  EXPECT_NEAR(curve->at(1000), 1017 + 0.592 * 1000, 0.5);
  EXPECT_DOUBLE_EQ(curve->at(23), 1031);
  EXPECT_DOUBLE_EQ(curve->at(101), 1076.2);
  EXPECT_DOUBLE_EQ(curve->at(100), 1119.9);
  EXPECT_DOUBLE_EQ(curve->at(-1000), 1.21);
  EXPECT_DOUBLE_EQ(curve->at(-3024), 1.21);  // padding
  EXPECT_DOUBLE_EQ(curve->at(30000), 2800);  // metal
}

TEST(Density, RefusesUnknownCurvesAndListsKnownOnes) {
  const auto curve = density_curve("schneider");
  ASSERT_FALSE(curve);
  EXPECT_EQ(curve.error().kind, Error::Kind::use);
  EXPECT_NE(curve.error().message().find("schneider2000, schneider1996, mcsquare, geant4, oncentra"),
            std::string::npos);
}

TEST(Density, GreyValuesGiveWeights) {
  const auto curve = density_curve(default_density_curve);
  const auto hu = density_weights(Quantity::hu, *curve),
             density = density_weights(Quantity::density_kgm3, *curve);
  ASSERT_TRUE(hu && density);
  ASSERT_EQ(hu->size(), 65536u);
  for (const int grey : {-32768, -1024, -98, 0, 57, 1200, 32767})
    EXPECT_EQ((*hu)[static_cast<std::size_t>(grey + 32768)], curve->at(grey));
  EXPECT_EQ((*density)[32768 + 1050], 1050);
  EXPECT_EQ((*density)[32768 - 5], 0);
  // outside the field of view the straight curve would give negative mass
  const auto straight = density_weights(Quantity::hu, *curve, BelowAir::straight);
  EXPECT_LT((*straight)[32768 - 1024], 0);
  EXPECT_EQ((*straight)[32768 + padding_hu], 0);
  EXPECT_EQ((*density)[32768 + padding_density], 0);
  EXPECT_FALSE(density_weights(Quantity::mr, *curve));
  EXPECT_FALSE(density_weights(Quantity::labels, *curve));
}

// CT number of a tissue at 120 kV from its composition: Schneider et al (2000), equation 8, with their fit's
// k1 = 1.24e-3 and k2 = 3.06e-5. Independent of the curves' code.
double ct_number(const CsvTable& tissues, std::size_t row) {
  struct Element {
    const char* name;
    double Z, A;
  };
  constexpr std::array<Element, 12> elements{{{"H", 1, 1.008},
                                              {"C", 6, 12.011},
                                              {"N", 7, 14.007},
                                              {"O", 8, 15.999},
                                              {"Na", 11, 22.990},
                                              {"Mg", 12, 24.305},
                                              {"P", 15, 30.974},
                                              {"S", 16, 32.06},
                                              {"Cl", 17, 35.45},
                                              {"K", 19, 39.098},
                                              {"Ca", 20, 40.078},
                                              {"Fe", 26, 55.845}}};
  const auto attenuation = [](const Element& e) {
    return (e.Z + std::pow(e.Z, 2.86) * 1.24e-3 + std::pow(e.Z, 4.62) * 3.06e-5) / e.A;
  };
  double sum = 0, share = 0;
  for (const Element& e : elements)
    if (const double w = tissues.number(row, e.name); !std::isnan(w)) sum += w * attenuation(e), share += w;
  const double water = 0.1119 * attenuation(elements[0]) + 0.8881 * attenuation(elements[3]);
  return 1000 * (tissues.number(row, "density_kgm3") / 1000 * sum / share / water - 1);
}

struct CurveError {
  double largest = 0, of_mass = 0;
};

CurveError error_of(const DensityCurve& curve, const CsvTable& tissues) {
  CurveError error;
  double mass = 0, found = 0;
  for (std::size_t row = 0; row < tissues.rows.size(); ++row) {
    const double ratio = curve.at(ct_number(tissues, row)) / tissues.number(row, "density_kgm3");
    error.largest = std::max(error.largest, std::abs(ratio - 1));
    mass += tissues.number(row, "kg_in_male");
    found += tissues.number(row, "kg_in_male") * ratio;
  }
  error.of_mass = found / mass - 1;
  return error;
}

TEST(Density, DefaultCurveIsClosestToIcru44Tissues) {
  const auto tissues =
      parse_csv(read_file(test::source_folder() + "/tests/inertia/icru44_tissues.csv"), "tissues");
  ASSERT_TRUE(tissues);
  for (std::size_t row = 0; row < tissues->rows.size();
       ++row) {  // the tables' rounding: 0.05 in each of 13 elements
    double share = 0;
    for (std::size_t c = 2; c < 14; ++c)
      if (!tissues->rows[row][c].empty()) share += std::stod(tissues->rows[row][c]);
    EXPECT_NEAR(share, 100, 0.2) << tissues->rows[row][0];
  }
  std::map<std::string, CurveError> errors;
  for (const auto& curve : density_curves()) {
    errors[curve.name] = error_of(curve, *tissues);
    RecordProperty(curve.name, std::to_string(errors[curve.name].of_mass));
  }
  const CurveError by_default = errors[std::string(default_density_curve)];
  for (const auto& [name, error] : errors)
    if (name != default_density_curve) {
      EXPECT_LT(by_default.largest, 0.5 * error.largest) << name;
    }
  // as density.hpp states
  EXPECT_NEAR(by_default.largest, 0.008, 0.0005);
  EXPECT_LT(std::abs(by_default.of_mass), 0.005);
}

}  // namespace
}  // namespace borelli
