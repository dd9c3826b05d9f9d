// The generalized-alpha method (Chung and Hulbert, Journal of Applied Mechanics 60, 1993): fixed implicit
// steps of order 2. One number sets the numerical damping of stiff modes: the spectral radius at infinite
// stiffness. Constraints kept by projection are met at position level within the step (index 3); orientations
// use the rotation vector of the step. Arnold and Bruels, Convergence of the generalized-alpha scheme for
// constrained mechanical systems, Multibody System Dynamics 18, 2007; Bruels, Cardona and Arnold, Lie group
// generalized-alpha time integration of constrained flexible multibody systems, Mechanism and Machine Theory
// 48, 2012.
#pragma once

#include <Eigen/LU>

#include "dynamics/methods/integrator.hpp"
#include "dynamics/numbers/scalar.hpp"

namespace borelli {

/// A step from (x0, v0), with the accelerations w of the equations of motion and the method's own a:
///   x1 = x0 + h v0 + h^2 ((1/2 - beta) a0 + beta a1),  v1 = v0 + h ((1 - gamma) a0 + gamma a1),
///   (1 - am) a1 + am a0 = (1 - af) w1 + af w0,
///   am = (2 r - 1) / (r + 1), af = r / (r + 1), gamma = 1/2 - am + af, beta = (gamma + 1/2)^2 / 4,
/// r the spectral radius; x in the local coordinates centred at the step's start. w1 solves the equations of
/// motion at the step's end, with the constraint forces that put x1 on the constraints.
class GeneralizedAlpha : public Integrator {
 public:
  explicit GeneralizedAlpha(double spectral_radius);  // 0 to 1
  int order() const override { return 2; }
  bool adaptive() const override { return false; }
  const char* objection(const System& system, ConstraintTreatment treatment) const override;
  Attempt attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                  Eigen::VectorXd& out) override;
  bool keep(Keeper& k) override {
    k(known_, a0_, w0_, made_, a1_, w1_, end_, start_, newton_, factored_step_, matrix_);
    if (factored_step_ != 0) factors_.compute(matrix_);
    return true;
  }
  void reset() override { known_ = made_ = newton_ = false, factored_step_ = 0; }

 private:
  enum class Outcome { solved, not_solved, not_evaluated };
  void take_up(double t, double h, const Eigen::VectorXd& dy);
  Outcome iterate(Flow& flow, double t, double h, const Eigen::VectorXd& y, Eigen::VectorXd& out);
  bool factor(Flow& flow, double t, double h, const Eigen::VectorXd& out);
  void place(double h, const Eigen::VectorXd& y, Eigen::VectorXd& out) const;
  int collect_rows(const MotionFlow& motion, double h);
  void hold_rows(int count);

  double mass_share_, force_share_, gamma_, beta_;  ///< am, af, gamma, beta
  double gain_;                                     ///< change of a per change of w: (1 - af) / (1 - am)
  Eigen::Index n_ = 0;
  bool known_ = false;                 ///< a0_ and w0_ are set
  Eigen::VectorXd a0_, w0_, a1_, w1_;  ///< n
  bool made_ = false;                  ///< a1_ and w1_ belong to a finished step
  double end_ = 0, start_ = 0;         ///< s: end of that step; start of the current one
  bool newton_ = false;                ///< Newton replaces the fixed-point iteration
  double factored_step_ = 0;           ///< the step that factors_ belongs to; 0: none
  Eigen::MatrixXd jacobian_, matrix_;  ///< slopes by (x, v), 2n x 2n; Newton's matrix, n x n
  Eigen::PartialPivLU<Eigen::MatrixXd> factors_;
  Eigen::VectorXd slope_, residual_, change_, moved_, moved_slope_;
  // Independent constraint rows: L, (A^-1 L^T)^T, the same through Newton's matrix, their Gram matrix; the
  // change of L a1 that is needed.
  RowsOf<double> rows_, response_, through_, gram_;
  Eigen::VectorXd wanted_, column_;
};

}  // namespace borelli
