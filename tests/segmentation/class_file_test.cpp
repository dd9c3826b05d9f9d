// Label maps that another program wrote: the phantom's bones and organs as TotalSegmentator would leave them,
// by write_classes.py, which shares no code with ours.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <fstream>

#include "samples/phantom_voxels.hpp"
#include "scratch_folder.hpp"
#include "segmentation/class_map.hpp"
#include "segmentation/segment.hpp"
#include "tests/paths.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

class ClassFile : public ::testing::Test {
 protected:
  void SetUp() override {
    if (std::system("/usr/bin/python3 -c 'import numpy' 2>/dev/null") != 0)
      GTEST_SKIP() << "needs python3 with numpy";
    body_ = build_phantom({}).value();
    GridOptions options;
    options.spacing = Vector3d(3, 3.5, 4);
    options.rotation_deg = Vector3d(2, -3, 5);
    scan_ = voxelise(body_, phantom_grid(body_, options));
    const Grid& g = scan_.grey.grid;
    std::vector<std::int32_t> solids;
    for (std::int64_t k = 0; k < g.size[2]; ++k)
      for (std::int64_t j = 0; j < g.size[1]; ++j)
        for (std::int64_t i = 0; i < g.size[0]; ++i)
          solids.push_back(scan_.labels.at(i, j, k) ? solid_at(body_, g.point(i, j, k)) : -1);
    std::ofstream(folder_ / "solids.raw", std::ios::binary)
        .write(reinterpret_cast<const char*>(solids.data()), static_cast<std::streamsize>(4 * solids.size()));
    std::ofstream names(folder_ / "solids.txt"), grid(folder_ / "grid.txt");
    for (const PhantomSolid& solid : body_.solids) names << solid.name << "\n";
    grid.precision(17);
    grid << g.size[0] << " " << g.size[1] << " " << g.size[2] << "\n";
    for (int r = 0; r < 3; ++r) grid << g.axes.row(r) << " " << g.origin[r] << "\n";
  }

  // the file, and what the script says is in it: number, name, voxels
  std::string write(const std::string& version, const std::string& more = "") {
    const std::string file = folder_ / ("total_" + version + ".nii.gz");
    const std::string command = "/usr/bin/python3 " + test::source_folder() +
                                "/tests/segmentation/write_classes.py " + folder_.path() + " " + version +
                                " " + file + more + " > " + (folder_ / "classes.txt");
    EXPECT_EQ(std::system(command.c_str()), 0);
    return file;
  }

  ScratchFolder folder_;
  Phantom body_;
  Scan scan_;
};

// Every class of the published list under its number and name, and every voxel.
TEST_F(ClassFile, TotalSegmentatorsNamesAndNumbers) {
  const auto read = read_numbered_labels(write("2"));
  ASSERT_TRUE(read) << read.error().message();
  const auto mapping = class_mapping("totalsegmentator");
  ASSERT_TRUE(mapping);
  EXPECT_LT((read->map.grid.axes - scan_.grey.grid.axes).norm(), 1e-5);  // single precision
  EXPECT_LT((read->map.grid.origin - scan_.grey.grid.origin).norm(), 1e-3);
  std::vector<std::int64_t> voxels(256, 0);
  for (const auto label : read->map.voxels) ++voxels[label];
  std::ifstream classes(folder_ / "classes.txt");
  std::size_t number = 0, count = 0, there = 0;
  std::string name;
  std::int64_t held = 0;
  while (classes >> number >> name >> held) {
    ++count, there += held > 0;
    EXPECT_EQ(read->map.names.at(number), name);
    EXPECT_EQ(voxels[number], held) << name;
    const ClassRule* rule = mapping->find(static_cast<std::int64_t>(number), "");
    ASSERT_TRUE(rule) << name;
    EXPECT_EQ(rule, mapping->find(0, name)) << name;
  }
  EXPECT_EQ(count, 117U);
  EXPECT_GT(there, 65U);  // 25 vertebrae with the sacrum, 24 ribs, the rest of the bones, some organs
}

// The same classes under the numbers of version 1 are told by their names; without names numbers count.
TEST_F(ClassFile, NamesInTheHeaderCountMoreThanNumbers) {
  const auto two = read_classes(write("2"), "", "totalsegmentator");
  ASSERT_TRUE(two) << two.error().message();
  const auto bare = read_classes(write("2", " --no-names"), "", "totalsegmentator");
  ASSERT_TRUE(bare) << bare.error().message();
  const auto one = read_classes(write("1"), "", "totalsegmentator");
  ASSERT_TRUE(one) << one.error().message();
  std::size_t bones = 0;
  for (std::size_t o = 0; o < two->labels.voxels.size(); ++o) {
    const auto label = two->labels.voxels[o];
    ASSERT_EQ(label, bare->labels.voxels[o]);
    if (!label) continue;
    EXPECT_EQ(two->rule(label), bare->rule(label));
    const std::string& name = two->labels.names[label];
    // skull, sternum and cartilages, heart: new in version 2
    if (const auto old = one->labels.voxels[o]) {
      ASSERT_EQ(one->labels.names[old], name);
      ASSERT_EQ(one->rule(old), two->rule(label)) << name;
      bones += two->rule(label).tissue == ClassTissue::bone;
    }
  }
  EXPECT_GT(bones, 10000U);
}

TEST_F(ClassFile, PartsByTotalSegmentatorsClasses) {
  const auto classes = read_classes(write("2"), "", "totalsegmentator");
  ASSERT_TRUE(classes) << classes.error().message();
  EXPECT_TRUE(classes->warnings.empty()) << classes->warnings.front();
  SegmentOptions options;
  options.classes = &*classes;
  const auto found = segment(scan_.grey, options);
  ASSERT_TRUE(found) << found.error().message();
  std::array<double, parts.size()> both{}, all{};
  std::size_t whole_bones = 0, elsewhere = 0;
  for (std::size_t o = 0; o < found->labels.voxels.size(); ++o) {
    const auto exact = scan_.labels.voxels[o], mine = found->labels.voxels[o];
    both[exact] += 2 * (exact == mine), ++all[exact], ++all[mine];
    const ClassRule& rule = classes->rule(classes->labels.voxels[o]);
    if (!classes->labels.voxels[o] || std::popcount(rule.parts) != 1) continue;
    ++whole_bones, elsewhere += part_bit(mine) != rule.parts;
  }
  EXPECT_GT(whole_bones, 10000U);
  EXPECT_EQ(elsewhere, 0U);
  for (std::size_t n = 1; n < parts.size(); ++n) {
    EXPECT_EQ(found->part[n].coverage, Coverage::whole) << parts[n].name;
    // hips and girdles go whole to the trunk here, where the phantom's planes cut their corners
    EXPECT_GT(both[n] / all[n], 0.95) << parts[n].name;
  }
}

// A table of names that is cut short is refused, not taken for a map without names.
TEST_F(ClassFile, DamagedNamesAreRefused) {
  const std::string file = write("2"), plain = folder_ / "plain.nii";
  ASSERT_EQ(std::system(("gunzip -c " + file + " > " + plain).c_str()), 0);
  auto bytes = file_bytes(plain);
  const std::string close = "</LabelTable>";
  const auto at = std::search(bytes.begin(), bytes.end(), close.begin(), close.end());
  ASSERT_NE(at, bytes.end());
  *(at + 2) = 'X';
  put_bytes(plain, bytes);
  const auto read = read_classes(plain, "", "totalsegmentator");
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message().find("names its labels in its header by XML that cannot be read"),
            std::string::npos)
      << read.error().message();
}

}  // namespace
}  // namespace borelli
