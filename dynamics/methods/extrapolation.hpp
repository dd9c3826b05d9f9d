// Extrapolation of Gragg, Bulirsch and Stoer: the explicit midpoint rule makes the step with 2, 4, 6, ...
// substeps. Its error has an expansion in even powers of the substep, so the results are extrapolated to a
// substep of zero. Order and step are chosen together for the least work per unit of time (Hairer, Norsett,
// Wanner, Solving Ordinary Differential Equations I, second edition, section II.9). The midpoint rule does
// not use the slope at the step's end, so it would miss a jump of the slope within the first or last substep.
// Accepted steps are therefore tested for such a jump.
//
// The rows of the table are independent. If the flow evaluates several states side by side (Flow::has_lanes),
// each lane makes some of the rows: a step takes as long as its longest row, and the work grows linearly with
// the number of rows, not quadratically (parallel rows: Rauber and Ruenger, Parallel Computing 23, 1997).
#pragma once

#include "dynamics/methods/integrator.hpp"

namespace borelli {

class Extrapolation : public Integrator {
 public:
  explicit Extrapolation(double tolerance);
  /// Fixed order 2 * rows, rows >= 2; only the step follows the error.
  Extrapolation(double tolerance, int rows);
  /// Order of the target row. It changes from step to step; without a fixed order it is at least 6.
  int order() const override { return 2 * target_; }
  bool adaptive() const override { return true; }
  Attempt attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                  Eigen::VectorXd& out) override;
  /// Uses as many rows as the last attempted step.
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

  /// Distribution of the rows over the lanes.
  struct Shares {
    int first[Quad::count] = {};       ///< the first row of each lane; 0: none
    int follower[most_rows + 1] = {};  ///< per row: the next row in the same lane; 0: none
    int slopes = 0;                    ///< number of slopes in the lane with the most
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
  int fixed_rows_ = 0;         ///< fixed number of rows; 0: the order is chosen
  bool side_by_side_ = false;  ///< the rows of a step are made in lanes
  int target_;                 ///< the row that is expected to meet the tolerance; rows count from 1
  bool rejected_ = false;
  int rows_made_ = 0;                   ///< number of rows of the last attempted step
  std::vector<Eigen::VectorXd> table_;  ///< last row of the table, column by column
  /// Per row, from 1: work in evaluations; step that would meet the target error, s; error in tolerances.
  std::vector<double> work_, step_, error_;
  /// Per row: bounds of the step's change, least_factor_ / 4 to 1 / least_factor_.
  std::vector<double> least_factor_;
  int worst_ = -1;
  Eigen::VectorXd before_, now_, slope_, next_;
  Eigen::VectorXd slope_before_, slope_before_that_;  ///< the slopes one and two substeps before slope_
  /// Second differences of the slope over the substeps of the last row: the first one, and the largest of the
  /// others.
  Eigen::VectorXd first_bend_, bend_;
  Eigen::VectorXd change_;  ///< largest first difference of the slope, except the first one

  Eigen::VectorX<Quad> before_lanes_, now_lanes_, slope_lanes_;
  std::vector<Eigen::VectorXd> ends_;  ///< per row made in lanes: its result
};

}  // namespace borelli
