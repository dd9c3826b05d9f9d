// Detects singular positions of the constraints (a flattened four-bar linkage, a parallelogram with all bars
// in line). Rows that are independent elsewhere become dependent there, and branches of motion cross. A
// motion that stays on its branch keeps its velocity; one that switches branch does not.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynamics/constraints/assembly.hpp"
#include "dynamics/system/certificate.hpp"

namespace borelli {

class SingularWatch {
 public:
  explicit SingularWatch(const System& system);

  /// Reason to distrust the run; empty: none.
  using Reason = std::optional<std::string>;

  /// Observes a state whose equations are solved in `w` with the rank decided. Detects rows that become
  /// dependent. When they are independent again, checks that the velocities of each affected group are still
  /// along their old line, in the kinetic metric. Logs changes of the rank.
  Reason observe(const State& state, const Workspace& w, std::vector<LoggedEvent>& log);
  /// Observes how a projection changed the velocities: the energy of the change in each group against the
  /// group's kinetic energy in `w`. A step that stays on its branch changes them by its own error, a step
  /// that switches branch by a finite fraction.
  Reason observe_projection(double t, const Projection& projection, const Workspace& w);

  /// An event changed the velocities or the active rows; a passage in progress ends.
  void pass_event() { inside_ = false; }

  int passages() const { return passages_; }
  double first_passage() const { return first_time_; }  ///< s
  int first_rank() const { return first_rank_; }        ///< rank of the rows in the first passage
  /// rad, largest turn of the velocity's line over a passage
  double largest_turn() const { return largest_turn_; }
  double nearness() const { return nearness_; }  ///< minimum of ConstraintSolver::nearness
  double nearness_time() const { return nearness_time_; }

  template <class Keeper>
  void keep(Keeper& k) {
    k.within(entry_row_, -1, system_.rows - 1);
    k(inside_, entry_time_, tied_, v_, fastest_, passages_, first_rank_, first_time_, largest_turn_,
      nearness_, nearness_time_);
  }

  /// Limits beyond which the motion jumped: turn of the velocity's line, rad; fraction of the velocity that a
  /// projection changed.
  static constexpr double turn_limit = 0.3, jump_limit = 0.1;

 private:
  double turn(const Eigen::VectorXd& v, const Workspace& w);

  const System& system_;
  bool inside_ = false;
  double entry_time_ = 0;
  int entry_row_ = -1;            ///< the first row that became dependent in the passage
  std::vector<char> tied_;        ///< per group: it has rows that became dependent
  Eigen::VectorXd v_;             ///< velocities at the last regular state
  Eigen::VectorXd fastest_;       ///< largest kinetic energy of each group so far, J
  Eigen::VectorXd now_, before_;  ///< scratch
  int passages_ = 0, first_rank_ = 0;
  double first_time_ = 0, largest_turn_ = 0, nearness_ = 1, nearness_time_ = 0;
};

}  // namespace borelli
