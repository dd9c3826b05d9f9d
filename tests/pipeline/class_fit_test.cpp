// Class maps that fit the scan, and mirrored, moved or foreign ones that do not: pairs that write_pairs.py
// draws from the ICRP bodies, and the phantom's.
#include "pipeline/body/class_fit.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "samples/phantom_voxels.hpp"
#include "segmentation/files/read.hpp"
#include "tests/paths.hpp"
#include "tests/segmentation/scratch_folder.hpp"

namespace borelli {
namespace {

// The limits were chosen with seeds 1 to 24; later seeds are independent. BORELLI_PAIRS=FIRST,LAST tries
// others.
TEST(ClassFit, RecognisesPairsOfTheIcrpBodies) {
  const std::string volumes = test::shared_folder() + "/volumes";
  if (!std::filesystem::exists(volumes + "/icrp_af")) GTEST_SKIP() << "the ICRP bodies are not there";
  if (std::system("/usr/bin/python3 -c 'import scipy' 2>/dev/null") != 0)
    GTEST_SKIP() << "needs python3 with numpy and scipy";
  int first = 1, last = 6;
  if (const char* asked = std::getenv("BORELLI_PAIRS")) std::sscanf(asked, "%d,%d", &first, &last);
  for (int seed = first; seed <= last; ++seed) {
    ScratchFolder folder;
    const std::string command = "/usr/bin/python3 " + test::source_folder() +
                                "/tests/pipeline/write_pairs.py " + volumes + " " + std::to_string(seed) +
                                " " + folder.path() + " > " + (folder / "what.txt");
    ASSERT_EQ(std::system(command.c_str()), 0);
    std::string what, how;
    std::ifstream told(folder / "what.txt");
    told >> what;
    std::getline(told, how);
    const auto scan = read_volume(folder / "ct.nii", {.quantity = FileQuantity::hu});
    ASSERT_TRUE(scan) << scan.error().message();
    const auto labels = read_numbered_labels(folder / "labels.nii");
    const auto mapping = class_mapping("totalsegmentator");
    ASSERT_TRUE(labels && mapping);
    const auto classes = class_labels("labels.nii", *labels, *mapping);
    ASSERT_TRUE(classes) << classes.error().message();
    const ClassFit fit = class_fit(scan->volume, *classes);
    EXPECT_EQ(fit.fits(), what == "genuine")
        << "seed " << seed << ": " << what << how << "; " << fit.judged << " " << fit.agreement << ", moved "
        << fit.moved << " by " << fit.shift.transpose() << ", reversed " << fit.reversed << "; "
        << in_words(fit);
    std::printf("%d %s%s: %.3f, beside %.3f, moved %.3f by %.0f mm, reversed %.3f\n", seed, what.c_str(),
                how.c_str(), fit.agreement, fit.beside, fit.moved, fit.shift.norm(), fit.reversed);
  }
}

// The phantom's bones, lungs and flesh, from its solids.
TEST(ClassFit, RecognisesThePhantomsClasses) {
  const Phantom body = build_phantom({}).value();
  GridOptions grid;
  grid.spacing.setConstant(4);
  const Scan scan = voxelise(body, phantom_grid(body, grid), {.partial_volume = true, .noise_hu = 15});
  ClassLabels classes;
  classes.labels = {{scan.grey.grid, std::vector<std::uint8_t>(scan.grey.voxels.size())},
                    {"outside", "bone", "lung", "flesh"},
                    {}};
  classes.rules = {
      {}, {all_parts, ClassTissue::bone}, {all_parts, ClassTissue::lung}, {all_parts, ClassTissue::soft}};
  const Grid& g = scan.grey.grid;
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        if (!scan.labels.at(i, j, k)) continue;
        const int solid = solid_at(body, g.point(i, j, k));
        if (solid < 0) continue;
        const std::string_view tissue = body.solids[static_cast<std::size_t>(solid)].tissue.name;
        classes.labels.at(i, j, k) = tissue == "cortex" || tissue == "spongiosa" ? 1
                                     : tissue == "lung"                          ? 2
                                     : tissue == "air"                           ? 0
                                                                                 : 3;
      }
  EXPECT_TRUE(class_fit(scan.grey, classes).fits()) << in_words(class_fit(scan.grey, classes));
  for (int axis = 0; axis < 3; ++axis) {
    ClassLabels off = classes;
    off.labels.grid.origin[axis] += 16;
    const ClassFit fit = class_fit(scan.grey, off);
    EXPECT_FALSE(fit.fits());
    EXPECT_NEAR(fit.shift[axis], -16, 4) << fit.shift.transpose();
    EXPECT_NE(in_words(fit).find("do not fit the scan"), std::string::npos);
  }
  // flesh alone does not determine the position
  for (auto& label : classes.labels.voxels) label = label == 3 ? 3 : 0;
  EXPECT_FALSE(class_fit(scan.grey, classes).judged);
}

}  // namespace
}  // namespace borelli
