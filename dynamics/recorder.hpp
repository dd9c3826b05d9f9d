// The rows of a trajectory as they come.
#pragma once

#include <algorithm>
#include <utility>

#include "dynamics/equations.hpp"
#include "dynamics/work.hpp"

namespace borelli {

/// Numbers row by row, of which there may be many: they grow where they are, if the system lets them.
class GrowingRows {
 public:
  /// How many rows to make room for at first.
  void expect(Eigen::Index rows) { expected_ = rows; }
  /// One row more, to be filled.
  double* add(Eigen::Index columns) {
    if (columns > 0 && count_ == numbers_.rows())
      numbers_.conservativeResize(std::max(expected_, 2 * count_), columns);
    return numbers_.data() + count_++ * columns;
  }
  /// One row more, x: its place, which holds until another row comes.
  template <class Vector>
  double* add(const Vector& x) {
    double* const row = add(x.size());
    Eigen::Map<Vector>(row, x.size()) = x;  // (they are few: no call to copy them)
    return row;
  }
  /// All of them; none are left.
  Rows take() {
    cut();
    count_ = 0;
    return std::move(numbers_);
  }

  template <class Keeper>
  void keep(Keeper& k) {
    cut();
    k(numbers_);
    count_ = numbers_.rows();
  }

 private:
  /// No room for more.
  void cut() {
    if (numbers_.cols() > 0)
      numbers_.conservativeResize(count_, numbers_.cols());
    else
      numbers_.resize(count_, 0);
  }

  Rows numbers_;  ///< with room for more
  Eigen::Index count_ = 0, expected_ = 1;
};

class Recorder {
 public:
  /// `rows`: how many are to be expected.
  Recorder(const System& system, std::size_t rows);

  /// A row: a state whose equations are solved in `w`.
  void record(const State& state, const Workspace& w, const Work& work);
  /// An accepted step of h from time t, s.
  void record_step(double t, double h);
  /// What contacts did in an accepted step of h (s) by impulses, N s: three numbers each, along the normal
  /// and the two across. The rows after it hold their mean forces since the row before, and their modes by
  /// these.
  void record_impulses(const Eigen::VectorXd& impulses, double h);
  Trajectory finish(Certificate certificate);

  template <class Keeper>
  void keep(Keeper& k) {
    k(out_.times, out_.poses, out_.kinetic, out_.potential, out_.work, out_.step_times, out_.step_sizes,
      contact_modes_, contact_forces_, impulses_, forces_, impulses_time_, q_, v_, a_, multipliers_,
      driven_efforts_, driven_positions_, gravity_centre_, linear_momentum_, angular_momentum_);
  }

 private:
  void record_contacts(const Workspace& w);

  const System& system_;
  Trajectory out_;
  GrowingRows contact_modes_, contact_forces_;
  Eigen::VectorXd impulses_, forces_;  // of contacts that act by impulses: since the last row, and at it
  double impulses_time_ = 0;           // s, that these took
  GrowingRows q_, v_, a_, multipliers_, driven_efforts_, driven_positions_;
  GrowingRows gravity_centre_, linear_momentum_, angular_momentum_;
};

}  // namespace borelli
