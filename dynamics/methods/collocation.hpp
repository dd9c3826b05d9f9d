// Gauss collocation at eight nodes, order 16, with steps as long as the tolerance allows. Fixed-point
// iteration finds the slopes at the nodes; it starts from an extrapolation of the previous step. A step takes
// about five rounds of eight slopes, and the slopes of a round are independent of each other (Everhart 1985,
// An efficient integrator that uses Gauss-Radau spacings; Rein and Spiegel, MNRAS 446, 2015). Positions
// follow from the velocities of the same round. If the flow evaluates several states side by side
// (Flow::has_lanes), a round costs little more than one slope. Otherwise the first half of the nodes predicts
// the second half in the first round.
//
// The method is for smooth motions. Stiff ones force short steps, as with explicit methods: in longer steps
// the iteration does not converge.
#pragma once

#include "dynamics/methods/integrator.hpp"

namespace borelli {

class Collocation : public Integrator {
 public:
  explicit Collocation(double tolerance) : tolerance_(tolerance) {}
  int order() const override { return 2 * nodes; }
  bool adaptive() const override { return true; }
  Attempt attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                  Eigen::VectorXd& out) override;
  int dense_order() const override { return nodes; }
  /// The collocation polynomial of the step. It is less accurate than the end of the step.
  bool prepare_dense(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                     const Eigen::VectorXd& out) override;
  void interpolate(double theta, Eigen::VectorXd& y) const override;
  /// Starts the iteration from the slopes of the last attempted step.
  bool shortened(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                 Eigen::VectorXd& out) override;
  bool keep(Keeper& k) override;
  void reset() override;

  static constexpr int nodes = Lanes::count;

 private:
  enum class Outcome { solved, hopeless, unsettled, not_evaluated };
  enum class Known { nothing, this_step, step_before };

  /// Error estimate of a step, taken from its slopes; the component with the largest error decides.
  struct Judgement {
    double error = 0;        ///< in units of the tolerance
    double fall = 0;         ///< ratio of one Legendre coefficient of the slopes to the previous one
    double coefficient = 0;  ///< last Legendre coefficient times h, relative to the error scale
    int worst = -1;          ///< index of that component; -1: no component has a significant error
  };

  Outcome solve(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                bool judged, Eigen::VectorXd& out);
  bool solve_in_parts(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                      int divisions, Eigen::VectorXd& out);
  void guess(const Flow& flow, double h, const Eigen::VectorXd& dy);
  double place(Flow& flow, double h, const Eigen::VectorXd& y);
  bool evaluate(Flow& flow, double t, double h, int from, int to);
  bool evaluate(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                bool predict);
  Judgement judge(const Flow& flow, double h);
  bool leaps_at_an_end(const Flow& flow, double h, const Eigen::VectorXd& dy) const;

  double tolerance_;
  /// State of the last attempted step.
  struct Last {
    Known known = Known::nothing;  ///< which step slopes_ belong to, relative to the next one
    double step = 0;               ///< s
    double rate = 1;  ///< contraction rate of the iteration: change of a round over that of the previous one
    double fall = 1;  ///< last Judgement::fall that was found
  } last_;
  int rounds_ = 0;
  bool rejected_ = false;
  Eigen::VectorX<Lanes> slopes_, stages_;  ///< per component, one node per lane
  Eigen::VectorX<Lanes> kept_;
  /// Coefficients of the Legendre polynomials in slopes_, per component, from the last judge().
  Eigen::VectorX<Lanes> coefficients_;
  /// State and slope at a single node; slope_ also holds the slope at the step's end.
  Eigen::VectorXd stage_, slope_;
  Eigen::VectorXd start_;  ///< state at the step's start, for dense output
};

}  // namespace borelli
