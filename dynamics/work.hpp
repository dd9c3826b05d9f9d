// The books of a run: what was done on the system since its start.
#pragma once

#include <Eigen/Core>

namespace borelli {

/// Work done on the system since the start, J; integrated with the motion, except that of projections and
/// events, which is their jump of energy.
struct Work {
  explicit Work(int group_count)
      : groups(Eigen::VectorXd::Zero(group_count)),
        group_projection(groups),
        group_projection_size(groups),
        group_events(groups) {}

  double efforts = 0, drives = 0, constraints = 0, violation = 0;
  double projection = 0, projection_size = 0;
  double events = 0, events_size = 0;
  double total() const { return efforts + drives + constraints + violation + projection + events; }

  /// Books the change of each group's energy by a projection.
  void add_projection(const Eigen::VectorXd& jump) {
    projection += jump.sum();
    projection_size += std::abs(jump.sum());
    group_projection += jump;
    group_projection_size += jump.cwiseAbs();
  }

  /// Books the change of each group's energy by an event.
  void add_event(const Eigen::VectorXd& jump) {
    events += jump.sum();
    events_size += std::abs(jump.sum());
    group_events += jump;
  }

  template <class Keeper>
  void keep(Keeper& k) {
    k(efforts, drives, constraints, violation, projection, projection_size, events, events_size, groups,
      group_projection, group_projection_size, group_events);
  }

  Eigen::VectorXd groups;  ///< on each independent group, but for what is in the next
  Eigen::VectorXd group_projection, group_projection_size, group_events;
};

}  // namespace borelli
