#include "dynamics/run/step_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "dynamics/numbers/rotation_vector.hpp"

namespace borelli {

namespace {

// A coordinate slower than this fraction of its group's fastest one is judged as if it had this speed: its
// energy is a thousandth, which is the error that fixed steps may have.
constexpr double least_share = 0.03;

// Speeds below are rounding (coordinates' scales per second).
constexpr double slowest_swing = 1e-7;

}  // namespace

StepWatch::StepWatch(const System& system)
    : system_(system), q_(system.nq), v_(system.nv), a_(system.nv), coordinates_(system.coordinates.size()) {}

void StepWatch::Largest::take(double now, double t, double h) {
  if (now > size) *this = {now, t, h};
}

std::optional<State> StepWatch::within_turn(const State& state) const {
  const double h = state.t - t_;
  if (!started_ || h <= 0) return std::nullopt;
  const auto turns_far = [&](const CoordinateInfo& info) {
    if (info.q_size == 4) return h * v_.segment<3>(info.v_index).norm() > std::numbers::pi;
    return info.angle && std::abs(state.q[info.q_index] - q_[info.q_index]) > std::numbers::pi;
  };
  if (std::none_of(system_.coordinates.begin(), system_.coordinates.end(), turns_far)) return std::nullopt;
  // the golden section: its multiples by small whole numbers are far from whole numbers
  const double part = (3 - std::sqrt(5.)) / 2;
  State out{t_ + part * h, q_, v_ + part * (state.v - v_)};
  for (const CoordinateInfo& info : system_.coordinates) {
    const int n = info.q_index;
    if (info.q_size == 4)
      out.q.segment<4>(n) =
          product(q_.segment<4>(n), exponential(part * h * v_.segment<3>(info.v_index))).normalized();
    else
      out.q[n] += part * (state.q[n] - q_[n]);
  }
  return out;
}

void StepWatch::observe(const State& state, const Eigen::VectorXd& a, bool joined,
                        const Eigen::VectorXd* within) {
  const double h = state.t - t_;
  for (std::size_t i = 0; i < coordinates_.size(); ++i) {
    const CoordinateInfo& info = system_.coordinates[i];
    const double scale = system_.velocity_scale[info.v_index];
    Followed& one = coordinates_[i];
    one.fastest = std::max(one.fastest, state.v.segment(info.v_index, info.v_size).norm() / scale);
    if (!started_ || !joined || h <= 0) continue;
    one.defect.take(defect(info, state, a, h) / (h * scale), state.t, h);
    const auto change = [&](const Eigen::VectorXd& from, const Eigen::VectorXd& to) {
      return h * (to - from).segment(info.v_index, info.v_size).norm() / scale;
    };
    one.change.take(change(a_, a), state.t, h);
    if (!within) continue;
    const double unseen = std::min(change(a_, *within), change(a, *within));
    one.unseen.take(unseen, state.t, h);
    one.all_unseen += unseen;
  }
  started_ = true;
  t_ = state.t;
  q_ = state.q;
  v_ = state.v;
  a_ = a;
}

/// Distance of the coordinate at the step's end from the quadrature of the rates at both ends, m or rad.
double StepWatch::defect(const CoordinateInfo& info, const State& state, const Eigen::VectorXd& a,
                         double h) const {
  const int i = info.v_index;
  if (info.q_size == 1)
    return std::abs(state.q[info.q_index] - q_[info.q_index] - h / 2 * (v_[i] + state.v[i]) +
                    h * h / 12 * (a[i] - a_[i]));
  const auto w0 = v_.segment<3>(i), w1 = state.v.segment<3>(i);
  const Eigen::Vector3d by =
      h / 2 * (w0 + w1) - h * h / 12 * (a.segment<3>(i) - a_.segment<3>(i)) + h * h / 12 * w0.cross(w1);
  const Quaternion led = product(q_.segment<4>(info.q_index), exponential(by));
  return logarithm(product(conjugate(led), state.q.segment<4>(info.q_index))).norm();
}

StepWatch::Finding StepWatch::worst(int order) const {
  const auto group = [&](std::size_t i) { return system_.velocity_groups[system_.coordinates[i].v_index]; };
  std::vector<double> fastest(system_.groups, slowest_swing / least_share);
  for (std::size_t i = 0; i < coordinates_.size(); ++i)
    fastest[group(i)] = std::max(fastest[group(i)], coordinates_[i].fastest);
  Finding worst;
  for (std::size_t i = 0; i < coordinates_.size(); ++i) {
    const Followed& one = coordinates_[i];
    const double speed = std::max(one.fastest, least_share * fastest[group(i)]);
    const auto take = [&](double part, const Largest& at) {
      if (part > worst.part) worst = {part, at.time, at.step, int(i)};
    };
    const double b2 = one.change.size / speed;  // phase angle per step, squared
    take(order < 4 ? b2 / 12 : order < 6 ? b2 * b2 / 720 : b2 * b2 * b2 / 100800, one.change);
    take(one.defect.size / speed, one.defect);
    take(one.all_unseen / speed, one.unseen);
  }
  return worst;
}

std::string StepWatch::reason(const Finding& finding) const {
  const CoordinateInfo& info = system_.coordinates[finding.coordinate];
  return fmt::format(
      "steps of {:.4g} s do not follow the motion of coordinate '{}' of '{}': the one up to t = {:.6g} s "
      "misses {:.2g} of its motion (limit {:.2g}); take shorter steps",
      finding.step, info.name, info.solid, finding.time, finding.part, limit);
}

}  // namespace borelli
