// Gauss collocation methods (Butcher 1964, Kuntzmann 1961): the implicit midpoint rule (one stage, order 2)
// and those of two and three stages (orders 4 and 6). Fixed steps. A-stable, so stiff springs do not make
// them unstable; symmetric in the local coordinates of the step. In (q, v) they are not symplectic if the
// mass matrix depends on q, but they keep energy over long runs. Hairer, Wanner, Solving ODEs II, sections
// IV.5 and IV.8.
#pragma once

#include <Eigen/LU>

#include "dynamics/methods/integrator.hpp"

namespace borelli {

/// Fixed-point iteration solves the stage equations. If it is slow or fails (stiffness), a simplified Newton
/// method takes over; it reuses its Jacobian (by differences) for as many steps as it converges. If Newton
/// fails too, the step fails with a message.
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
  double factored_step_ = 0;                     ///< the step that factors_ belongs to; 0: none
  std::vector<Eigen::VectorXd> moves_, slopes_;  ///< per stage: its displacement from y; its slope
  Eigen::MatrixXd jacobian_, matrix_;
  Eigen::PartialPivLU<Eigen::MatrixXd> factors_;
  Eigen::VectorXd stage_, residual_, changed_;
};

}  // namespace borelli
