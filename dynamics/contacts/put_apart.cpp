#include "dynamics/contacts/put_apart.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "dynamics/constraints/assembly.hpp"
#include "dynamics/constraints/local_coordinates.hpp"
#include "dynamics/equations/branch_sparse.hpp"
#include "dynamics/equations/equations.hpp"

namespace borelli {

namespace {

constexpr int most_moves = 100, most_projections = 1000;
constexpr double settled = 1e-9;      // tolerance of the sweeps, relative to the deepest overlap
constexpr double longest_move = 0.2;  // of a coordinate, relative to its scale (1 rad)
// Gaps relative to the length of what touches: a gap below `overlaps` is an overlap, and closed contacts must
// exceed `apart`.
constexpr double overlaps = -1e-9, apart = -5e-10;

class PuttingApart {
 public:
  PuttingApart(const System& system, const Parameters& parameters, State& state)
      : system_(system),
        parameters_(parameters),
        state_(state),
        w_(system),
        every_(system),
        of_contact_(std::size_t(system.rows)) {
    every_.detail = ConstraintRows::Detail::values;
    for (const Contact& contact : system.contacts)
      for (int c = 0; c < (contact.tangents ? 3 : 1); ++c) of_contact_[std::size_t(contact.row + c)] = 1;
  }

  Result<void> run() {
    for (int move = 0; move <= most_moves; ++move) {
      if (auto seen = find_overlaps(); !seen) return seen;
      if (worst_ == 0 && (move == 0 || others_hold())) return {};
      if (!step()) break;
    }
    return failure(
        fmt::format("contact '{}'", system_.contacts[deepest_].name),
        fmt::format(
            "overlaps at the start, and no move separates it: {:.6g} remains; change the initial positions",
            -every_.h[system_.contacts[deepest_].row]));
  }

  int overlapped = 0;  ///< number of overlapping contacts at the start
  int first = 0;       ///< the deepest overlap's contact
  double depth = 0;    ///< its overlap, m

 private:
  double gap(std::size_t i) const {
    const int row = system_.contacts[i].row;
    return every_.h[row] / system_.row_scale[row];
  }

  /// Finds the contacts that overlap now. A contact that has overlapped stays closed from then on: it may only
  /// separate.
  Result<void> find_overlaps() {
    const auto update = [&]() -> Result<void> {
      if (const Fault fault =
              update_terms(system_, parameters_, state_.t, state_.q.data(), state_.v.data(), w_))
        return tl::unexpected(describe(system_, fault, state_.t));
      return {};
    };
    if (auto done = update(); !done) return done;
    scan_constraints(system_, parameters_, w_.kinematics, every_);
    worst_ = 0;
    bool more = false;
    for (std::size_t i = 0; i < system_.contacts.size(); ++i) {
      ContactMode& mode = w_.rows.modes[i];
      const bool closed = mode.touch != Touch::open;
      if (gap(i) >= (closed ? apart : overlaps)) continue;
      if (worst_ == 0 || gap(i) < gap(deepest_)) deepest_ = i;
      worst_ = -gap(deepest_);
      if (closed) continue;
      mode.touch = Touch::sliding;
      more = true;
    }
    if (!begun_) note_start();
    return more ? update() : Result<void>{};
  }

  bool others_hold() const {
    for (int row = 0; row < system_.rows; ++row)
      if (!of_contact_[std::size_t(row)] && !(std::abs(w_.rows.h[row]) <= -overlaps * system_.row_scale[row]))
        return false;
    return true;
  }

  void note_start() {
    begun_ = true;
    if (worst_ == 0) return;
    first = deepest_;
    depth = -every_.h[system_.contacts[deepest_].row];
    overlapped = int(std::count_if(w_.rows.modes.begin(), w_.rows.modes.end(),
                                   [](const ContactMode& mode) { return mode.touch != Touch::open; }));
  }

  /// The least move after which no closed contact overlaps and the other rows hold, to first order. One
  /// multiplier per row, nonnegative for contacts, by projected Gauss-Seidel. Returns false if no coordinate
  /// moves any of these rows.
  bool step() {
    std::vector<int> rows;
    for (int row = 0; row < system_.rows; ++row)
      if (!w_.rows.L.row(row).leftCols(system_.nv).isZero(0)) rows.push_back(row);
    if (rows.empty()) return false;
    const auto n = Eigen::Index(rows.size());
    Rows Y(n, system_.nv);  // L F^-1: rows in the norm of the mass matrix
    Eigen::VectorXd h(n), lambda = Eigen::VectorXd::Zero(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      Y.row(k) = w_.rows.L.row(rows[std::size_t(k)]).leftCols(system_.nv);
      solve_transposed(system_, w_.factor, Y.row(k).data());
      h[k] = w_.rows.h[rows[std::size_t(k)]];
    }
    const Rows G = Y * Y.transpose();
    const double deepest = h.cwiseMin(0).cwiseAbs().maxCoeff();
    for (int sweep = 0; sweep < most_projections; ++sweep) {
      double most = 0;
      for (Eigen::Index k = 0; k < n; ++k) {
        double to = lambda[k] - (h[k] + G.row(k).dot(lambda)) / G(k, k);
        if (of_contact_[std::size_t(rows[std::size_t(k)])]) to = std::max(0., to);
        most = std::max(most, std::abs(to - lambda[k]) * G(k, k));
        lambda[k] = to;
      }
      if (most <= settled * deepest) break;
    }
    w_.correction = Y.transpose() * lambda;
    solve_lower(system_, w_.factor, w_.correction.data());
    double largest = 0;
    for (int i = 0; i < system_.nv; ++i)
      largest = std::max(largest, std::abs(w_.correction[i]) / system_.velocity_scale[std::size_t(i)]);
    if (largest > longest_move) w_.correction *= longest_move / largest;
    from_local_coordinates(system_, state_.q.data(), w_.correction.data(), state_.q.data());
    return true;
  }

  const System& system_;
  const Parameters& parameters_;
  State& state_;
  Workspace w_;
  ConstraintRows every_;
  std::vector<char> of_contact_;  // per row
  double worst_ = 0;              // the deepest overlap, relative to its scale
  std::size_t deepest_ = 0;
  bool begun_ = false;
};

}  // namespace

Result<std::string> put_apart(const System& system, const Parameters& parameters, State& state) {
  if (system.contacts.empty()) return std::string{};
  const State before = state;
  PuttingApart moves(system, parameters, state);
  if (auto done = moves.run(); !done) return tl::unexpected(done.error());
  if (moves.overlapped == 0) return std::string{};
  const Assembly::Move most = largest_move(system, before, state, true);
  return fmt::format(
      "contact '{}' overlapped by {:.4g} m at the start{}; it was separated by the smallest move, mostly of "
      "coordinate '{}', by {:.4g} {}",
      system.contacts[moves.first].name, moves.depth,
      moves.overlapped > 1 ? fmt::format(", and {} others", moves.overlapped - 1) : "", most.coordinate,
      most.size, most.angle ? "rad" : "m");
}

}  // namespace borelli
