// The rows of a trajectory as they come.
#pragma once

#include <array>

#include "dynamics/equations/equations.hpp"
#include "dynamics/methods/work.hpp"
#include "error/error.hpp"

namespace borelli {

class Recorder {
 public:
  /// `rows`: the expected number; `known`: it is exact.
  Recorder(const System& system, std::size_t rows, bool known);

  /// Asks for the memory of coming rows (process/memory.hpp): of all if their number is known, else of as
  /// many again each time they run out. Call before each record().
  Result<void> admit();
  /// A row: a state whose equations are solved in `w`.
  void record(const State& state, Workspace& w, const Work& work);
  /// An accepted step of h from time t, s.
  void record_step(double t, double h);
  /// What contacts did in an accepted step of h (s) by impulses, N s: three numbers each, along the normal
  /// and the two across. The rows after it hold their mean forces since the row before, and their modes by
  /// these.
  void record_impulses(const Eigen::VectorXd& impulses, double h);
  Trajectory finish(Certificate certificate);
  /// The rows so far; they stay as they are until the next one.
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
  /// All that has a row of numbers per output time.
  std::array<Rows*, 11> numbers();
  /// Makes room for so many of these rows, no less and no more. There may be many: they grow where they are,
  /// if the system lets them.
  void make_room(Eigen::Index rows);
  void make_room_for_poses();
  double bytes_per_row() const;
  /// The row that is being recorded.
  double* row_of(Rows& numbers) const { return numbers.data() + row_ * numbers.cols(); }

  const System& system_;
  Trajectory out_;  // its rows with room for more
  Eigen::Index row_ = 0, room_ = 0;
  std::size_t all_rows_ = 0;           // 0: unknown
  Eigen::Index admitted_ = 0;          // rows
  Eigen::VectorXd impulses_, forces_;  // of contacts that act by impulses: since the last row, and at it
  double impulses_time_ = 0;           // s, that these took
};

}  // namespace borelli
