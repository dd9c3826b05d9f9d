// Random scenes of elements that MJCF has, for tests of the model writers.
#pragma once

#include "scenes.hpp"

namespace borelli::test {

/// The orientation of a ball at which MuJoCo's quaternion is the identity (its spring's rest, else its
/// start), and the rotation from the ball's frame to the solid's frame, which MuJoCo uses.
struct BallFrame {
  Quaternion zero, after;
};
using BallFrames = std::map<std::string, BallFrame>;  ///< by coordinate

/// A state in MuJoCo's terms: each ball's quaternion is relative to its zero, in the solid's axes. `axes`
/// maps velocities of the scene to MuJoCo's.
struct InSolidAxes {
  Eigen::VectorXd q, v;
  Eigen::MatrixXd axes;

  InSolidAxes(const System& system, const State& state, const BallFrames& balls)
      : q(state.q), axes(Eigen::MatrixXd::Identity(system.nv, system.nv)) {
    for (const CoordinateInfo& info : system.coordinates) {
      const auto ball = balls.find(info.name);
      if (ball == balls.end()) continue;
      const auto& [zero, after] = ball->second;
      const Quaternion turned = product(conjugate(zero), state.q.segment<4>(info.q_index));
      q.segment<4>(info.q_index) = product(product(conjugate(after), turned), after);
      axes.block<3, 3>(info.v_index, info.v_index) = rotation_matrix(after).transpose();
    }
    v = axes * state.v;
  }
};

/// A random tree with a free root and solids on hinges, slides, balls or several of these, between constant
/// poses. It has ranges, springs, dampers, markers and a moving state.
class WritableScene {
 public:
  struct Holds {
    bool springs = true;  ///< stiffness, armatures, point springs, which URDF lacks
    bool balls = true;    ///< besides that of the free root
    bool free_root = true;
  };

  WritableScene(unsigned seed, int solids, Holds holds) : random_(seed), holds_(holds) {
    scene.name = fmt::format("random {}", seed);
    if (holds.springs) scene.gravity = random_.vector(10);
    for (int i = 0; i < solids; ++i) add_solid(i);
    if (holds.springs) add_point_springs(solids);
    for (int i = 0; i < 3; ++i)
      scene.markers.push_back(
          {fmt::format("m{}", i), {name(random_.integer(0, solids - 1)), random_.vector(1)}});
  }

  Scene scene;
  BallFrames balls;

 private:
  static std::string name(int i) { return fmt::format("s{}", i); }
  Matrix3d turn() { return rotation_matrix(random_.turn()); }
  // at least 0.3 m long, so that every coordinate moves some inertia
  Vector3d arm() { return random_.number(0.3, 0.8) * random_.direction(); }

  void add_solid(int i) {
    std::vector<Switch> switches;
    const bool floats = i == 0 && holds_.free_root;
    if (floats) {
      switches = free_switches("root");
      for (Switch& one : switches) start(one);
      balls.clear();  // a free joint's quaternion is relative to the world's axes
      scene.solids.push_back(solid(name(0), "world", switches, {heavy()}));
      return;
    }
    const std::string parent = i == 0 ? "world" : name(random_.integer(std::max(0, i - 3), i - 1));
    switches.push_back(fixed(arm(), turn()));
    const int first = holds_.balls ? 0 : 3;
    const int recipe = random_.integer(first, 8);
    add_joints(i, recipe, switches);
    const bool massless = recipe == 8;  // a frame that carries a welded solid
    std::vector<Inertial> inertials;
    if (!massless) inertials = {heavy(), random_.inertia().inertial()};
    scene.solids.push_back(solid(name(i), parent, switches, inertials));
    if (massless)
      scene.solids.push_back(solid(name(i) + " welded", name(i), {fixed(arm(), turn())}, {heavy()}));
    if (recipe == 0)
      balls.at(fmt::format("c{}.0", i)).after =
          quaternion(std::get<Fixed>(scene.solids.back().switches[2].kind).X_AB.R);
    if (recipe == 0 && holds_.springs) add_ball_spring(i, parent);
  }

  Inertial heavy() {
    Inertial out = random_.inertia().inertial();
    out.tensor += 0.05 * Matrix3d::Identity();
    return out;
  }

  void add_joints(int i, int recipe, std::vector<Switch>& switches) {
    auto next = [&, count = 0](int kind) mutable {  // 0: hinge, 1: slide, 2: ball
      const std::string coordinate = fmt::format("c{}.{}", i, count++);
      Switch one = kind == 0   ? hinge(coordinate, random_.direction())
                   : kind == 1 ? slide(coordinate, random_.direction())
                               : ball(coordinate);
      start(one);
      if (kind < 2) add_scalar_parts(one);
      switches.push_back(one);
    };
    const auto shift = [&] { switches.push_back(fixed(arm())); };
    const auto place = [&] { switches.push_back(fixed(arm(), turn())); };
    switch (recipe) {
      case 0:
        next(2), place();
        break;
      case 1:
        next(2), place(), next(0), place();
        break;  // a ball, then a hinge at a distance
      case 2:
        next(0), place(), next(2), shift(), next(1);
        break;  // a ball, then a slide
      case 3:
        next(0), place();
        break;
      case 4:
        next(1);
        break;
      case 5:
        next(0), place(), next(0), shift();
        break;
      case 6:
        next(1), next(0), place();
        break;
      case 7:
        break;  // welded
      default:
        next(0), shift();
        break;
    }
  }

  void start(Switch& one) {
    const Quaternion q = random_.turn();
    const bool is_ball = std::holds_alternative<Ball>(one.kind);
    one.q = is_ball ? std::vector{q[0], q[1], q[2], q[3]} : std::vector{random_.number(-1, 1)};
    one.v.clear();
    for (int i = 0; i < (is_ball ? 3 : 1); ++i) one.v.push_back(random_.number(-2, 2));
    if (is_ball) balls[one.coordinate] = {q, identity_quaternion()};
  }

  void add_scalar_parts(Switch& one) {
    if (random_.integer(0, 2) == 0) one.ranges = {{one.q[0] - random_.number(0, 1), one.q[0] + 2}};
    if (random_.integer(0, 1))
      scene.efforts.push_back({"damper of " + one.coordinate, CoordinateSpring{{one.coordinate}, 0, 0.3, 0}});
    if (!holds_.springs) return;
    if (random_.integer(0, 1)) one.armature = 0.1;
    if (random_.integer(0, 1))
      scene.efforts.push_back(
          {"spring of " + one.coordinate, CoordinateSpring{{one.coordinate}, 5, 0.1, random_.number(-1, 1)}});
    if (random_.integer(0, 2) == 0)
      scene.efforts.push_back({"control of " + one.coordinate,
                               PdController{{one.coordinate}, 7, 0.2, {constant(random_.number(-1, 1))}}});
  }

  // A torsion spring between the solid of one ball and its parent, at rest where the ball is `zero`.
  void add_ball_spring(int i, const std::string& parent) {
    const Solid& own = scene.solids.back();
    const Quaternion zero = random_.turn();
    balls.at(fmt::format("c{}.0", i)).zero = zero;
    const Matrix3d before = std::get<Fixed>(own.switches[0].kind).X_AB.R,
                   after = std::get<Fixed>(own.switches[2].kind).X_AB.R;
    const Matrix3d rest = before * rotation_matrix(zero) * after;
    TorsionSpring spring{{own.name}, {parent}, 3, 0.2, logarithm(quaternion(rest))};
    if (random_.integer(0, 1)) {  // the same, seen from the other end
      std::swap(spring.a, spring.b);
      spring.rest = -spring.rest;
    }
    scene.efforts.push_back({"ball spring of " + own.name, spring});
  }

  void add_point_springs(int solids) {
    for (int i = 0; i < 2; ++i)
      scene.efforts.push_back(
          {fmt::format("rope {}", i), PointSpring{{name(random_.integer(0, solids - 1)), random_.vector(1)},
                                                  {i == 0 ? "world" : name(0), random_.vector(2)},
                                                  20,
                                                  0.5,
                                                  0.4}});
  }

  Random random_;
  Holds holds_;
};

/// Indices of one system's coordinates in another with coordinates of the same names.
struct SameNames {
  std::vector<Eigen::Index> q, v;  ///< per position and velocity of `from`: its index in `to`

  SameNames(const System& from, const System& to) : q(std::size_t(from.nq)), v(std::size_t(from.nv)) {
    std::map<std::string, const CoordinateInfo*> known;
    for (const CoordinateInfo& info : to.coordinates) known[info.name] = &info;
    for (const CoordinateInfo& info : from.coordinates) {
      const auto found = known.find(info.name);
      if (found == known.end()) throw std::runtime_error("no coordinate " + info.name);
      for (int i = 0; i < info.q_size; ++i) q[std::size_t(info.q_index + i)] = found->second->q_index + i;
      for (int i = 0; i < info.v_size; ++i) v[std::size_t(info.v_index + i)] = found->second->v_index + i;
    }
  }
};

}  // namespace borelli::test
