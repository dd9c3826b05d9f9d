#include "pipeline/export/deface.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>

#include "segmentation/vocabulary/cuts.hpp"

namespace borelli {

namespace {

using Eigen::Vector2d, Eigen::Vector3d;

constexpr double sampling = 2.5;     // mm: sampling of the head
constexpr double level_height = 4;   // mm, of the profile's levels
constexpr double middle_width = 30;  // mm to either side of the head's middle: width of the profile
// over the head's depth: levels this close behind the foremost one belong to the face
constexpr double near_share = 0.17;
constexpr double steepest = 0.84;     // tangent of 40 degrees: largest tilt of a face up or down
constexpr double taken_share = 0.22;  // of the head's depth
constexpr double around = 30;         // mm beside and above the head where grey values are removed too

template <class Visit>
void each_voxel_of(const LabelMap& labels, std::uint8_t label, const std::array<std::int64_t, 3>& step,
                   Visit&& visit) {
  const auto& size = labels.grid.size;
  for (std::int64_t k = 0; k < size[2]; k += step[2])
    for (std::int64_t j = 0; j < size[1]; j += step[1]) {
      const std::uint8_t* row = labels.voxels.data() + labels.grid.offset(0, j, k);
      for (std::int64_t i = 0; i < size[0]; i += step[0])
        if (row[i] == label) visit(i, j, k);
    }
}

Vector3d place_of(const Grid& grid, std::int64_t i, std::int64_t j, std::int64_t k) {
  return grid.point(i, j, k);
}

/// The trunk's axes rotated about `up` to the cranium's long axis, if that is distinct and within 45 degrees
/// of them. `head` holds points in `axes`.
Eigen::Matrix3d facing(const Eigen::Matrix3d& axes, const std::vector<Vector3d>& head) {
  const auto [lowest, highest] =
      std::ranges::minmax(head, {}, [](const Vector3d& place) { return place[2]; });
  const double brow = highest[2] - 0.4 * (highest[2] - lowest[2]);
  Vector2d sum = Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  double count = 0;
  for (const Vector3d& place : head) {
    if (place[2] < brow) continue;
    const Vector2d across = place.head<2>();
    sum += across, squares += across * across.transpose(), ++count;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solved(squares / count -
                                                              sum * sum.transpose() / (count * count));
  // an ellipse a tenth longer than wide has 1.2 times the variance
  if (!(solved.eigenvalues()[1] > 1.2 * solved.eigenvalues()[0])) return axes;
  Vector2d back = solved.eigenvectors().col(1);
  if (back[1] < 0) back = -back;
  if (back[1] < std::numbers::sqrt2 / 2) return axes;
  const double turn = std::atan2(-back[0], back[1]);
  return Eigen::AngleAxisd(turn, axes.col(2)).toRotationMatrix() * axes;
}

/// The line f = offset + slope u along the face: f forwards, u up. Of all slopes, the one with the most
/// levels close behind the foremost, which excludes the neck and the top of the head.
struct FaceLine {
  double offset, slope;
};

FaceLine face_line(const std::vector<Vector2d>& profile, double near_the_front) {
  const auto along_it = [&](double slope) {
    double foremost = -1e300;
    for (const Vector2d& p : profile) foremost = std::max(foremost, p[1] - slope * p[0]);
    const double from = foremost - near_the_front * std::hypot(1, slope);
    std::vector<Vector2d> near;
    for (const Vector2d& p : profile)
      if (p[1] - slope * p[0] >= from) near.push_back(p);
    return near;
  };
  std::vector<Vector2d> face;
  for (double slope = 0; slope < steepest; slope += 0.02)
    for (const double tried : {slope, -slope})
      if (auto near = along_it(tried); near.size() > face.size()) face = std::move(near);
  double n = 0, u = 0, f = 0, uu = 0, uf = 0;
  for (const Vector2d& p : face) ++n, u += p[0], f += p[1], uu += p[0] * p[0], uf += p[0] * p[1];
  const double spread = uu - u * u / n;
  const double slope = spread > 0 ? std::clamp((uf - u * f / n) / spread, -steepest, steepest) : 0;
  return {(f - slope * u) / n, slope};
}

}  // namespace

bool FaceCut::takes(const Vector3d& place) const {
  const Vector3d along = axes.transpose() * place;
  return (place - point).dot(front) > 0 && along[2] >= low[2] && along[2] <= high[2] + around &&
         along[0] >= low[0] - around && along[0] <= high[0] + around;
}

std::optional<FaceCut> face_cut(const LabelMap& labels, const Landmarks& landmarks) {
  const auto named = std::ranges::find(labels.names, "head");
  if (named == labels.names.end()) return std::nullopt;
  FaceCut cut;
  cut.head = static_cast<std::uint8_t>(named - labels.names.begin());
  std::array<std::int64_t, 3> step{};
  const Vector3d spacing = labels.grid.spacing();
  for (int c = 0; c < 3; ++c)
    step[static_cast<std::size_t>(c)] = std::max<std::int64_t>(1, std::llround(sampling / spacing[c]));
  const auto head_along = [&](const Eigen::Matrix3d& axes) {
    std::vector<Vector3d> head;  // along the axes
    each_voxel_of(labels, cut.head, step, [&](std::int64_t i, std::int64_t j, std::int64_t k) {
      head.push_back(axes.transpose() * place_of(labels.grid, i, j, k));
    });
    return head;
  };
  std::vector<Vector3d> head = head_along(trunk_axes(landmarks));
  if (head.empty()) return std::nullopt;
  cut.axes = facing(trunk_axes(landmarks), head);
  head = head_along(cut.axes);
  cut.low = cut.high = head.front();
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& place : head) {
    cut.low = cut.low.cwiseMin(place), cut.high = cut.high.cwiseMax(place);
    mean += place / static_cast<double>(head.size());
  }
  // half a voxel more, so that the box contains all voxels of the head
  const Vector3d half = 0.5 * (cut.axes.transpose() * labels.grid.axes).cwiseAbs().rowwise().sum();
  cut.low -= half, cut.high += half;

  const auto levels = static_cast<std::size_t>((cut.high[2] - cut.low[2]) / level_height) + 1;
  std::vector<double> foremost(levels, -1e300);
  for (const Vector3d& place : head) {
    if (std::abs(place[0] - mean[0]) > middle_width) continue;
    double& level = foremost[static_cast<std::size_t>((place[2] - cut.low[2]) / level_height)];
    level = std::max(level, -place[1]);
  }
  std::vector<Vector2d> profile;
  for (std::size_t level = 0; level < levels; ++level)
    if (foremost[level] > -1e300)
      profile.emplace_back(cut.low[2] + level_height * (static_cast<double>(level) + 0.5), foremost[level]);
  if (profile.empty()) return std::nullopt;
  const FaceLine line = face_line(profile, near_share * (cut.high[1] - cut.low[1]));
  const Vector3d up = cut.axes.col(2), ahead = -cut.axes.col(1);
  cut.front = (ahead - line.slope * up).normalized();
  cut.point = line.offset * ahead;  // level 0 of the line, in the middle
  double hindmost = 1e300;
  for (const Vector3d& place : head)
    hindmost = std::min(hindmost, (cut.axes * place - cut.point).dot(cut.front));
  cut.point += taken_share * hindmost * cut.front;
  return cut;
}

void deface(Thumbnail& copy, const FaceCut& cut) {
  std::size_t at = 0;
  for (std::int64_t k = 0; k < copy.size[2]; ++k)
    for (std::int64_t j = 0; j < copy.size[1]; ++j)
      for (std::int64_t i = 0; i < copy.size[0]; ++i, ++at) {
        if (!copy.labels.empty() && copy.labels[at] != 0 && copy.labels[at] != cut.head) continue;
        const Vector3d steps(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
        if (!cut.takes(copy.origin + copy.spacing * steps)) continue;
        if (!copy.labels.empty()) copy.labels[at] = 0;
        if (!copy.grey.empty()) copy.grey[at] = 0;
      }
}

void keep_labelled(Thumbnail& copy) {
  for (std::size_t at = 0; at < copy.grey.size(); ++at)
    if (copy.labels.empty() || copy.labels[at] == 0) copy.grey[at] = 0;
}

Result<void> deface(std::vector<Mesh>& meshes, const LabelMap& labels, const FaceCut& cut,
                    const MeshOptions& options) {
  const auto mesh = std::ranges::find(meshes, std::string_view("head"), &Mesh::name);
  if (mesh == meshes.end()) return {};
  std::array<std::int64_t, 3> low = labels.grid.size, high{-1, -1, -1};
  each_voxel_of(labels, cut.head, {1, 1, 1}, [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    const std::array<std::int64_t, 3> at{i, j, k};
    for (std::size_t c = 0; c < 3; ++c) low[c] = std::min(low[c], at[c]), high[c] = std::max(high[c], at[c]);
  });
  LabelMap head;  // the rest of the head, on a grid around it
  head.names = labels.names;
  head.grid.axes = labels.grid.axes;
  head.grid.origin = place_of(labels.grid, low[0], low[1], low[2]);
  for (std::size_t c = 0; c < 3; ++c) head.grid.size[c] = std::max<std::int64_t>(0, high[c] - low[c] + 1);
  head.voxels.assign(head.grid.count(), 0);
  each_voxel_of(labels, cut.head, {1, 1, 1}, [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    if (!cut.takes(place_of(labels.grid, i, j, k))) head.at(i - low[0], j - low[1], k - low[2]) = cut.head;
  });
  MeshOptions quiet = options;
  quiet.progress = nullptr;
  auto made = part_meshes(head, quiet);
  if (!made) return tl::unexpected(made.error());
  if (made->empty())
    meshes.erase(mesh);
  else
    *mesh = std::move(made->front());
  return {};
}

}  // namespace borelli
