// Collects the rows of a trajectory.
#pragma once

#include <array>

#include "dynamics/equations/equations.hpp"
#include "dynamics/methods/work.hpp"
#include "error/error.hpp"

namespace borelli {

class Recorder {
 public:
  /// `rows`: expected number of rows; `known`: the number is exact.
  Recorder(const System& system, std::size_t rows, bool known);

  /// Requests memory for coming rows (process/memory.hpp): for all rows if their number is known; otherwise
  /// for as many again whenever the room is used up. Call before each record(). Fails if memory is short.
  Result<void> admit();
  /// Appends a row: a state whose equations are solved in `w`.
  void record(const State& state, Workspace& w, const Work& work);
  /// Records an accepted step of h from time t, s.
  void record_step(double t, double h);
  /// Records contact impulses of an accepted step of h (s), in N s: three per contact, along the normal and
  /// the two tangents. The next row holds the mean contact forces since the previous row, and the modes that
  /// follow from them.
  void record_impulses(const Eigen::VectorXd& impulses, double h);
  Trajectory finish(Certificate certificate);
  /// The rows so far; valid until the next record().
  const Trajectory& so_far(Certificate certificate);

  template <class Keeper>
  void keep(Keeper& k) {
    std::size_t rows = row_;
    k.count(rows, std::size_t(bytes_per_row()));
    make_room(Eigen::Index(rows));
    out_.poses.resize(rows * system_.solids.size());
    k.growing(out_.step_times);
    k.growing(out_.step_sizes);
    k(out_.times, out_.poses, out_.kinetic, out_.potential, out_.work, out_.contact_modes,
      out_.contact_forces, impulses_, forces_, impulses_time_, out_.q, out_.v, out_.a, out_.multipliers,
      out_.driven_efforts, out_.driven_positions, out_.gravity_centre, out_.linear_momentum,
      out_.angular_momentum);
    row_ = room_;
  }

 private:
  void record_contacts(const Workspace& w);
  /// All arrays with one row of numbers per output time.
  std::array<Rows*, 11> numbers();
  /// Resizes these arrays to exactly `rows` rows. Large arrays grow in place if the system can.
  void make_room(Eigen::Index rows);
  void make_room_for_poses();
  double bytes_per_row() const;
  /// The row being recorded.
  double* row_of(Rows& numbers) const { return numbers.data() + row_ * numbers.cols(); }

  const System& system_;
  Trajectory out_;  // arrays have spare rows
  Eigen::Index row_ = 0, room_ = 0;
  std::size_t all_rows_ = 0;           // 0: unknown
  Eigen::Index admitted_ = 0;          // rows
  Eigen::VectorXd impulses_, forces_;  // contact impulses since the last row, N s; mean forces, N
  double impulses_time_ = 0;           // s, duration over which impulses_ were summed
};

}  // namespace borelli
