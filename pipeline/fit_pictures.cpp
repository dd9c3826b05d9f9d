#include "pipeline/fit_pictures.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "segmentation/bone_edges.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// unit, along the joint's axis, for joints that were measured as cylinders
std::optional<Vector3d> axis_of(const std::string& joint, const Landmarks& landmarks) {
  const auto bar = joint.rfind('_');
  if (bar == std::string::npos) return std::nullopt;
  const std::string stem = joint.substr(0, bar), side = joint.substr(bar);
  auto medial = landmarks.find(stem + "_medial" + side), lateral = landmarks.find(stem + "_lateral" + side);
  if (stem == "ankle") {
    medial = landmarks.find("medial_malleolus" + side);
    lateral = landmarks.find("lateral_malleolus" + side);
  }
  if (medial == landmarks.end() || lateral == landmarks.end()) return std::nullopt;
  return (lateral->second.point - medial->second.point).normalized();
}

// as radiologists look: the patient's right on the left and the head above; from the side, the front on the
// left
FitPlane plane_across(const Vector3d& axis) {
  const auto square = [&](const Vector3d& v) { return Vector3d(v - v.dot(axis) * axis); };
  Vector3d down = square(-Vector3d::UnitZ());
  if (down.norm() < 0.3) down = square(Vector3d::UnitY());
  down.normalize();
  Vector3d across = axis.cross(down);
  const Vector3d rightwards = Vector3d::UnitX() + Vector3d::UnitY();
  if (across.dot(rightwards) < 0) across = -across;
  return {"across the axis", across, down, {}};
}

void draw(const CloseUp& view, const FitPicture& picture, FitPlane& plane) {
  constexpr int n = FitPicture::pixels;
  const double step = picture.side / n;
  plane.grey.resize(static_cast<std::size_t>(n) * n);
  std::vector<double> row(n);
  for (int v = 0; v < n; ++v) {
    const Vector3d from = picture.fit.point + (0.5 * step - 0.5 * picture.side) * plane.across +
                          ((v + 0.5) * step - 0.5 * picture.side) * plane.down;
    view.along(from, step * plane.across, n, row.data());
    std::transform(row.begin(), row.end(), plane.grey.begin() + static_cast<std::ptrdiff_t>(v) * n,
                   [](double hu) {
                     const double t = (hu - FitPicture::low) / (FitPicture::high - FitPicture::low);
                     return static_cast<std::uint8_t>(std::lround(255 * std::clamp(t, 0.0, 1.0)));
                   });
  }
}

}  // namespace

std::vector<FitPicture> fit_pictures(const GreyVolume& grey, const Landmarks& landmarks) {
  std::vector<FitPicture> pictures;
  if (grey.quantity == Quantity::mr || grey.quantity == Quantity::labels) return pictures;
  for (const auto& [name, landmark] : landmarks) {
    if (landmark.radius <= 0) continue;
    FitPicture picture{name, landmark, 4 * landmark.radius, {}};
    if (const auto axis = axis_of(name, landmarks))
      picture.planes = {plane_across(*axis)};
    else
      picture.planes = {{"coronal", Vector3d::UnitX(), -Vector3d::UnitZ(), {}},
                        {"axial", Vector3d::UnitX(), Vector3d::UnitY(), {}}};
    const CloseUp view = close_up(grey, landmark.point, 0.75 * picture.side);  // half the diagonal and more
    for (FitPlane& plane : picture.planes) draw(view, picture, plane);
    pictures.push_back(std::move(picture));
  }
  return pictures;
}

}  // namespace borelli
