// Collocation at Gauss' eight nodes, of order 16, with steps as long as the tolerance allows. The slopes at
// the nodes are iterated as they stand, from what the step before foretells: a step takes some five rounds of
// eight slopes, of which none waits for another (Everhart 1985, An efficient integrator that uses Gauss-Radau
// spacings; Rein and Spiegel, MNRAS 446, 2015). Positions follow from the velocities of the same round. Where
// a flow has slopes of several states side by side (Flow::has_lanes), a round takes hardly longer than one of
// them; one by one, the first half of the nodes foretell the others.
//
// For smooth motions. Stiff ones make the steps short, as they do those of explicit methods: in longer ones
// the rounds would not settle.
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
  /// The polynomial that the step's slopes make: coarser than the step's end.
  bool prepare_dense(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                     const Eigen::VectorXd& out) override;
  void interpolate(double theta, Eigen::VectorXd& y) const override;
  /// Begun with the slopes of the step last attempted.
  bool shortened(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                 Eigen::VectorXd& out) override;
  bool keep(Keeper& k) override;
  void reset() override;

  static constexpr int nodes = Lanes::count;

 private:
  enum class Outcome { solved, hopeless, unsettled, not_evaluated };
  enum class Known { nothing, this_step, step_before };

  /// Of a step by its slopes; the component with the largest error tells.
  struct Judgement {
    double error = 0;        ///< in tolerances
    double fall = 0;         ///< from one coefficient of its slopes, by Legendre, to the next
    double coefficient = 0;  ///< the last of these, as a move over the step, on the scale
    int worst = -1;          ///< which component; -1: none has an error to speak of
  };

  Outcome solve(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                bool judged, Eigen::VectorXd& out);
  bool solve_in_parts(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                      int divisions, Eigen::VectorXd& out);
  void guess(const Flow& flow, double h, const Eigen::VectorXd& dy);
  double place(Flow& flow, double h, const Eigen::VectorXd& y);
  bool evaluate(Flow& flow, double t, double h, int from, int to);
  bool evaluate(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                bool foretell);
  Judgement judge(const Flow& flow, double h);
  bool leaps_at_an_end(const Flow& flow, double h, const Eigen::VectorXd& dy) const;

  double tolerance_;
  /// Of the step last attempted.
  struct Last {
    Known known = Known::nothing;  ///< whose slopes slopes_ are, as seen from the step to come
    double step = 0;               ///< s
    double rate = 1;               ///< so much of a change was left after one more round
    double fall = 1;               ///< Judgement::fall, where there was one
  } last_;
  int rounds_ = 0;
  bool rejected_ = false;
  Eigen::VectorX<Lanes> slopes_, stages_;  ///< at the nodes, per component
  Eigen::VectorX<Lanes> kept_;
  Eigen::VectorX<Lanes>
      coefficients_;               ///< of Legendre's polynomials in slopes_, as last judged, per component
  Eigen::VectorXd stage_, slope_;  ///< of a node by itself; the slope at the end
  Eigen::VectorXd start_;          ///< of the step that dense output is for
};

}  // namespace borelli
