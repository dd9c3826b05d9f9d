#include "inertia/inertial.hpp"

#include <fmt/core.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// inertia tensor of a unit point mass at r
Matrix3d point_tensor(const Vector3d& r) {
  return r.squaredNorm() * Matrix3d::Identity() - r * r.transpose();
}

}  // namespace

Inertial Inertial::moved(const Vector3d& displacement) const { return {mass, centre + displacement, tensor}; }

Inertial Inertial::rotated(const Matrix3d& R) const { return {mass, R * centre, R * tensor * R.transpose()}; }

Inertial Inertial::expressed_in(const Matrix3d& R_GF, const Vector3d& p_GF) const {
  return rotated(R_GF).moved(p_GF);
}

Matrix3d Inertial::tensor_about(const Vector3d& point) const {
  return tensor + mass * point_tensor(centre - point);
}

PrincipalAxes Inertial::principal() const {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(tensor);
  PrincipalAxes principal{solver.eigenvalues(), solver.eigenvectors()};
  if (principal.axes.determinant() < 0) principal.axes.col(2) *= -1;
  return principal;
}

Vector3d Inertial::radii_of_gyration(const Matrix3d& R_FA) const {
  return ((R_FA.transpose() * tensor * R_FA).diagonal() / mass).cwiseSqrt();
}

Inertial operator+(const Inertial& a, const Inertial& b) {
  const double mass = a.mass + b.mass;
  if (mass == 0) return {};
  const Vector3d from_a_to_b = b.centre - a.centre;
  return {mass, a.centre + b.mass / mass * from_a_to_b,
          a.tensor + b.tensor + a.mass * (b.mass / mass) * point_tensor(from_a_to_b)};
}

Inertial operator-(const Inertial& whole, const Inertial& part) {
  const double mass = whole.mass - part.mass;
  if (mass == 0) return {};
  const Vector3d centre = whole.centre + part.mass / mass * (whole.centre - part.centre);
  return {mass, centre,
          whole.tensor - part.tensor - mass * (part.mass / whole.mass) * point_tensor(part.centre - centre)};
}

Result<void> check_physical(const Inertial& inertial, std::string name, Extent extent) {
  const auto refuse = [&](std::string what) { return failure(std::move(name), std::move(what)); };
  const Matrix3d& I = inertial.tensor;
  if (!std::isfinite(inertial.mass) || !inertial.centre.allFinite() || !I.allFinite())
    return refuse("mass, gravity centre or inertia tensor is not a finite number");
  if (inertial.mass <= 0)
    return refuse(fmt::format("mass is {:.6g} kg, expected a positive number", inertial.mass));

  const double rounding = 1e-12 * I.cwiseAbs().maxCoeff();
  const Matrix3d skew = I - I.transpose();
  if (skew.cwiseAbs().maxCoeff() > rounding)
    return refuse(
        fmt::format("inertia tensor is not symmetric: Ixy {:.6g} and Iyx {:.6g}, Ixz {:.6g} and Izx "
                    "{:.6g}, Iyz {:.6g} and Izy {:.6g} kg m^2",
                    I(0, 1), I(1, 0), I(0, 2), I(2, 0), I(1, 2), I(2, 1)));

  const Vector3d moments = inertial.principal().moments;
  const bool bar_or_point = extent == Extent::may_be_bar_or_point;
  if (bar_or_point ? moments[0] < -rounding : moments[0] <= rounding)
    return refuse(
        fmt::format("inertia tensor is not positive definite: its principal moments are {:.6g}, {:.6g} and "
                    "{:.6g} kg m^2",
                    moments[0], moments[1], moments[2]));
  if (moments[2] > moments[0] + moments[1] + rounding)
    return refuse(fmt::format(
        "inertia tensor violates the triangle inequality: its largest principal moment {:.6g} exceeds the "
        "sum of the others, {:.6g} + {:.6g} = {:.6g} kg m^2, which is impossible for a body",
        moments[2], moments[0], moments[1], moments[0] + moments[1]));
  return {};
}

}  // namespace borelli
