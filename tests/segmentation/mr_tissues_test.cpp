// MR: the phantom with intensities by tissue, a known smooth bias field and noise; its tissues and mass are
// recovered.
#include "segmentation/labelling/mr_tissues.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <random>

#include "samples/phantom_voxels.hpp"
#include "segmentation/body/bias_field.hpp"
#include "segmentation/labelling/segment.hpp"
#include "tests/paths.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// brightness of a T1-weighted spin echo, arbitrary units
double brightness(std::string_view tissue) {
  for (const auto& [name, value] : {std::pair{"air", 0.},
                                    {"lung", 20.},
                                    {"fat", 900.},
                                    {"brain", 420.},
                                    {"blood", 300.},
                                    {"muscle", 330.},
                                    {"liver", 400.},
                                    {"cartilage", 380.},
                                    {"spongiosa", 850.},
                                    {"cortex", 30.}})
    if (tissue == name) return value;
  return 0;
}

// a coil's sensitivity: 0.7 to 1.4 over the body
double bias_at(const Vector3d& p, const Vector3d& middle, double length) {
  const Vector3d x = (p - middle) / length;
  return std::exp(0.8 * x[2] - 0.9 * x[2] * x[2] + 0.9 * x[0] - 1.2 * x[1]);
}

struct Drawn {
  Phantom body;
  Scan scan;  // labels, CT numbers
  GreyVolume mr;
  std::vector<std::string_view> tissue;  // of each voxel; empty outside
  Vector3d middle = Vector3d::Zero();
  double length = 1;
};

Drawn drawn(double spacing, double noise) {
  Drawn d{*build_phantom({}), {}, {}, {}};
  GridOptions options;
  options.spacing.setConstant(spacing);
  const Grid grid = phantom_grid(d.body, options);
  d.scan = voxelise(d.body, grid);
  d.mr.grid = grid;
  d.mr.quantity = Quantity::mr;
  d.mr.voxels.resize(grid.count());
  d.tissue.resize(grid.count());
  std::map<int, std::string_view> by_hu;  // no two tissues have the same CT number
  for (const PhantomSolid& solid : d.body.solids) by_hu[solid.tissue.hu] = solid.tissue.name;
  d.middle = grid.point(0.5 * Vector3d(static_cast<double>(grid.size[0]), static_cast<double>(grid.size[1]),
                                       static_cast<double>(grid.size[2])));
  d.length = grid.axes(2, 2) * static_cast<double>(grid.size[2]);
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0, noise);
  for (std::int64_t k = 0; k < grid.size[2]; ++k)
    for (std::int64_t j = 0; j < grid.size[1]; ++j)
      for (std::int64_t i = 0; i < grid.size[0]; ++i) {
        const Vector3d p = grid.point(i, j, k);
        const std::size_t o = grid.offset(i, j, k);
        if (const auto it = by_hu.find(d.scan.grey.voxels[o]); it != by_hu.end() && d.scan.labels.voxels[o])
          d.tissue[o] = it->second;
        double signal = brightness(d.tissue[o]);
        signal *= bias_at(p, d.middle, d.length);
        // the magnitude of a complex signal with noise in both parts (Rice)
        const double value = std::hypot(signal + normal(random), normal(random));
        d.mr.voxels[o] = static_cast<std::int16_t>(std::lround(value));
      }
  return d;
}

TEST(MrTissues, GiveClassesAndMassOfThePhantom) {
  const Drawn d = drawn(3, 20);
  const auto read = read_mr(d.mr);
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->density.quantity, Quantity::density_kgm3);
  double all_fat = 0, right_fat = 0, all_lean = 0, right_lean = 0, all_lung = 0, right_lung = 0, body = 0,
         lost = 0, more = 0;
  double mass = 0;
  const auto label = [](MrTissue t) { return static_cast<int>(parts.size()) - 1 + static_cast<int>(t); };
  for (std::size_t o = 0; o < d.tissue.size(); ++o) {
    const int found = read->tissues.voxels[o];
    mass += read->density.voxels[o] * d.mr.grid.voxel_volume() * 1e-9;
    const bool inside = d.scan.labels.voxels[o] != 0;
    body += inside, lost += inside && found == 0, more += !inside && found != 0;
    const std::string_view tissue = d.tissue[o];
    if (tissue == "fat") ++all_fat, right_fat += found == label(MrTissue::fat);
    if (tissue == "muscle" || tissue == "liver" || tissue == "brain")
      ++all_lean, right_lean += found == label(MrTissue::lean);
    if (tissue == "lung") ++all_lung, right_lung += found == label(MrTissue::gas);
  }
  // each voxel has one tissue; errors come from noise (20, with 570 between the classes) and the residual
  // field
  EXPECT_GT(right_fat / all_fat, 0.97);
  EXPECT_GT(right_lean / all_lean, 0.97);
  EXPECT_GT(right_lung / all_lung, 0.9);
  EXPECT_LT(lost / body, 0.01);
  EXPECT_LT(more / body, 0.01);
  // fat and lean tissue have the phantom's masses within 1 %; of the bones' 10 kg, cortex counts 1500 instead
  // of 1900 kg/m^3, and spongiosa counts as fat, 950 instead of 1170
  EXPECT_NEAR(mass, d.body.whole.mass, 0.03 * d.body.whole.mass);
  bool said = false;
  for (const auto& warning : read->warnings)
    said = said || warning.find("cortical bone, tendon or air") != std::string::npos;
  EXPECT_TRUE(said);
}

// The found field against the drawn one, up to a factor.
TEST(MrTissues, RecoverTheDrawnBiasField) {
  const Drawn d = drawn(10, 10);
  Volume<float> mr{d.mr.grid, {d.mr.voxels.begin(), d.mr.voxels.end()}};
  Mask mask{d.mr.grid, std::vector<std::uint8_t>(mr.voxels.size())};
  for (std::size_t o = 0; o < mr.voxels.size(); ++o)
    mask.voxels[o] = d.scan.labels.voxels[o] && mr.voxels[o] > 100;
  const auto field = bias_field(mr, mask);
  ASSERT_TRUE(field) << field.error().message();
  double sum = 0, square = 0, spread = 0, mean = 0, count = 0;
  const auto& g = d.mr.grid;
  for (std::size_t o = 0; o < mr.voxels.size(); ++o) {
    if (!mask.voxels[o]) continue;
    const auto i = static_cast<std::int64_t>(o) % g.size[0],
               j = static_cast<std::int64_t>(o) / g.size[0] % g.size[1],
               k = static_cast<std::int64_t>(o) / (g.size[0] * g.size[1]);
    const double exact = std::log(bias_at(g.point(i, j, k), d.middle, d.length));
    const double off = std::log(static_cast<double>(field->voxels[o])) - exact;
    sum += off, square += off * off, mean += exact, spread += exact * exact, ++count;
  }
  const double left = std::sqrt(square / count - std::pow(sum / count, 2)),
               drawn_spread = std::sqrt(spread / count - std::pow(mean / count, 2));
  EXPECT_GT(drawn_spread, 0.15);
  // N4 leaves a residual where tissues change along the body: muscle in the legs, organs in the trunk
  EXPECT_LT(left, 0.35 * drawn_spread);
  const auto again = bias_field(mr, mask);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->voxels, field->voxels);
}

TEST(MrTissues, BonesOfALabelMapHaveBoneDensity) {
  const Drawn d = drawn(4, 15);
  ClassLabels classes;
  classes.labels.grid = d.mr.grid;
  classes.labels.names = {"outside", "bone"};
  classes.rules = {ClassRule{}, ClassRule{all_parts, ClassTissue::bone}};
  classes.labels.voxels.resize(d.tissue.size());
  for (std::size_t o = 0; o < d.tissue.size(); ++o)
    classes.labels.voxels[o] = d.tissue[o] == "cortex" || d.tissue[o] == "spongiosa";
  const auto with = read_mr(d.mr, &classes);
  ASSERT_TRUE(with) << with.error().message();
  double mass = 0;
  for (const auto v : with->density.voxels) mass += v * d.mr.grid.voxel_volume() * 1e-9;
  // cortex 1920 and spongiosa 1180 against the phantom's 1900 and 1170; the rest of the error is from fat,
  // lean tissue and lung
  EXPECT_NEAR(mass, d.body.whole.mass, 0.02 * d.body.whole.mass);
}

// Parts of a body without visible bones, from joints alone.
TEST(MrTissues, LandmarksAloneGiveParts) {
  const Drawn d = drawn(4, 15);
  const auto read = read_mr(d.mr);
  ASSERT_TRUE(read) << read.error().message();
  SegmentOptions options;
  options.step = 4, options.given = d.body.landmarks;
  const auto found = segment(uniform_body(*read), options);
  ASSERT_TRUE(found) << found.error().message();
  ASSERT_FALSE(found->warnings.empty());
  std::array<double, parts.size()> both{}, all{};
  for (std::size_t o = 0; o < d.scan.labels.voxels.size(); ++o) {
    const auto a = d.scan.labels.voxels[o], b = found->labels.voxels[o];
    if (a == b) both[a] += 2;
    ++all[a], ++all[b];
  }
  for (std::size_t n = 1; n < parts.size(); ++n) EXPECT_GT(both[n] / all[n], 0.93) << parts[n].name;
}

TEST(MrTissues, RefuseOtherVolumes) {
  GreyVolume ct;
  ct.grid.size = {4, 4, 4};
  ct.voxels.assign(64, 40);
  EXPECT_FALSE(read_mr(ct));
  ct.quantity = Quantity::mr;
  ct.voxels.assign(64, 0);
  const auto dark = read_mr(ct);
  ASSERT_FALSE(dark);
  EXPECT_NE(dark.error().message().find("no signal"), std::string::npos);
}

// A real knee: its tissue has a plausible density, and no part is labelled.
TEST(MrTissues, ReadARealKnee) {
  const std::string folder = test::shared_folder() + "/volumes/mr_knee_dicom";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "the knee scan is not beside the checkout";
  const auto scan = read_volume(folder);
  ASSERT_TRUE(scan) << scan.error().message();
  ASSERT_EQ(scan->volume.quantity, Quantity::mr);
  const auto read = read_mr(scan->volume);
  ASSERT_TRUE(read) << read.error().message();
  double litres = 0, mass = 0;
  const auto& g = scan->volume.grid;
  for (const auto v : read->density.voxels) {
    litres += (v > 0) * g.voxel_volume() * 1e-6;
    mass += v * g.voxel_volume() * 1e-9;
  }
  // a knee in 10 cm of slices with a field of view of 17 cm: at most the whole view, 3.0 litres, and more
  // than half of its inscribed cylinder
  EXPECT_GT(litres, 1.0);
  EXPECT_LT(litres, 0.95 * static_cast<double>(g.count()) * g.voxel_volume() * 1e-6);
  EXPECT_GT(mass / litres, 0.95);
  EXPECT_LT(mass / litres, 1.15);
  EXPECT_GT(read->brightness[3], 1.5 * read->brightness[2]);
  EXPECT_GT(read->brightness[2], 1.5 * read->brightness[1]);
}

}  // namespace
}  // namespace borelli
