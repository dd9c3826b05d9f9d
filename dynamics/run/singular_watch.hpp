// Watches a run for singular positions of its constraints (a four-bar flattened, a parallelogram with all
// bars in line): rows that are independent elsewhere become dependent there, and branches of motion cross. A
// motion that goes on along its branch keeps its velocity; one that came out on another branch does not.
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

  /// Why the run is no longer to be trusted.
  using Reason = std::optional<std::string>;

  /// Looks at a state whose equations are solved in `w` with the rank decided: whether rows have become
  /// dependent that were not, and where they are independent again, whether the velocities of what they tie
  /// (each independent group by its kinetic metric) still go along the line that they came on.
  /// Changes of the rank go to the log.
  Reason observe(const State& state, const Workspace& w, std::vector<LoggedEvent>& log);
  /// Looks at what putting a state on the constraints did to its velocities: the energy of the change in each
  /// group against the group's kinetic energy in `w`. A step that kept to its branch changes them by its
  /// own error; one that came out on another branch by a finite part.
  Reason observe_projection(double t, const Projection& projection, const Workspace& w);

  /// The velocities, or which rows hold, have changed in an event: a passage that it fell into ends there.
  void pass_event() { inside_ = false; }

  int passages() const { return passages_; }
  double first_passage() const { return first_time_; }   ///< s
  int first_rank() const { return first_rank_; }         ///< the rank that the rows fell to in the first one
  double largest_turn() const { return largest_turn_; }  ///< rad, of the velocity's line over a passage
  double nearness() const { return nearness_; }          ///< the smallest ConstraintSolver::nearness
  double nearness_time() const { return nearness_time_; }

  template <class Keeper>
  void keep(Keeper& k) {
    k.within(entry_row_, -1, system_.rows - 1);
    k(inside_, entry_time_, tied_, v_, fastest_, passages_, first_rank_, first_time_, largest_turn_,
      nearness_, nearness_time_);
  }

  /// A line of velocities that turns by more, rad, or a projection that changes more of a velocity: a jump.
  static constexpr double turn_limit = 0.3, jump_limit = 0.1;

 private:
  double turn(const Eigen::VectorXd& v, const Workspace& w);

  const System& system_;
  bool inside_ = false;
  double entry_time_ = 0;
  int entry_row_ = -1;            ///< the first that became dependent there
  std::vector<char> tied_;        ///< the groups whose rows became dependent
  Eigen::VectorXd v_;             ///< at the last state before
  Eigen::VectorXd fastest_;       ///< the largest kinetic energy of each group so far, J
  Eigen::VectorXd now_, before_;  ///< scratch
  int passages_ = 0, first_rank_ = 0;
  double first_time_ = 0, largest_turn_ = 0, nearness_ = 1, nearness_time_ = 0;
};

}  // namespace borelli
