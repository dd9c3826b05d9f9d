#include "tests/suite/warped_scan.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "samples/phantom_builder.hpp"

namespace borelli::suite {
namespace {

using Eigen::Matrix3d, Eigen::Vector3d;

constexpr double trough = 700, half_width = 230, table_depth = 24, table_shell = 2;  // mm
constexpr double blanket_width = 260, blanket_depth = 6;

}  // namespace

Box view_box(const Scanner& scanner, const Landmarks& landmarks) {
  Box box{Vector3d::Constant(-1e9), Vector3d::Constant(1e9)};
  const auto z = [&](const char* name) { return landmarks.at(name).point.z() + scanner.shift; };
  const auto between = [&](double low, double high) { box.low.z() = low, box.high.z() = high; };
  const double hip = z("mid_hip"), neck = z("neck"), xiphion = z("xiphion");
  switch (scanner.view) {
    case View::whole:
      break;
    case View::no_head:
      box.high.z() = neck + 10;
      break;
    case View::trunk:
      between(hip - 130, neck + 40);
      break;
    case View::chest:
      between(xiphion - 70, neck + 20);
      break;
    case View::abdomen:
      between(hip + 30, xiphion + 50);
      break;
    case View::pelvis:
      between(hip - 100, z("spine_lower") + 20);
      break;
    case View::legs:
      box.high.z() = hip + 70;
      break;
    case View::head_neck:
      box.low.z() = neck - 50;
      break;
    case View::arms_and_trunk:
      box.low.z() = hip - 60;
      break;
    case View::one_leg: {
      box.high.z() = hip + 70;
      const double across = landmarks.at("hip_left").point.x() - landmarks.at("hip_right").point.x();
      if (std::abs(across) < 60) break;  // lying on a side: one leg is above the other
      (scanner.left == (across > 0) ? box.low : box.high).x() = landmarks.at("mid_hip").point.x();
    }
  }
  return box;
}

Grid scan_grid(const Scanner& scanner, const Landmarks& landmarks,
               const std::vector<Eigen::Vector3f>& corners) {
  const auto turn = [&](int axis) {
    return Eigen::AngleAxisd(scanner.rotation_deg[axis] * std::numbers::pi / 180, Vector3d::Unit(axis));
  };
  const Matrix3d directions = (turn(2) * turn(1) * turn(0)).toRotationMatrix();
  Grid grid;
  grid.axes = directions * scanner.spacing.asDiagonal();
  grid.axes.col(2) +=
      directions.col(1) * std::tan(scanner.tilt_deg * std::numbers::pi / 180) * scanner.spacing.z();
  const Matrix3d inverse = grid.axes.inverse();
  const Box view = view_box(scanner, landmarks);
  Box shown;
  Vector3d sum = Vector3d::Zero();
  double count = 0;
  for (const auto& corner : corners) {
    const Vector3d p = corner.cast<double>();
    if ((p - view.low).minCoeff() >= 0 && (view.high - p).minCoeff() >= 0)
      shown.hold(inverse * p), sum += inverse * p, ++count;
  }
  // a margin only where the body itself ends, not at the view's ends
  Box all;
  for (const auto& corner : corners) all.hold(inverse * corner.cast<double>());
  Vector3d first, last;
  for (int c = 0; c < 3; ++c) {
    const double margin = 15 / scanner.spacing[c];
    first[c] = std::floor(shown.low[c] - (shown.low[c] - all.low[c] < 2 * margin || c < 2 ? margin : 0));
    last[c] = std::ceil(shown.high[c] + (all.high[c] - shown.high[c] < 2 * margin || c < 2 ? margin : 0));
  }
  if (view.low.x() > -1e8) first[0] = std::ceil(shown.low[0]);
  if (view.high.x() < 1e8) last[0] = std::floor(shown.high[0]);
  // a round view is centred on the body, not on the box around outstretched limbs
  if (scanner.effects.field_of_view > 0 && count > 0)
    for (int c = 0; c < 2; ++c) {
      const double half = 0.5 * scanner.effects.field_of_view / scanner.spacing[c];
      first[c] = std::floor(sum[c] / count - half), last[c] = std::ceil(sum[c] / count + half);
    }
  else if (scanner.effects.table)
    last[1] = std::ceil(last[1] + 40 / scanner.spacing.y());
  grid.origin = grid.axes * (first + 0.5 * scanner.offset);
  for (int c = 0; c < 3; ++c)
    grid.size[static_cast<std::size_t>(c)] = std::max<std::int64_t>(2, std::int64_t(last[c] - first[c]) + 1);
  return grid;
}

Grid cube_grid(const std::vector<Eigen::Vector3f>& corners, double step) {
  Box box;
  for (const auto& corner : corners) box.hold(corner.cast<double>());
  Grid grid;
  grid.axes = step * Matrix3d::Identity();
  grid.origin = box.low;
  for (int c = 0; c < 3; ++c)
    grid.size[static_cast<std::size_t>(c)] = std::int64_t((box.high[c] - box.low[c]) / step) + 2;
  return grid;
}

Surroundings::Surroundings(const ScanOptions& options, const std::vector<Eigen::Vector3f>& corners,
                           double blanket_top)
    : table_(options.table), blanket_(options.blanket), top_(blanket_top) {
  Box box;
  for (const auto& corner : corners) box.hold(corner.cast<double>());
  middle_ = 0.5 * (box.low.x() + box.high.x());
  back_ = box.high.y(), deep_ = box.high.y() - box.low.y();
  for (const auto& corner : corners) {
    const double dx = corner.x() - middle_;
    if (std::abs(dx) < half_width)
      axis_y_ = std::max(axis_y_, corner.y() - std::sqrt(trough * trough - dx * dx) + 3);
  }
}

int Surroundings::hu(const Vector3d& p) const {
  const double dx = p.x() - middle_;
  if (table_ && std::abs(dx) < half_width) {
    const double r = std::hypot(dx, p.y() - axis_y_) - trough;
    if (p.y() > axis_y_ && r >= 0 && r <= table_depth)
      return r < table_shell || r > table_depth - table_shell || std::abs(dx) > half_width - table_shell
                 ? tissue::table.hu
                 : -940;
  }
  if (blanket_ && p.y() < back_ && p.z() < top_) {
    const double inner = std::hypot(dx / blanket_width, (p.y() - back_) / deep_),
                 outer = std::hypot(dx / (blanket_width + blanket_depth),
                                    (p.y() - back_) / (deep_ + blanket_depth));
    if (inner >= 1 && outer <= 1) return tissue::blanket.hu;
  }
  return -1000;
}

}  // namespace borelli::suite
