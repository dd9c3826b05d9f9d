#include "dynamics/formats/osim_write_joint.hpp"

#include <fmt/core.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "dynamics/formats/osim_write_function.hpp"
#include "dynamics/system/switch_check.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;
using AxisKind = GuidedPart::Kind;

constexpr double collinear_axes = 1e-4;  // OpenSim refuses axes whose cross product is below 1e-5
constexpr double near_lock = 0.98;       // sine of the second angle: 78.5 degrees
constexpr int deepest_coupling = 100;    // of coordinates that follow each other

/// An order of axes for the angles of a rotation: R = R_i(a) R_j(b) R_k(c).
struct OsimAngleOrder {
  std::array<int, 3> axes;
  double sign() const { return (axes[1] - axes[0] + 3) % 3 == 1 ? 1 : -1; }
  double lock(const Eigen::Matrix3d& R) const { return std::abs(R(axes[0], axes[2])); }

  Vector3d angles(const Eigen::Matrix3d& R) const {
    const auto [i, j, k] = axes;
    const double s = sign();
    return {std::atan2(-s * R(j, k), R(k, k)), std::atan2(s * R(i, k), std::hypot(R(i, i), R(i, j))),
            std::atan2(-s * R(i, j), R(i, i))};
  }

  /// The rates of the angles at an angular velocity in the axes of the turned frame.
  Vector3d rates(const Vector3d& at, const Vector3d& w) const {
    Eigen::Matrix3d E, R = Eigen::Matrix3d::Identity();
    for (int n = 0; n < 3; ++n) {
      E.col(n) = R.col(axes[n]);
      R = R * rotation_about(Vector3d::Unit(axes[n]), at[n]);
    }
    return E.fullPivLu().solve(R * w);
  }
};

// x, y, z where it can be; else the order that starts farthest from gimbal lock.
OsimAngleOrder order_for(const Eigen::Matrix3d& R) {
  static constexpr std::array<OsimAngleOrder, 6> orders{
      {{{0, 1, 2}}, {{1, 2, 0}}, {{2, 0, 1}}, {{0, 2, 1}}, {{1, 0, 2}}, {{2, 1, 0}}}};
  if (orders[0].lock(R) < near_lock) return orders[0];
  return *std::min_element(
      orders.begin(), orders.end(),
      [&](const OsimAngleOrder& a, const OsimAngleOrder& b) { return a.lock(R) < b.lock(R); });
}

class OsimChainWriter {
 public:
  OsimChainWriter(const Scene& scene, const Solid& solid, OsimNames& names, Omissions& lost)
      : scene_(scene), solid_(solid), names_(names), lost_(lost) {}

  Result<WrittenChain> write() {
    for (std::size_t i = 0; i < solid_.switches.size(); ++i)
      if (auto done = add(solid_.switches[i], coordinate_name(solid_, i)); !done)
        return tl::unexpected(done.error());
    end_joint();
    return std::move(chain_);
  }

 private:
  Result<void> add(const Switch& one, const std::string& name) {
    if (one.armature != 0) lost_.add("armatures are not written; OpenSim has none", name);
    if (const auto* fixed = std::get_if<Fixed>(&one.kind)) {
      X_ = X_ * fixed->X_AB;
    } else if (std::holds_alternative<Ball>(one.kind)) {
      add_ball(one, name);
    } else if (has_other_kind(one)) {
      const auto checked = check_switch(one, scene_.where(solid_));
      if (!checked) return tl::unexpected(checked.error());
      lost_.add(fmt::format("{} switches are fixed at their start", checked->kind_name), name);
      move_through(checked->kind, checked->q.data(), X_);
    } else {
      const std::vector<GuidedPart> parts = parts_of(one);
      for (const GuidedPart& part : parts)
        if (const std::string bad = osim_function_complaint(part.by); !bad.empty())
          return failure(scene_.where(solid_), fmt::format("its coordinate '{}' would {}", name, bad));
      if (!is_empty() && !fit(parts)) end_joint();
      add_scalar(one, name, parts);
    }
    return {};
  }

  // Where a scalar coordinate starts.
  double start_of(const Switch& one, int depth = 0) const {
    if (const auto* driven = std::get_if<Driven>(&one.motion)) return at(driven->functions[0], 0).value;
    const auto* coupled = std::get_if<Coupled>(&one.motion);
    if (!coupled || depth > deepest_coupling) return one.q.empty() ? 0 : one.q[0];
    for (const Solid& solid : scene_.solids)
      for (std::size_t i = 0; i < solid.switches.size(); ++i)
        if (coordinate_name(solid, i) == coupled->to)
          return at(coupled->function, start_of(solid.switches[i], depth + 1)).value;
    return 0;
  }

  // Whether no CustomJoint holds a switch.
  static bool has_other_kind(const Switch& one) {
    return std::visit([](const auto& kind) { return kind.nv > 1; }, one.kind) &&
           !std::holds_alternative<Ball>(one.kind);
  }

  static std::vector<GuidedPart> parts_of(const Switch& one) {
    const TimeFunction itself = linear(0, 1);
    if (const auto* slide = std::get_if<Translation>(&one.kind))
      return {{AxisKind::translation, slide->axis, itself}};
    if (const auto* turn = std::get_if<Rotation>(&one.kind))
      return {{AxisKind::rotation, turn->axis, itself}};
    if (const auto* screw = std::get_if<Screw>(&one.kind))
      return {{AxisKind::translation, screw->axis, linear(0, screw->pitch)},
              {AxisKind::rotation, screw->axis, itself}};
    return std::get<Guided>(one.kind).parts;
  }

  // ---- the joint at hand: translations, then rotations; X_ is the pose behind them ----

  bool is_empty() const { return joint_.translations.empty() && joint_.rotations.empty(); }

  static bool has_room(const std::vector<WrittenAxis>& axes, const Vector3d& axis) {
    return axes.size() < 3 && std::none_of(axes.begin(), axes.end(), [&](const WrittenAxis& other) {
             return other.part.axis.cross(axis).norm() < collinear_axes;
           });
  }

  bool fits(const GuidedPart& part) const {
    if (is_empty()) return true;
    const Vector3d axis = X_.R * part.axis;
    if (part.kind == AxisKind::translation)
      return joint_.rotations.empty() && has_room(joint_.translations, axis);
    return (joint_.rotations.empty() || X_.p.isZero(0)) && has_room(joint_.rotations, axis);
  }

  // Whether all parts, one after the other, fit into the joint.
  bool fit(const std::vector<GuidedPart>& parts) const {
    OsimChainWriter trial(*this);
    return std::all_of(parts.begin(), parts.end(), [&](const GuidedPart& part) {
      const bool fine = trial.fits(part);
      if (fine) trial.append(part, 0);
      return fine;
    });
  }

  // X T(q a) = T(q R a) X, and X R(a, q) = T(p) R(R a, q) R; translations commute.
  void append(const GuidedPart& part, std::size_t coordinate) {
    if (is_empty()) {
      joint_.X_PF = X_;
      X_ = {};
    }
    WrittenAxis axis{part, coordinate};
    axis.part.axis = (X_.R * part.axis).normalized();
    if (part.kind == AxisKind::translation) {
      joint_.translations.push_back(axis);
      return;
    }
    if (joint_.rotations.empty()) {
      joint_.X_PF.p += joint_.X_PF.R * X_.p;
      X_.p.setZero();
    }
    joint_.rotations.push_back(axis);
  }

  void end_joint() {
    if (is_empty()) {
      joint_.X_PF = X_;
      X_ = {};
    }
    joint_.X_MB = X_;
    chain_.joints.push_back(std::move(joint_));
    joint_ = {};
    X_ = {};
  }

  // ---- coordinates ----

  void add_scalar(const Switch& one, const std::string& name, const std::vector<GuidedPart>& parts) {
    WrittenCoordinate own = scalar_coordinate(one, name);
    joint_.coordinates.push_back(own);
    for (const GuidedPart& part : parts) {
      if (!fits(part)) {
        end_joint();
        WrittenCoordinate next{.name = names_.new_coordinate(own.name), .turns = own.turns};
        next.start = own.start, next.speed = own.speed;
        chain_.couplings.push_back({next.name, own.name, linear(0, 1)});
        joint_.coordinates.push_back(std::move(next));
      }
      append(part, joint_.coordinates.size() - 1);
    }
    if (const auto* coupled = std::get_if<Coupled>(&one.motion))
      chain_.couplings.push_back({own.name, names_.coordinate(coupled->to), coupled->function});
  }

  WrittenCoordinate scalar_coordinate(const Switch& one, const std::string& name) {
    WrittenCoordinate out{.name = names_.coordinate(name),
                          .turns = !std::holds_alternative<Translation>(one.kind)};
    out.start = start_of(one);
    if (!one.v.empty()) out.speed = one.v[0];
    out.locked = std::holds_alternative<Locked>(one.motion);
    if (!one.ranges.empty() && std::holds_alternative<Free>(one.motion)) {
      out.range = one.ranges[0];
      out.clamped = true;
    }
    if (const auto* driven = std::get_if<Driven>(&one.motion)) {
      if (const std::string bad = osim_function_complaint(driven->functions[0]); bad.empty()) {
        out.prescribed = driven->functions[0];
      } else {
        out.locked = true;
        lost_.add(fmt::format("driven coordinates that {}, are locked where they are at time 0", bad), name);
      }
    }
    return out;
  }

  void add_ball(const Switch& one, const std::string& name) {
    if (!joint_.rotations.empty()) end_joint();
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    if (!one.q.empty()) R = rotation_matrix(Quaternion(one.q[0], one.q[1], one.q[2], one.q[3]));
    bool locked = std::holds_alternative<Locked>(one.motion);
    if (const auto* driven = std::get_if<Driven>(&one.motion)) {
      Vector3d turned;
      for (int i = 0; i < 3; ++i) turned[i] = at(driven->functions[i], 0).value;
      R = R * rotation_matrix(exponential(turned));
      locked = true;
      lost_.add("driven balls are locked where they are at time 0", name);
    }
    if (!one.ranges.empty())
      lost_.add("ranges of balls bound rotation vectors; the angles have them, but are not clamped", name);
    const OsimAngleOrder order = order_for(R);
    const Vector3d angles = order.angles(R);
    Vector3d rates = Vector3d::Zero();
    if (one.v.size() == 3) rates = order.rates(angles, {one.v[0], one.v[1], one.v[2]});
    for (int n = 0; n < 3; ++n) {
      const int axis = order.axes[n];
      WrittenCoordinate angle{.name = names_.new_coordinate(name + "_" + "xyz"[axis])};
      angle.start = angles[n], angle.speed = rates[n], angle.locked = locked;
      if (one.ranges.size() == 3)
        angle.range =
            Range{std::min(one.ranges[axis].lower, angles[n]), std::max(one.ranges[axis].upper, angles[n])};
      joint_.coordinates.push_back(std::move(angle));
      append({AxisKind::rotation, Vector3d::Unit(axis), linear(0, 1)}, joint_.coordinates.size() - 1);
    }
  }

  const Scene& scene_;
  const Solid& solid_;
  OsimNames& names_;
  Omissions& lost_;
  WrittenChain chain_;
  WrittenJoint joint_;
  Pose X_;  // behind the axes of joint_; before it has any, in the parent body
};

}  // namespace

Result<WrittenChain> write_osim_chain(const Scene& scene, const Solid& solid, OsimNames& names,
                                      Omissions& lost) {
  return OsimChainWriter(scene, solid, names, lost).write();
}

}  // namespace borelli
