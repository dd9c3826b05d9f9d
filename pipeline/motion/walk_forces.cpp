#include "pipeline/motion/walk_forces.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/equations/momentum.hpp"
#include "pipeline/motion/solid_poses.hpp"

namespace borelli {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr double sole_room = 0.02;  // m, of flesh around the points of the sole

/// How far a centre of pressure is outside of the box around a standing foot's sole, m.
double beyond_sole(const WalkingFoot& foot, const WalkTiming& timing, const FootSoles& soles, double cycles,
                   const Vector3d& point) {
  const Vector3d heel_start = foot.X_WS * foot.heel;
  const double whole = std::floor(cycles - foot.lead);
  const Vector2d heel(heel_start.x() + foot.inward, -timing.stride() * (whole + foot.lead));
  Eigen::AlignedBox2d box;
  for (const Vector3d& sole : soles.find(foot.solid)->second)
    box.extend(Vector2d(heel + (sole - heel_start).head<2>()));
  return box.exteriorDistance(Vector2d(point.head<2>()));
}

}  // namespace

RootWrenches::RootWrenches(const System& system)
    : system_(system), efforts_(system), solid_(solid_index(system, "lower_trunk")) {
  for (const CoordinateInfo& c : system.coordinates)
    if (c.solid == "lower_trunk")
      for (int i = 0; i < c.v_size; ++i) root_.push_back(c.v_index + i);
}

GroundWrench RootWrenches::needed(const State& state, const VectorXd& a) {
  using Vector6d = Eigen::Matrix<double, 6, 1>;
  const auto left_at_root = [&](const std::vector<SolidWrench>& wrenches) {
    const VectorXd& efforts = efforts_.needed(state, a, wrenches);
    Vector6d out;
    for (int k = 0; k < 6; ++k) out[k] = efforts[root_[std::size_t(k)]];
    return out;
  };
  const Vector6d wanted = left_at_root({});
  Eigen::Matrix<double, 6, 6> unit_efforts;  // of unit forces and moments at the world's origin
  for (int k = 0; k < 6; ++k) {
    SolidWrench unit{.solid = solid_};
    (k < 3 ? unit.force[k] : unit.moment[k - 3]) = 1;
    unit_efforts.col(k) = wanted - left_at_root({unit});
  }
  const Vector6d wrench = unit_efforts.partialPivLu().solve(wanted);
  return {wrench.head<3>(), wrench.tail<3>()};
}

WalkLoads walk_loads(const System& system, const RecordedMotion& motion, const std::vector<double>& times,
                     const std::array<WalkingFoot, 2>& feet, const WalkTiming& timing,
                     const FootSoles& soles) {
  WalkLoads out;
  const auto count = std::ssize(times);
  for (const WalkingFoot& foot : feet) {
    const Eigen::Matrix3Xd nothing = Eigen::Matrix3Xd::Zero(3, count);
    const Eigen::Matrix3Xd nowhere =
        Eigen::Matrix3Xd::Constant(3, count, std::numeric_limits<double>::quiet_NaN());
    out.loads.push_back({foot.solid, "ground", "ground", {foot.solid, times, nothing, nowhere, nothing}});
  }
  RootWrenches wrenches(system);
  Kinematics kinematics(system, Equations::recursive);
  State state;
  VectorXd a;
  double farthest = 0, when = 0;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const double t = times[std::size_t(i)], cycles = t / timing.cycle;
    motion.at(t, state, a);
    const GroundWrench whole = wrenches.needed(state, a);
    update_kinematics(system, system.parameters, t, state.q.data(), state.v.data(), kinematics);
    const Vector3d centre = momenta(system, system.parameters, kinematics).centre;
    std::array<double, 2> share{};
    std::array<Vector3d, 2> force, point;
    Vector2d planned = Vector2d::Zero();
    for (std::size_t f = 0; f < 2; ++f) {
      share[f] = planned_share(feet[f], cycles);
      point[f] = planned_pressure(feet[f], timing, cycles);
      planned += share[f] * point[f].head<2>();
    }
    // each force points at the gravity centre; the rest of the sum is shared by planned_share
    Vector2d left = whole.force.head<2>();
    for (std::size_t f = 0; f < 2; ++f) {
      point[f].head<2>() += whole.pressure() - planned;
      force[f] = share[f] * whole.force.z() / centre.z() * (centre - point[f]);
      force[f].z() = share[f] * whole.force.z();
      left -= force[f].head<2>();
    }
    double turn = whole.moment.z();
    for (std::size_t f = 0; f < 2; ++f) {
      force[f].head<2>() += share[f] * left;
      turn -= point[f].cross(force[f]).z();
    }
    for (std::size_t f = 0; f < 2; ++f) {
      if (share[f] <= 0) continue;
      MeasuredForce& measured = out.loads[f].measured;
      measured.force.col(i) = force[f];
      measured.point.col(i) = point[f];
      measured.moment.col(i) = Vector3d(0, 0, share[f] * turn);
      if (const double off = beyond_sole(feet[f], timing, soles, cycles, point[f]); off > farthest)
        farthest = off, when = t;
    }
  }
  if (farthest > sole_room)
    out.warnings.push_back(fmt::format(
        "the centre of pressure is up to {:.0f} mm outside of the points of the sole, at {:.2f} s",
        1e3 * farthest, when));
  return out;
}

}  // namespace borelli
