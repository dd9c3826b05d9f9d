#include "pipeline/body/foot_soles.hpp"

#include <algorithm>
#include <limits>
#include <optional>

#include "pipeline/body/segment_frames.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

constexpr double around = 12;  // mm, of a landmark, along the sole

/// The landmarks of one foot, and what lies lowest below each.
struct Foot {
  std::string name;
  std::uint8_t label = 0;
  Eigen::Matrix3d R_FW;             ///< rows: the foot's axes (x from heel to toe, y up)
  std::vector<Vector3d> landmarks;  ///< mm, in the foot's axes
  std::vector<double> lowest;       ///< mm along y; infinite: no voxel
};

std::optional<Foot> foot_on(const std::string& side, const LabelMap& labels, const Landmarks& landmarks) {
  Foot foot;
  foot.name = "foot_" + side;
  const auto name = std::ranges::find(labels.names, foot.name);
  const auto frame = segment_frame(foot.name, landmarks, {});
  if (name == labels.names.end() || !frame) return std::nullopt;
  foot.label = static_cast<std::uint8_t>(name - labels.names.begin());
  foot.R_FW = frame->R_WA.transpose();
  for (const char* stem : {"heel", "metatarsal_1", "metatarsal_5", "toe_tip"})
    if (const auto found = landmarks.find(stem + ("_" + side)); found != landmarks.end())
      foot.landmarks.push_back(foot.R_FW * found->second.point);
  foot.lowest.assign(foot.landmarks.size(), std::numeric_limits<double>::infinity());
  return foot;
}

void lower(Foot& foot, const Vector3d& p_F) {
  for (std::size_t m = 0; m < foot.landmarks.size(); ++m) {
    const Vector3d away = p_F - foot.landmarks[m];
    if (away.x() * away.x() + away.z() * away.z() <= around * around)
      foot.lowest[m] = std::min(foot.lowest[m], p_F.y());
  }
}

}  // namespace

FootSoles foot_soles(const LabelMap& labels, const Landmarks& landmarks) {
  std::vector<Foot> feet;
  for (const char* side : {"left", "right"})
    if (auto foot = foot_on(side, labels, landmarks)) feet.push_back(std::move(*foot));
  const Grid& grid = labels.grid;
  std::size_t n = 0;
  for (std::int64_t k = 0; k < grid.size[2]; ++k)
    for (std::int64_t j = 0; j < grid.size[1]; ++j)
      for (std::int64_t i = 0; i < grid.size[0]; ++i, ++n)
        for (Foot& foot : feet)
          if (labels.voxels[n] == foot.label) lower(foot, foot.R_FW * grid.point(i, j, k));
  FootSoles soles;
  for (const Foot& foot : feet)
    for (std::size_t m = 0; m < foot.landmarks.size(); ++m) {
      if (!(foot.lowest[m] < std::numeric_limits<double>::infinity())) continue;
      const Vector3d p_F(foot.landmarks[m].x(), foot.lowest[m], foot.landmarks[m].z());
      soles[foot.name].push_back(1e-3 * (foot.R_FW.transpose() * p_F));
    }
  return soles;
}

}  // namespace borelli
