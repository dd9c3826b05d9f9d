#include "simbody_loop.hpp"

#include <Simbody.h>

#include <map>

namespace borelli::test {

namespace {

SimTK::Vec3 vec(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }

}  // namespace

struct SimbodyLoop::Parts {
  SimTK::MultibodySystem system;
  SimTK::SimbodyMatterSubsystem matter{system};
  SimTK::GeneralForceSubsystem forces{system};
  SimTK::Force::UniformGravity gravity{forces, matter, SimTK::Vec3(0, 0, -9.81)};
  std::map<std::string, SimTK::MobilizedBody> bodies;
  SimTK::Constraint::Ball closing;
  std::string held;
  SimTK::State state;
};

SimbodyLoop::SimbodyLoop() : parts_(std::make_unique<Parts>()) {}
SimbodyLoop::~SimbodyLoop() = default;

// A pin turns about the z axis of its frames, so they are rotated to put z on the axis.
void SimbodyLoop::add(const std::string& name, const std::string& parent, const Eigen::Vector3d& p,
                      const Eigen::Vector3d& axis, const Link& link, const Eigen::Vector3d& radii) {
  const SimTK::Inertia about_origin = SimTK::Inertia(link.moments[0], link.moments[1], link.moments[2])
                                          .shiftFromMassCenter(vec(link.centre), link.mass);
  const SimTK::Body::Rigid body(SimTK::MassProperties(link.mass, vec(link.centre), about_origin));
  SimTK::MobilizedBody& base = parent == "world" ? parts_->matter.updGround()
                                                 : static_cast<SimTK::MobilizedBody&>(parts_->bodies[parent]);
  if (!radii.isZero()) {
    parts_->bodies[name] =
        SimTK::MobilizedBody::Ellipsoid(base, SimTK::Transform(vec(p)), body, SimTK::Transform(), vec(radii));
    return;
  }
  if (axis.isZero()) {
    parts_->bodies[name] =
        SimTK::MobilizedBody::Ball(base, SimTK::Transform(vec(p)), body, SimTK::Transform());
    return;
  }
  const SimTK::Rotation R(SimTK::UnitVec3(vec(axis)), SimTK::ZAxis);
  parts_->bodies[name] =
      SimTK::MobilizedBody::Pin(base, SimTK::Transform(R, vec(p)), body, SimTK::Transform(R));
}

void SimbodyLoop::close(const std::string& a, const Eigen::Vector3d& p_a, const std::string& b,
                        const Eigen::Vector3d& p_b) {
  parts_->held = a;
  parts_->closing = SimTK::Constraint::Ball(parts_->bodies.at(a), vec(p_a), parts_->bodies.at(b), vec(p_b));
  parts_->state = parts_->system.realizeTopology();
  parts_->matter.setUseEulerAngles(parts_->state, false);
  parts_->system.realizeModel(parts_->state);
}

void SimbodyLoop::set(const std::string& name, const Eigen::VectorXd& q, const Eigen::VectorXd& v) {
  const SimTK::MobilizedBody& body = parts_->bodies.at(name);
  for (int i = 0; i < int(q.size()); ++i) body.setOneQ(parts_->state, i, q[i]);
  for (int i = 0; i < int(v.size()); ++i) body.setOneU(parts_->state, i, v[i]);
}

double SimbodyLoop::solve() {
  parts_->system.realize(parts_->state, SimTK::Stage::Acceleration);
  return std::max(SimTK::max(parts_->state.getQErr().abs()), SimTK::max(parts_->state.getUErr().abs()));
}

Eigen::VectorXd SimbodyLoop::acceleration(const std::string& name) const {
  const SimTK::MobilizedBody& body = parts_->bodies.at(name);
  Eigen::VectorXd out(body.getNumU(parts_->state));
  for (int i = 0; i < int(out.size()); ++i) out[i] = body.getOneUDot(parts_->state, i);
  return out;
}

// Simbody's multipliers obey M u' + G^T lambda = f (SimbodyMatterSubsystem.h), so the forces are their
// negative.
Eigen::Vector3d SimbodyLoop::force() const {
  const SimTK::Vec3 own = parts_->closing.getBallReactionForceOnBody1(parts_->state);
  const SimTK::Vec3 f = parts_->bodies.at(parts_->held).expressVectorInGroundFrame(parts_->state, own);
  return {-f[0], -f[1], -f[2]};
}

}  // namespace borelli::test
