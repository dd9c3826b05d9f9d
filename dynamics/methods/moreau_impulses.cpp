// Moreau's time stepping: the effect of contact impulses on velocities, positions and energy.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "dynamics/equations/branch_sparse.hpp"
#include "dynamics/methods/moreau.hpp"
#include "dynamics/methods/motion_flow.hpp"
#include "dynamics/numbers/lanes.hpp"
#include "dynamics/numbers/processor.hpp"

namespace borelli {

using Eigen::VectorXd;

namespace {

// Overlaps below this fraction of the length scale are not removed.
constexpr double least_overlap = 1e-5;

constexpr int separating_sweeps = 200, most_separations = 4;

/// G = Y^T Y by blocks of eight columns of Y. `touched` lists the nonzero rows of Y per block, each list
/// after its length.
template <class L>
void find_gram(const double* Y, int columns, Eigen::Index stride, const int* touched, double* G) {
  constexpr int block = Lanes::count;
  for (int i = 0; i < columns; i += block) {
    const int count = *touched++;
    for (int j = 0; j < columns; j += L::count) {
      L sums[block];
      for (L& sum : sums) sum = 0;
      for (const int* k = touched; k < touched + count; ++k) {
        const L across = L::load(Y + *k * stride + j);
        for (int l = 0; l < block; ++l) sums[l] += Y[*k * stride + i + l] * across;
      }
      for (int l = 0; l < block; ++l) sums[l].store(G + (i + l) * stride + j);
    }
    touched += count;
  }
}

}  // namespace

/// The response to impulses along the first `rows` columns of J, through the mass matrix and with the
/// bilateral constraints.
void MoreauStepping::find_response(const System& system, int rows) {
  Scratch& s = *scratch_;
  const int columns = (rows + Lanes::count - 1) / Lanes::count * Lanes::count;
  s.J.middleCols(rows, columns - rows).setZero();
  s.Y.leftCols(columns) = s.J.leftCols(columns);
  int* touched = s.touched.data();
  for (int r = 0; r < columns; r += Lanes::count) {
    int count = solve_transposed(system, s.at.factor, &s.Y(0, r), s.Y.cols(), touched + 1);
    if (s.at.has_rows() && s.at.solver.rank() > 0) {  // their forces reach the whole system
      count = system.nv;
      std::iota(touched + 1, touched + 1 + count, 0);
      for (int column = r; column < std::min(r + Lanes::count, rows); ++column)
        hold_bilateral(system, column);
    }
    *touched = count;
    touched += 1 + count;
  }
  in_registers([]<int width>(auto&... each) { find_gram<LanesOf<width, width>>(each...); },
               std::as_const(s.Y).data(), columns, s.Y.cols(), std::as_const(s.touched).data(),
               s.problem.G.data());
}

/// Subtracts the reaction of the bilateral constraints from the response to an impulse.
void MoreauStepping::hold_bilateral(const System& system, int column) {
  Scratch& s = *scratch_;
  s.response = s.Y.col(column);
  solve_lower(system, s.at.factor, s.response.data());
  s.wanted.noalias() = -s.at.rows.L.leftCols(system.nv) * s.response;
  s.at.solver.correct(s.at.factor, s.wanted, s.response);
  s.Y.col(column) += s.at.solver.measured().head(system.nv);
}

/// change <- velocity change by impulses along these rows.
void MoreauStepping::respond(const System& system, const VectorXd& impulse, int rows, VectorXd& change) {
  Scratch& s = *scratch_;
  change.noalias() = s.Y.leftCols(rows) * impulse.head(rows);
  solve_lower(system, s.at.factor, change.data());
}

/// Work of the impulses over the step, J: their change of the energy if the forces are constant in the step
/// (Acary, Energy conservation and dissipation properties of time-integration methods for nonsmooth
/// elastodynamics with contact, ZAMM 96, 2016).
double MoreauStepping::work(const VectorXd& impulse) const {
  const Scratch& s = *scratch_;
  const Eigen::Index rows = 3 * Eigen::Index(s.problem.count);
  return 0.5 * impulse.head(rows).dot(s.before.head(rows) + s.problem.free.head(rows) +
                                      s.problem.G.topLeftCorner(rows, rows) * impulse.head(rows));
}

/// Scales rebounds back that would add energy. (Newton's law can add energy with several contacts or with
/// friction.)
void MoreauStepping::scale_back(double scale) {
  Scratch& s = *scratch_;
  const Eigen::Index count = s.problem.count, rows = 3 * count;
  if (s.problem.target.head(count).maxCoeff() <= 0 || work(s.impulse) <= 0) return;
  s.plastic.head(rows) = s.impulse.head(rows);
  s.problem.target.head(count) = s.problem.target.head(count).cwiseMin(0);
  s.solver.solve(s.problem, scale, s.plastic, ContactStep::most_unsettled);
  double low = 0, high = 1;
  s.impulse.head(rows) -= s.plastic.head(rows);  // the contribution of the rebound
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (work(s.plastic + middle * s.impulse) <= 0 ? low : high) = middle;
  }
  s.impulse.head(rows) = s.plastic.head(rows) + low * s.impulse.head(rows);
}

/// Books the work of the impulses. Contacts that closed faster than gravity accelerates in a step count as
/// impacts.
void MoreauStepping::book(const System& system) {
  Scratch& s = *scratch_;
  const Eigen::Index rows = 3 * Eigen::Index(s.problem.count);
  for (Eigen::Index k = 0; k < rows; k += 3) {
    const int i = s.acting[k / 3];
    double done = 0;
    for (int c = 0; c < 3; ++c)
      done += 0.5 * s.impulse[k + c] *
              (s.before[k + c] + s.problem.free[k + c] +
               s.problem.G.row(k + c).head(rows).dot(s.impulse.head(rows)));
    step_.group_work[system.constraints[system.contacts[i].constraint].group] += done;
    if (s.before[k] < -fall_ && s.impulse[k] > 0) {
      ++step_.impacts;
      step_.impact_loss -= done;
    }
    step_.impulse.segment<3>(3 * i) = s.impulse.segment<3>(k);
  }
}

/// Corrects the work of efforts, drives and moving constraints to the mean velocity with impulses, and adds
/// the work of drives against the impulses. Without any of these, nothing changes.
bool MoreauStepping::book_powers(Flow& flow, const MotionFlow& motion, double t, double h, const VectorXd& y,
                                 VectorXd& out) {
  const System& system = motion.system();
  Scratch& s = *scratch_;
  const Eigen::Index n = system.nv, works = y.size() - 2 * n, drives = 2 * n + 1;
  if (system.parameters.drives.empty() && system.parameters.efforts.empty() &&
      motion.workspace().rows.partial_rate.isZero(0))
    return true;
  s.moved = middle_;
  s.moved.segment(n, n) += 0.5 * s.change;
  if (!flow.derivative(t + 0.5 * h, s.moved, s.slope)) return false;
  out.tail(works) = y.tail(works) + h * s.slope.tail(works);
  for (Eigen::Index r = 0; r < 3 * Eigen::Index(s.problem.count); ++r) {
    const double done = -s.impulse[r] * s.driven[r];
    out[drives] += done;
    out[2 * n + 4 + system.constraints[system.contacts[s.acting[r / 3]].constraint].group] += done;
  }
  return true;
}

/// Moves the positions of `out` by `shift` (nv, velocities times s).
void MoreauStepping::move(Flow& flow, const VectorXd& shift, VectorXd& out) {
  Scratch& s = *scratch_;
  const Eigen::Index n = shift.size();
  s.moved = middle_;
  s.moved.segment(n, n) = shift;
  s.slope.resize(out.size());
  flow.position_rate(s.moved, s.slope);
  out.head(n) += s.slope.head(n);
}

/// Adds to `book` the energy change by moving the positions from those of `from` to those of `to`, at the
/// velocities of `to`.
bool MoreauStepping::book_move(const MotionFlow& motion, double t, const VectorXd& from, const VectorXd& to,
                               VectorXd& book) {
  const System& system = motion.system();
  Scratch& s = *scratch_;
  motion.take(to, s.state, s.work);
  const auto add = [&](double sign) {
    if (update_energies(system, system.parameters, t, s.state.q.data(), s.state.v.data(), s.at)) return false;
    book += sign * (s.at.terms.group_kinetic + s.at.terms.group_potential);
    return true;
  };
  if (!add(1)) return false;
  s.moved = from;
  s.moved.segment(system.nv, system.nv) = to.segment(system.nv, system.nv);
  motion.take(s.moved, s.state, s.work);
  return add(-1);
}

/// Whether any overlap is large enough to remove.
bool MoreauStepping::overlaps(const System& system) const {
  return std::any_of(system.contacts.begin(), system.contacts.end(), [&](const Contact& contact) {
    return scratch_->end.h[contact.row] < -least_overlap * system.row_scale[contact.row];
  });
}

/// The normals of the contacts to separate, with newly overlapping ones, at the present positions, and the
/// response along them. Overwrites the rows of the acting contacts.
void MoreauStepping::find_normals(const MotionFlow& motion, double t) {
  const System& system = motion.system();
  Scratch& s = *scratch_;
  for (int i = 0; i < int(system.contacts.size()); ++i)
    if (s.end.h[system.contacts[i].row] < 0 &&
        std::find(s.parted.begin(), s.parted.end(), i) == s.parted.end())
      s.parted.push_back(i);
  const int count = int(s.parted.size());
  s.reserve(count);
  update_kinematics(system, system.parameters, t, s.state.q.data(), s.state.v.data(), s.landed);
  std::fill(s.known.begin(), s.known.end(), 0);
  for (int k = 0; k < count; ++k) {
    find_rows(system, s.landed, s.parted[k]);
    s.J.col(k) = s.rows.L.row(system.contacts[s.parted[k]].row).head(system.nv);
  }
  find_response(system, count);
}

/// Position impulses that remove the overlaps by the least move in the norm of the mass matrix. Row stride *
/// k of the response is the normal of contact k.
void MoreauStepping::find_separation(const System& system, int stride) {
  Scratch& s = *scratch_;
  const int count = int(s.parted.size());
  s.apart.head(count).setZero();
  // Gaps are linear only in small moves, so an accuracy of a hundredth suffices.
  for (int pass = 0; pass < separating_sweeps; ++pass) {
    double changed = 0, most = 0;
    for (int k = 0; k < count; ++k) {
      const double own = s.problem.G(stride * k, stride * k);
      if (own <= 0) continue;
      double gap = s.end.h[system.contacts[s.parted[k]].row];
      for (int j = 0; j < count; ++j) gap += s.problem.G(stride * k, stride * j) * s.apart[j];
      const double to = std::max(0., s.apart[k] - gap / own), by = std::abs(to - s.apart[k]) * own;
      s.apart[k] = to;
      changed = std::max(changed, by);
      most = std::max(most, to * own);
    }
    if (changed <= 1e-2 * most) break;
  }
}

/// Removes the overlaps at the step's end: separated_ is landed_ after the move. Gaps are not linear in the
/// move, and the move may close other contacts; it is repeated along the new normals while overlaps remain.
/// Returns false if nothing had to move.
bool MoreauStepping::separate(Flow& flow, const MotionFlow& motion, double t) {
  const System& system = motion.system();
  Scratch& s = *scratch_;
  int made = 0;
  for (; made < most_separations && overlaps(system); ++made) {
    const bool first = made == 0;
    if (first) {
      separated_ = landed_;
      s.parted = s.acting;
    } else {
      find_normals(motion, t);
    }
    const int stride = first ? 3 : 1, rows = stride * int(s.parted.size());
    find_separation(system, stride);
    s.plastic.head(rows).setZero();
    for (std::size_t k = 0; k < s.parted.size(); ++k)
      s.plastic[stride * Eigen::Index(k)] = s.apart[Eigen::Index(k)];
    respond(system, s.plastic, rows, s.x);
    move(flow, s.x, separated_);
    find_gaps(motion, t, separated_);
  }
  return made > 0;
}

}  // namespace borelli
