// Memory use for a large scan.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>

#include "program_run.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/files/write.hpp"

namespace borelli {
namespace {

/// Repeats each voxel `times` times along each axis.
GreyVolume finer(const GreyVolume& coarse, std::int64_t times) {
  GreyVolume out;
  out.quantity = coarse.quantity;
  out.grid.axes = coarse.grid.axes / double(times);
  out.grid.origin = coarse.grid.point(Eigen::Vector3d::Constant(0.5 / double(times) - 0.5));
  for (int c = 0; c < 3; ++c) out.grid.size[c] = coarse.grid.size[c] * times;
  out.voxels.resize(out.grid.count());
  std::size_t n = 0;
  for (std::int64_t k = 0; k < out.grid.size[2]; ++k)
    for (std::int64_t j = 0; j < out.grid.size[1]; ++j) {
      const std::int16_t* const row = coarse.voxels.data() + coarse.grid.offset(0, j / times, k / times);
      for (std::int64_t i = 0; i < out.grid.size[0]; ++i) out.voxels[n++] = row[i / times];
    }
  return out;
}

// A scan of 512 x 512 x 1000 voxels needs less than 2 GB from file to table.
TEST(Memory, ForALargeScanStaysBelowTwoGigabytes) {
  const TestFolder folder;
  const std::string at = folder.path().string();
  ASSERT_EQ(run_program("phantom --spacing 2.5 -o " + at + "/body.nii.gz").code, 0);
  std::size_t voxels = 0;
  {
    const auto body = read_volume(at + "/body.nii.gz");
    ASSERT_TRUE(body) << body.error().message();
    const GreyVolume large = finer(body->volume, 2);
    voxels = large.voxels.size();
    ASSERT_GT(voxels, 0.97 * 512 * 512 * 1000);
    ASSERT_TRUE(write_volume(at + "/large.nii", large));
  }
  ASSERT_EQ(run_program("segment " + at + "/large.nii --quantity hu -o " + at + "/segmentation").code, 0);
  ASSERT_EQ(run_program("inertia --volume " + at + "/large.nii --quantity hu --labels " + at +
                        "/segmentation/labels.nii.gz --landmarks " + at + "/segmentation/landmarks.json -o " +
                        at + "/table.json")
                .code,
            0);
  rusage used{};
  ASSERT_EQ(getrusage(RUSAGE_CHILDREN, &used), 0);
  EXPECT_LT(1024. * double(used.ru_maxrss), 2e9) << voxels << " voxels";
}

// Text of a few megabytes may become half a gigabyte.
TEST(Memory, ForModelsIsAskedBeforeTheyAreRead) {
  const TestFolder folder;
  std::string scene, bodies;
  for (int n = 0; n < 20000; ++n) {
    scene += fmt::format(
        "[[solid]]\nname='s{0}'\njoint=[{{translation='x',name='x{0}'}},{{translation='y',name='y{0}'}},"
        "{{translation='z',name='z{0}'}},{{ball=true,name='b{0}'}}]\nmass=1\ntensor=[1,1,1]\n",
        n);
    bodies += "<body><freejoint/><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/></body>";
  }
  const std::string begin = "<mujoco><worldbody>", end = "</worldbody></mujoco>";
  folder.write("many.toml", scene);
  folder.write("many.xml", begin + bodies + bodies + end);
  folder.write("copies.xml", begin +
                                 "<replicate count='40000'><body><freejoint/><inertial pos='0 0 0' mass='1' "
                                 "diaginertia='1 1 1'/></body></replicate>" +
                                 end);
  for (const char* name : {"many.toml", "many.xml", "copies.xml"}) {
    const ProgramRun run = run_program("info " + (folder / name).string() + " --max-memory 100M");
    EXPECT_EQ(run.code, 1) << name;
    EXPECT_NE(run.err.find(std::string(name)), std::string::npos) << run.err;
    EXPECT_NE(run.err.find("of memory; 100 MB may be used (--max-memory)"), std::string::npos) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  }
}

// The mass matrix of a chain as text is larger than all that the equations need.
TEST(Memory, ForTheTextOfAMassMatrixIsAskedBeforeItIsFound) {
  const TestFolder folder;
  std::string chain;
  for (int n = 0; n < 3000; ++n)
    chain += fmt::format(
        "[[solid]]\nname='s{0}'\nparent='{1}'\njoint={{rotation='y',name='j{0}'}}\nmass=1\n"
        "centre=[0,0,-0.1]\ntensor=[1,1,1]\n",
        n, n == 0 ? "world" : fmt::format("s{}", n - 1));
  const ProgramRun run =
      run_program("evaluate " + std::string(folder.write("chain.toml", chain)) + " --max-memory 1G");
  EXPECT_EQ(run.code, 1);
  EXPECT_NE(
      run.err.find("the mass matrix of 3000 coordinates as text needs 1.13 GB of memory; 1 GB may be used"),
      std::string::npos)
      << run.err;
}

}  // namespace
}  // namespace borelli
