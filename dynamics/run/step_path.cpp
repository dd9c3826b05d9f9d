#include "dynamics/run/step_path.hpp"

#include <fmt/format.h>

namespace borelli {

void Landing::book_projection(const Workspace& workspace) {
  if (!projected) return;
  work.add_projection(workspace.terms.group_kinetic + workspace.terms.group_potential -
                      projection.energy_before);
  projected = false;
}

StepPath::StepPath(const System& system, const SimulationSettings& settings, MotionFlow& motion,
                   Integrator& integrator, Workspace* probe)
    : system_(system),
      projecting_(settings.constraints == ConstraintTreatment::projection),
      motion_(motion),
      integrator_(integrator),
      probe_(probe),
      between_(motion.size()) {}

void StepPath::begin(double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                     const Eigen::VectorXd& out, const Work& work) {
  t_ = t;
  h_ = h;
  y_ = &y;
  dy_ = &dy;
  out_ = &out;
  work_ = &work;
  dense_ready_ = false;
}

/// Prepares dense output for the step. Returns false if the equations could not be solved.
bool StepPath::ready() {
  dense_ready_ = dense_ready_ || integrator_.prepare_dense(motion_, t_, h_, *y_, *dy_, *out_);
  return dense_ready_;
}

Result<void> StepPath::find_between(double theta) {
  const double t = t_ + theta * h_;
  if (integrator_.dense_suffices()) {
    if (!ready()) return tl::unexpected(motion_.failure(t));
    integrator_.interpolate(theta, between_);
  } else if (theta <= 0) {
    between_ = *y_;
  } else if (!integrator_.shortened(motion_, t_, theta * h_, *y_, *dy_, between_)) {
    return tl::unexpected(motion_.failure(t));
  }
  return {};
}

Result<void> StepPath::land(double theta, Landing& landing) {
  if (auto done = find_between(theta); !done) return done;
  return settle(between_, t_ + theta * h_, landing);
}

Result<void> StepPath::glance(double theta, Landing& landing) {
  if (auto done = find_between(theta); !done) return done;
  take(between_, t_ + theta * h_, landing);
  return {};
}

Result<void> StepPath::outline(double theta, Landing& landing) {
  const double t = t_ + theta * h_;
  if (!ready()) return tl::unexpected(motion_.failure(t));
  integrator_.interpolate(theta, between_);
  take(between_, t, landing);
  return {};
}

Result<void> StepPath::land_at_end(double end, Landing& landing) { return settle(*out_, end, landing); }

void StepPath::take(const Eigen::VectorXd& y, double t, Landing& landing) {
  landing.work = *work_;
  landing.state.q.resize(system_.nq);
  motion_.take(y, landing.state, landing.work);
  landing.state.t = t;
  landing.projected = false;
}

Result<void> StepPath::settle(const Eigen::VectorXd& y, double t, Landing& landing) {
  take(y, t, landing);
  if (!projecting_ || !probe_ || !probe_->has_rows() || !landing.state.q.allFinite() ||
      !landing.state.v.allFinite())
    return {};
  const Projection& projection = landing.projection;
  project(system_, system_.parameters, landing.state, *probe_, landing.projection);
  if (projection.fault) return tl::unexpected(describe(system_, projection.fault, t));
  if (projection.unreached >= 0)
    return failure(system_.row_place(projection.unreached),
                   fmt::format("the step moved it too far off to be corrected; take a smaller step{}",
                               contradiction(system_, *probe_, projection.unreached)));
  landing.projected = true;
  return {};
}

}  // namespace borelli
