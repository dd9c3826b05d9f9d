// Gauss' collocation methods (Butcher 1964, Kuntzmann 1961): the implicit midpoint rule (one stage, order 2),
// and those of two and three stages (orders 4 and 6). Fixed steps; A-stable, so that stiff springs do not
// blow them up; symmetric in the local coordinates of the step. In (q, v) they are not symplectic where the
// mass matrix depends on q, but keep energy for long. Hairer, Wanner, Solving ODEs II, sections IV.5 and
// IV.8.
#pragma once

#include <Eigen/LU>

#include "dynamics/methods/integrator.hpp"

namespace borelli {

/// The stages' equations are solved by iterating them as they stand; where that is slow or fails (stiffness),
/// by Newton's method with one matrix of derivatives (by differences) for as many steps as it serves. Where
/// that does not settle either, the step fails and says so.
class GaussLegendre : public Integrator {
 public:
  explicit GaussLegendre(int stages);  // 1, 2 or 3
  int order() const override { return 2 * stages_; }
  bool adaptive() const override { return false; }
  Attempt attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                  Eigen::VectorXd& out) override;
  bool keep(Keeper& k) override {
    k(newton_, factored_step_, matrix_);
    if (factored_step_ != 0) factors_.compute(matrix_);
    return true;
  }
  void reset() override { newton_ = false, factored_step_ = 0; }

 private:
  enum class Outcome { solved, not_solved, not_evaluated };
  Outcome iterate(Flow& flow, double t, double h, const Eigen::VectorXd& y);
  Outcome solve_by_newton(Flow& flow, double t, double h, const Eigen::VectorXd& y,
                          const Eigen::VectorXd& dy);
  bool factor(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy);
  bool evaluate(Flow& flow, double t, double h, const Eigen::VectorXd& y);
  void start_from(double h, const Eigen::VectorXd& dy);

  int stages_;
  Eigen::VectorXd nodes_, weights_;
  Eigen::MatrixXd coupling_;
  bool newton_ = false;
  double factored_step_ = 0;                     ///< the step that factors_ is for; 0: none
  std::vector<Eigen::VectorXd> moves_, slopes_;  ///< per stage: from y to it; the slope there
  Eigen::MatrixXd jacobian_, matrix_;
  Eigen::PartialPivLU<Eigen::MatrixXd> factors_;
  Eigen::VectorXd stage_, residual_, changed_;
};

}  // namespace borelli
