// Simbody: builds mobilizers, forces and constraints from the tree and runs Simbody's integrators. They
// project onto constraints as they choose. Steps end on the output times, except for CPodes, which
// interpolates at its own order.
#include <Simbody.h>
#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <iostream>

#include "peer.hpp"

namespace borelli::peers {
namespace {

SimTK::Vec3 vec(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }
Eigen::Vector3d vec(const SimTK::Vec3& v) { return {v[0], v[1], v[2]}; }
SimTK::Mat33 mat(const Eigen::Matrix3d& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}
SimTK::Rotation rotation(const Eigen::Matrix3d& R) { return SimTK::Rotation(mat(R), true); }

/// Silences standard output, because the time stepper of Debian's build prints every step.
class Silence {
 public:
  Silence() : out_(dup(1)) {
    std::cout.flush();
    fflush(stdout);
    const int nothing = open("/dev/null", O_WRONLY);
    dup2(nothing, 1);
    close(nothing);
  }
  ~Silence() {
    std::cout.flush();
    fflush(stdout);
    dup2(out_, 1);
    close(out_);
  }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  int out_;
};

class Simbody : public Peer {
 public:
  explicit Simbody(const Tree& tree) : tree_(tree), gravity_(forces_, matter_, vec(tree.gravity)) {
    for (const Link& link : tree.links) add(link);
    for (const Spring& s : tree.springs) {
      SimTK::Force::TwoPointLinearSpring(forces_, body(s.a), vec(s.a.point), body(s.b), vec(s.b.point),
                                         s.stiffness, s.rest);
      if (s.damping != 0)
        SimTK::Force::TwoPointLinearDamper(forces_, body(s.a), vec(s.a.point), body(s.b), vec(s.b.point),
                                           s.damping);
    }
    for (const JointSpring& s : tree.joint_springs) {
      SimTK::Force::MobilityLinearSpring(forces_, bodies_[s.link], SimTK::MobilizerQIndex(0), s.stiffness,
                                         s.rest);
      if (s.damping != 0)
        SimTK::Force::MobilityLinearDamper(forces_, bodies_[s.link], SimTK::MobilizerUIndex(0), s.damping);
    }
    for (const Turn& t : tree.turns) SimTK::Force::ConstantTorque(forces_, bodies_[t.link], vec(t.torque));
    for (const Held& h : tree.held)
      SimTK::Constraint::Ball(body(h.a), vec(h.a.point), body(h.b), vec(h.b.point));
    for (const InPlane& c : tree.in_planes)
      SimTK::Constraint::PointInPlane(body(c.plane), SimTK::UnitVec3(vec(c.normal)),
                                      c.normal.dot(c.plane.point), body(c.point), vec(c.point.point));
    for (const Ground& g : tree.grounds) add(g);
    start_ = system_.realizeTopology();
    matter_.setUseEulerAngles(start_, false);
    system_.realizeModel(start_);
    for (std::size_t i = 0; i < tree.links.size(); ++i) set_start(tree.links[i], bodies_[i]);
  }

  std::string version() const override {
    int major, minor, build;
    SimTK_version_simbody(&major, &minor, &build);
    return "Simbody " + std::to_string(major) + "." + std::to_string(minor);
  }

  std::vector<Method> methods() const override {
    if (!tree_.grounds.empty()) return {{"Simbody time stepper", false}};
    return {{"Simbody RK-Merson", true},
            {"Simbody RK-Fehlberg", true},
            {"Simbody RK3", true},
            {"Simbody Verlet", true},
            {"Simbody semi-explicit 2", true},
            {"Simbody semi-explicit Euler", false},
            {"Simbody CPodes BDF", true},
            {"Simbody CPodes Adams", true}};
  }

  Result<Run> run(std::size_t method, double step, double tolerance, const std::vector<double>& times,
                  const std::function<bool()>& go_on) override {
    try {
      if (!tree_.grounds.empty()) return run_stepper(step, times, go_on);
      const bool own_output = method >= 6;
      if (own_output && step > 0) return failure("", "has no steps of one length");
      const std::unique_ptr<SimTK::Integrator> integrator = make(method);
      if (step > 0)
        integrator->setFixedStepSize((times[0] - 0) / double(steps_in(times[0], step)));
      else
        integrator->setAccuracy(tolerance);
      if (!own_output) integrator->setAllowInterpolation(false);
      integrator->setReturnEveryInternalStep(true);
      system_.resetAllCountersToZero();
      integrator->initialize(start_);
      Run out;
      for (const double t : times) {
        while (integrator->getTime() < t) {
          integrator->stepTo(t);
          if (!go_on()) return failure("", "took too long");
        }
        if (!note(integrator->getState(), out))
          return failure("", "numbers that are not finite at t = " + std::to_string(t));
      }
      out.evaluations = system_.getNumRealizationsOfThisStage(SimTK::Stage::Acceleration);
      return out;
    } catch (const std::exception& e) {
      return failure("", e.what());
    }
  }

 private:
  /// Simbody's time stepper for contacts.
  Result<Run> run_stepper(double step, const std::vector<double>& times, const std::function<bool()>& go_on) {
    const Silence silence;
    SimTK::SemiExplicitEulerTimeStepper stepper(system_);
    // the same restitution at all but the smallest speeds
    stepper.setDefaultImpactCaptureVelocity(1e-6);
    stepper.setDefaultImpactMinCORVelocity(2e-6);
    stepper.initialize(start_);
    Run out;
    double t = 0;
    for (const double next : times) {
      const long steps = steps_in(next - t, step);
      for (long i = 1; i <= steps; ++i) {
        stepper.stepTo(i == steps ? next : t + (next - t) * double(i) / double(steps));
        if (i % 64 == 0 && !go_on()) return failure("", "took too long");
      }
      out.evaluations += steps;
      t = next;
      if (!note(stepper.getState(), out))
        return failure("", "numbers that are not finite at t = " + std::to_string(t));
    }
    return out;
  }

  void add(const Ground& g) {
    SimTK::MobilizedBody& on = bodies_[g.centre.link];
    const SimTK::UnitVec3 n(vec(g.normal));
    const double height = g.normal.dot(g.on);
    if (g.radius > 0) {
      matter_.adoptUnilateralContact(new SimTK::SpherePlaneContact(
          ground_, n, height, on, vec(g.centre.point), g.radius, g.restitution, g.friction, g.friction, 0));
      return;
    }
    for (int k = 0; k < (g.size.isZero() ? 1 : 8); ++k) {
      const Eigen::Vector3d side(k & 1 ? 0.5 : -0.5, k & 2 ? 0.5 : -0.5, k & 4 ? 0.5 : -0.5);
      matter_.adoptUnilateralContact(new SimTK::PointPlaneContact(
          ground_, n, height, on, vec(Eigen::Vector3d(g.centre.point + side.cwiseProduct(g.size))),
          g.restitution, g.friction, g.friction, 0));
    }
  }

  SimTK::MobilizedBody& body(const At& at) { return at.link < 0 ? ground_ : bodies_[at.link]; }

  void add(const Link& link) {
    const Eigen::Matrix3d about_centre =
        link.principal * link.moments.asDiagonal() * link.principal.transpose();
    const Eigen::Vector3d c = link.centre;
    const Eigen::Matrix3d about_origin =
        about_centre + link.mass * (c.squaredNorm() * Eigen::Matrix3d::Identity() - c * c.transpose());
    const SimTK::Body::Rigid rigid(
        SimTK::MassProperties(link.mass, vec(c),
                              SimTK::Inertia(about_origin(0, 0), about_origin(1, 1), about_origin(2, 2),
                                             about_origin(0, 1), about_origin(0, 2), about_origin(1, 2))));
    SimTK::MobilizedBody& base = link.parent < 0 ? ground_ : bodies_[link.parent];
    const SimTK::Transform X_PJ(rotation(link.R), vec(link.p));
    switch (link.joint) {
      case Link::Joint::hinge: {
        const SimTK::Rotation R(SimTK::UnitVec3(vec(link.axis)), SimTK::ZAxis);
        bodies_.push_back(SimTK::MobilizedBody::Pin(base, X_PJ * SimTK::Transform(R), rigid, R));
        return;
      }
      case Link::Joint::slide: {
        const SimTK::Rotation R(SimTK::UnitVec3(vec(link.axis)), SimTK::XAxis);
        bodies_.push_back(SimTK::MobilizedBody::Slider(base, X_PJ * SimTK::Transform(R), rigid, R));
        return;
      }
      case Link::Joint::ball:
        bodies_.push_back(SimTK::MobilizedBody::Ball(base, X_PJ, rigid, SimTK::Transform()));
        return;
      case Link::Joint::free:
        bodies_.push_back(SimTK::MobilizedBody::Free(base, X_PJ, rigid, SimTK::Transform()));
    }
  }

  // In Simbody a ball's velocities are in the parent's axes, and a free joint's rotation precedes its
  // position.
  void set_start(const Link& link, const SimTK::MobilizedBody& b) {
    if (link.v.size() == 1) {
      b.setOneQ(start_, 0, link.q[0]);
      b.setOneU(start_, 0, link.v[0]);
      return;
    }
    const int ball = link.joint == Link::Joint::free ? 3 : 0;
    SimTK::Vec4 turn;
    for (int i = 0; i < 4; ++i) {
      turn[i] = link.q[ball + i];
      b.setOneQ(start_, i, turn[i]);
    }
    const SimTK::Vec3 own(link.v[ball], link.v[ball + 1], link.v[ball + 2]);
    const SimTK::Vec3 omega = SimTK::Rotation(SimTK::Quaternion(turn)) * own;
    for (int i = 0; i < 3; ++i) {
      b.setOneU(start_, i, omega[i]);
      if (ball == 0) continue;
      b.setOneQ(start_, 4 + i, link.q[i]);
      b.setOneU(start_, 3 + i, link.v[i]);
    }
  }

  std::unique_ptr<SimTK::Integrator> make(std::size_t method) const {
    switch (method) {
      case 0:
        return std::make_unique<SimTK::RungeKuttaMersonIntegrator>(system_);
      case 1:
        return std::make_unique<SimTK::RungeKuttaFeldbergIntegrator>(system_);
      case 2:
        return std::make_unique<SimTK::RungeKutta3Integrator>(system_);
      case 3:
        return std::make_unique<SimTK::VerletIntegrator>(system_);
      case 4:
        return std::make_unique<SimTK::SemiExplicitEuler2Integrator>(system_);
      case 5:
        return std::make_unique<SimTK::SemiExplicitEulerIntegrator>(system_, 1e-3);
      case 6:
        return std::make_unique<SimTK::CPodesIntegrator>(system_, SimTK::CPodes::BDF);
      default:
        return std::make_unique<SimTK::CPodesIntegrator>(system_, SimTK::CPodes::Adams);
    }
  }

  bool note(const SimTK::State& state, Run& out) const {
    system_.realize(state, SimTK::Stage::Velocity);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const SimTK::MobilizedBody& b = bodies_[i];
      Moving m;
      const SimTK::Rotation& R = b.getBodyRotation(state);
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) m.R(r, c) = R[r][c];
      m.p = vec(b.getBodyOriginLocation(state));
      m.omega = vec(b.getBodyAngularVelocity(state));
      m.centre = vec(b.findStationVelocityInGround(state, vec(tree_.links[i].centre)));
      if (!m.p.allFinite() || !m.R.allFinite()) return false;
      out.links.push_back(m);
    }
    return true;
  }

  Tree tree_;
  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_{system_};
  SimTK::GeneralForceSubsystem forces_{system_};
  SimTK::Force::UniformGravity gravity_;
  SimTK::MobilizedBody ground_{matter_.Ground()};
  std::vector<SimTK::MobilizedBody> bodies_;
  SimTK::State start_;
};

}  // namespace

extern "C" void make_simbody(const Tree& tree, Result<std::unique_ptr<Peer>>& out) {
  try {
    out = std::make_unique<Simbody>(tree);
  } catch (const std::exception& e) {
    out = failure("Simbody", e.what());
  }
}

}  // namespace borelli::peers
