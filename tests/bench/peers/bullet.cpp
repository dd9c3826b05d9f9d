// Bullet's multibody (Featherstone), in double precision: built from the tree without colliders and stepped
// by its own world. Its link frames are at the gravity centres, along the principal axes.
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <BulletDynamics/Featherstone/btMultiBodyPoint2Point.h>
#include <btBulletDynamicsCommon.h>

#include <Eigen/Geometry>

#include "peer.hpp"

namespace borelli::peers {
namespace {

using Eigen::Matrix3d, Eigen::Vector3d;

btVector3 vec(const Vector3d& v) { return {v[0], v[1], v[2]}; }
Vector3d vec(const btVector3& v) { return {v[0], v[1], v[2]}; }
btQuaternion quat(const Matrix3d& R) {
  const Eigen::Quaterniond q(R);
  return {q.x(), q.y(), q.z(), q.w()};
}
Matrix3d matrix(const btMatrix3x3& m) {
  Matrix3d R;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) R(r, c) = m[r][c];
  return R;
}

/// A world with the tree in it.
class World {
 public:
  World(const Tree& tree, bool rk4) : tree_(tree) {
    world_.setGravity(vec(tree.gravity));
    world_.getSolverInfo().m_numIterations = 200;
    world_.getSolverInfo().m_globalCfm = 0;
    places_.resize(tree.links.size());
    for (std::size_t i = 0; i < tree.links.size(); ++i)
      if (tree.links[i].parent < 0) add_tree(int(i), rk4);
    // Bullet ignores constraints between multibodies without colliders unless all are in one island.
    world_.getSimulationIslandManager()->setSplitIslands(!tree.held.empty());
    if (!tree.held.empty() && tree.grounds.empty())
      for (std::size_t k = 0; k < tree.links.size(); ++k) add_collider_of(k, new btEmptyShape, 0, 0, 4, 0);
    for (const Ground& g : tree.grounds) add_ground(g);
    reset();
    for (const Held& h : tree.held) hold(h);
  }
  ~World() {
    for (auto& c : colliders_) world_.removeCollisionObject(c.get());
    for (auto& c : constraints_) world_.removeMultiBodyConstraint(c.get());
    for (auto& body : bodies_) world_.removeMultiBody(body.get());
  }
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  void reset() {
    for (std::size_t i = 0; i < tree_.links.size(); ++i) set_start(i);
    for (auto& body : bodies_) place(*body);
  }

  void step(double h) {
    push();
    world_.stepSimulation(h, 0);
  }

  bool note(Run& out) {
    std::vector<Vector3d> omega(places_.size()), velocity(places_.size());
    for (auto& body : bodies_) {
      place(*body);
      const int n = body->getNumLinks() + 1;
      btAlignedObjectArray<btVector3> w, v;
      w.resize(n), v.resize(n);
      body->compTreeLinkVelocities(&w[0], &v[0]);
      for (std::size_t i = 0; i < places_.size(); ++i) {
        if (places_[i].body != body.get()) continue;
        const Matrix3d R = frame(i);
        omega[i] = R * vec(w[places_[i].index + 1]);
        velocity[i] = R * vec(v[places_[i].index + 1]);
      }
    }
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const Matrix3d R = frame(i) * tree_.links[i].principal.transpose();
      const Vector3d c = vec(transform(i).getOrigin());
      if (!R.allFinite() || !c.allFinite()) return false;
      out.links.push_back({R, c - R * tree_.links[i].centre, omega[i], velocity[i]});
    }
    return true;
  }

 private:
  struct Place {
    btMultiBody* body = nullptr;
    int index = -1;  ///< link number in the multibody; -1: its base
  };

  /// Adds the links of one root. The base is the root if it is free, else the world.
  void add_tree(int root, bool rk4) {
    const bool floats = tree_.links[root].joint == Link::Joint::free;
    std::vector<int> links;
    std::vector<char> mine(tree_.links.size());
    mine[root] = 1;
    for (std::size_t i = root; i < tree_.links.size(); ++i) {
      const int parent = tree_.links[i].parent;
      if (parent >= 0 && mine[parent]) mine[i] = 1;
      if (mine[i] && !(floats && int(i) == root)) links.push_back(int(i));
    }
    const Link& base = tree_.links[root];
    bodies_.push_back(std::make_unique<btMultiBody>(int(links.size()), floats ? base.mass : 0,
                                                    floats ? vec(base.moments) : btVector3(0, 0, 0), !floats,
                                                    false));
    btMultiBody& body = *bodies_.back();
    if (floats) places_[root] = {&body, -1};
    for (std::size_t k = 0; k < links.size(); ++k) {
      places_[links[k]] = {&body, int(k)};
      join(body, int(k), tree_.links[links[k]]);
    }
    body.finalizeMultiDof();
    body.setLinearDamping(0);
    body.setAngularDamping(0);
    body.setUseGyroTerm(true);
    body.setMaxCoordinateVelocity(1e30);
    body.setMaxAppliedImpulse(1e30);
    body.useRK4Integration(rk4);
    world_.addMultiBody(&body);
  }

  void join(btMultiBody& body, int k, const Link& link) {
    const bool on_world = link.parent < 0;
    const Matrix3d parent = on_world ? Matrix3d::Identity() : tree_.links[link.parent].principal;
    const Vector3d centre = on_world ? Vector3d(0, 0, 0) : tree_.links[link.parent].centre;
    const btQuaternion turn = quat((parent.transpose() * link.R * link.principal).transpose());
    const btVector3 to_pivot = vec(Vector3d(parent.transpose() * (link.p - centre)));
    const btVector3 to_centre = vec(Vector3d(link.principal.transpose() * link.centre));
    const btVector3 axis = vec(Vector3d(link.principal.transpose() * link.axis));
    const int above = on_world ? -1 : places_[link.parent].index;
    const btVector3 moments = vec(link.moments);
    if (link.joint == Link::Joint::hinge)
      body.setupRevolute(k, link.mass, moments, above, turn, axis, to_pivot, to_centre, true);
    else if (link.joint == Link::Joint::slide)
      body.setupPrismatic(k, link.mass, moments, above, turn, axis, to_pivot, to_centre, true);
    else
      body.setupSpherical(k, link.mass, moments, above, turn, to_pivot, to_centre, true);
  }

  void set_start(std::size_t i) {
    const Link& link = tree_.links[i];
    auto& [body, k] = places_[i];
    const std::size_t ball = link.joint == Link::Joint::free ? 3 : 0;
    if (link.v.size() == 1) {
      body->setJointPos(k, link.q[0]);
      body->setJointVel(k, link.v[0]);
      return;
    }
    const Vector3d own(link.v[ball], link.v[ball + 1], link.v[ball + 2]);
    const Eigen::Quaterniond q(link.q[ball], link.q[ball + 1], link.q[ball + 2], link.q[ball + 3]);
    if (ball == 0) {  // in the principal axes
      const Vector3d axis = link.principal.transpose() * q.vec(), omega = link.principal.transpose() * own;
      const double position[] = {axis[0], axis[1], axis[2], q.w()};
      body->setJointPosMultiDof(k, position);
      body->setJointVelMultiDof(k, omega.data());
      return;
    }
    const Matrix3d R = link.R * q.toRotationMatrix();
    const Vector3d omega = R * own, arm = R * link.centre;
    const Vector3d p = link.R * Vector3d(link.q[0], link.q[1], link.q[2]) + link.p + arm;
    body->setBaseWorldTransform(btTransform(quat(R * link.principal), vec(p)));
    body->setBaseOmega(vec(omega));
    body->setBaseVel(vec(Vector3d(link.R * Vector3d(link.v[0], link.v[1], link.v[2]) + omega.cross(arm))));
  }

  static void place(btMultiBody& body) {
    btAlignedObjectArray<btQuaternion> turns;
    btAlignedObjectArray<btVector3> places;
    body.forwardKinematics(turns, places);
    body.updateCollisionObjectWorldTransforms(turns, places);
  }

  void add_collider(std::unique_ptr<btCollisionObject> object, btCollisionShape* shape, double restitution,
                    double friction, int group, int mask) {
    shapes_.emplace_back(shape);
    object->setCollisionShape(shape);
    object->setRestitution(restitution);
    object->setFriction(friction);
    world_.addCollisionObject(object.get(), group, mask);
    colliders_.push_back(std::move(object));
  }

  void add_collider_of(std::size_t link, btCollisionShape* shape, double restitution, double friction,
                       int group, int mask) {
    auto& [body, k] = places_[link];
    auto collider = std::make_unique<btMultiBodyLinkCollider>(body, k);
    if (k < 0)
      body->setBaseCollider(collider.get());
    else
      body->getLink(k).m_collider = collider.get();
    add_collider(std::move(collider), shape, restitution, friction, group, mask);
  }

  /// Adds a plane for each form; a link has one form at most (make_bullet checks).
  void add_ground(const Ground& g) {
    world_.getSolverInfo().m_restitutionVelocityThreshold = 1e-6;
    const Link& link = tree_.links[g.centre.link];
    if (g.radius > 0)
      shapes_.push_back(std::make_unique<btSphereShape>(g.radius));
    else
      shapes_.push_back(std::make_unique<btBoxShape>(vec(Vector3d(0.5 * g.size))));
    auto* compound = new btCompoundShape;
    compound->addChildShape(btTransform(quat(link.principal.transpose()), pivot(g.centre)),
                            shapes_.back().get());
    add_collider_of(g.centre.link, compound, g.restitution, g.friction, 2, 1);
    for (const Ground& before : tree_.grounds) {
      if (&before.on == &g.on) break;
      if (before.normal == g.normal && before.on == g.on) return;
    }
    add_collider(std::make_unique<btCollisionObject>(),
                 new btStaticPlaneShape(vec(g.normal), g.normal.dot(g.on)), 1, 1, 1, 2);
  }

  btTransform transform(std::size_t i) const {
    const auto& [body, k] = places_[i];
    return k < 0 ? body->getBaseWorldTransform() : body->getLink(k).m_cachedWorldTransform;
  }
  Matrix3d frame(std::size_t i) const { return matrix(transform(i).getBasis()); }

  /// From the link's gravity centre, along its principal axes.
  btVector3 pivot(const At& at) const {
    const Link& link = tree_.links[at.link];
    return vec(Vector3d(link.principal.transpose() * (at.point - link.centre)));
  }

  void hold(const Held& h) {
    const At& a = h.a.link < 0 ? h.b : h.a;
    const At& b = h.a.link < 0 ? h.a : h.b;
    const Place& on = places_[a.link];
    if (b.link < 0)
      constraints_.push_back(std::make_unique<btMultiBodyPoint2Point>(
          on.body, on.index, static_cast<btRigidBody*>(nullptr), pivot(a), vec(b.point)));
    else
      constraints_.push_back(std::make_unique<btMultiBodyPoint2Point>(
          on.body, on.index, places_[b.link].body, places_[b.link].index, pivot(a), pivot(b)));
    constraints_.back()->setMaxAppliedImpulse(1e30);
    world_.addMultiBodyConstraint(constraints_.back().get());
  }

  void push_at(int link, const Vector3d& force, const Vector3d& arm) {
    const auto& [body, k] = places_[link];
    const btVector3 f = vec(force), m = vec(Vector3d(arm.cross(force)));
    if (k < 0)
      body->addBaseForce(f), body->addBaseTorque(m);
    else
      body->addLinkForce(k, f), body->addLinkTorque(k, m);
  }

  void push() {
    for (const JointSpring& s : tree_.joint_springs) {
      const auto& [body, k] = places_[s.link];
      body->addJointTorque(k,
                           -s.stiffness * (body->getJointPos(k) - s.rest) - s.damping * body->getJointVel(k));
    }
    for (const Turn& t : tree_.turns) {
      const auto& [body, k] = places_[t.link];
      k < 0 ? body->addBaseTorque(vec(t.torque)) : body->addLinkTorque(k, vec(t.torque));
    }
    if (tree_.springs.empty()) return;
    for (auto& body : bodies_) place(*body);
    for (const Spring& s : tree_.springs) {
      const auto centre = [&](const At& at) {
        return at.link < 0 ? Vector3d(0, 0, 0) : vec(transform(at.link).getOrigin());
      };
      const auto point = [&](const At& at) {
        return at.link < 0 ? at.point : Vector3d(centre(at) + frame(at.link) * vec(pivot(at)));
      };
      const Vector3d a = point(s.a), b = point(s.b), d = a - b;
      const Vector3d f = -s.stiffness * (d.norm() - s.rest) * d.normalized();
      if (s.a.link >= 0) push_at(s.a.link, f, a - centre(s.a));
      if (s.b.link >= 0) push_at(s.b.link, -f, b - centre(s.b));
    }
  }

  const Tree& tree_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btMultiBodyConstraintSolver solver_;
  btMultiBodyDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  std::vector<std::unique_ptr<btMultiBody>> bodies_;
  std::vector<std::unique_ptr<btMultiBodyConstraint>> constraints_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btCollisionObject>> colliders_;
  std::vector<Place> places_;  ///< per link
};

class Bullet : public Peer {
 public:
  explicit Bullet(const Tree& tree)
      : tree_(tree), worlds_{std::make_unique<World>(tree_, false), std::make_unique<World>(tree_, true)} {}

  std::string version() const override { return "Bullet " + std::to_string(btGetVersion()); }
  std::vector<Method> methods() const override { return {{"Bullet"}, {"Bullet RK4"}}; }

  Result<Run> run(std::size_t method, double step, double, const std::vector<double>& times,
                  const std::function<bool()>& go_on) override {
    if (!tree_.grounds.empty())
      worlds_[method] = std::make_unique<World>(tree_, method == 1);  // a new world, without old contacts
    World& world = *worlds_[method];
    world.reset();
    Run out;
    double t = 0;
    for (const double next : times) {
      const long steps = steps_in(next - t, step);
      for (long i = 0; i < steps; ++i) {
        world.step((next - t) / double(steps));
        if (i % 64 == 0 && !go_on()) return failure("", "took too long");
      }
      out.evaluations += steps * (method == 1 ? 4 : 1);
      t = next;
      if (!world.note(out)) return failure("", "numbers that are not finite at t = " + std::to_string(t));
    }
    return out;
  }

 private:
  Tree tree_;
  std::unique_ptr<World> worlds_[2];
};

}  // namespace

Result<std::unique_ptr<Peer>> make_bullet(const Tree& tree) {
  const auto held = with_held_points(tree);
  if (!held) return tl::unexpected(held.error());
  for (const Spring& s : tree.springs)
    if (s.damping != 0) return failure("Bullet", "has no twin here of a damped spring between points");
  for (const Link& link : tree.links)
    if (link.joint == Link::Joint::free && link.parent >= 0)
      return failure("Bullet", "has no twin of a free joint on a moving solid");
  for (std::size_t i = 0; i < tree.grounds.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (tree.grounds[i].centre.link == tree.grounds[k].centre.link)
        return failure("Bullet", "has no twin here of several forms of one solid");
  if (!tree.grounds.empty() && !held->held.empty())
    return failure("Bullet", "has no twin here of held points over a ground");
  return std::make_unique<Bullet>(*held);
}

}  // namespace borelli::peers
