// Reading and writing NIfTI: hand-made headers, real files, damage.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <numbers>
#include <random>

#include "grids.hpp"
#include "scratch_folder.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/files/write.hpp"
#include "tests/paths.hpp"

namespace borelli::nifti_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

template <class T>
T field(const std::vector<char>& bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

template <class T>
void set_field(std::vector<char>& bytes, std::size_t offset, T value) {
  std::memcpy(bytes.data() + offset, &value, sizeof value);
}

// the header stores float32: 24 bits of the largest entry (1234.5 mm) are 7e-5 mm; entries of the axes 3e-7
// mm
constexpr double origin_tolerance = 1e-4, axes_tolerance = 5e-7;

struct GridCase {
  bool mirrored;
  double sheared;
};
void PrintTo(const GridCase& c, std::ostream* out) {
  *out << (c.mirrored ? "mirrored" : "as it is") << ", sheared by " << c.sheared;
}

class NiftiRoundTrip : public ::testing::TestWithParam<GridCase> {};

TEST_P(NiftiRoundTrip, KeepsGridVoxelsAndQuantity) {
  ScratchFolder folder;
  const Grid grid = oblique_grid(GetParam().mirrored, GetParam().sheared);
  for (const std::string name : {"a.nii", "a.nii.gz"}) {
    const GreyVolume volume = noise_volume(grid, Quantity::hu);
    ASSERT_TRUE(write_volume(folder / name, volume));
    const auto back = read_volume(folder / name);
    ASSERT_TRUE(back) << back.error().message();
    EXPECT_EQ(back->volume.voxels, volume.voxels);
    EXPECT_EQ(back->volume.quantity, Quantity::hu);
    EXPECT_EQ(back->volume.grid.size, grid.size);
    EXPECT_LT((back->volume.grid.axes - grid.axes).cwiseAbs().maxCoeff(), axes_tolerance);
    EXPECT_LT((back->volume.grid.origin - grid.origin).cwiseAbs().maxCoeff(), origin_tolerance);
    EXPECT_TRUE(back->warnings.empty()) << back->warnings.front();
    EXPECT_NE(back->reading.find("header states"), std::string::npos) << back->reading;
  }
}

// The header's bytes as nifti1.h has them: the sform places voxel (1, 2, 3) where the grid does, in RAS; a
// set qform gives the same by the formula of nifti1.h.
TEST_P(NiftiRoundTrip, HeaderMatchesHandWrittenBytes) {
  ScratchFolder folder;
  const Grid grid = oblique_grid(GetParam().mirrored, GetParam().sheared);
  ASSERT_TRUE(write_volume(folder / "a.nii", noise_volume(grid, Quantity::hu)));
  const auto bytes = file_bytes(folder / "a.nii");
  ASSERT_EQ(bytes.size(), 352 + 2 * grid.count());
  EXPECT_EQ(field<std::int32_t>(bytes, 0), 348);
  EXPECT_EQ(std::string(bytes.data() + 344), "n+1");
  EXPECT_EQ(field<std::int16_t>(bytes, 40), 3);
  EXPECT_EQ(field<std::int16_t>(bytes, 44), 7);
  EXPECT_EQ(field<std::int16_t>(bytes, 70), 4);
  EXPECT_EQ(bytes[123] & 7, 2);

  const Vector3d lps = grid.point({1, 2, 3}), ras(-lps.x(), -lps.y(), lps.z());
  ASSERT_GT(field<std::int16_t>(bytes, 254), 0);
  Vector3d by_sform;
  for (std::size_t r = 0; r < 3; ++r) {
    const std::size_t row = 280 + 16 * r;
    by_sform[static_cast<int>(r)] = field<float>(bytes, row) + 2 * field<float>(bytes, row + 4) +
                                    3 * field<float>(bytes, row + 8) + field<float>(bytes, row + 12);
  }
  EXPECT_LT((by_sform - ras).norm(), origin_tolerance);

  if (GetParam().sheared != 0) {
    EXPECT_EQ(field<std::int16_t>(bytes, 252), 0) << "a quaternion cannot say a sheared grid";
    return;
  }
  ASSERT_GT(field<std::int16_t>(bytes, 252), 0);
  const double b = field<float>(bytes, 256), c = field<float>(bytes, 260), d = field<float>(bytes, 264);
  const double a = std::sqrt(1 - b * b - c * c - d * d), qfac = field<float>(bytes, 76);
  Matrix3d R;
  R << a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c),  //
      2 * (b * c + a * d), a * a + c * c - b * b - d * d, 2 * (c * d - a * b),   //
      2 * (b * d - a * c), 2 * (c * d + a * b), a * a + d * d - b * b - c * c;
  const Vector3d scaled(1 * field<float>(bytes, 80), 2 * field<float>(bytes, 84),
                        qfac * 3 * field<float>(bytes, 88));
  const Vector3d offset(field<float>(bytes, 268), field<float>(bytes, 272), field<float>(bytes, 276));
  EXPECT_LT((R * scaled + offset - ras).norm(), origin_tolerance);
}

INSTANTIATE_TEST_SUITE_P(Grids, NiftiRoundTrip,
                         ::testing::Values(GridCase{false, 0}, GridCase{true, 0}, GridCase{false, 1.5},
                                           GridCase{true, -0.8}));

// A header made by hand, any field of which a test may set.
struct HandMade {
  std::vector<char> bytes = std::vector<char>(352, 0);

  HandMade(std::array<std::int16_t, 8> dim, std::int16_t datatype, std::int16_t bits) {
    set_field<std::int32_t>(bytes, 0, 348);
    for (std::size_t i = 0; i < 8; ++i) set_field(bytes, 40 + 2 * i, dim[i]);
    set_field(bytes, 70, datatype);
    set_field(bytes, 72, bits);
    for (std::size_t i = 0; i < 8; ++i) set_field(bytes, 76 + 4 * i, 1.f);
    set_field(bytes, 108, 352.f);
    bytes[123] = 2;
    std::memcpy(bytes.data() + 344, "n+1", 4);
  }
  void sform(const std::array<float, 12>& rows) {
    set_field<std::int16_t>(bytes, 254, 1);
    for (std::size_t i = 0; i < 12; ++i) set_field(bytes, 280 + 4 * i, rows[i]);
    for (std::size_t c = 0; c < 3; ++c)  // pixdim agrees
      set_field(bytes, 80 + 4 * c, std::hypot(rows[c], rows[4 + c], rows[8 + c]));
  }
  // converts all fields, and `count` voxels of `width` bytes, to big-endian
  void to_big_endian(std::size_t width, std::size_t count) {
    const auto turn = [&](std::size_t offset, std::size_t bytes, std::size_t n) {
      for (std::size_t i = 0; i < n; ++i)
        std::reverse(bytes_at(offset + i * bytes), bytes_at(offset + (i + 1) * bytes));
    };
    turn(0, 4, 1), turn(40, 2, 8), turn(68, 2, 4), turn(76, 4, 8), turn(108, 4, 3), turn(252, 2, 2);
    turn(256, 4, 18), turn(352, width, count);
  }
  std::vector<char>::iterator bytes_at(std::size_t offset) {
    return bytes.begin() + static_cast<std::ptrdiff_t>(offset);
  }
  template <class T>
  void voxels(const std::vector<T>& values) {
    const auto* first = reinterpret_cast<const char*>(values.data());
    bytes.insert(bytes.end(), first, first + values.size() * sizeof(T));
  }
};

const std::array<float, 12> plain_rows{2, 0, 0, 10, 0, 2, 0, 20, 0, 0, 3, 30};
const ReadOptions as_hu{FileQuantity::hu, {}};

template <class T>
void expect_values(std::int16_t datatype, const std::vector<T>& stored, float slope, float intercept,
                   const std::vector<std::int16_t>& expected) {
  ScratchFolder folder;
  HandMade file({3, 2, 2, 1, 1, 1, 1, 1}, datatype, static_cast<std::int16_t>(8 * sizeof(T)));
  set_field(file.bytes, 112, slope);
  set_field(file.bytes, 116, intercept);
  file.sform(plain_rows);
  file.voxels(stored);
  put_bytes(folder / "a.nii", file.bytes);
  const auto back = read_volume(folder / "a.nii", as_hu);
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(back->volume.voxels, expected) << "datatype " << datatype;
}

TEST(Nifti, ReadsEveryScalarTypeWithSlopeAndIntercept) {
  expect_values<std::uint8_t>(2, {0, 1, 200, 255}, 2, -100, {-100, -98, 300, 410});
  expect_values<std::int8_t>(256, {-128, 0, 1, 127}, 0, 99, {-128, 0, 1, 127});  // slope 0: no scaling
  expect_values<std::uint16_t>(512, {0, 1000, 2000, 33000}, 1, -1024, {-1024, -24, 976, 31976});
  expect_values<std::int16_t>(4, {-1000, 0, 40, 3000}, 1, 0, {-1000, 0, 40, 3000});
  expect_values<std::uint32_t>(768, {0, 1000, 2000, 4095}, 1, -1000, {-1000, 0, 1000, 3095});
  expect_values<std::int32_t>(8, {-1000, 0, 40, 3000}, 1, 0, {-1000, 0, 40, 3000});
  expect_values<std::int64_t>(1024, {-1000, 0, 40, 3000}, 1, 0, {-1000, 0, 40, 3000});
  expect_values<std::uint64_t>(1280, {0, 1, 40, 3000}, 1, 0, {0, 1, 40, 3000});
  expect_values<float>(16, {-999.6f, 0.4f, 40.6f, 3000}, 1, 0, {-1000, 0, 41, 3000});
  expect_values<double>(64, {-999.6, 0.4, 40.6, 3000}, 1, 0, {-1000, 0, 41, 3000});
}

// Files of many blocks, whose voxels are byte-swapped and checked while more are read, and converted in
// slabs.
template <class T>
void expect_blocks(std::int16_t datatype, bool big_endian, bool packed) {
  SCOPED_TRACE(testing::Message() << "datatype " << datatype << (big_endian ? ", big endian" : "")
                                  << (packed ? ", packed" : ""));
  HandMade file({3, 131, 127, 150, 1, 1, 1, 1}, datatype, static_cast<std::int16_t>(8 * sizeof(T)));
  file.sform(plain_rows);
  std::mt19937 random(5);
  std::uniform_int_distribution<int> value(-1000, 3000);
  std::vector<T> stored(131 * 127 * 150);
  std::vector<std::int16_t> expected;
  for (T& v : stored) {
    const int whole = value(random);
    v = static_cast<T>(whole);
    expected.push_back(static_cast<std::int16_t>(whole));
  }
  if constexpr (std::is_floating_point_v<T>) stored.back() = NAN, expected.back() = padding_hu;
  file.voxels(stored);
  if (big_endian) file.to_big_endian(sizeof(T), stored.size());
  ScratchFolder folder;
  const std::string path = folder / (packed ? "a.nii.gz" : "a.nii");
  auto sink = ByteSink::create(path, packed ? ByteSink::Packing::gzip : ByteSink::Packing::plain);
  ASSERT_TRUE(sink);
  ASSERT_TRUE(sink->write(std::as_bytes(std::span(file.bytes))));
  ASSERT_TRUE(sink->close());
  std::vector<double> progress;
  const auto back = read_volume(path, {FileQuantity::hu, [&](double done) { progress.push_back(done); }});
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_GT(progress.size(), 1U);
  EXPECT_TRUE(back->volume.voxels == expected);
  EXPECT_EQ(back->least, *std::ranges::min_element(expected));
  EXPECT_EQ(back->greatest, *std::ranges::max_element(expected));
}

TEST(Nifti, ChecksVoxelsOfAllBlocks) {
  for (const bool big_endian : {false, true})
    for (const bool packed : {false, true}) {
      expect_blocks<std::int16_t>(4, big_endian, packed);
      expect_blocks<float>(16, big_endian, packed);
      expect_blocks<double>(64, big_endian, packed);
    }
}

TEST(Nifti, MarksPaddingAndClampsWithWarnings) {
  ScratchFolder folder;
  HandMade file({3, 4, 5, 2, 1, 1, 1, 1}, 16, 32);
  file.sform(plain_rows);
  std::vector<float> stored(40, 40);
  std::ranges::copy(std::vector<float>{-3024, -3024, -1024, 0, 40, 50000, NAN, INFINITY}, stored.begin());
  file.voxels(stored);
  put_bytes(folder / "a.nii", file.bytes);
  const auto back = read_volume(folder / "a.nii", as_hu);
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(std::vector(back->volume.voxels.begin(), back->volume.voxels.begin() + 8),
            (std::vector<std::int16_t>{padding_hu, padding_hu, -1024, 0, 40, 32767, padding_hu, padding_hu}));
  ASSERT_EQ(back->warnings.size(), 3u);
  EXPECT_NE(back->warnings[0].find("2 voxels (5 %) at -3024 are padding"), std::string::npos)
      << back->warnings[0];
  EXPECT_NE(back->warnings[1].find("1 voxels (2.5 %) above 32767"), std::string::npos) << back->warnings[1];
  EXPECT_NE(back->warnings[2].find("2 voxels (5 %) are not finite"), std::string::npos) << back->warnings[2];
}

TEST(Nifti, DoubtsMissingAirAndRefusesAnAdded1024) {
  ScratchFolder folder;
  HandMade file({3, 2, 2, 1, 1, 1, 1, 1}, 512, 16);
  file.sform(plain_rows);
  file.voxels<std::uint16_t>({24, 1064, 1100, 24});  // air and tissue, 1024 added
  put_bytes(folder / "a.nii", file.bytes);
  const auto refused = read_volume(folder / "a.nii", as_hu);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("1000 or 1024 added"), std::string::npos)
      << refused.error().message();
  set_field<std::uint16_t>(file.bytes, 354, 40), set_field<std::uint16_t>(file.bytes, 356, 60);
  put_bytes(folder / "a.nii", file.bytes);
  const auto back = read_volume(folder / "a.nii", as_hu);
  ASSERT_TRUE(back) << back.error().message();
  ASSERT_EQ(back->warnings.size(), 1u);
  EXPECT_NE(back->warnings[0].find("CT numbers with 1024 added"), std::string::npos);
}

TEST(Nifti, ReadsBigEndianAndUnits) {
  ScratchFolder folder;
  HandMade file({3, 2, 2, 1, 1, 1, 1, 1}, 4, 16);
  file.bytes[123] = 1;  // metres
  file.sform({0.002f, 0, 0, 0.01f, 0, 0.002f, 0, 0.02f, 0, 0, 0.003f, 0.03f});
  file.voxels<std::int16_t>({-1000, 0, 40, 3000});
  file.to_big_endian(2, 4);
  put_bytes(folder / "a.nii", file.bytes);
  const auto back = read_volume(folder / "a.nii", as_hu);
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(back->volume.voxels, (std::vector<std::int16_t>{-1000, 0, 40, 3000}));
  const Grid& grid = back->volume.grid;  // RAS metres to LPS millimetres
  EXPECT_LT((grid.spacing() - Vector3d(2, 2, 3)).norm(), 1e-6);
  EXPECT_LT((grid.origin - Vector3d(-10, -20, 30)).norm(), 1e-5);
  EXPECT_LT(grid.axes(0, 0), 0);
}

TEST(Nifti, ReportsConflictingSformAndQform) {
  ScratchFolder folder;
  HandMade file({3, 2, 2, 1, 1, 1, 1, 1}, 4, 16);
  set_field<float>(file.bytes, 80, 2), set_field<float>(file.bytes, 84, 2),
      set_field<float>(file.bytes, 88, 3);
  file.sform(plain_rows);
  set_field<std::int16_t>(file.bytes, 252, 1);
  set_field<float>(file.bytes, 268, 10), set_field<float>(file.bytes, 272, 20),
      set_field<float>(file.bytes, 276, 30);
  file.voxels<std::int16_t>({-1000, 0, 40, 3000});
  put_bytes(folder / "same.nii", file.bytes);
  set_field<float>(file.bytes, 268, 17);
  put_bytes(folder / "apart.nii", file.bytes);
  const auto same = read_volume(folder / "same.nii", as_hu), apart = read_volume(folder / "apart.nii", as_hu);
  ASSERT_TRUE(same && apart);
  EXPECT_TRUE(same->warnings.empty());
  ASSERT_EQ(apart->warnings.size(), 1u);
  EXPECT_NE(apart->warnings[0].find("differ by up to 3.5"), std::string::npos)
      << apart->warnings[0];  // 7 mm of 2
  EXPECT_EQ(apart->volume.grid, same->volume.grid);
}

// If sform and qform are mirror images, the patient's left is unknown.
TEST(Nifti, RefusesMirroredForms) {
  ScratchFolder folder;
  HandMade file({3, 2, 2, 1, 1, 1, 1, 1}, 4, 16);
  set_field<float>(file.bytes, 80, 2), set_field<float>(file.bytes, 84, 2),
      set_field<float>(file.bytes, 88, 3);
  file.sform({-2, 0, 0, 10, 0, 2, 0, 20, 0, 0, 3, 30});
  set_field<std::int16_t>(file.bytes, 252, 1);  // a quaternion of no rotation
  file.voxels<std::int16_t>({-1000, 0, 40, 3000});
  put_bytes(folder / "a.nii", file.bytes);
  const auto read = read_volume(folder / "a.nii", as_hu);
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message().find("mirror each other"), std::string::npos) << read.error().message();
  set_field<std::int16_t>(file.bytes, 252, 0);
  put_bytes(folder / "a.nii", file.bytes);
  EXPECT_TRUE(read_volume(folder / "a.nii", as_hu));
}

TEST(Nifti, ReadsUnitsOfLength) {
  ScratchFolder folder;
  const auto read = [&](char code, float voxel) {
    HandMade file({3, 2, 2, 1, 1, 1, 1, 1}, 4, 16);
    file.bytes[123] = code;
    file.sform({voxel, 0, 0, 0, 0, voxel, 0, 0, 0, 0, voxel, 0});
    file.voxels<std::int16_t>({-1000, 0, 40, 3000});
    put_bytes(folder / "a.nii", file.bytes);
    return read_volume(folder / "a.nii", as_hu);
  };
  struct Case {
    char code;
    float voxel;
    double mm;
  };
  // metres, millimetres, micrometres, unset (programs mean millimetres); 16: seconds in the same field
  for (const Case& c : {Case{1, 0.002F, 2}, {2, 2, 2}, {3, 500, 0.5}, {0, 2, 2}, {2 + 16, 2, 2}}) {
    const auto fine = read(c.code, c.voxel);
    ASSERT_TRUE(fine) << fine.error().message();
    EXPECT_TRUE(fine->warnings.empty()) << fine->warnings[0];
    EXPECT_NEAR(fine->volume.grid.spacing()[0], c.mm, 1e-6);
  }
  for (const char code : {char{1}, char{3}}) {  // such files mean millimetres
    const auto doubted = read(code, 0.9F);
    ASSERT_TRUE(doubted) << doubted.error().message();
    EXPECT_NEAR(doubted->volume.grid.spacing()[0], 0.9, 1e-6);
    ASSERT_EQ(doubted->warnings.size(), 1u);
    EXPECT_NE(doubted->warnings[0].find("read as millimetres"), std::string::npos);
  }
  const auto unsaid = read(0, 0.002F), unknown = read(5, 2);
  ASSERT_FALSE(unsaid);
  EXPECT_NE(unsaid.error().message().find("does not state its unit"), std::string::npos);
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().message().find("a unit unknown to NIfTI (5"), std::string::npos);
}

struct BadFile {
  const char* name;
  std::function<void(std::vector<char>&)> spoil;
  const char* sentence;
};

TEST(Nifti, RefusesDamageInOneSentence) {
  const std::vector<BadFile> cases{
      {"cut", [](auto& b) { b.resize(b.size() - 3); }, "cut off"},
      {"header only", [](auto& b) { b.resize(352); }, "cut off"},
      {"stub", [](auto& b) { b.resize(100); }, "shorter than the header's 348 bytes"},
      {"empty", [](auto& b) { b.clear(); }, "shorter than the header's 348 bytes"},
      {"no magic", [](auto& b) { b[344] = 'x'; }, "not a NIfTI file"},
      {"text", [](auto& b) { b.assign(1000, 'q'); }, "not a NIfTI file"},
      {"half a pair", [](auto& b) { b[345] = 'i', b[346] = '1'; }, "pair"},
      {"negative size", [](auto& b) { set_field<std::int16_t>(b, 42, -2); }, "-2 voxels along axis 1"},
      {"absurd size",
       [](auto& b) { set_field<std::int16_t>(b, 42, 32000), set_field<std::int16_t>(b, 44, 32000); },
       "cut off"},
      {"time", [](auto& b) { set_field<std::int16_t>(b, 40, 4), set_field<std::int16_t>(b, 48, 9); },
       "9 volumes"},
      {"two dimensions", [](auto& b) { set_field<std::int16_t>(b, 40, 2); }, "2 dimensions"},
      {"colours", [](auto& b) { set_field<std::int16_t>(b, 70, 128); }, "colours"},
      {"complex", [](auto& b) { set_field<std::int16_t>(b, 70, 32); }, "complex"},
      {"unknown type", [](auto& b) { set_field<std::int16_t>(b, 70, 77); }, "datatype 77"},
      {"infinite slope", [](auto& b) { set_field<float>(b, 112, INFINITY); }, "scl_slope"},
      {"absurd offset", [](auto& b) { set_field<float>(b, 108, 1e30f); }, "vox_offset"},
      {"flat and no spacing",
       [](auto& b) {
         set_field<std::int16_t>(b, 254, 0);
         set_field<float>(b, 88, 0);
       },
       "voxel size of 0"},
  };
  ScratchFolder folder;
  for (const auto& c : cases) {
    HandMade file({3, 2, 2, 1, 1, 1, 1, 1}, 4, 16);
    file.sform(plain_rows);
    file.voxels<std::int16_t>({-1000, 0, 40, 3000});
    c.spoil(file.bytes);
    put_bytes(folder / "bad.nii", file.bytes);
    const auto read = read_volume(folder / "bad.nii", as_hu);
    ASSERT_FALSE(read) << c.name;
    EXPECT_NE(read.error().message().find(c.sentence), std::string::npos)
        << c.name << ": " << read.error().message();
    EXPECT_NE(read.error().message().find("bad.nii"), std::string::npos);
  }
}

// Any header bytes give a volume or a one-sentence error, never a crash or endless memory.
TEST(Nifti, FlippedHeaderBytesNeverCrash) {
  ScratchFolder folder;
  HandMade file({3, 4, 4, 4, 1, 1, 1, 1}, 4, 16);
  file.sform(plain_rows);
  file.voxels(std::vector<std::int16_t>(64, 40));
  std::mt19937 random(11);
  int refused = 0;
  for (int round = 0; round < 1000; ++round) {
    auto bytes = file.bytes;
    for (unsigned flips = 1 + random() % 6; flips > 0; --flips)
      bytes[random() % 352] = static_cast<char>(random());
    put_bytes(folder / "f.nii", bytes);
    const auto read = read_volume(folder / "f.nii", as_hu);
    if (!read) {
      ++refused;
      EXPECT_GT(read.error().what.size(), 10u);
    }
  }
  EXPECT_GT(refused, 30);
}

TEST(Nifti, NamesDamagedCompressedData) {
  ScratchFolder folder;
  ASSERT_TRUE(write_volume(folder / "a.nii.gz", noise_volume(oblique_grid(false, 0), Quantity::hu)));
  const auto whole = file_bytes(folder / "a.nii.gz");
  auto cut = whole;
  cut.resize(cut.size() / 2);
  put_bytes(folder / "cut.nii.gz", cut);
  auto flipped = whole;
  flipped[flipped.size() - 6] ^= 1;  // the checksum: the last eight bytes are CRC-32 and length
  put_bytes(folder / "flipped.nii.gz", flipped);
  const auto from_cut = read_volume(folder / "cut.nii.gz"),
             from_flipped = read_volume(folder / "flipped.nii.gz");
  ASSERT_FALSE(from_cut);
  EXPECT_NE(from_cut.error().what.find("cut off"), std::string::npos) << from_cut.error().message();
  ASSERT_FALSE(from_flipped);
  EXPECT_NE(from_flipped.error().what.find("damaged"), std::string::npos) << from_flipped.error().message();
}

TEST(Nifti, SameVolumeGivesTheSameBytes) {
  ScratchFolder folder;
  const auto volume = noise_volume(oblique_grid(false, 1), Quantity::density_kgm3);
  ASSERT_TRUE(write_volume(folder / "a.nii.gz", volume));
  ASSERT_TRUE(write_volume(folder / "b.nii.gz", volume));
  EXPECT_EQ(file_bytes(folder / "a.nii.gz"), file_bytes(folder / "b.nii.gz"));
}

// The ICRP male as DATA.md describes it: 254x127x222 at 2.137/2.137/8 mm along L, P, S; 72.991 kg by its
// organ list.
TEST(Nifti, ReadsTheIcrpMale) {
  const std::string path = test::shared_folder() + "/volumes/icrp_am/AM_density_kgm3.nii.gz";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "the ICRP male is not there: " << path;
  const auto am = read_volume(path, {FileQuantity::density_kgm3, {}});
  ASSERT_TRUE(am) << am.error().message();
  const Grid& grid = am->volume.grid;
  EXPECT_EQ(grid.size, (std::array<std::int64_t, 3>{254, 127, 222}));
  // the header's float32 of 2.137 is 2.13700008
  EXPECT_LT((grid.axes - Matrix3d(Vector3d(2.137, 2.137, 8).asDiagonal())).cwiseAbs().maxCoeff(), 1e-6);
  double mass = 0;
  for (const auto v : am->volume.voxels) mass += v;
  mass *= grid.voxel_volume() * 1e-9;
  EXPECT_NEAR(mass, 72.991, 5e-4);  // its organ list is rounded to 1 g
}

}  // namespace
}  // namespace borelli::nifti_test
