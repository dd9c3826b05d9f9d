// Label maps of another program: the phantom's bones and organs in TotalSegmentator's form, written by
// write_classes.py, which shares no code with ours.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <utility>

#include "samples/phantom_voxels.hpp"
#include "scratch_folder.hpp"
#include "segmentation/files/class_labels.hpp"
#include "segmentation/files/mapping_fit.hpp"
#include "segmentation/files/write.hpp"
#include "segmentation/labelling/mr_tissues.hpp"
#include "segmentation/labelling/segment.hpp"
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

  // writes the file and returns the script's list of its contents: number, name, voxels
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

// Every class of the published list has its number, name and voxels.
TEST_F(ClassFile, ReadsTotalSegmentatorsNamesAndNumbers) {
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

// The same classes with version 1's numbers are identified by their names; without names, numbers count.
TEST_F(ClassFile, NamesInTheHeaderOverrideNumbers) {
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

TEST_F(ClassFile, TotalSegmentatorsClassesGiveParts) {
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
    // hip bones and girdles belong entirely to the trunk here, while the phantom's planes cut their corners
    EXPECT_GT(both[n] / all[n], 0.95) << parts[n].name;
  }
}

// Numbers without names are read by the version whose classes fit the body's anatomy, whatever version is
// requested; each voxel gets its name's rule.
TEST_F(ClassFile, NumbersWithoutNamesUseTheFittingVersion) {
  const auto count = [](const ClassLabels& one, const ClassLabels& other) {
    std::size_t differ = 0;
    for (std::size_t o = 0; o < one.labels.voxels.size(); ++o) {
      const auto a = one.labels.voxels[o], b = other.labels.voxels[o];
      differ += (a != 0) != (b != 0) || (a && one.rule(a) != other.rule(b));
    }
    return differ;
  };
  for (const auto& [version, own] :
       {std::pair{"1", "totalsegmentator_v1"}, {"2", "totalsegmentator"}, {"mr", "totalsegmentator_mr"}}) {
    const auto named = read_classes(write(version), "", "totalsegmentator");
    ASSERT_TRUE(named) << named.error().message();
    EXPECT_TRUE(named->warnings.empty()) << named->warnings.front();
    const std::string bare = write(version, " --no-names");
    for (const std::string asked : {"totalsegmentator", "totalsegmentator_v1", "totalsegmentator_mr"})
      for (const GreyVolume* scan : {static_cast<const GreyVolume*>(nullptr), &std::as_const(scan_.grey)}) {
        const auto read = read_classes(bare, "", asked, scan);
        ASSERT_TRUE(read) << version << " by " << asked << ": " << read.error().message();
        EXPECT_EQ(count(*named, *read), 0U) << version << " by " << asked;
        ASSERT_EQ(read->warnings.size(), asked == own ? 0U : 1U) << version << " by " << asked;
        if (asked == own) continue;
        for (const std::string& both :
             {"with the mapping " + asked, std::string("they were read with ") + own})
          EXPECT_NE(read->warnings[0].find(both), std::string::npos) << read->warnings[0];
      }
    const auto foreign = read_classes(bare, "", "icrp110");
    ASSERT_FALSE(foreign) << version;
    EXPECT_NE(foreign.error().message().find("choose " + std::string(own) + ", which fits"),
              std::string::npos)
        << foreign.error().message();
  }
}

// An MR of the phantom (bright fat, dark cortex and air) with TotalSegmentator's MR classes gets parts.
TEST_F(ClassFile, ClassesGivePartsOfAnMr) {
  Phantom drawn = body_;
  for (PhantomSolid& solid : drawn.solids) {
    const std::string_view name = solid.tissue.name;
    const int bright = name == "fat" || name == "spongiosa" ? 900
                       : name == "cortex"                   ? 30
                       : name == "lung"                     ? 20
                       : name == "air"                      ? 0
                                                            : 340;
    solid.tissue.hu = bright - 1000;
  }
  GreyVolume mr = voxelise(drawn, scan_.grey.grid).grey;
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 10);
  for (auto& v : mr.voxels)
    v = static_cast<std::int16_t>(std::lround(std::hypot(v + 1000 + noise(random), noise(random))));
  mr.quantity = Quantity::mr;
  const auto classes = read_classes(write("mr", " --no-names"), "", "totalsegmentator", &mr);
  ASSERT_TRUE(classes) << classes.error().message();
  const auto reading = read_mr(mr, &*classes);
  ASSERT_TRUE(reading) << reading.error().message();
  SegmentOptions options;
  options.classes = &*classes;
  const auto found = segment(uniform_body(*reading), options);
  ASSERT_TRUE(found) << found.error().message();
  std::array<double, parts.size()> both{}, all{};
  for (std::size_t o = 0; o < found->labels.voxels.size(); ++o) {
    const auto exact = scan_.labels.voxels[o], mine = found->labels.voxels[o];
    both[exact] += 2 * (exact == mine), ++all[exact], ++all[mine];
  }
  // the classes show shoulders, hips and the column, but no elbow, wrist, knee or ankle
  for (const char* name : {"head", "upper_trunk", "middle_trunk", "lower_trunk", "thigh_left", "thigh_right",
                           "upper_arm_left", "upper_arm_right"}) {
    const auto n = static_cast<std::size_t>(part_label(name));
    EXPECT_NE(found->part[n].coverage, Coverage::absent) << name;
    std::printf("%s %.3f\n", name, both[n] / all[n]);
  }
}

// Random numbers fit no known table.
TEST_F(ClassFile, RefusesNumbersThatFitNoTable) {
  auto labels = read_numbered_labels(write("2", " --no-names"));
  ASSERT_TRUE(labels);
  const auto places = places_of(*labels, nullptr);
  std::vector<std::string> warnings;
  EXPECT_TRUE(fitting_mapping("a.nii", "totalsegmentator", places, warnings));
  for (unsigned seed = 1; seed <= 20; ++seed) {
    auto drawn = places;
    std::vector<std::int64_t> numbers;
    for (const NumberPlace& place : places) numbers.push_back(place.number);
    std::ranges::shuffle(numbers, std::mt19937(seed));
    for (std::size_t n = 0; n < drawn.size(); ++n) drawn[n].number = numbers[n];
    const auto none = fitting_mapping("a.nii", "totalsegmentator", drawn, warnings);
    ASSERT_FALSE(none) << seed;
    EXPECT_NE(none.error().message().find("no built-in mapping fits"), std::string::npos)
        << none.error().message();
  }
  EXPECT_TRUE(warnings.empty());
}

// A header that mirrors or turns the body is reported elsewhere; its classes keep their names.
TEST_F(ClassFile, MirroredHeaderChangesNoMapping) {
  auto labels = read_numbered_labels(write("2", " --no-names"));
  ASSERT_TRUE(labels);
  for (const int axis : {0, 1, 2}) {
    labels->map.grid.axes.row(axis) *= -1;
    std::vector<std::string> warnings;
    EXPECT_TRUE(fitting_mapping("a.nii", "totalsegmentator", places_of(*labels, nullptr), warnings));
    EXPECT_TRUE(warnings.empty());
  }
}

// The folder of masks, TotalSegmentator's default output, gives the same as its single file with names.
TEST_F(ClassFile, FolderOfMasksGivesTheSameLabelMap) {
  const auto whole = read_numbered_labels(write("2"));
  ASSERT_TRUE(whole);
  const std::string masks = folder_ / "masks";
  ASSERT_EQ(
      std::system(("/usr/bin/python3 " + test::source_folder() + "/tests/segmentation/write_classes.py " +
                   folder_.path() + " 2 " + masks + " --masks > /dev/null")
                      .c_str()),
      0);
  std::ofstream(masks + "/._liver.nii.gz") << "what macOS leaves beside a file";
  const auto read = read_numbered_labels(masks);
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_TRUE(read->map.warnings.empty());
  ASSERT_EQ(read->map.voxels.size(), whole->map.voxels.size());
  std::size_t differ = 0;
  for (std::size_t o = 0; o < read->map.voxels.size(); ++o) {
    const auto a = read->map.voxels[o], b = whole->map.voxels[o];
    differ += (a != 0) != (b != 0) || (a && read->map.names[a] != whole->map.names[b]);
  }
  EXPECT_EQ(differ, 0U);
  const auto classes = read_classes(masks, "", "totalsegmentator");
  ASSERT_TRUE(classes) << classes.error().message();
  EXPECT_TRUE(classes->warnings.empty());

  const auto message = [&] {
    const auto again = read_classes(masks, "", "totalsegmentator");
    return again ? "read: " + (again->warnings.empty() ? "" : again->warnings.back())
                 : again.error().message();
  };
  // two known classes of the same voxels
  const std::string gland = masks + "/adrenal_gland_left.nii.gz", aside = folder_ / "aside.nii.gz";
  std::filesystem::rename(gland, aside);
  std::filesystem::copy(masks + "/liver.nii.gz", gland);
  EXPECT_NE(message().find("overlap: adrenal_gland_left and liver by 100 %"), std::string::npos) << message();
  std::filesystem::remove(gland);
  std::filesystem::rename(aside, gland);
  // an unknown class is reported once
  std::filesystem::rename(masks + "/liver.nii.gz", masks + "/moon.nii.gz");
  EXPECT_NE(message().find("1 of its classes are not in the mapping (moon)"), std::string::npos) << message();
  // a file of many values is no mask
  std::filesystem::copy(write("2"), masks + "/all.nii.gz");
  EXPECT_NE(message().find("all.nii.gz: is not a mask"), std::string::npos) << message();
  std::filesystem::remove(masks + "/all.nii.gz");
  // two files of one class, and another grid
  std::filesystem::copy(masks + "/brain.nii.gz", masks + "/brain.nii");
  EXPECT_NE(message().find("two masks of brain"), std::string::npos) << message();
  std::filesystem::remove(masks + "/brain.nii");
  LabelMap other{{Grid{}, {}}, {"outside", "skin"}, {}};
  other.grid.size = {4, 4, 4}, other.voxels.assign(64, 1);
  ASSERT_TRUE(write_labels(masks + "/skin.nii.gz", other));
  EXPECT_NE(message().find("skin.nii.gz: lies on another grid than"), std::string::npos) << message();
}

// A truncated table of names is refused, not treated as a map without names.
TEST_F(ClassFile, RefusesDamagedNames) {
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
  EXPECT_NE(
      read.error().message().find(
          "has label names in its header in a text that is not well-formed XML: an end tag has another name"),
      std::string::npos)
      << read.error().message();
}

}  // namespace
}  // namespace borelli
