// Fixed-step methods that treat positions and velocities separately, for long runs of scenes that conserve
// energy: the energy error stays bounded, while that of Runge-Kutta methods drifts.
//
// Both work on (q, v) with accelerations a(q, v), not on momenta. If the mass matrix A is constant and forces
// depend on positions alone, they are the symplectic Euler and the Stoermer-Verlet method. If A depends on q,
// they are not symplectic, but Verlet's variant is time-reversible (Hairer, Lubich, Wanner, Geometric
// Numerical Integration, second edition, sections I.1 and V.1).
#pragma once

#include "dynamics/methods/integrator.hpp"

namespace borelli {

/// v1 = v0 + h a(q0, v0), then q1 from q0 with v1. First order.
class SemiImplicitEuler : public Integrator {
 public:
  int order() const override { return 1; }
  bool adaptive() const override { return false; }
  Attempt attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                  Eigen::VectorXd& out) override;

 private:
  Eigen::VectorXd slope_, at_start_;
};

/// Velocity Verlet with an implicit half step of the velocity, because accelerations depend on velocity:
///   v' = v0 + h/2 a(t0, q0, v'),  q1 from q0 with v',  v1 = v' + h/2 a(t1, q1, v').
/// The step with -h is its inverse, so it is reversible and of order 2; a ball turns by exp(h v') and back by
/// exp(-h v'). Work is integrated by the same half steps.
class VelocityVerlet : public Integrator {
 public:
  int order() const override { return 2; }
  bool adaptive() const override { return false; }
  Attempt attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                  Eigen::VectorXd& out) override;

 private:
  Eigen::VectorXd half_, first_, slope_, at_start_;
};

}  // namespace borelli
