// The work done on the system since the start of a run.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

namespace borelli {

/// Work done on the system since the start, J. Most is integrated with the motion; that of projections and
/// events is the jump of energy they cause.
struct Work {
  /// Work on one independent group.
  struct OnGroup {
    double moving = 0;  ///< integrated with the motion
    double rows = 0;    ///< part of `moving` done by violated constraint rows
    double projection = 0, projection_size = 0, events = 0;
    double total() const { return moving + projection + events; }
    double row_work() const { return rows + projection; }
  };

  explicit Work(int group_count) : groups(std::size_t(group_count)) {}

  double efforts = 0, drives = 0, constraints = 0, violation = 0;
  double projection = 0, projection_size = 0;
  double events = 0, events_size = 0;
  std::vector<OnGroup> groups;
  double total() const { return efforts + drives + constraints + violation + projection + events; }
  /// Work of violated constraint rows (step errors or Baumgarte); satisfied rows do none.
  double row_work() const { return violation + projection; }

  /// Adds the energy change of each group by a projection, J.
  void add_projection(const Eigen::VectorXd& jump) {
    projection += jump.sum();
    projection_size += std::abs(jump.sum());
    for (std::size_t g = 0; g < groups.size(); ++g) {
      groups[g].projection += jump[Eigen::Index(g)];
      groups[g].projection_size += std::abs(jump[Eigen::Index(g)]);
    }
  }

  /// Adds the energy change of each group by an event, J.
  void add_event(const Eigen::VectorXd& jump) {
    events += jump.sum();
    events_size += std::abs(jump.sum());
    for (std::size_t g = 0; g < groups.size(); ++g) groups[g].events += jump[Eigen::Index(g)];
  }

  template <class Keeper>
  void keep(Keeper& k) {
    k(efforts, drives, constraints, violation, projection, projection_size, events, events_size, groups);
  }
};

}  // namespace borelli
