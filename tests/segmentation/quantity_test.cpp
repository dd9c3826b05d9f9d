// The quantity of voxels, decided from their values: hand-made files with one, two or no possible quantity.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <numeric>
#include <random>

#include "scratch_folder.hpp"
#include "segmentation/files/quantity.hpp"
#include "segmentation/files/read.hpp"
#include "tests/paths.hpp"

namespace borelli {
namespace {

StoredVoxels floats(const std::vector<float>& values) {
  StoredVoxels voxels{Scalar::f32, values.size(), {}};
  voxels.storage.resize(values.size() * 2);
  std::memcpy(voxels.storage.data(), values.data(), values.size() * 4);
  return voxels;
}

Result<QuantityReading> decide(const std::vector<float>& values, std::optional<FileQuantity> asked = {},
                               const std::string& recorded = "") {
  const StoredVoxels voxels = floats(values);
  return decide_quantity("file", voxels, 1, 0, value_range(voxels, 1, 0), asked, recorded);
}

// n values around `middle`, then air: a body in a box, without anatomy
std::vector<float> body(float middle, float spread, float air, std::size_t n = 1000) {
  std::mt19937 random(3);
  std::normal_distribution<float> tissue(middle, spread);
  std::vector<float> values(n, air);
  for (std::size_t i = 0; i < n / 2; ++i) values[i] = tissue(random);
  return values;
}

TEST(Quantity, RecognisesCtNumbers) {
  const auto plain = decide(body(40, 60, -1000));
  ASSERT_TRUE(plain) << plain.error().message();
  EXPECT_EQ(plain->quantity, FileQuantity::hu);
  EXPECT_NE(plain->statement.find("no other reading"), std::string::npos);

  auto padded = body(40, 60, -1000);  // a tenth outside the field of view
  for (std::size_t i = 900; i < 1000; ++i) padded[i] = -3024;
  const auto with_padding = decide(padded);
  ASSERT_TRUE(with_padding) << with_padding.error().message();
  EXPECT_EQ(with_padding->quantity, FileQuantity::hu);
}

TEST(Quantity, RecognisesDensitiesInGrams) {
  const auto grams = decide(body(1.04f, 0.03f, 0.001f));
  ASSERT_TRUE(grams) << grams.error().message();
  EXPECT_EQ(grams->quantity, FileQuantity::density_gcm3);
}

TEST(Quantity, RecognisesLabels) {
  std::vector<float> labels;
  for (const int label : {0, 3, 7, 0, 7, 16, 0}) labels.insert(labels.end(), 50, static_cast<float>(label));
  const auto read = decide(labels);
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->quantity, FileQuantity::labels);
}

TEST(Quantity, RefusesAmbiguousValues) {
  // CT numbers with 1024 added and densities in kg/m3 look alike
  EXPECT_FALSE(decide(body(1064, 60, 24)));
  // MR: whole numbers without a scale, air near 0
  std::mt19937 random(5);
  std::vector<float> mr(1000);
  for (auto& v : mr) v = static_cast<float>(random() % 255);
  EXPECT_FALSE(decide(mr));
  // MR scaled to 1
  for (auto& v : mr) v /= 255;
  EXPECT_FALSE(decide(mr));
  // MR phase, from -4096 to 4095: passes through air's and water's numbers, but goes below them too
  for (auto& v : mr) v = static_cast<float>(static_cast<int>(random() % 8192) - 4096);
  EXPECT_FALSE(decide(mr));
  // a body mask as float: 0 or 1
  std::vector<float> mask(1000, 0);
  std::fill_n(mask.begin(), 500, 1.f);
  const auto as_mask = decide(mask);
  ASSERT_TRUE(as_mask);
  EXPECT_EQ(as_mask->quantity, FileQuantity::labels);
  // the error names the range and the choices
  const auto refused = decide(body(1064, 60, 24));
  EXPECT_NE(refused.error().what.find("--quantity hu"), std::string::npos) << refused.error().message();
  EXPECT_EQ(refused.error().kind, Error::Kind::use);
}

TEST(Quantity, RequestIsUsedUnlessImpossible) {
  EXPECT_EQ(decide(body(1064, 60, 24), FileQuantity::density_kgm3)->quantity, FileQuantity::density_kgm3);
  EXPECT_EQ(decide(body(1064, 60, 24), FileQuantity::mr)->quantity, FileQuantity::mr);
  EXPECT_EQ(decide(body(1064, 60, 24), {}, "mr")->quantity, FileQuantity::mr);
  EXPECT_FALSE(decide(body(1064, 60, 24), FileQuantity::density_gcm3));     // 1064 g/cm3
  EXPECT_FALSE(decide(body(1.064f, 0.1f, 0), FileQuantity::density_kgm3));  // 1 kg/m3
  EXPECT_FALSE(decide(body(40, 60, -1000), FileQuantity::density_kgm3));    // negative density
  EXPECT_FALSE(decide(body(40, 60, -1000), FileQuantity::labels));          // negative and fractional labels
  EXPECT_FALSE(decide(std::vector<float>(100, NAN), FileQuantity::hu));
}

TEST(Quantity, SuggestsPossibleQuantities) {
  const auto advice = [](const std::vector<float>& values, FileQuantity asked) {
    const auto refused = decide(values, asked);
    return refused ? std::string("not refused") : refused.error().what;
  };
  const auto ends = [](const std::string& text, const std::string& end) {
    EXPECT_TRUE(text.ends_with(end)) << text;
  };
  const auto hu = body(40, 60, -1000), grams = body(1.04f, 0.03f, 0.001f), kilograms = body(1064, 60, 0);
  ends(advice(hu, FileQuantity::density_gcm3), "give hu");
  ends(advice(hu, FileQuantity::density_kgm3), "give hu");
  ends(advice(grams, FileQuantity::density_kgm3), "give density_gcm3");
  ends(advice(kilograms, FileQuantity::density_gcm3), "give density_kgm3");
  // no quantity fits: no advice
  std::vector<float> stretched(100, -3e6f);
  stretched[0] = 3e6f;
  EXPECT_EQ(advice(stretched, FileQuantity::density_gcm3).find("give "), std::string::npos);
}

TEST(Quantity, GramsBecomeKilogramsPerCubicMetre) {
  std::vector<std::string> warnings;
  const auto stored = floats({0, 0.0012f, 1.0004f, 1.92f, -0.1f});
  const auto values = to_int16(stored, 1, 0, value_range(stored, 1, 0), FileQuantity::density_gcm3, warnings);
  EXPECT_EQ(values, (std::vector<std::int16_t>{0, 1, 1000, 1920, 0}));
  ASSERT_EQ(warnings.size(), 1u);  // the overshoot below 0
  EXPECT_NE(warnings[0].find("1 voxels (20 %) below 0"), std::string::npos) << warnings[0];
}

// A file with NaN outside the field of view reads like one with a padding value there.
TEST(Quantity, NonFiniteValuesCountAsPadding) {
  std::vector<float> padded = body(40, 60, -1000), holes = padded;
  for (std::size_t n = 0; n < 20; ++n) padded[50 * n] = -2000, holes[50 * n] = std::nanf("");
  const auto read = [](const std::vector<float>& values, FileQuantity quantity,
                       std::vector<std::string>& warnings) {
    const StoredVoxels stored = floats(values);
    return to_int16(stored, 1, 0, value_range(stored, 1, 0), quantity, warnings);
  };
  std::vector<std::string> warnings, other;
  EXPECT_EQ(read(holes, FileQuantity::hu, warnings), read(padded, FileQuantity::hu, other));
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("20 voxels (2 %) are not finite numbers; the scan does not show"),
            std::string::npos)
      << warnings[0];
  EXPECT_EQ(read({std::nanf(""), 0, 1050, INFINITY}, FileQuantity::density_kgm3, warnings),
            (std::vector<std::int16_t>{padding_density, 0, 1050, padding_density}));
  EXPECT_EQ(read({std::nanf(""), 0, 4000}, FileQuantity::mr, warnings),
            (std::vector<std::int16_t>{0, 0, 4000}));
}

TEST(Quantity, MrKeepsItsSteps) {
  std::vector<std::string> warnings;
  const auto small = floats({0, 0.25f, 0.5f, 1});
  EXPECT_EQ(to_int16(small, 1, 0, value_range(small, 1, 0), FileQuantity::mr, warnings),
            (std::vector<std::int16_t>{0, 7500, 15000, 30000}));
  EXPECT_EQ(warnings.size(), 1u);
  const auto large = floats({0, 60000});
  EXPECT_EQ(to_int16(large, 1, 0, value_range(large, 1, 0), FileQuantity::mr, warnings),
            (std::vector<std::int16_t>{0, 30000}));
  warnings.clear();
  const auto fits = floats({0, 1, 4095});
  EXPECT_EQ(to_int16(fits, 1, 0, value_range(fits, 1, 0), FileQuantity::mr, warnings),
            (std::vector<std::int16_t>{0, 1, 4095}));
  EXPECT_TRUE(warnings.empty());
}

// Ranges of blocks combine in any order to the range of all, even if blocks have no finite value or repeat
// the least one.
TEST(Quantity, RangesOfBlocksCombine) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const StoredVoxels voxels = floats({nan, nan, 3, 1.5F, -7, 2, nan, -7, -7, 4, 9, 9});
  const auto expect = [&](const ValueRange& r) {
    EXPECT_EQ(r.least, -7);
    EXPECT_EQ(r.greatest, 9);
    EXPECT_EQ(r.count, 12U);
    EXPECT_EQ(r.not_finite, 3U);
    EXPECT_EQ(r.fractional, 1U);
    EXPECT_EQ(r.at_least, 3U);
  };
  expect(value_range(voxels, 1, 0));
  std::vector<ValueRange> pieces;
  for (const auto& [first, last] : {std::pair(0U, 2U), {2U, 4U}, {4U, 8U}, {8U, 9U}, {9U, 12U}})
    pieces.push_back(value_range(voxels, 1, 0, first, last));
  EXPECT_EQ(pieces[0].not_finite, 2U);
  std::vector<std::size_t> order(pieces.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  do {
    ValueRange whole;
    for (const std::size_t n : order) whole += pieces[n];
    expect(whole);
  } while (std::ranges::next_permutation(order).found);
}

template <class T>
StoredVoxels stored_as(Scalar scalar, const std::vector<T>& values) {
  StoredVoxels voxels{scalar, values.size(), {}};
  voxels.storage.resize((values.size() * sizeof(T) + 1) / 2);
  std::memcpy(voxels.storage.data(), values.data(), values.size() * sizeof(T));
  return voxels;
}

// integers of few bits against the same values as doubles
template <class T>
void expect_as_doubles(Scalar scalar, const std::vector<T>& raw, double slope, double intercept) {
  SCOPED_TRACE(testing::Message() << scalar_name(scalar) << ' ' << slope << ' ' << intercept);
  std::vector<double> values;
  for (const T value : raw) values.push_back(slope * double(value) + intercept);
  const StoredVoxels whole = stored_as(scalar, raw), doubles = stored_as(Scalar::f64, values);
  const ValueRange range = value_range(whole, slope, intercept), of_doubles = value_range(doubles, 1, 0);
  EXPECT_EQ(range.least, of_doubles.least);
  EXPECT_EQ(range.greatest, of_doubles.greatest);
  EXPECT_EQ(range.count, of_doubles.count);
  EXPECT_EQ(range.not_finite, 0u);
  EXPECT_EQ(range.fractional, of_doubles.fractional);
  EXPECT_EQ(range.at_least, of_doubles.at_least);
  const auto decided = decide_quantity("file", whole, slope, intercept, range, {}, "");
  const auto by_doubles = decide_quantity("file", doubles, 1, 0, of_doubles, {}, "");
  ASSERT_EQ(decided.has_value(), by_doubles.has_value());
  if (decided)
    EXPECT_EQ(decided->statement, by_doubles->statement);
  else
    EXPECT_EQ(decided.error().message(), by_doubles.error().message());
  for (const FileQuantity quantity : {FileQuantity::hu, FileQuantity::density_kgm3,
                                      FileQuantity::density_gcm3, FileQuantity::labels, FileQuantity::mr}) {
    std::vector<std::string> warnings, other;
    EXPECT_EQ(to_int16(whole, slope, intercept, range, quantity, warnings),
              to_int16(doubles, 1, 0, of_doubles, quantity, other))
        << quantity_name(quantity);
    EXPECT_EQ(warnings, other);
  }
}

TEST(Quantity, ShortIntegersAreReadLikeDoubles) {
  std::mt19937 random(11);
  const auto numbers = [&]<class T>(T, int low, int high, std::size_t n) {
    std::uniform_int_distribution<int> value(low, high);
    std::vector<T> out(n);
    for (T& x : out) x = static_cast<T>(value(random));
    return out;
  };
  std::vector<std::int16_t> scan = numbers(std::int16_t{}, -1060, 1500, 100001);
  for (std::size_t n = 0; n < scan.size(); ++n)
    if (n % 3 == 0) scan[n] = -1000;
  std::vector<std::int16_t> padded = scan;
  for (std::size_t n = 0; n < padded.size(); n += 7) padded[n] = -3024;
  std::vector<std::uint16_t> shifted;
  for (const std::int16_t value : scan) shifted.push_back(static_cast<std::uint16_t>(value + 1100));
  std::vector<std::uint8_t> labels;
  for (int n = 0; n < 70000; ++n) labels.push_back(static_cast<std::uint8_t>(n / 1000 % 3 ? n / 7000 : 0));
  for (const auto& [slope, intercept] : {std::pair{1.0, 0.0},
                                         {1.0, -1100.0},
                                         {-1.0, 5.0},
                                         {2.0, -3.0},
                                         {0.5, 0.25},
                                         {0.0, 7.0},
                                         {100.0, 16384.0},
                                         {20000.0, 0.0}}) {
    expect_as_doubles(Scalar::i16, scan, slope, intercept);
    expect_as_doubles(Scalar::i16, padded, slope, intercept);
    expect_as_doubles(Scalar::u16, shifted, slope, intercept);
    expect_as_doubles(Scalar::u8, labels, slope, intercept);
    expect_as_doubles(Scalar::i8, numbers(std::int8_t{}, -128, 127, 1000), slope, intercept);
    expect_as_doubles(Scalar::i16, numbers(std::int16_t{}, -32768, 32767, 3), slope, intercept);
    expect_as_doubles(Scalar::u16, numbers(std::uint16_t{}, 0, 65535, 1), slope, intercept);
  }
}

TEST(Quantity, NamesRoundTrip) {
  for (const char* name : {"hu", "density_kgm3", "density_gcm3", "labels", "mr"})
    EXPECT_EQ(quantity_name(*parse_quantity(name)), name);
  EXPECT_FALSE(parse_quantity("HU"));
}

std::string shared(const std::string& name) { return test::shared_folder() + "/volumes/" + name; }

// Real files whose quantity is known from their source.
TEST(Quantity, RecognisesRealFiles) {
  const std::string am = shared("icrp_am/AM_hu.nii.gz");
  if (!std::filesystem::exists(am)) GTEST_SKIP() << "the ICRP male is not there: " << am;
  const auto hu = read_volume(am), abdomen = read_volume(shared("ct_abdomen_3mm.nii.gz")),
             labels = read_volume(shared("icrp_am/AM_labels.nii.gz")),
             density = read_volume(shared("icrp_am/AM_density_kgm3.nii.gz"));
  ASSERT_TRUE(hu) << hu.error().message();
  EXPECT_EQ(hu->volume.quantity, Quantity::hu);
  ASSERT_TRUE(abdomen) << abdomen.error().message();
  EXPECT_EQ(abdomen->volume.quantity, Quantity::hu);
  ASSERT_TRUE(labels) << labels.error().message();
  EXPECT_EQ(labels->volume.quantity, Quantity::labels);
  EXPECT_FALSE(density) << "densities in kg/m3 could be CT numbers with 1024 added";
}

}  // namespace
}  // namespace borelli
