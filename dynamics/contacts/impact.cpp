#include "dynamics/contacts/impact.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <limits>

namespace borelli {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

// Part of the largest initial velocity that counts as zero; the looser one is for friction at its limit.
constexpr double rounding = 1e-13, nearly = 1e-8;
constexpr int most_passes = 200000, most_sweeps = 20000, most_newton = 100;

/// Moves from the impulse without rebound towards the requested one, as far as its work stays at or below
/// zero.
template <class Vector>
Vector without_gain(const Vector& plastic, const Vector& asked, const auto& work) {
  double low = 0, high = 1;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (work(Vector(plastic + middle * (asked - plastic))) <= 0 ? low : high) = middle;
  }
  return plastic + low * (asked - plastic);
}

/// One contact alone; all other impulses stay fixed.
class Pair {
 public:
  Pair(const Matrix3d& response, const Vector3d& velocity, double friction)
      : G_(response), u_(velocity), friction_(std::max(G_(1, 1), G_(2, 2)) > 0 ? friction : 0) {
    if (friction_ == 0) return;
    // a joint may block one tangential direction
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> across(G_.block<2, 2>(1, 1));
    const Vector2d values = across.eigenvalues();
    const Vector2d inverse = (values.array() > 1e-12 * values[1]).select(values.cwiseInverse(), 0);
    across_inverse_ = across.eigenvectors() * inverse.asDiagonal() * across.eigenvectors().transpose();
  }

  /// The impulse after which the normal velocity is `asked`.
  Vector3d to_velocity(double asked) const {
    return with_friction(
        [&](const Vector2d* slip) -> double {
          if (slip) return (asked - u_[0]) / (G_(0, 0) - friction_ * G_.block<1, 2>(0, 1).dot(*slip));
          // no slip afterwards: the normal impulse after eliminating the two tangential ones
          const Eigen::RowVector2d c = G_.block<1, 2>(0, 1) * across_inverse_;
          return (asked - u_[0] + c.dot(u_.tail<2>())) / (G_(0, 0) - c.dot(G_.block<2, 1>(1, 0)));
        },
        asked);
  }

  /// The impulse whose normal part is given.
  Vector3d of_size(double normal) const {
    return with_friction([&](const Vector2d*) { return normal; }, 0);
  }

  double work(const Vector3d& p) const { return p.dot(u_ + 0.5 * G_ * p); }

 private:
  /// `normal_of(slip)`: the normal impulse for slip in that direction; null: no slip.
  Vector3d with_friction(const auto& normal_of, double asked) const {
    if (friction_ == 0) {
      const Vector2d none = Vector2d::Zero();
      double normal = normal_of(&none);
      if (!std::isfinite(normal)) normal = (asked - u_[0]) / G_(0, 0);
      return {normal, 0, 0};
    }
    const auto across = [&](double normal) {
      return Vector2d(-across_inverse_ * (u_.tail<2>() + G_.block<2, 1>(1, 0) * normal));
    };
    double normal = normal_of(nullptr);
    Vector2d t = across(normal);
    const Vector2d left = u_.tail<2>() + G_.block<2, 1>(1, 0) * normal + G_.block<2, 2>(1, 1) * t;
    if (normal >= 0 && t.norm() <= friction_ * normal && left.norm() <= 1e-9 * u_.norm())
      return {normal, t[0], t[1]};
    // It slips afterwards: friction opposes that slip, found by fixed-point iteration.
    Vector2d slip = u_.tail<2>().norm() > 0 ? Vector2d(u_.tail<2>().normalized()) : Vector2d(-t.normalized());
    for (int i = 0; i < 500; ++i) {
      normal = normal_of(&slip);
      t = -friction_ * normal * slip;
      const Vector2d after = u_.tail<2>() + G_.block<2, 1>(1, 0) * normal + G_.block<2, 2>(1, 1) * t;
      if (after.norm() <= rounding * u_.norm()) break;
      const Vector2d next = i < 20 ? Vector2d(after.normalized())
                                   : Vector2d((slip + after.normalized()).normalized());  // damps oscillation
      const double change = (next - slip).norm();
      slip = next;
      if (!(change > 1e-14)) break;
    }
    return {normal, t[0], t[1]};
  }

  Matrix3d G_;
  Vector3d u_;
  double friction_;
  Eigen::Matrix2d across_inverse_;
};

class Resolution {
 public:
  Resolution(const Shock& shock, RestitutionLaw law, double rest_speed)
      : shock_(shock), law_(law), rest_speed_(rest_speed), n_(int(shock.surfaces.size())) {
    out_.impulse = VectorXd::Zero(3 * n_);
    out_.velocity = shock.velocity;
    out_.lost = VectorXd::Zero(n_);
    still_ = rounding * shock.velocity.cwiseAbs().maxCoeff();
  }

  /// One pair of solids after the other, the fastest-approaching first.
  ShockResult one_by_one() {
    for (int pass = 0; pass < most_passes; ++pass) {
      int fastest = 0;
      for (int i = 1; i < n_; ++i)
        // Of two equally fast contacts take the earlier one, whatever the rounding.
        if (out_.velocity[3 * i] < out_.velocity[3 * fastest] - still_) fastest = i;
      if (out_.velocity[3 * fastest] >= -still_) {
        out_.settled = true;
        break;
      }
      if (std::count(shock_.pair.begin(), shock_.pair.end(), shock_.pair[fastest]) == 1)
        strike(fastest);
      else if (!strike_pair(shock_.pair[fastest]))
        break;
    }
    return std::move(out_);
  }

  /// All at once. For each contact, with target u* of its normal velocity: impulse >= 0, u >= u*, and
  /// equality in one of them; friction within Coulomb's cone and opposed to the slip. By projected
  /// Gauss-Seidel (Jean, The non-smooth contact dynamics method, 1999).
  ShockResult all_at_once() {
    const VectorXd none = VectorXd::Zero(n_);
    VectorXd target = none;
    for (int i = 0; i < n_; ++i)
      if (shock_.velocity[3 * i] < -rest_speed_)
        target[i] = -shock_.surfaces[i].restitution * shock_.velocity[3 * i];
    const bool rebounds = target.maxCoeff() > 0;
    VectorXd plastic = VectorXd::Zero(3 * n_);
    if (law_ == RestitutionLaw::poisson || rebounds) out_.settled = sweep(none, none, plastic);
    VectorXd impulse = plastic;
    if (law_ == RestitutionLaw::newton) {
      out_.settled = sweep(target, none, impulse);
    } else if (out_.settled) {
      VectorXd least = none;
      for (int i = 0; i < n_; ++i) {
        const double e = target[i] > 0 ? shock_.surfaces[i].restitution : 0;
        impulse.segment<3>(3 * i) *= 1 + e;
        least[i] = impulse[3 * i];
      }
      out_.settled = sweep(none, least, impulse);
    }
    const auto work = [&](const VectorXd& p) { return p.dot(shock_.velocity + 0.5 * shock_.response * p); };
    if (work(impulse) > 1e-12 * impulse.cwiseAbs().dot(shock_.velocity.cwiseAbs())) {
      impulse = without_gain(plastic, impulse, work);
      out_.energetic = true;
    }
    out_.impulse = impulse;
    out_.velocity = shock_.velocity + shock_.response * impulse;
    for (int i = 0; i < n_; ++i)
      out_.lost[i] = -0.5 * impulse.segment<3>(3 * i).dot(shock_.velocity.segment<3>(3 * i) +
                                                          out_.velocity.segment<3>(3 * i));
    return std::move(out_);
  }

  ShockResult without_rebound() {
    const VectorXd none = VectorXd::Zero(n_);
    out_.settled = sweep(none, none, out_.impulse);
    out_.velocity = shock_.velocity + shock_.response * out_.impulse;
    for (int i = 0; i < n_; ++i)
      if (out_.velocity[3 * i] < 0 && normal_response(i) == 0) out_.jammed = i;
    return std::move(out_);
  }

 private:
  void strike(int i) {
    const Matrix3d G = shock_.response.block<3, 3>(3 * i, 3 * i);
    const Vector3d u = out_.velocity.segment<3>(3 * i);
    const double e = u[0] > -rest_speed_ ? 0 : shock_.surfaces[i].restitution;
    const Pair pair(G, u, shock_.surfaces[i].friction);
    const Vector3d plastic = pair.to_velocity(0);
    Vector3d p = plastic;
    if (e > 0)
      p = law_ == RestitutionLaw::newton ? pair.to_velocity(-e * u[0]) : pair.of_size((1 + e) * plastic[0]);
    if (pair.work(p) > 1e-12 * std::abs(p.dot(u))) {
      p = without_gain(plastic, p, [&](const Vector3d& x) { return pair.work(x); });
      out_.energetic = true;
    }
    out_.lost[i] -= pair.work(p);
    out_.impulse.segment<3>(3 * i) += p;
    out_.velocity += shock_.response.middleCols<3>(3 * i) * p;
  }

  /// All contacts of one pair of solids at once.
  bool strike_pair(int pair) {
    std::vector<int> rows;
    Shock shock;
    for (int i = 0; i < n_; ++i) {
      if (shock_.pair[i] != pair) continue;
      shock.surfaces.push_back(shock_.surfaces[i]);
      for (int c = 0; c < 3; ++c) rows.push_back(3 * i + c);
    }
    shock.response = shock_.response(rows, rows);
    shock.velocity = out_.velocity(rows);
    const ShockResult result = Resolution(shock, law_, rest_speed_).all_at_once();
    out_.energetic = out_.energetic || result.energetic;
    out_.velocity += shock_.response(Eigen::all, rows) * result.impulse;
    out_.impulse(rows) += result.impulse;
    for (std::size_t k = 0; k < rows.size(); k += 3)
      out_.lost[rows[k] / 3] += result.lost[Eigen::Index(k) / 3];
    return result.settled;
  }

  bool slides(int i) const {
    return !shock_.slip.empty() && shock_.slip[i].squaredNorm() > 0 && shock_.surfaces[i].friction > 0;
  }

  /// Contact i's impulse with all others fixed; u and p are its current velocity and impulse.
  Vector3d alone(int i, const Vector3d& u, const Vector3d& p, double target, double least) const {
    const Matrix3d G = shock_.response.block<3, 3>(3 * i, 3 * i);
    const Vector3d without = u - G * p;
    if (least == 0 && without[0] >= target) return Vector3d::Zero();
    const Pair pair(G, without, shock_.surfaces[i].friction);
    const Vector3d next = pair.to_velocity(target);
    return next[0] >= least ? next : pair.of_size(least);
  }

  /// Projected Gauss-Seidel until the impulses settle: each contact's normal impulse, then its friction,
  /// projected onto the cone. If convergence is slow (friction at its limit, very different masses), Newton's
  /// method continues from there. If strong friction makes the sweeps oscillate, each contact's own problem
  /// is solved exactly instead. `least`: lower bounds of the normal impulses. Returns false if not settled.
  bool sweep(const VectorXd& target, const VectorXd& least, VectorXd& p) const {
    const VectorXd start = p;
    // With friction exactly at its limit, sweeps stall at this residual.
    const double enough = std::max(nearly * shock_.velocity.cwiseAbs().maxCoeff(), 1e-2 * rest_speed_);
    const double left = sweep(target, least, p, false);
    if (left <= still_) return true;
    // Newton's method starts from the sweeps' result and from the impulses that stop all contacts.
    VectorXd polished = p, kept = keeping(target);
    double left_by_newton = newton(target, least, polished);
    if (left_by_newton > enough)
      if (const double left_of_kept = newton(target, least, kept); left_of_kept < left_by_newton) {
        polished = kept;
        left_by_newton = left_of_kept;
      }
    if (std::min(left, left_by_newton) <= enough) {
      if (left_by_newton <= left) p = polished;
      return true;
    }
    p = start;
    return sweep(target, least, p, true) <= enough;
  }

  /// Smallest impulses that bring the normal velocities to their targets and stop all slip.
  VectorXd keeping(const VectorXd& target) const {
    VectorXd wanted = -shock_.velocity;
    for (int i = 0; i < n_; ++i) wanted[3 * i] += target[i];
    return shock_.response.completeOrthogonalDecomposition().solve(wanted);
  }

  /// The projection P(p) of p = P(p), with each row's own step size, and its derivative `slope` by the
  /// impulses.
  void project(const VectorXd& target, const VectorXd& least, const VectorXd& p, VectorXd& to,
               MatrixXd& slope) const {
    const VectorXd u = shock_.velocity + shock_.response * p;
    to = p;
    slope.setZero(3 * n_, 3 * n_);
    for (int i = 0; i < n_; ++i) {
      const int row = 3 * i;
      const double friction = shock_.surfaces[i].friction, own = shock_.response(row, row);
      if (own <= 0) continue;
      const double normal = p[row] - (u[row] - target[i]) / own;
      to[row] = std::max(least[i], normal);
      if (normal > least[i]) {
        slope.row(row) = -shock_.response.row(row) / own;
        slope(row, row) += 1;
      }
      const double across = std::max(shock_.response(row + 1, row + 1), shock_.response(row + 2, row + 2));
      if (friction == 0 || across <= 0) continue;
      if (slides(i)) {
        to.segment<2>(row + 1) = -friction * to[row] * shock_.slip[i];
        slope.middleRows<2>(row + 1) = -friction * shock_.slip[i] * slope.row(row);
        continue;
      }
      const Vector2d tangent = p.segment<2>(row + 1) - u.segment<2>(row + 1) / across;
      MatrixXd own_slope = -shock_.response.middleRows<2>(row + 1) / across;
      own_slope(0, row + 1) += 1;
      own_slope(1, row + 2) += 1;
      const double limit = friction * to[row], size = tangent.norm();
      if (size <= limit) {
        to.segment<2>(row + 1) = tangent;
        slope.middleRows<2>(row + 1) = own_slope;
      } else {
        const Vector2d along = tangent / size;
        to.segment<2>(row + 1) = limit * along;
        slope.middleRows<2>(row + 1) = limit / size * (own_slope - along * (along.transpose() * own_slope)) +
                                       friction * along * slope.row(row);
      }
    }
  }

  /// Newton's method on p - P(p) = 0, which is not smooth where contacts change between open, sticking and
  /// sliding (Alart and Curnier, A mixed formulation for frictional contact problems prone to Newton like
  /// solution methods, CMAME 92, 1991). Dependent contacts take the least change. Returns the residual, m/s.
  double newton(const VectorXd& target, const VectorXd& least, VectorXd& p) const {
    VectorXd to, next_to, units(3 * n_);
    MatrixXd slope;
    for (int i = 0; i < 3 * n_; ++i) units[i] = std::max(shock_.response(i, i), 0.);
    project(target, least, p, to, slope);
    const auto off = [&](const VectorXd& a, const VectorXd& b) {
      return (a - b).cwiseProduct(units).cwiseAbs().maxCoeff();
    };
    double size = off(p, to), least_size = size;
    VectorXd nearest = to;
    for (int pass = 0; pass < most_newton && size > still_; ++pass) {
      const MatrixXd jacobian = MatrixXd::Identity(3 * n_, 3 * n_) - slope;
      const VectorXd change = jacobian.completeOrthogonalDecomposition().solve(to - p);
      double share = 1, best = 1, best_size = std::numeric_limits<double>::infinity();
      for (int k = 0; k < 8 && best_size >= size; ++k, share /= 2) {
        const VectorXd next = p + share * change;
        project(target, least, next, next_to, slope);
        if (const double now = off(next, next_to); now < best_size) {
          best_size = now;
          best = share;
        }
      }
      p += best * change;
      project(target, least, p, to, slope);
      size = off(p, to);
      if (size < least_size) {
        least_size = size;
        nearest = to;
      }
    }
    p = nearest;
    return least_size;
  }

  /// Sweeps and returns the velocity change of the last one, m/s. `whole`: solve each contact's own problem
  /// exactly.
  double sweep(const VectorXd& target, const VectorXd& least, VectorXd& p, bool whole) const {
    VectorXd u = shock_.velocity + shock_.response * p;
    const auto move = [&](int row, double to) {
      const double by = to - p[row];
      p[row] = to;
      u += by * shock_.response.col(row);
      return std::abs(by) * shock_.response(row, row);
    };
    double change = 0;
    for (int pass = 0; pass < most_sweeps; ++pass) {
      change = 0;
      for (int i = 0; i < n_; ++i) {
        const int row = 3 * i;
        const double friction = shock_.surfaces[i].friction;
        const double across = std::max(shock_.response(row + 1, row + 1), shock_.response(row + 2, row + 2));
        const bool rubs = friction > 0 && across > 0;
        if (whole && rubs && !slides(i)) {
          const Vector3d next = alone(i, u.segment<3>(row), p.segment<3>(row), target[i], least[i]);
          for (int c = 0; c < 3; ++c) change = std::max(change, move(row + c, next[c]));
          continue;
        }
        const double own = normal_response(i);
        if (own <= 0) continue;  // jammed
        change = std::max(change, move(row, std::max(least[i], p[row] - (u[row] - target[i]) / own)));
        if (!rubs) continue;
        Vector2d t = p.segment<2>(row + 1) - u.segment<2>(row + 1) / across;
        if (slides(i))
          t = -friction * p[row] * shock_.slip[i];
        else
          t = on_friction_cone(t, friction * p[row]);
        change = std::max({change, move(row + 1, t[0]), move(row + 2, t[1])});
      }
      if (change <= still_) break;
    }
    return change;
  }

  /// Normal velocity per unit normal impulse, with the friction of a contact that slides already; 0: jammed.
  double normal_response(int i) const {
    const double G = shock_.response(3 * i, 3 * i);
    if (!slides(i)) return G;
    const double with =
        G - shock_.surfaces[i].friction * shock_.response.block<1, 2>(3 * i, 3 * i + 1).dot(shock_.slip[i]);
    return with > 1e-12 * G ? with : 0;
  }

  const Shock& shock_;
  RestitutionLaw law_;
  double rest_speed_;  ///< m/s; 0 when the velocities are accelerations
  int n_;
  double still_;  ///< velocity that counts as zero, m/s
  ShockResult out_;
};

}  // namespace

ShockResult press(const Shock& shock) {
  return Resolution(shock, RestitutionLaw::newton, 0).without_rebound();
}

ShockResult resolve(const Shock& shock, ImpactLaw law, RestitutionLaw restitution, double rest_speed) {
  Resolution resolution(shock, restitution, rest_speed);
  return law == ImpactLaw::sequential ? resolution.one_by_one() : resolution.all_at_once();
}

}  // namespace borelli
