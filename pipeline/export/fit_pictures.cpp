#include "pipeline/export/fit_pictures.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "segmentation/body/bone_edges.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// both ends of the joint's axis, medial first, for joints fitted by cylinders
std::optional<std::array<Vector3d, 2>> axis_of(const std::string& joint, const Landmarks& landmarks) {
  const auto bar = joint.rfind('_');
  if (bar == std::string::npos) return std::nullopt;
  const std::string stem = joint.substr(0, bar), side = joint.substr(bar);
  const bool ankle = stem == "ankle";
  const auto medial = landmarks.find((ankle ? "medial_malleolus" : stem + "_medial") + side),
             lateral = landmarks.find((ankle ? "lateral_malleolus" : stem + "_lateral") + side);
  if (medial == landmarks.end() || lateral == landmarks.end()) return std::nullopt;
  return std::array{medial->second.point, lateral->second.point};
}

// radiological view: the patient's right on the left, the head above; from the side, the front on the left
FitPlane plane_across(const Vector3d& axis, const char* name, const Vector3d& middle) {
  const auto square = [&](const Vector3d& v) { return Vector3d(v - v.dot(axis) * axis); };
  Vector3d down = square(-Vector3d::UnitZ());
  if (down.norm() < 0.3) down = square(Vector3d::UnitY());
  down.normalize();
  Vector3d across = axis.cross(down);
  const Vector3d rightwards = Vector3d::UnitX() + Vector3d::UnitY();
  if (across.dot(rightwards) < 0) across = -across;
  return {name, middle, across, down, {}};
}

void draw(const CloseUp& view, const FitPicture& picture, FitPlane& plane) {
  constexpr int n = FitPicture::pixels;
  const double step = picture.side / n;
  plane.grey.resize(static_cast<std::size_t>(n) * n);
  std::vector<double> row(n);
  for (int v = 0; v < n; ++v) {
    const Vector3d from = plane.middle + (0.5 * step - 0.5 * picture.side) * plane.across +
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
    const Vector3d& centre = landmark.point;
    if (const auto ends = axis_of(name, landmarks)) {
      const Vector3d axis = ((*ends)[1] - (*ends)[0]).normalized();
      // project onto the axis: the tips of the malleoli lie beside it
      const auto half_way = [&](const Vector3d& end) {
        return Vector3d(centre + 0.5 * (end - centre).dot(axis) * axis);
      };
      picture.planes = {plane_across(axis, "medial", half_way((*ends)[0])),
                        plane_across(axis, "lateral", half_way((*ends)[1]))};
    } else {
      picture.planes = {{"coronal", centre, Vector3d::UnitX(), -Vector3d::UnitZ(), {}},
                        {"axial", centre, Vector3d::UnitX(), Vector3d::UnitY(), {}}};
    }
    double farthest = 0;
    for (const FitPlane& plane : picture.planes)
      farthest = std::max(farthest, (plane.middle - centre).norm());
    const CloseUp view =
        close_up(grey, centre, farthest + 0.75 * picture.side);  // half the diagonal and more
    for (FitPlane& plane : picture.planes) draw(view, picture, plane);
    pictures.push_back(std::move(picture));
  }
  return pictures;
}

}  // namespace borelli
