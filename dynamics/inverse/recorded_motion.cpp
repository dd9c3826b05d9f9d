#include "dynamics/inverse/recorded_motion.hpp"

#include <fmt/format.h>

#include "dynamics/inverse/low_pass.hpp"
#include "dynamics/numbers/pose.hpp"

namespace borelli {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

/// A ball's quaternions, each with the sign that makes it nearest to the one before.
void keep_signs(MatrixXd& q, Eigen::Index first) {
  for (Eigen::Index i = 1; i < q.rows(); ++i)
    if (q.block<1, 4>(i, first).dot(q.block<1, 4>(i - 1, first)) < 0) q.block<1, 4>(i, first) *= -1;
}

}  // namespace

Result<RecordedMotion> RecordedMotion::of(const System& system, const RecordedPositions& positions,
                                          double cutoff) {
  if (positions.q.cols() != system.nq)
    return bad_use("recorded motion", fmt::format("has {} positions an instant, the system has {}",
                                                  positions.q.cols(), system.nq));
  SampledSignal signal{positions.times, positions.q};
  for (const CoordinateInfo& c : system.coordinates)
    if (c.q_size == 4) keep_signs(signal.values, c.q_index);
  if (cutoff != 0) {
    auto filtered = low_pass(signal, cutoff);
    if (!filtered) return tl::unexpected(filtered.error());
    signal = std::move(*filtered);
  }
  auto spline = QuinticSpline::through(signal.times, signal.values);
  if (!spline) return tl::unexpected(spline.error());
  RecordedMotion motion(system, std::move(*spline));
  motion.start_ = positions.times.front();
  motion.end_ = positions.times.back();
  return motion;
}

void RecordedMotion::at(double t, State& state, VectorXd& a) const {
  VectorXd value, rate, second;
  spline_.at(t, value, rate, second);
  state.t = t;
  state.q = value;
  state.v.resize(system_->nv);
  a.resize(system_->nv);
  for (const CoordinateInfo& c : system_->coordinates) {
    if (c.q_size == 1) {
      state.v[c.v_index] = rate[c.q_index];
      a[c.v_index] = second[c.q_index];
      continue;
    }
    // q = Q / |Q|; the angular velocity in the ball's own axes is w = 2 vec(conj(q) dq/dt), and its rate
    // 2 vec(conj(q) d2q/dt2), as conj(dq/dt) dq/dt has no vector part
    const Quaternion Q = value.segment<4>(c.q_index), dQ = rate.segment<4>(c.q_index),
                     ddQ = second.segment<4>(c.q_index);
    const double length = Q.norm(), stretch = Q.dot(dQ) / (length * length);
    const Quaternion q = Q / length;
    state.q.segment<4>(c.q_index) = q;
    const Quaternion back = conjugate(q);
    const Vector3d spin = 2 / length * product(back, dQ).tail<3>();
    state.v.segment<3>(c.v_index) = spin;
    a.segment<3>(c.v_index) = 2 / length * product(back, ddQ).tail<3>() - 2 * stretch * spin;
  }
}

}  // namespace borelli
