#include "pipeline/export/cut_lines.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <optional>

#include "segmentation/vocabulary/parts.hpp"

namespace borelli {

namespace {

using Eigen::Vector3d;

constexpr double widest = 500;  // mm from a cut's point: no segment is wider

/// Part labels of parts.hpp by place, whatever the numbers in the label map.
class PartsAt {
 public:
  PartsAt(const Thumbnail& copy, const std::vector<std::string>& names) : copy_(copy) {
    for (const auto& name : names) part_.push_back(part_label(name));
  }
  int operator()(const Vector3d& point) const {
    const auto voxel = ((point - copy_.origin) / copy_.spacing).array().round().cast<std::int64_t>().eval();
    for (int c = 0; c < 3; ++c)
      if (voxel[c] < 0 || voxel[c] >= copy_.size[static_cast<std::size_t>(c)]) return 0;
    const std::size_t label = copy_.labels[static_cast<std::size_t>(
        (voxel[2] * copy_.size[1] + voxel[1]) * copy_.size[0] + voxel[0])];
    return label < part_.size() ? part_[label] : 0;
  }

 private:
  const Thumbnail& copy_;
  std::vector<int> part_;
};

std::optional<CutLine> line_of(const Thumbnail& copy, const PartsAt& part_at, const Cut& cut) {
  const double in_picture = std::hypot(cut.normal[0], cut.normal[2]);
  if (in_picture < 0.1) return std::nullopt;
  Vector3d along = Vector3d(cut.normal[2], 0, -cut.normal[0]) / in_picture;
  if (along[0] < 0) along = -along;  // towards the patient's left
  const Vector3d deep = cut.normal.cross(along);
  // offset from the plane to the voxels on its sides, beyond those that it crosses
  const Vector3d beside = 1.5 * copy.spacing * cut.normal;
  const auto steps = static_cast<int>(std::ceil(std::min(widest, cut.reach) / copy.spacing));
  std::optional<int> first, last;
  for (int t = -steps; t <= steps; ++t)
    for (int s = -steps; s <= steps; ++s) {
      const Vector3d away = copy.spacing * (t * along + s * deep);
      if (away.norm() > cut.reach || part_at(cut.point + away + beside) != cut.distal ||
          part_at(cut.point + away - beside) != cut.proximal)
        continue;
      if (!first) first = t;
      last = t;
      break;
    }
  if (!first) return std::nullopt;
  // each sample covers a voxel's width
  return CutLine{cut.joint, cut.point + copy.spacing * (*first - 0.5) * along,
                 cut.point + copy.spacing * (*last + 0.5) * along};
}

}  // namespace

std::vector<CutLine> cut_lines(const Thumbnail& copy, const std::vector<std::string>& names,
                               const std::vector<Cut>& cuts) {
  std::vector<CutLine> lines;
  if (copy.labels.empty()) return lines;
  const PartsAt part_at(copy, names);
  for (const Cut& cut : cuts)
    if (auto line = line_of(copy, part_at, cut)) lines.push_back(std::move(*line));
  return lines;
}

}  // namespace borelli
