#include "segmentation/labelling/views.hpp"

#include <Eigen/Eigenvalues>

namespace borelli {
namespace {

using Eigen::Vector3d;

Eigen::Matrix3d axes_of(const Vector3d& left, const Vector3d& up) {
  Eigen::Matrix3d axes;
  axes.col(2) = up.normalized();
  axes.col(0) = (left - left.dot(axes.col(2)) * axes.col(2)).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

// The body's axes without hips and shoulders, from its shape: up along the centres of its sections, left
// along their longer axis.
Eigen::Matrix3d axes_of_form(const Anatomy& a) {
  const auto& g = a.grid();
  double count = 0;
  Vector3d sum = Vector3d::Zero();
  Eigen::Matrix2d across = Eigen::Matrix2d::Zero();  // second moments of all sections about their centres
  std::vector<std::pair<Vector3d, double>> sections;
  for (std::int64_t k = 0; k < g.size[2]; ++k) {
    double n = 0;
    Vector3d first = Vector3d::Zero();
    Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        if (!a.body.at(i, j, k)) continue;
        const Vector3d p = g.point(i, j, k);
        first += p, ++n;
        second += p.head<2>() * p.head<2>().transpose();
      }
    if (n == 0) continue;
    first /= n;
    across += second - n * first.head<2>() * first.head<2>().transpose();
    sections.emplace_back(first, n);
    sum += n * first, count += n;
  }
  if (count == 0) return Eigen::Matrix3d::Identity();
  const Vector3d centre = sum / count;
  Eigen::Vector2d rises = Eigen::Vector2d::Zero();
  double heights = 0;
  for (const auto& [c, n] : sections) {
    const double z = c[2] - centre[2];
    rises += n * z * (c - centre).head<2>();
    heights += n * z * z;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(across);
  Vector3d left(solver.eigenvectors()(0, 1), solver.eigenvectors()(1, 1), 0);
  constexpr double round = 1.3;  // ratio of second moments; below it no axis is longer
  if (solver.eigenvalues()[1] < round * solver.eigenvalues()[0]) left = Vector3d::UnitX();
  if (left[0] < 0) left = -left;
  // the sections of a short piece do not determine the up axis
  constexpr double long_enough = 500;  // mm
  const bool tall = a.step() * static_cast<double>(sections.size()) > long_enough;
  return axes_of(
      left, tall && heights > 0 ? Vector3d(rises[0] / heights, rises[1] / heights, 1) : Vector3d::UnitZ());
}

}  // namespace

bool has_both(const Trunk& trunk) {
  return trunk.hip[0] && trunk.hip[1] && trunk.shoulder[0] && trunk.shoulder[1];
}

Eigen::Matrix3d axes_of(const Trunk& trunk) {
  const auto across = [](const auto& pair) { return Vector3d(pair[0]->centre - pair[1]->centre); };
  const auto middle = [](const auto& pair) { return Vector3d(0.5 * (pair[0]->centre + pair[1]->centre)); };
  const Vector3d hips = across(trunk.hip), shoulders = across(trunk.shoulder);
  return axes_of(hips.normalized() + shoulders.normalized(), middle(trunk.shoulder) - middle(trunk.hip));
}

std::vector<View> other_views(const Anatomy& a, const Trunk& trunk) {
  constexpr double small = 0.82, large = 1.14;
  if (has_both(trunk)) {
    View view;
    if (trunk.scale < small || trunk.scale > large) view.size = trunk.scale;
    if (const View own{1, axes_of(trunk)}; own.turn() > straight_body) view.body = own.body;
    if (view.size == 1 && view.turn() == 0) return {};
    return {view};
  }
  std::vector<View> views;
  const View form{1, axes_of_form(a)};
  const bool turned = form.turn() > straight_body;
  if (turned) views.push_back(form);
  if (trunk.shoulder[0]) return views;  // confirmed by the lungs: only the hips are out of view
  constexpr double child = 0.68, giant = 1.22, trunk_and_more = 800;  // mm, an adult from knee to chin
  const double height = a.step() * static_cast<double>(a.grid().size[2]);
  for (const double size : {child, giant}) {
    if (height <= trunk_and_more * size) continue;
    views.push_back({size});
    if (turned) views.push_back({size, form.body});
  }
  return views;
}

}  // namespace borelli
