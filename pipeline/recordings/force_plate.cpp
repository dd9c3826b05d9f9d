#include "pipeline/recordings/force_plate.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

namespace borelli {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

// Force and moment about the surface's centre C, in the plate's frame.
struct PlateWrench {
  Matrix3Xd force, moment;
};

// M_C = M_O + F × p_OC
void move_to_surface(PlateWrench& wrench, const Vector3d& p_OC) {
  for (Index i = 0; i < wrench.force.cols(); ++i)
    wrench.moment.col(i) += Vector3d(wrench.force.col(i)).cross(p_OC);
}

PlateWrench wrench_of_type_1(const Eigen::MatrixXd& c) {
  PlateWrench out{c.topRows(3), Matrix3Xd::Zero(3, c.cols())};
  const auto px = c.row(3).array(), py = c.row(4).array();
  out.moment.row(0) = py * c.row(2).array();
  out.moment.row(1) = -px * c.row(2).array();
  out.moment.row(2) = c.row(5).array() + px * c.row(1).array() - py * c.row(0).array();
  return out;
}

PlateWrench wrench_of_type_3(const Eigen::MatrixXd& c, const Vector3d& origin) {
  const double a = std::abs(origin.x()), b = std::abs(origin.y());
  PlateWrench out{Matrix3Xd(3, c.cols()), Matrix3Xd(3, c.cols())};
  out.force.row(0) = c.row(0) + c.row(1);
  out.force.row(1) = c.row(2) + c.row(3);
  out.force.row(2) = c.row(4) + c.row(5) + c.row(6) + c.row(7);
  out.moment.row(0) = b * (c.row(4) + c.row(5) - c.row(6) - c.row(7));
  out.moment.row(1) = a * (-c.row(4) + c.row(5) + c.row(6) - c.row(7));
  out.moment.row(2) = b * (c.row(1) - c.row(0)) + a * (c.row(2) - c.row(3));
  move_to_surface(out, {0, 0, origin.z()});
  return out;
}

PlateWrench wrench_of(const ForcePlate& plate, const Eigen::MatrixXd& channels, const Vector3d& origin) {
  if (plate.type == 1) return wrench_of_type_1(channels);
  if (plate.type == 3) return wrench_of_type_3(channels, origin);
  PlateWrench out{channels.topRows(3), channels.middleRows(3, 3)};
  move_to_surface(out, origin);
  return out;
}

Eigen::RowVectorXd vertical_channel(const ForcePlate& plate) {
  if (plate.type == 3) return plate.channels.middleRows(4, 4).colwise().sum();
  return plate.channels.row(2);
}

double greatest(const Eigen::RowVectorXd& values) {
  double out = 0;
  for (const double value : values)
    if (value > out) out = value;  // skips NaN
  return out;
}

Eigen::MatrixXd without_baseline(const ForcePlate& plate, std::vector<std::string>& warnings) {
  const auto [first, end] = plate.unloaded;
  Eigen::MatrixXd out = plate.channels;
  if (first < 0 || end <= first || end > out.cols()) return out;
  const Eigen::RowVectorXd load = vertical_channel(plate);
  const double mean = load.segment(first, end - first).mean();
  if (!(std::abs(mean) <= greatest(load.cwiseAbs()) / 10)) {
    if (std::abs(mean) > least_plate_load)
      warnings.push_back(
          fmt::format("{} carries {:.0f} N in the frames that FORCE_PLATFORM:ZERO calls unloaded, so no "
                      "baseline was subtracted",
                      plate.name, std::abs(mean)));
    return out;
  }
  const Eigen::VectorXd baseline = out.middleCols(first, end - first).rowwise().mean();
  // type 1 gives a point, which has no meaning while nothing stands on the plate
  for (Index row = 0; row < out.rows(); ++row)
    if (plate.type != 1 || (row != 3 && row != 4)) out.row(row).array() -= baseline[row];
  return out;
}

Vector3d upward_origin(const ForcePlate& plate, double z_up, std::vector<std::string>& warnings) {
  Vector3d out = plate.origin;
  if (plate.type == 1 || !(out.z() * z_up < 0)) return out;
  warnings.push_back(
      fmt::format("ORIGIN of {} has the wrong sign ({:g} m along z) and was reversed", plate.name, out.z()));
  if (plate.type == 3)
    out.z() = -out.z();
  else
    out = -out;
  return out;
}

}  // namespace

Result<Matrix3d> plate_axes(const ForcePlate& plate) {
  const auto& c = plate.corners;
  const Vector3d x = (c.col(0) - c.col(1) + c.col(3) - c.col(2)) / 2;
  const Vector3d y = (c.col(0) - c.col(3) + c.col(1) - c.col(2)) / 2;
  const double width = x.norm(), length = y.norm();
  if (!c.allFinite() || !(std::min(width, length) >= 0.01) || !(std::max(width, length) <= 100))
    return failure(plate.name,
                   fmt::format("has corners {:g} m and {:g} m apart, expected 0.01 to 100 m", width, length));
  const double skew = x.dot(y) / (width * length);
  if (std::abs(skew) > std::sin(12 * M_PI / 180))
    return failure(plate.name, fmt::format("has edges at {:.0f} degrees, expected a rectangle",
                                           std::acos(std::clamp(skew, -1.0, 1.0)) * 180 / M_PI));
  Matrix3d R_WP;
  R_WP.col(0) = x / width;
  R_WP.col(2) = x.cross(y).normalized();
  R_WP.col(1) = R_WP.col(2).cross(R_WP.col(0));
  return R_WP;
}

Vector3d plate_normal(const Matrix3d& R_WP, const std::optional<Vector3d>& up) {
  const Vector3d z = R_WP.col(2);
  return up && z.dot(*up) > 0.5 ? z : Vector3d(-z);
}

Result<MeasuredForce> measured_force(const ForcePlate& plate, const std::vector<double>& times,
                                     const std::optional<Vector3d>& up, std::vector<std::string>& warnings) {
  if (plate.type < 1 || plate.type > 4)
    return failure(plate.name, fmt::format("is of type {}, expected 1 to 4", plate.type));
  const auto axes = plate_axes(plate);
  if (!axes) return tl::unexpected(axes.error());
  const Matrix3d& R_WP = *axes;
  const Vector3d normal = plate_normal(R_WP, up);
  const Vector3d origin = upward_origin(plate, normal.dot(R_WP.col(2)), warnings);
  PlateWrench wrench = wrench_of(plate, without_baseline(plate, warnings), origin);
  const double z_up = normal.dot(R_WP.col(2)) > 0 ? 1 : -1;
  const double push = greatest(z_up * wrench.force.row(2)), pull = greatest(-z_up * wrench.force.row(2));
  if (pull > 50 && pull > 2 * push) {
    warnings.push_back(
        fmt::format("{} would pull with {:.0f} N, so the file states the body's force on the plate; all "
                    "signs were changed",
                    plate.name, pull));
    wrench.force = -wrench.force;
    wrench.moment = -wrench.moment;
  }

  const bool has_point = plate.type != 3 || (origin.x() != 0 && origin.y() != 0);
  if (!has_point)
    warnings.push_back(fmt::format(
        "{} has no sensor positions in ORIGIN, so its centre of pressure is unknown", plate.name));
  MeasuredForce out{plate.name, times, R_WP * wrench.force, {}, {}};
  const Vector3d centre = plate.corners.rowwise().mean();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  out.point = out.moment = Matrix3Xd::Constant(3, wrench.force.cols(), nan);
  for (Index i = 0; i < wrench.force.cols(); ++i) {
    const Vector3d F = wrench.force.col(i), M = wrench.moment.col(i);
    if (!has_point || !(z_up * F.z() >= least_plate_load) || !F.allFinite() || !M.allFinite()) continue;
    const Vector3d p(-M.y() / F.z(), M.x() / F.z(), 0);  // where the moment has no x and no y
    out.point.col(i) = centre + R_WP * p;
    out.moment.col(i) = R_WP.col(2) * (M - p.cross(F)).z();
  }
  return out;
}

}  // namespace borelli
