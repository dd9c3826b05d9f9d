#include "dynamics/run/recorder.hpp"

#include <fmt/format.h>

#include "dynamics/equations/momentum.hpp"
#include "process/memory.hpp"

namespace borelli {

namespace {

// Poses are reserved for this multiple of those present: unused memory costs nothing, while each growth
// copies all poses.
constexpr std::size_t ahead = 4;

/// Copies in place; the vectors are too short for a library call.
template <class Vector>
void copy(const Vector& x, double* to) {
  for (Eigen::Index i = 0; i < x.size(); ++i) to[i] = x[i];
}

// Rows and steps that are reserved at first, in number and bytes; a run may end early.
constexpr std::size_t most_expected = 1024, steps_expected = 64;
constexpr double bytes_expected = 64e6;

// Smaller amounts of memory are not requested.
constexpr double few_bytes = 64e6;

}  // namespace

Recorder::Recorder(const System& system, std::size_t rows, bool known)
    : system_(system), all_rows_(known ? rows : 0) {
  rows = std::min({rows, most_expected, std::size_t(1 + bytes_expected / bytes_per_row())});
  for (auto* numbers : {&out_.step_times, &out_.step_sizes}) numbers->reserve(std::max(rows, steps_expected));
  out_.poses.reserve(rows * system.solids.size());
  out_.coordinates = system.coordinates;
  out_.solids = system.solids;
  out_.multiplier_names = system.row_names;
  for (const Contact& contact : system.contacts) out_.contact_names.push_back(contact.name);
  for (const CoordinateInfo& info : system.driven)
    for (int i = 0; i < info.v_size; ++i)
      out_.driven_names.push_back(info.v_size == 1 ? info.name : fmt::format("{}[{}]", info.name, i));
  const auto contacts = Eigen::Index(system.contacts.size());
  out_.q.resize(0, system.nq);
  out_.v.resize(0, system.nv);
  out_.a.resize(0, system.nv);
  out_.multipliers.resize(0, system.rows);
  out_.contact_modes.resize(0, contacts);
  out_.contact_forces.resize(0, contacts);
  out_.driven_efforts.resize(0, system.driven_nv);
  out_.driven_positions.resize(0, system.driven_nv);
  for (Rows* vectors : {&out_.gravity_centre, &out_.linear_momentum, &out_.angular_momentum})
    vectors->resize(0, 3);
  make_room(Eigen::Index(rows));
}

double Recorder::bytes_per_row() const {
  const double numbers = system_.nq + 2.0 * system_.nv + system_.rows +
                         2.0 * double(system_.contacts.size()) + 2.0 * system_.driven_nv + 13;
  return sizeof(double) * numbers + sizeof(Pose) * double(system_.solids.size());
}

Result<void> Recorder::admit() {
  if (row_ < admitted_) return {};
  const bool known = Eigen::Index(all_rows_) > row_;
  const Eigen::Index rows = known ? Eigen::Index(all_rows_) - row_ : std::max<Eigen::Index>(row_, 1);
  admitted_ = row_ + rows;
  const double bytes = bytes_per_row() * double(rows);
  if (bytes < few_bytes) return {};
  return admit_memory(
      system_.scene,
      fmt::format("the {} of {} rows of {} solids and {} coordinates (a longer output_interval "
                  "makes fewer)",
                  known ? "trajectory" : "rest of the trajectory, as many again", rows, system_.solids.size(),
                  system_.nv),
      bytes);
}

std::array<Rows*, 11> Recorder::numbers() {
  return {&out_.q,
          &out_.v,
          &out_.a,
          &out_.multipliers,
          &out_.contact_modes,
          &out_.contact_forces,
          &out_.driven_efforts,
          &out_.driven_positions,
          &out_.gravity_centre,
          &out_.linear_momentum,
          &out_.angular_momentum};
}

void Recorder::make_room(Eigen::Index rows) {
  room_ = rows;
  for (auto* each : {&out_.times, &out_.kinetic, &out_.potential, &out_.work})
    each->resize(std::size_t(rows));
  for (Rows* each : numbers())
    if (each->cols() > 0)
      each->conservativeResize(rows, Eigen::NoChange);
    else
      each->resize(rows, 0);  // no memory
}

void Recorder::make_room_for_poses() {
  std::size_t poses = ahead * (out_.poses.size() + system_.solids.size());
  if (const std::size_t all = all_rows_ * system_.solids.size(); all > out_.poses.size())
    poses = std::min(poses, all);
  out_.poses.reserve(poses);
}

void Recorder::record_impulses(const Eigen::VectorXd& impulses, double h) {
  if (impulses_.size() == 0) impulses_ = Eigen::VectorXd::Zero(impulses.size());
  impulses_ += impulses;
  impulses_time_ += h;
}

void Recorder::record_contacts(const Workspace& w) {
  double *const multipliers = row_of(out_.multipliers), *const modes = row_of(out_.contact_modes),
                *const forces = row_of(out_.contact_forces);
  if (impulses_time_ > 0) {
    forces_ = impulses_ / impulses_time_;
    impulses_.setZero();
    impulses_time_ = 0;
  }
  for (std::size_t i = 0; i < system_.contacts.size(); ++i) {
    const Contact& contact = system_.contacts[i];
    Touch touch = w.rows.modes[i].touch;
    if (forces_.size() > 0) {
      const auto force = forces_.segment<3>(3 * Eigen::Index(i));
      const double friction = surface_of(system_.parameters.constraints[contact.constraint].kind).friction;
      for (int c = 0; c < (contact.tangents ? 3 : 1); ++c) multipliers[contact.row + c] = force[c];
      // At the friction limit, up to the residual of the impulses.
      const bool limited = !contact.tangents || force.tail<2>().norm() >= (1 - 1e-6) * friction * force[0];
      touch = force[0] <= 0 ? Touch::open : limited ? Touch::sliding : Touch::sticking;
    }
    modes[i] = double(touch);
    forces[i] = multipliers[contact.row];
  }
}

void Recorder::record(const State& state, Workspace& w, const Work& work) {
  if (row_ == room_) make_room(std::max<Eigen::Index>(2 * room_, 1));
  const auto row = std::size_t(row_);
  out_.times[row] = state.t;
  copy(state.q, row_of(out_.q));
  copy(state.v, row_of(out_.v));
  copy(w.a, row_of(out_.a));
  copy(w.multipliers, row_of(out_.multipliers));
  if (!system_.contacts.empty()) record_contacts(w);
  copy(w.drive_efforts, row_of(out_.driven_efforts));
  double* driven = row_of(out_.driven_positions);
  for (const Drive& drive : system_.parameters.drives)
    for (const TimeFunction& f : drive.functions) *driven++ = at(f, state.t).value;
  if (out_.poses.size() == out_.poses.capacity()) make_room_for_poses();
  const BodyMotion* const bodies = w.kinematics.bodies.data();
  const int* body_of = system_.solid_bodies.data();
  for (const Placement& place : system_.parameters.solid_places) {
    const Pose& X = bodies[*body_of++].X;
    if (place.form == Placement::Form::identity)
      out_.poses.push_back(X);  // without a copy in between
    else
      out_.poses.push_back(X * place);
  }
  const Momenta now = momenta(system_, system_.parameters, w.kinematics);
  copy(now.centre, row_of(out_.gravity_centre));
  copy(now.linear, row_of(out_.linear_momentum));
  copy(now.angular, row_of(out_.angular_momentum));
  out_.kinetic[row] = w.terms.kinetic;
  out_.potential[row] = w.terms.potential;
  out_.work[row] = work.total();
  ++row_;
}

void Recorder::record_step(double t, double h) {
  out_.step_times.push_back(t);
  out_.step_sizes.push_back(h);
}

const Trajectory& Recorder::so_far(Certificate certificate) {
  make_room(row_);
  out_.certificate = std::move(certificate);
  return out_;
}

Trajectory Recorder::finish(Certificate certificate) {
  so_far(std::move(certificate));
  return std::move(out_);
}

}  // namespace borelli
