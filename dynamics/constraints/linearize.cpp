#include "dynamics/constraints/linearize.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>

#include "dynamics/constraints/change_in_time.hpp"
#include "dynamics/equations/constraint_solver.hpp"
#include "dynamics/equations/derivatives.hpp"
#include "dynamics/system/border.hpp"

namespace borelli {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double steady = 1e-6;  // of the accelerations that each force, or a deviation by one length, gives
                                 // alone
constexpr double zero_real_part = 1e-6;  // of the largest eigenvalue

/// The part of the rate of the position deviation beyond the velocity deviation: for a ball's small rotation
/// x in its own axes, dx/dt = dv - w x x.
MatrixXd transport(const System& system, const State& state) {
  MatrixXd C = MatrixXd::Zero(system.nv, system.nv);
  for (const CoordinateInfo& info : system.coordinates) {
    if (info.v_size != 3) continue;
    const Eigen::Vector3d w = state.v.segment<3>(info.v_index);
    C.block<3, 3>(info.v_index, info.v_index) << 0, w[2], -w[1], -w[2], 0, w[0], w[1], -w[0], 0;
  }
  return C;
}

/// Whether accelerations, their derivatives and the constraints are the same at later times. `largest`: the
/// scale of accelerations in lengths per s^2.
Result<void> check_unchanging(const System& system, const State& state, const ForwardDerivatives& d,
                              const VectorXd& lengths, double largest) {
  const ChangeInTime change = change_in_time(system, state.t);
  const auto differ = [](const Rows& one, const Rows& other, double scale) {
    return (one - other).cwiseAbs().maxCoeff() > steady * std::max(scale, one.cwiseAbs().maxCoeff());
  };
  for (const double t : change.times) {
    State later = state;
    later.t = t;
    const auto then = evaluate(system, later);
    if (!then) return tl::unexpected(then.error());
    const auto by = forward_derivatives(system, later);
    if (!by) return tl::unexpected(by.error());
    if (then->acceleration.cwiseQuotient(lengths).cwiseAbs().maxCoeff() > steady * largest ||
        !violation(system, *then).empty() || differ(d.acceleration_by_q, by->acceleration_by_q, largest) ||
        differ(d.acceleration_by_v, by->acceleration_by_v, std::sqrt(largest)))
      return bad_use(system.scene,
                     fmt::format("{}: the equations of motion at t = {:.6g} s differ from those at {:.6g} s; "
                                 "small deviations have modes only if nothing changes",
                                 change.words(), t, state.t));
  }
  return {};
}

Result<void> check_steady(const System& system, const State& state, const Evaluation& now,
                          const ForwardDerivatives& d) {
  // Scale: the acceleration that each generalised force and multiplier gives alone ...
  VectorXd efforts = now.generalized_efforts.cwiseAbs() + now.bias.cwiseAbs();
  if (!now.rows.empty())
    efforts += (now.constraint_jacobian.transpose().cwiseAbs() * now.multipliers.cwiseAbs());
  const VectorXd scale = Eigen::Map<const VectorXd>(system.velocity_scale.data(), system.nv);
  double largest = 0;  // ... or a deviation by one length, if larger
  for (int i = 0; i < system.nv; ++i)
    largest = std::max(
        {largest, efforts[i] / now.mass_matrix(i, i) / scale[i],
         (d.acceleration_by_q.row(i).transpose().cwiseProduct(scale)).cwiseAbs().maxCoeff() / scale[i]});
  if (const std::string violated = violation(system, now); !violated.empty())
    return bad_use(system.scene, "is not steady at this state: " + violated + "; start from an equilibrium");
  Eigen::Index worst = 0;
  const double a = now.acceleration.cwiseQuotient(scale).cwiseAbs().maxCoeff(&worst);
  if (a > steady * largest)
    return bad_use(
        fmt::format("coordinate '{}'", now.coordinates[std::size_t(worst)]),
        fmt::format("the state is not steady: its acceleration is {:.3g}; start from an equilibrium",
                    now.acceleration[worst]));
  const VectorXd jerk = d.acceleration_by_q * state.v;
  const VectorXd size = d.acceleration_by_q.cwiseAbs() * state.v.cwiseAbs();
  for (int i = 0; i < system.nv; ++i)
    if (std::abs(jerk[i]) > steady * size.maxCoeff())
      return bad_use(fmt::format("coordinate '{}'", now.coordinates[std::size_t(i)]),
                     fmt::format("the state is not steady: its acceleration is zero only for an instant and "
                                 "grows by {:.3g} per second",
                                 jerk[i]));
  return check_unchanging(system, state, d, scale, largest);
}

/// Directions that the rows leave free, in coordinates without units: orthonormal columns.
MatrixXd free_directions(const System& system, const Rows& L, const VectorXd& scale) {
  const int n = system.nv;
  if (L.rows() == 0) return MatrixXd::Identity(n, n);
  MatrixXd rows = MatrixXd(L) * scale.asDiagonal();
  for (Eigen::Index r = 0; r < rows.rows(); ++r)
    if (const double length = rows.row(r).norm(); length > 0) rows.row(r) /= length;
  Eigen::JacobiSVD<MatrixXd> svd(rows, Eigen::ComputeFullV);
  Eigen::Index rank = 0;
  for (const double s : svd.singularValues()) rank += s > ConstraintSolver::rank_tolerance;
  return svd.matrixV().rightCols(n - rank);
}

std::vector<Mode> modes_of(const MatrixXd& state_matrix, const Rows& basis, const VectorXd& scale,
                           double& largest, double& growth) {
  const Eigen::EigenSolver<MatrixXd> solver(state_matrix);
  const auto& values = solver.eigenvalues();
  const auto& vectors = solver.eigenvectors();
  largest = values.cwiseAbs().maxCoeff();
  growth = values.real().maxCoeff();
  std::vector<Mode> out;
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    if (values[i].imag() < 0) continue;
    Mode& mode = out.emplace_back();
    mode.eigenvalue = values[i];
    const double size = std::abs(values[i]);
    mode.frequency = values[i].imag() > 0 ? size / (2 * M_PI) : 0;
    mode.damping_ratio = size > 0 ? -values[i].real() / size : 0;
    mode.shape = basis.cast<std::complex<double>>() * vectors.col(i).head(basis.cols());
    Eigen::Index farthest = 0;
    if (mode.shape.cwiseAbs().cwiseQuotient(scale).maxCoeff(&farthest) > 0)
      mode.shape /= mode.shape[farthest];
  }
  std::sort(out.begin(), out.end(), [](const Mode& a, const Mode& b) {
    return std::pair(a.eigenvalue.imag(), a.eigenvalue.real()) <
           std::pair(b.eigenvalue.imag(), b.eigenvalue.real());
  });
  return out;
}

}  // namespace

Result<Linearization> linearize(const System& system, const State& state) {
  return at_border(system, [&]() -> Result<Linearization> {
    if (!system.contacts.empty())
      return bad_use(
          fmt::format("constraint '{}'", system.constraint_names[std::size_t(system.contacts[0].constraint)]),
          "is a contact, which small deviations open and close, so there is no state matrix; replace it by a "
          "constraint or a limit_spring");
    if (system.nv == 0) return bad_use(system.scene, "has no free coordinate, so there are no deviations");
    const auto now = evaluate(system, state);
    if (!now) return tl::unexpected(now.error());
    if (system.rows > 0 && state.v.cwiseAbs().maxCoeff() > 0)
      return bad_use(
          system.scene,
          "has constraints, whose small deviations are computed only at rest; give zero velocities");
    const auto d = forward_derivatives(system, state);
    if (!d) return tl::unexpected(d.error());
    if (auto fine = check_steady(system, state, *now, *d); !fine) return tl::unexpected(fine.error());

    const VectorXd scale = Eigen::Map<const VectorXd>(system.velocity_scale.data(), system.nv);
    const MatrixXd N = free_directions(system, now->constraint_jacobian, scale);
    Linearization out;
    out.basis = scale.asDiagonal() * N;
    const MatrixXd back = N.transpose() * scale.cwiseInverse().asDiagonal();
    const Eigen::Index m = N.cols();
    if (m == 0)
      return bad_use(system.scene,
                     "cannot move at all because of its constraints, so there are no deviations");
    out.state_matrix.setZero(2 * m, 2 * m);
    out.state_matrix.topLeftCorner(m, m) = back * transport(system, state) * out.basis;
    out.state_matrix.topRightCorner(m, m).setIdentity();
    out.state_matrix.bottomLeftCorner(m, m) = back * d->acceleration_by_q * out.basis;
    out.state_matrix.bottomRightCorner(m, m) = back * d->acceleration_by_v * out.basis;
    double largest = 0, growth = 0;
    out.modes = modes_of(out.state_matrix, out.basis, scale, largest, growth);
    const double zero = zero_real_part * largest;
    out.stability = growth > zero    ? Stability::unstable
                    : growth < -zero ? Stability::stable
                                     : Stability::neutral;
    return out;
  });
}

const char* word_for(Stability stability) {
  switch (stability) {
    case Stability::stable:
      return "stable";
    case Stability::neutral:
      return "neutral";
    case Stability::unstable:
      break;
  }
  return "unstable";
}

}  // namespace borelli
