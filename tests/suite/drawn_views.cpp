#include "tests/suite/drawn_views.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "segmentation/files/class_labels.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli::suite {
namespace {

double uniform(std::mt19937_64& random, double least, double most) {
  return std::uniform_real_distribution<double>(least, most)(random);
}

// Draws a phantom whose limbs do not intersect. Empty if the drawn pose is impossible, or if `touching` is
// asked for and no forearm or hand touches another part.
std::optional<Phantom> draw_body(std::mt19937_64& random, std::uint64_t seed, bool posed, bool touching) {
  PhantomOptions options;
  options.variation = seed;
  options.sex = uniform(random, 0, 1) < 0.5 ? Sex::male : Sex::female;
  options.stature_m = uniform(random, 1.15, 2.0);
  options.mass_kg = uniform(random, 17, 32) * *options.stature_m * *options.stature_m;
  if (posed)
    for (const PoseAngle& angle : pose_angles)
      for (const char* side : {"_left_", "_right_"}) {
        // the power favours angles near standing
        const double share = std::pow(uniform(random, 0, 1), 1.5);
        const double end = uniform(random, 0, 1) < 0.5 ? angle.least : angle.most;
        options.pose_deg[std::string(angle.joint) + side + std::string(angle.motion)] =
            angle.standing + share * (end - angle.standing);
      }
  const auto body = build_phantom(options);
  if (!body) return std::nullopt;
  if (*std::max_element(body->overlap.begin(), body->overlap.end()) > 0.12) return std::nullopt;
  constexpr double touch = 0.005;
  if (touching && !std::any_of(body->overlap.begin() + part_label("forearm_left"),
                               body->overlap.begin() + part_label("hand_right") + 1,
                               [](double share) { return share > touch; }))
    return std::nullopt;
  return *body;
}

// The scan of one limb alone, as of an arm held away from the body: all else becomes air. Unchanged if the limb is
// not in view.
LabelledScan one_limb(LabelledScan scan, std::mt19937_64& random) {
  constexpr std::array<std::array<std::string_view, 3>, 2> limbs{
      {{"upper_arm", "forearm", "hand"}, {"thigh", "shank", "foot"}}};
  std::array<bool, parts.size()> of_limb{};
  const std::string side = uniform(random, 0, 1) < 0.5 ? "_left" : "_right";
  for (const std::string_view part : limbs[uniform(random, 0, 1) < 0.5 ? 0 : 1])
    of_limb[static_cast<std::size_t>(part_label(std::string(part) + side))] = true;
  if (std::ranges::none_of(scan.parts.voxels, [&](std::uint8_t part) { return of_limb[part]; })) return scan;
  for (std::size_t o = 0; o < scan.parts.voxels.size(); ++o)
    if (!of_limb[scan.parts.voxels[o]]) scan.parts.voxels[o] = 0, scan.grey.voxels[o] = -1000;
  return scan;
}

}  // namespace

Result<LabelledScan> read_labelled(const std::string& folder) {
  const std::string parts_path = folder + "/parts.nii.gz";
  auto scan = read_volume(folder + "/scan.nii.gz", {FileQuantity::hu, {}});
  if (!scan) return tl::unexpected(scan.error());
  auto labels = read_labels(parts_path);
  if (!labels) return tl::unexpected(labels.error());
  if (!same_grid(labels->grid, scan->volume.grid))
    return failure(parts_path, "lies on another grid than the scan");
  return LabelledScan{std::move(scan->volume), {labels->grid, std::move(labels->voxels)}};
}

LabelledScan drawn_phantom(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const bool posed = uniform(random, 0, 1) < 0.6, touching = posed && uniform(random, 0, 1) < 0.5;
  std::optional<Phantom> body;
  for (int attempt = 0; attempt < 200 && !body; ++attempt) body = draw_body(random, seed, posed, touching);
  if (!body) throw std::runtime_error("no body could be drawn");
  GridOptions grid;
  grid.spacing = {2.5, 2.5, uniform(random, 2.5, 6)};
  for (int c = 0; c < 3; ++c) grid.offset[c] = uniform(random, -1, 1);
  ScanOptions options;
  options.seed = seed;
  Scan scan = voxelise(*body, phantom_grid(*body, grid), options);
  return {std::move(scan.grey), {scan.labels.grid, std::move(scan.labels.voxels)}};
}

LabelledScan cropped(const LabelledScan& whole, int axis, double first, double last) {
  const Grid& from = whole.grey.grid;
  const auto c = static_cast<std::size_t>(axis);
  const auto n = static_cast<double>(from.size[c]);
  const auto low = std::clamp<std::int64_t>(std::llround(first * n), 0, from.size[c] - 1);
  const auto high = std::clamp<std::int64_t>(std::llround(last * n), low + 1, from.size[c]);
  Grid grid = from;
  grid.size[c] = high - low;
  std::array<std::int64_t, 3> start{0, 0, 0};
  start[c] = low;
  grid.origin = from.point(start[0], start[1], start[2]);
  LabelledScan out{{{grid, std::vector<std::int16_t>(grid.count())}, whole.grey.quantity},
                   {grid, std::vector<std::uint8_t>(grid.count())}};
  for (std::int64_t k = 0; k < grid.size[2]; ++k)
    for (std::int64_t j = 0; j < grid.size[1]; ++j)
      for (std::int64_t i = 0; i < grid.size[0]; ++i) {
        const std::size_t o = from.offset(i + start[0], j + start[1], k + start[2]);
        out.grey.at(i, j, k) = whole.grey.voxels[o], out.parts.at(i, j, k) = whole.parts.voxels[o];
      }
  return out;
}

LabelledScan drawn_view(const LabelledScan& whole, std::mt19937_64& random) {
  LabelledScan out = whole;
  if (uniform(random, 0, 1) < 0.7) {  // a part of its height, at least a sixth
    const double share = uniform(random, 0.16, 0.8), first = uniform(random, 0, 1 - share);
    int axis = 0;
    whole.grey.grid.axes.row(2).cwiseAbs().maxCoeff(&axis);
    out = cropped(out, axis, first, first + share);
  }
  if (uniform(random, 0, 1) < 0.25) {  // a part of its breadth
    const double share = uniform(random, 0.35, 0.8), first = uniform(random, 0, 1 - share);
    int axis = 0;
    whole.grey.grid.axes.row(0).cwiseAbs().maxCoeff(&axis);
    out = cropped(out, axis, first, first + share);
  }
  if (uniform(random, 0, 1) < 0.15) out = one_limb(std::move(out), random);
  constexpr double most = 12 * EIGEN_PI / 180;
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  for (int c = 0; c < 3; ++c)
    turn = turn * Eigen::AngleAxisd(uniform(random, -most, most), Eigen::Vector3d::Unit(c));
  // bodies of other sizes and girths: scaled first, then turned
  const double size = uniform(random, 0.85, 1.15);
  for (int c = 0; c < 3; ++c) turn.col(c) *= size * uniform(random, 0.93, 1.07);
  for (Grid* grid : {&out.grey.grid, &out.parts.grid})
    grid->axes = turn * grid->axes, grid->origin = turn * grid->origin;
  std::normal_distribution<double> noise(0, uniform(random, 0, 40));
  for (std::int16_t& hu : out.grey.voxels)
    hu = static_cast<std::int16_t>(std::max(-1024.0, hu + noise(random)));
  return out;
}

}  // namespace borelli::suite
