// The recursive equations and the paper's scan, two independent sets of formulas, at one state.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <string>
#include <vector>

#include "dynamics/equations/equations.hpp"
#include "dynamics/equations/inverse_dynamics.hpp"
#include "dynamics/equations/recursive.hpp"

namespace borelli::test::recursive_test {

/// The largest difference relative to the largest entry.
inline double relative(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  if (b.size() == 0) return 0;
  return (a - b).cwiseAbs().maxCoeff() / std::max(1e-3, b.cwiseAbs().maxCoeff());
}

inline double condition(const Eigen::MatrixXd& A) {
  const Eigen::VectorXd s = A.jacobiSvd().singularValues();
  return s[0] / s[s.size() - 1];
}

struct Pair {
  Workspace lagrange, recursive;
  explicit Pair(const System& system)
      : lagrange(system, Equations::lagrange), recursive(system, Equations::recursive) {}
};

inline Eigen::VectorXd efforts_for(const System& system, const Parameters& p, const State& state,
                                   const Eigen::VectorXd& a, Workspace& w) {
  Eigen::VectorXd out(system.nv);
  inverse_dynamics(system, p, p.inertials, state.t, state.q.data(), state.v.data(), a.data(), w.kinematics,
                   w.efforts, w.articulation, out.data());
  return out;
}

/// Compares all that the two sets of formulas give at one state.
struct EquationsCompared {
  const System& system;
  const Parameters& p;
  const State& state;
  const std::string& which;  ///< names the comparison where it fails
  Pair w{system};
  Rows A{};

  void compare() {
    const Fault fault = update_terms(system, p, state.t, state.q.data(), state.v.data(), w.lagrange);
    const Fault same = update_terms(system, p, state.t, state.q.data(), state.v.data(), w.recursive);
    A = w.lagrange.terms.A.selfadjointView<Eigen::Lower>();
    const double conditioned = condition(A.topLeftCorner(system.nv, system.nv));
    if (fault || same || conditioned > 1e10) {
      // a coordinate depends on others, exactly or up to rounding
      EXPECT_GT(conditioned, 1e10) << which;
      EXPECT_TRUE(!fault || fault.kind == Fault::Kind::singular_mass) << which;
      const Fault again = accelerate(system, p, state.t, state.q.data(), state.v.data(), {}, w.recursive);
      EXPECT_EQ(again.index, same.index) << which;
      return;
    }
    compare_terms();
    compare_inverse_dynamics();
    ASSERT_NO_FATAL_FAILURE(compare_accelerations());
    compare_completed_terms();
  }

  void compare_terms() {
    const LagrangeTerms &l = w.lagrange.terms, &r = w.recursive.terms;
    // sums of about a hundred terms: 1e-14 each of the largest
    EXPECT_LT(relative(r.A.selfadjointView<Eigen::Lower>(), A), 1e-12) << which;
    EXPECT_LT(relative(r.B, l.B), 1e-12) << which;
    EXPECT_LT(relative(r.Q, l.Q), 1e-12) << which;
    EXPECT_NEAR(r.kinetic, l.kinetic, 1e-12 * l.kinetic) << which;
    EXPECT_NEAR(r.potential, l.potential, 1e-12 * (1 + std::abs(l.potential))) << which;
    EXPECT_LT(relative(r.group_kinetic, l.group_kinetic), 1e-12) << which;
    EXPECT_LT(relative(r.group_potential, l.group_potential), 1e-12) << which;
    EXPECT_LT(relative(w.recursive.rows.L, w.lagrange.rows.L), 1e-12) << which;
    EXPECT_LT(relative(w.recursive.rows.E, w.lagrange.rows.E), 1e-12) << which;
    for (std::size_t b = 1; b < system.bodies.size(); ++b) {
      if (!system.bodies[b].touched) continue;
      const BodyMotion &ml = w.lagrange.kinematics.bodies[b], &mr = w.recursive.kinematics.bodies[b];
      EXPECT_LT(relative(mr.v, ml.v) + relative(mr.vdot, ml.vdot) + relative(mr.wdot, ml.wdot), 3e-12)
          << which;
    }
  }

  void compare_inverse_dynamics() {
    const LagrangeTerms& l = w.lagrange.terms;
    const int free = system.nv;
    const Eigen::VectorXd wanted = Eigen::VectorXd::LinSpaced(free, 2, -1);
    const Eigen::VectorXd moved = A.topLeftCorner(free, free) * wanted;
    EXPECT_LT((efforts_for(system, p, state, wanted, w.recursive) - (moved + (l.B - l.Q).head(free)))
                  .cwiseAbs()
                  .maxCoeff(),
              1e-12 * (moved.cwiseAbs().maxCoeff() + l.B.cwiseAbs().maxCoeff() + l.Q.cwiseAbs().maxCoeff()))
        << which;
  }

  void compare_accelerations() {
    const LagrangeTerms& l = w.lagrange.terms;
    // rounding of the terms (about 10 units) times the conditions of A and of the rows
    const int n = system.nv;
    double amplified = condition(A.topLeftCorner(n, n));
    if (system.rows > 0) amplified *= condition(w.lagrange.rows.L.leftCols(n));
    const double bound = 10 * 2.3e-16 * amplified;
    const Eigen::VectorXd efforts = Eigen::VectorXd::LinSpaced(system.nv, -1, 2);
    for (const double* given : {efforts.data(), static_cast<const double*>(nullptr)}) {
      ASSERT_FALSE(accelerate(system, p, state.t, state.q.data(), state.v.data(), {}, w.lagrange, given));
      ASSERT_FALSE(accelerate(system, p, state.t, state.q.data(), state.v.data(), {}, w.recursive, given));
      EXPECT_LT(relative(w.recursive.a, w.lagrange.a), bound) << which;
      EXPECT_LT(relative(w.recursive.multipliers, w.lagrange.multipliers), bound) << which;
      EXPECT_NEAR(w.recursive.power.total(), w.lagrange.power.total(),
                  bound * (1 + std::abs(w.lagrange.power.total())))
          << which;
      // the equations hold to rounding of their largest term, however badly conditioned A is
      const Eigen::VectorXd residual = A.topLeftCorner(n, n) * w.recursive.a + l.B.head(n) - l.Q.head(n) -
                                       w.lagrange.rows.L.leftCols(n).transpose() * w.recursive.multipliers;
      const double part = A.cwiseAbs().maxCoeff() * w.recursive.a.cwiseAbs().maxCoeff() +
                          l.B.cwiseAbs().maxCoeff() + l.Q.cwiseAbs().maxCoeff() +
                          (system.rows ? w.lagrange.rows.L.cwiseAbs().maxCoeff() *
                                             w.recursive.multipliers.cwiseAbs().maxCoeff()
                                       : 0);
      EXPECT_LT(residual.cwiseAbs().maxCoeff(), 1e-12 * part) << which;
      if (system.driven_nv > 0) {  // these are sums of such terms, which may nearly cancel
        EXPECT_LT((w.recursive.drive_efforts - w.lagrange.drive_efforts).cwiseAbs().maxCoeff(), bound * part)
            << which;
      }
    }
  }

  /// Terms that a step leaves out are the same when computed afterwards.
  void compare_completed_terms() {
    const LagrangeTerms all = w.recursive.terms;
    const std::vector<BodyMotion> bodies = w.recursive.kinematics.bodies;
    Workspace later(system, Equations::recursive);
    ASSERT_FALSE(accelerate(system, p, state.t, state.q.data(), state.v.data(), {}, later, nullptr,
                            Wanted::accelerations));
    EXPECT_EQ(relative(later.a, w.recursive.a), 0) << which;
    complete(system, p, later);
    EXPECT_EQ(later.terms.kinetic, all.kinetic) << which;
    EXPECT_EQ(relative(later.terms.group_potential, all.group_potential), 0) << which;
    for (std::size_t b = 1; b < bodies.size(); ++b) {
      if (!system.bodies[b].touched) continue;
      EXPECT_TRUE(later.kinematics.bodies[b].g == bodies[b].g && later.kinematics.bodies[b].v == bodies[b].v)
          << which;
    }
  }
};

inline void compare(const System& system, const Parameters& p, const State& state, const std::string& which) {
  EquationsCompared{system, p, state, which}.compare();
}

inline void compare(const System& system, const State& state, const std::string& which) {
  compare(system, system.parameters, state, which);
}

}  // namespace borelli::test::recursive_test
