#include "dynamics/recorder.hpp"

#include <fmt/format.h>

#include "dynamics/jacobian.hpp"

namespace borelli {

namespace {

// poses that more memory is asked for at once, in parts of those there are: what is not written to costs
// nothing, and all of them are copied
constexpr std::size_t ahead = 4;

// rows that room is made for at first: a run may end before its time; and steps, whose number may be unknown
constexpr std::size_t most_expected = 1024, steps_expected = 64;

}  // namespace

Recorder::Recorder(const System& system, std::size_t rows) : system_(system) {
  rows = std::min(rows, most_expected);
  for (GrowingRows* numbers :
       {&contact_modes_, &contact_forces_, &q_, &v_, &a_, &multipliers_, &driven_efforts_, &driven_positions_,
        &gravity_centre_, &linear_momentum_, &angular_momentum_})
    numbers->expect(Eigen::Index(rows));
  for (auto* numbers : {&out_.times, &out_.kinetic, &out_.potential, &out_.work}) numbers->reserve(rows);
  for (auto* numbers : {&out_.step_times, &out_.step_sizes}) numbers->reserve(std::max(rows, steps_expected));
  out_.poses.reserve(rows * system.solids.size());
  out_.coordinates = system.coordinates;
  out_.solids = system.solids;
  out_.multiplier_names = system.row_names;
  for (const Contact& contact : system.contacts) out_.contact_names.push_back(contact.name);
  for (const CoordinateInfo& info : system.driven)
    for (int i = 0; i < info.v_size; ++i)
      out_.driven_names.push_back(info.v_size == 1 ? info.name : fmt::format("{}[{}]", info.name, i));
}

void Recorder::record_impulses(const Eigen::VectorXd& impulses, double h) {
  if (impulses_.size() == 0) impulses_ = Eigen::VectorXd::Zero(impulses.size());
  impulses_ += impulses;
  impulses_time_ += h;
}

void Recorder::record_contacts(const Workspace& w) {
  double* const multipliers = multipliers_.add(w.multipliers);
  if (impulses_time_ > 0) {
    forces_ = impulses_ / impulses_time_;
    impulses_.setZero();
    impulses_time_ = 0;
  }
  const auto contacts = Eigen::Index(system_.contacts.size());
  double *const modes = contact_modes_.add(contacts), *const forces = contact_forces_.add(contacts);
  for (std::size_t i = 0; i < system_.contacts.size(); ++i) {
    const Contact& contact = system_.contacts[i];
    Touch touch = w.rows.modes[i].touch;
    if (forces_.size() > 0) {
      const auto force = forces_.segment<3>(3 * Eigen::Index(i));
      const double friction = surface_of(system_.parameters.constraints[contact.constraint].kind).friction;
      for (int c = 0; c < (contact.tangents ? 3 : 1); ++c) multipliers[contact.row + c] = force[c];
      // at its limit, but for what impulses leave to settle
      const bool limited = !contact.tangents || force.tail<2>().norm() >= (1 - 1e-6) * friction * force[0];
      touch = force[0] <= 0 ? Touch::open : limited ? Touch::sliding : Touch::sticking;
    }
    modes[i] = double(touch);
    forces[i] = multipliers[contact.row];
  }
}

void Recorder::record(const State& state, const Workspace& w, const Work& work) {
  out_.times.push_back(state.t);
  q_.add(state.q);
  v_.add(state.v);
  a_.add(w.a);
  driven_efforts_.add(w.drive_efforts);
  record_contacts(w);
  double* driven = driven_positions_.add(Eigen::Index(out_.driven_names.size()));
  for (const Drive& drive : system_.parameters.drives)
    for (const TimeFunction& f : drive.functions) *driven++ = at(f, state.t).value;
  if (out_.poses.size() == out_.poses.capacity())
    out_.poses.reserve(ahead * (out_.poses.size() + system_.solids.size()));
  for (std::size_t s = 0; s < system_.solids.size(); ++s)
    out_.poses.push_back(w.kinematics.bodies[system_.solid_bodies[s]].X * system_.parameters.solid_places[s]);
  const Momenta now = momenta(system_, system_.parameters, w.kinematics);
  gravity_centre_.add(now.centre);
  linear_momentum_.add(now.linear);
  angular_momentum_.add(now.angular);
  out_.kinetic.push_back(w.terms.kinetic);
  out_.potential.push_back(w.terms.potential);
  out_.work.push_back(work.total());
}

void Recorder::record_step(double t, double h) {
  out_.step_times.push_back(t);
  out_.step_sizes.push_back(h);
}

Trajectory Recorder::finish(Certificate certificate) {
  out_.q = q_.take();
  out_.v = v_.take();
  out_.a = a_.take();
  out_.multipliers = multipliers_.take();
  out_.contact_modes = contact_modes_.take();
  out_.contact_forces = contact_forces_.take();
  out_.driven_efforts = driven_efforts_.take();
  out_.driven_positions = driven_positions_.take();
  out_.gravity_centre = gravity_centre_.take();
  out_.linear_momentum = linear_momentum_.take();
  out_.angular_momentum = angular_momentum_.take();
  out_.certificate = std::move(certificate);
  return std::move(out_);
}

}  // namespace borelli
