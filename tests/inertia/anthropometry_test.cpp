#include "inertia/anthropometry.hpp"
#include "tests/paths.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include "inertia/csv.hpp"
#include "tests/inertia/checksum.hpp"

namespace borelli {
namespace data {
extern const char* const deleva1996;
extern const char* const dumas2007;
extern const char* const winter2009;
extern const char* const zatsiorsky2002;
}  // namespace data
namespace {

TEST(Anthropometry, DataHaveTheirProofreadChecksum) {
  EXPECT_EQ(checksum(data::deleva1996), 4156993167460503624u);
  EXPECT_EQ(checksum(data::dumas2007), 5443407324323167102u);
  EXPECT_EQ(checksum(data::winter2009), 17342387942170466158u);
  EXPECT_EQ(checksum(data::zatsiorsky2002), 9895171158965395203u);
}

Result<CsvTable> shared_table(const std::string& name) {
  std::ifstream file(test::shared_folder() + "/reference/" + name);
  std::ostringstream text;
  text << file.rdbuf();
  return parse_csv(text.str(), name);
}

const std::map<std::string, std::string> our_names{{"Head", "head"},
                                                   {"Trunk", "trunk"},
                                                   {"UpperTrunk", "upper_trunk"},
                                                   {"MiddleTrunk", "middle_trunk"},
                                                   {"LowerTrunk", "lower_trunk"},
                                                   {"UpperArm", "upper_arm"},
                                                   {"Forearm", "forearm"},
                                                   {"Hand", "hand"},
                                                   {"Thigh", "thigh"},
                                                   {"Shank", "shank"},
                                                   {"Foot", "foot"},
                                                   {"HeadNeck", "head"},
                                                   {"Torso", "torso"},
                                                   {"Pelvis", "pelvis"}};

constexpr double rounding = 1e-12;

TEST(Anthropometry, DeLevaEqualsTheSharedTable) {
  const auto shared = shared_table("deleva1996.csv");
  if (!shared) GTEST_SKIP() << "no reference/deleva1996.csv beside the checkout";
  for (std::size_t row = 0; row < shared->rows.size(); ++row) {
    const std::string ends = shared->field(row, "endpoints"),
                      segment = our_names.at(shared->field(row, "segment"));
    const std::size_t dash = ends.find('-');
    int found = 0;
    for (const auto& published : published_segments())
      if (published.table == "deleva1996" && published.sex == shared->field(row, "sex") &&
          published.segment == segment && published.from == ends.substr(0, dash) &&
          published.to == ends.substr(dash + 1)) {
        ++found;
        EXPECT_NEAR(100 * published.mass_share, shared->number(row, "mass_pct"), rounding);
        EXPECT_NEAR(100 * published.centre_along, shared->number(row, "com_pct"), rounding);
        EXPECT_NEAR(1000 * published.length, shared->number(row, "mean_length_mm"), 1e-9);
        const bool foot = segment == "foot";
        EXPECT_NEAR(100 * published.radii[foot ? 1 : 0], shared->number(row, "r_sagittal_pct"), rounding);
        EXPECT_NEAR(100 * published.radii[foot ? 0 : 1], shared->number(row, "r_longitudinal_pct"), rounding);
        EXPECT_NEAR(100 * published.radii[2], shared->number(row, "r_transverse_pct"), rounding);
      }
    EXPECT_EQ(found, 1) << segment << " " << ends;
  }
}

TEST(Anthropometry, DumasEqualsTheSharedTable) {
  const auto shared = shared_table("dumas2007.csv");
  if (!shared) GTEST_SKIP() << "no reference/dumas2007.csv beside the checkout";
  // our rows of 2007 equal the shared table's, in order
  std::vector<const PublishedSegment*> ours;
  for (const auto& published : published_segments())
    if (published.table == "dumas2007") ours.push_back(&published);
  std::size_t next = 0;
  for (std::size_t row = 0; row < shared->rows.size(); ++row) {
    const std::string& name = shared->field(row, "segment");
    if (name.find("Dumas2015") != name.npos) continue;
    ASSERT_LT(next, ours.size());
    const PublishedSegment& published = *ours[next++];
    EXPECT_EQ(published.sex, shared->field(row, "sex"));
    EXPECT_EQ(published.segment, our_names.at(name));
    EXPECT_NEAR(100 * published.mass_share, shared->number(row, "mass_pct"), rounding);
    const char* radii[3] = {"rxx", "ryy", "rzz"};
    const char* products[3] = {"rxy", "rxz", "ryz"};
    const char* signs[3] = {"sign_xy", "sign_xz", "sign_yz"};
    for (int n = 0; n < 3; ++n) {
      EXPECT_NEAR(100 * published.radii[n], shared->number(row, radii[n]), rounding);
      EXPECT_NEAR(100 * published.products[n],
                  shared->number(row, signs[n]) * shared->number(row, products[n]), rounding)
          << name << " " << n;
    }
    if (published.from == "HJC") {
      EXPECT_NEAR(-100 * published.centre_along, shared->number(row, "com_y"), rounding);
    }
    if (published.from == "CAL") {
      EXPECT_NEAR(100 * published.centre_along, shared->number(row, "com_x"), rounding);
    }
  }
  EXPECT_EQ(next, ours.size());
}

TEST(Anthropometry, WinterEqualsTheSharedTable) {
  const auto shared = shared_table("winter_dempster.csv");
  if (!shared) GTEST_SKIP() << "no reference/winter_dempster.csv beside the checkout";
  std::vector<const PublishedSegment*> ours;
  for (const auto& published : published_segments())
    if (published.table == "winter2009") ours.push_back(&published);
  ASSERT_EQ(ours.size(), shared->rows.size());
  for (std::size_t row = 0; row < ours.size(); ++row) {  // in the same order
    EXPECT_NEAR(ours[row]->mass_share, shared->number(row, "mass_frac"), rounding);
    EXPECT_NEAR(ours[row]->centre_along, shared->number(row, "com_prox"), rounding);
    if (std::isfinite(shared->number(row, "rg_com"))) {
      EXPECT_NEAR(ours[row]->radii[2], shared->number(row, "rg_com"), rounding);
      // radii about an end follow by Steiner's theorem; the table rounds each to 0.001. Three rows do not:
      // the foot, the whole leg (0.560 printed, 0.553 from the other two) and the head, whose centre lies at
      // its end.
      const std::string& name = ours[row]->segment;
      const bool odd = name == "foot" || name == "head" || name == "leg";
      const double about_end = std::hypot(ours[row]->radii[2], ours[row]->centre_along);
      if (!odd) {
        EXPECT_NEAR(about_end, shared->number(row, "rg_prox"), 0.002) << ours[row]->segment;
      }
    }
    const std::string ends = shared->field(row, "endpoints");
    EXPECT_TRUE(ends.starts_with(ours[row]->from + "-" + ours[row]->to)) << ends;
  }
}

TEST(Anthropometry, ZatsiorskyEqualsTheSharedTable) {
  const auto shared = shared_table("zatsiorsky_mean.csv");
  if (!shared) GTEST_SKIP() << "no reference/zatsiorsky_mean.csv beside the checkout";
  const CsvTable ours = parse_csv(data::zatsiorsky2002, "zatsiorsky2002.csv").value();
  ASSERT_EQ(ours.rows.size(), shared->rows.size());
  for (std::size_t row = 0; row < ours.rows.size(); ++row) {
    EXPECT_EQ(ours.field(row, "sex"), shared->field(row, "sex"));
    for (const auto& [own, theirs] : {std::pair{"mass_kg", "mass_kg"},
                                      {"mass_pct", "mass_pct"},
                                      {"sagittal_kgcm2", "I_sagittal_kgcm2"},
                                      {"transverse_kgcm2", "I_transverse_kgcm2"},
                                      {"longitudinal_kgcm2", "I_longitudinal_kgcm2"}})
      EXPECT_EQ(ours.number(row, own), shared->number(row, theirs)) << own;
    // de Leva took the masses over
    const auto* deleva = published_segment("deleva1996", ours.field(row, "sex"), ours.field(row, "segment"),
                                           "", "", ours.field(row, "cuts"));
    ASSERT_TRUE(deleva) << ours.field(row, "segment");
    EXPECT_NEAR(100 * deleva->mass_share, ours.number(row, "mass_pct"), 0.0101);
  }
}

const PublishedSegment& row(const char* table, const std::string& sex, const char* segment) {
  for (const auto& published : published_segments())
    if (published.table == table && published.sex == sex && published.segment == segment) return published;
  throw std::runtime_error(segment);
}

TEST(Anthropometry, MassesSumToTheBody) {
  for (const std::string sex : {"male", "female"}) {
    double deleva = row("deleva1996", sex, "head").mass_share,
           dumas = row("dumas2007", sex, "head").mass_share;
    for (const char* part : {"upper_trunk", "middle_trunk", "lower_trunk"})
      deleva += row("deleva1996", sex, part).mass_share;
    dumas += row("dumas2007", sex, "torso").mass_share + row("dumas2007", sex, "pelvis").mass_share;
    for (const char* part : {"upper_arm", "forearm", "hand", "thigh", "shank", "foot"}) {
      deleva += 2 * row("deleva1996", sex, part).mass_share;
      dumas += 2 * row("dumas2007", sex, part).mass_share;
    }
    EXPECT_NEAR(deleva, 1, 0.0003) << sex;  // ten numbers rounded to 0.01 %, the limbs' counted twice
    EXPECT_NEAR(dumas, 1, 0.003) << sex;    // nine rounded to 0.1 %
    double trunk = 0;
    for (const char* part : {"upper_trunk", "middle_trunk", "lower_trunk"})
      trunk += row("deleva1996", sex, part).mass_share;
    EXPECT_NEAR(trunk, row("deleva1996", sex, "trunk").mass_share, 0.00005) << sex;
  }
}

TEST(Anthropometry, DeLevasEndpointsDescribeSegmentsConsistently) {
  // A segment listed with several endpoints has one radius of gyration in mm and, from a common endpoint, one
  // gravity centre. So a wrong digit in any length or percentage shows.
  const auto& all = published_segments();
  int pairs = 0;
  for (const auto& a : all)
    for (const auto& b : all) {
      if (&a >= &b || a.table != "deleva1996" || b.table != a.table || a.sex != b.sex ||
          a.segment != b.segment)
        continue;
      ++pairs;
      const double length = 1000 * std::max(a.length, b.length);
      for (int n = 0; n < 3; ++n)  // percentages rounded to 0.1 each, lengths to 0.1 mm
        EXPECT_NEAR(1000 * a.radii[n] * a.length, 1000 * b.radii[n] * b.length, 1.05e-3 * length)
            << a.sex << " " << a.segment << " " << a.from << "-" << a.to << ", " << b.from << "-" << b.to;
      if (a.from == b.from) {
        EXPECT_NEAR(1000 * a.centre_along * a.length, 1000 * b.centre_along * b.length, 2e-4 * length + 0.1)
            << a.sex << " " << a.segment;
      }
    }
  EXPECT_GT(pairs, 20);
}

TEST(Anthropometry, ComparesOnlyWithTheSameEndpointsAndCuts) {
  const auto* thigh = published_segment("deleva1996", "female", "thigh", "HJC", "KJC", "zatsiorsky");
  ASSERT_TRUE(thigh);
  EXPECT_NEAR(thigh->mass_share, 0.1478, 1e-12);
  EXPECT_NEAR(thigh->centre_along, 0.3612, 1e-12);
  EXPECT_FALSE(published_segment("deleva1996", "female", "thigh", "HJC", "KJC", "mcconville"));
  EXPECT_FALSE(published_segment("dumas2007", "female", "thigh", "HJC", "KJC", "zatsiorsky"));
  EXPECT_FALSE(published_segment("dumas2007", "male", "head", "VERT", "CERV", "zatsiorsky"));
  EXPECT_TRUE(published_segment("dumas2007", "male", "shank", "KJC", "AJC", "joint"));
  EXPECT_FALSE(published_segment("deleva1996", "", "shank", "KJC", "AJC", "joint"));
}

}  // namespace
}  // namespace borelli
