// Extrapolation after Gragg, Bulirsch and Stoer: the step is made by the explicit midpoint rule with 2, 4, 6,
// ... substeps, whose results, having an error in even powers of the substep, are extrapolated to none. Order
// and step are chosen together for the least work per unit of time (Hairer, Norsett, Wanner, Solving Ordinary
// Differential Equations I, second edition, section II.9). The rows weigh neither end of the step, so an
// accepted one is looked at there: a slope that leaps within the first or last substep would go unseen.
//
// No row waits for another. Where a flow has slopes of several states side by side (Flow::has_lanes), a row
// is a lane: a step takes as long as its longest row, and its work grows with the number of rows, not with
// its square (the rows in parallel: Rauber and Ruenger, Parallel Computing 23, 1997).
#pragma once

#include "dynamics/methods/integrator.hpp"

namespace borelli {

class Extrapolation : public Integrator {
 public:
  explicit Extrapolation(double tolerance);
  /// Of one order: 2 * rows, rows from 2; the step alone follows the error.
  Extrapolation(double tolerance, int rows);
  /// Of the row that it aims at; it changes from step to step, and is never below 6, where it is not fixed.
  int order() const override { return 2 * target_; }
  bool adaptive() const override { return true; }
  Attempt attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                  Eigen::VectorXd& out) override;
  /// With as many rows as the step last attempted took.
  bool shortened(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                 Eigen::VectorXd& out) override;
  bool keep(Keeper& k) override {
    k.within(target_, 1, most_rows);
    k.within(rows_made_, 0, most_rows);
    k(rejected_, step_, error_);
    return true;
  }
  void reset() override;

 private:
  static constexpr int least_target = 3, most_rows = 10, most_target = most_rows - 2;
  static constexpr int substeps(int row) { return 2 * row; }

  /// Which rows each lane makes.
  struct Shares {
    int first[Quad::count] = {};       ///< of each lane; 0: none
    int follower[most_rows + 1] = {};  ///< per row: which one follows it in its lane; 0: none
    int slopes = 0;                    ///< that the lane which has most of them asks for
  };
  static Shares share(int rows);

  void work_side_by_side(bool side_by_side);
  bool make_row(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy, int row);
  bool make_rows(Flow& flow, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy, int rows);
  void note_bend(int i);
  bool extrapolate(const Eigen::VectorXd& scale, double h, int row);
  void choose_after(int row, Attempt& attempt, double h);
  bool leaps_or_rattles(const Eigen::VectorXd& scale, double substep) const;

  double tolerance_;
  int fixed_rows_ = 0;         ///< of a method of one order; 0: it is chosen
  bool side_by_side_ = false;  ///< the rows of a step are made at once
  int target_;                 ///< the row that is expected to meet the tolerance, from 1
  bool rejected_ = false;
  int rows_made_ = 0;                   ///< by the step last attempted
  std::vector<Eigen::VectorXd> table_;  ///< the table's last row, column by column
  /// Per row, from 1: in evaluations; step that would do, s; error.
  std::vector<double> work_, step_, error_;
  /// Per row: a step shrinks to a quarter of it at most, and grows by its inverse.
  std::vector<double> least_factor_;
  int worst_ = -1;
  Eigen::VectorXd before_, now_, slope_, next_;
  Eigen::VectorXd slope_before_, slope_before_that_;  ///< one and two substeps before slope_
  /// The slope's second differences over the last row's substeps: the first, and the largest of the others.
  Eigen::VectorXd first_bend_, bend_;
  Eigen::VectorXd change_;  ///< the largest first difference after the first

  Eigen::VectorX<Quad> before_lanes_, now_lanes_, slope_lanes_;
  std::vector<Eigen::VectorXd> ends_;  ///< per row made at once: what it has come to
};

}  // namespace borelli
