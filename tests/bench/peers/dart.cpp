// DART: a skeleton built from the tree and stepped by DART's world (semi-implicit Euler, its only method).
#include <dart/collision/dart/DARTCollisionDetector.hpp>
#include <dart/dart.hpp>

#include "dynamics/numbers/rotation_between.hpp"
#include "peer.hpp"

namespace borelli::peers {
namespace {

namespace dd = dart::dynamics;

class Dart : public Peer {
 public:
  explicit Dart(const Tree& tree) : tree_(tree), world_(dart::simulation::World::create()) {
    world_->setGravity(tree.gravity);
    for (const Link& link : tree.links) add(link);
    for (const JointSpring& s : tree.joint_springs) {
      dd::Joint* joint = bodies_[s.link]->getParentJoint();
      joint->setSpringStiffness(0, s.stiffness);
      joint->setDampingCoefficient(0, s.damping);
      joint->setRestPosition(0, s.rest);
    }
    world_->getConstraintSolver()->setCollisionDetector(dart::collision::DARTCollisionDetector::create());
    for (const Ground& g : tree_.grounds) add(g);
    world_->addSkeleton(skeleton_);
    set_start();
    for (const Held& h : tree.held) {
      // DART takes the point in world axes
      const At& on = h.a.link < 0 ? h.b : h.a;
      const Eigen::Vector3d p = bodies_[on.link]->getTransform() * on.point;
      const int other = h.a.link < 0 ? -1 : h.b.link;
      world_->getConstraintSolver()->addConstraint(
          other < 0
              ? std::make_shared<dart::constraint::BallJointConstraint>(bodies_[on.link], p)
              : std::make_shared<dart::constraint::BallJointConstraint>(bodies_[on.link], bodies_[other], p));
    }
  }

  std::string version() const override { return std::string("DART ") + DART_VERSION; }
  std::vector<Method> methods() const override { return {{"DART"}}; }

  Result<Run> run(std::size_t, double step, double, const std::vector<double>& times,
                  const std::function<bool()>& go_on) override {
    set_start();
    world_->setTime(0);
    Run out;
    double t = 0;
    for (const double next : times) {
      const long steps = steps_in(next - t, step);
      world_->setTimeStep((next - t) / double(steps));
      for (long i = 0; i < steps; ++i) {
        push();
        world_->step();
        // DART aborts the process on numbers that are not finite
        if (!(skeleton_->getVelocities().cwiseAbs().maxCoeff() < 1e8))
          return failure("", "diverged at t = " + std::to_string(world_->getTime()));
        if (i % 64 == 0 && !go_on()) return failure("", "took too long");
      }
      out.evaluations += steps;
      t = next;
      if (!note(out)) return failure("", "numbers that are not finite at t = " + std::to_string(t));
    }
    return out;
  }

 private:
  static Eigen::Isometry3d place(const Eigen::Matrix3d& R, const Eigen::Vector3d& p) {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.linear() = R;
    X.translation() = p;
    return X;
  }

  template <class Joint>
  void join(dd::BodyNode* parent, const typename Joint::Properties& joint,
            const dd::BodyNode::Properties& body) {
    bodies_.push_back(skeleton_->createJointAndBodyNodePair<Joint>(parent, joint, body).second);
  }

  void add(const Link& link) {
    const std::string number = std::to_string(bodies_.size());
    dd::Joint::Properties base;
    base.mName = "j" + number;
    base.mT_ParentBodyToJoint = place(link.R, link.p);
    dd::BodyNode::Properties body;
    body.mName = "l" + number;
    const Eigen::Matrix3d moment = link.principal * link.moments.asDiagonal() * link.principal.transpose();
    body.mInertia = dd::Inertia(link.mass, link.centre, moment);
    dd::BodyNode* parent = link.parent < 0 ? nullptr : bodies_[link.parent];
    switch (link.joint) {
      case Link::Joint::hinge: {
        dd::RevoluteJoint::Properties joint{dd::GenericJoint<dart::math::R1Space>::Properties(base)};
        joint.mAxis = link.axis;
        return join<dd::RevoluteJoint>(parent, joint, body);
      }
      case Link::Joint::slide: {
        dd::PrismaticJoint::Properties joint{dd::GenericJoint<dart::math::R1Space>::Properties(base)};
        joint.mAxis = link.axis;
        return join<dd::PrismaticJoint>(parent, joint, body);
      }
      case Link::Joint::ball:
        return join<dd::BallJoint>(
            parent, dd::BallJoint::Properties{dd::GenericJoint<dart::math::SO3Space>::Properties(base)},
            body);
      case Link::Joint::free:
        return join<dd::FreeJoint>(
            parent, dd::FreeJoint::Properties{dd::GenericJoint<dart::math::SE3Space>::Properties(base)},
            body);
    }
  }

  static void touch(dd::BodyNode* body, const dd::ShapePtr& shape, const Eigen::Vector3d& p,
                    double restitution, double friction) {
    auto* node = body->createShapeNodeWith<dd::CollisionAspect, dd::DynamicsAspect>(shape);
    node->setRelativeTranslation(p);
    node->getDynamicsAspect()->setRestitutionCoeff(restitution);
    node->getDynamicsAspect()->setFrictionCoeff(friction);
  }

  /// Adds a plane as the top of a wide box, once per plane.
  void add(const Ground& g) {
    if (g.radius > 0)
      touch(bodies_[g.centre.link], std::make_shared<dd::SphereShape>(g.radius), g.centre.point,
            g.restitution, g.friction);
    else
      touch(bodies_[g.centre.link], std::make_shared<dd::BoxShape>(g.size), g.centre.point, g.restitution,
            g.friction);
    for (const Ground& before : tree_.grounds) {
      if (&before.on == &g.on) break;
      if (before.normal == g.normal && before.on == g.on) return;
    }
    const auto plane = dd::Skeleton::create("plane" + std::to_string(world_->getNumSkeletons()));
    dd::WeldJoint::Properties weld;
    weld.mT_ParentBodyToJoint = place(rotation_between(Eigen::Vector3d::UnitZ(), g.normal), g.on);
    touch(plane->createJointAndBodyNodePair<dd::WeldJoint>(nullptr, weld).second,
          std::make_shared<dd::BoxShape>(Eigen::Vector3d(1000, 1000, 10)), {0, 0, -5}, 1, 1e3);
    world_->addSkeleton(plane);
  }

  static Eigen::Matrix3d turn(const std::vector<double>& q, std::size_t i) {
    return Eigen::Quaterniond(q[i], q[i + 1], q[i + 2], q[i + 3]).toRotationMatrix();
  }
  static Eigen::Vector3d three(const std::vector<double>& x, std::size_t i) {
    return {x[i], x[i + 1], x[i + 2]};
  }

  // Velocities of a ball and of a free joint are those of the child, in its own axes.
  void set_start() {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const Link& link = tree_.links[i];
      dd::Joint* joint = bodies_[i]->getParentJoint();
      if (link.v.size() == 1) {
        joint->setPosition(0, link.q[0]);
        joint->setVelocity(0, link.v[0]);
      } else if (link.joint == Link::Joint::ball) {
        joint->setPositions(dd::BallJoint::convertToPositions(turn(link.q, 0)));
        joint->setVelocities(three(link.v, 0));
      } else {
        const Eigen::Matrix3d R = turn(link.q, 3);
        joint->setPositions(dd::FreeJoint::convertToPositions(place(R, three(link.q, 0))));
        Eigen::Vector6d v;
        v << three(link.v, 3), R.transpose() * three(link.v, 0);
        joint->setVelocities(v);
      }
    }
    skeleton_->clearExternalForces();
    skeleton_->clearInternalForces();
    world_->getConstraintSolver()->clearLastCollisionResult();
  }

  Eigen::Vector3d point(const At& at) const {
    return at.link < 0 ? at.point : bodies_[at.link]->getTransform() * at.point;
  }
  Eigen::Vector3d velocity(const At& at) const {
    return at.link < 0 ? Eigen::Vector3d(0, 0, 0) : bodies_[at.link]->getLinearVelocity(at.point);
  }

  void push() {
    for (const Spring& s : tree_.springs) {
      const Eigen::Vector3d d = point(s.a) - point(s.b);
      const double length = d.norm();
      const Eigen::Vector3d n = d / length;
      const Eigen::Vector3d f =
          -(s.stiffness * (length - s.rest) + s.damping * n.dot(velocity(s.a) - velocity(s.b))) * n;
      if (s.a.link >= 0) bodies_[s.a.link]->addExtForce(f, s.a.point, false, true);
      if (s.b.link >= 0) bodies_[s.b.link]->addExtForce(-f, s.b.point, false, true);
    }
    for (const Turn& t : tree_.turns) bodies_[t.link]->addExtTorque(t.torque, false);
  }

  bool note(Run& out) const {
    for (const dd::BodyNode* b : bodies_) {
      const Moving m{b->getTransform().linear(), b->getTransform().translation(), b->getAngularVelocity(),
                     b->getCOMLinearVelocity()};
      if (!m.p.allFinite() || !m.R.allFinite()) return false;
      out.links.push_back(m);
    }
    return true;
  }

  Tree tree_;
  dart::simulation::WorldPtr world_;
  dd::SkeletonPtr skeleton_ = dd::Skeleton::create("tree");
  std::vector<dd::BodyNode*> bodies_;
};

}  // namespace

Result<std::unique_ptr<Peer>> make_dart(const Tree& tree) {
  const auto held = with_held_points(tree);
  if (!held) return tl::unexpected(held.error());
  return std::make_unique<Dart>(*held);
}

}  // namespace borelli::peers
