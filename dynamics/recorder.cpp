#include "dynamics/recorder.hpp"

#include <fmt/format.h>

#include "dynamics/jacobian.hpp"

namespace borelli {

namespace {

template <class Vector>
void append(std::vector<double>& numbers, const Vector& x) {
  numbers.insert(numbers.end(), x.data(), x.data() + x.size());
}

}  // namespace

Recorder::Recorder(const System& system) : system_(system) {
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
  const std::size_t row = multipliers_.size();
  append(multipliers_, w.multipliers);
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
      for (int c = 0; c < (contact.tangents ? 3 : 1); ++c)
        multipliers_[row + std::size_t(contact.row + c)] = force[c];
      // at its limit, but for what impulses leave to settle
      const bool limited = !contact.tangents || force.tail<2>().norm() >= (1 - 1e-6) * friction * force[0];
      touch = force[0] <= 0 ? Touch::open : limited ? Touch::sliding : Touch::sticking;
    }
    contact_modes_.push_back(double(touch));
    contact_forces_.push_back(multipliers_[row + std::size_t(contact.row)]);
  }
}

void Recorder::record(const State& state, const Workspace& w, const Work& work) {
  out_.times.push_back(state.t);
  append(q_, state.q);
  append(v_, state.v);
  append(a_, w.a);
  append(driven_efforts_, w.drive_efforts);
  record_contacts(w);
  for (const Drive& drive : system_.parameters.drives)
    for (const TimeFunction& f : drive.functions) driven_positions_.push_back(at(f, state.t).value);
  for (std::size_t s = 0; s < system_.solids.size(); ++s)
    out_.poses.push_back(w.kinematics.bodies[system_.solid_bodies[s]].X * system_.parameters.solid_poses[s]);
  const Momenta now = momenta(system_, system_.parameters, w.kinematics);
  append(gravity_centre_, now.centre);
  append(linear_momentum_, now.linear);
  append(angular_momentum_, now.angular);
  out_.kinetic.push_back(w.terms.kinetic);
  out_.potential.push_back(w.terms.potential);
  out_.work.push_back(work.total());
}

void Recorder::record_step(double t, double h) {
  out_.step_times.push_back(t);
  out_.step_sizes.push_back(h);
}

Trajectory Recorder::finish(Certificate certificate) {
  const auto rows = Eigen::Index(out_.times.size());
  const auto matrix = [rows](const std::vector<double>& numbers) -> Rows {
    return Eigen::Map<const Rows>(numbers.data(), rows, Eigen::Index(numbers.size()) / rows);
  };
  out_.q = matrix(q_);
  out_.v = matrix(v_);
  out_.a = matrix(a_);
  out_.multipliers = matrix(multipliers_);
  out_.contact_modes = matrix(contact_modes_);
  out_.contact_forces = matrix(contact_forces_);
  out_.driven_efforts = matrix(driven_efforts_);
  out_.driven_positions = matrix(driven_positions_);
  out_.gravity_centre = matrix(gravity_centre_);
  out_.linear_momentum = matrix(linear_momentum_);
  out_.angular_momentum = matrix(angular_momentum_);
  out_.certificate = std::move(certificate);
  return std::move(out_);
}

}  // namespace borelli
