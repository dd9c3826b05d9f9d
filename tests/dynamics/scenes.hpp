// Scenes that several tests share.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <random>

#include "dynamics/formats/scene_file.hpp"
#include "dynamics/run/simulate.hpp"
#include "tests/paths.hpp"

namespace borelli::test {

using Eigen::Matrix3d;
using Eigen::Vector3d;

inline Inertial inertial(double mass, const Vector3d& centre, const Vector3d& moments) {
  return {mass, centre, moments.asDiagonal()};
}

inline Switch fixed(const Vector3d& p, const Matrix3d& R = Matrix3d::Identity()) {
  return {.kind = Fixed{Pose{R, p}}, .coordinate = {}, .motion = {}, .q = {}, .v = {}, .ranges = {}};
}

inline Switch hinge(const std::string& name, const Vector3d& axis, double q = 0, double v = 0) {
  return {.kind = Rotation{axis}, .coordinate = name, .motion = {}, .q = {q}, .v = {v}, .ranges = {}};
}

inline Switch slide(const std::string& name, const Vector3d& axis, double q = 0, double v = 0) {
  return {.kind = Translation{axis}, .coordinate = name, .motion = {}, .q = {q}, .v = {v}, .ranges = {}};
}

inline Switch ball(const std::string& name, const Quaternion& q = identity_quaternion(),
                   const Vector3d& v = Vector3d::Zero()) {
  return {.kind = Ball{},
          .coordinate = name,
          .motion = {},
          .q = {q[0], q[1], q[2], q[3]},
          .v = {v[0], v[1], v[2]},
          .ranges = {}};
}

/// A switch driven by one function of time.
inline Switch driven(Switch one, const TimeFunction& f) {
  one.motion = Driven{{f}};
  one.q.clear();
  one.v.clear();
  return one;
}

inline Solid solid(const std::string& name, const std::string& parent, std::vector<Switch> switches,
                   std::vector<Inertial> inertials) {
  Solid out;
  out.name = name;
  out.parent = parent;
  out.switches = std::move(switches);
  out.inertials = std::move(inertials);
  return out;
}

/// Three translations and a ball, for a solid free in space; linear velocity in world axes, angular velocity
/// in body axes.
inline std::vector<Switch> free_switches(const std::string& name) {
  return {slide(name + ".x", Vector3d::UnitX()), slide(name + ".y", Vector3d::UnitY()),
          slide(name + ".z", Vector3d::UnitZ()), ball(name + ".turn")};
}

/// The link of the benchmark scenes: 1 kg, 1 m, hanging from its hinge.
inline Inertial link() { return inertial(1, {0, 0, -0.5}, {1.0 / 12, 1.0 / 12, 0.001}); }

/// n links in a row; hinges about y, or about y and x in turn.
inline Scene chain(int n, bool alternating, double start = 0) {
  Scene scene;
  scene.name = fmt::format("chain of {}", n);
  for (int i = 0; i < n; ++i) {
    const Vector3d axis = alternating && i % 2 ? Vector3d::UnitX() : Vector3d::UnitY();
    std::vector<Switch> switches;
    if (i > 0) switches.push_back(fixed({0, 0, -1}));
    switches.push_back(hinge(fmt::format("h{}", i), axis, start));
    scene.solids.push_back(
        solid(fmt::format("l{}", i), i ? fmt::format("l{}", i - 1) : "world", switches, {link()}));
  }
  return scene;
}

/// n independent bars.
inline Scene bars(int n) {
  Scene scene;
  scene.name = fmt::format("{} bars", n);
  for (int i = 0; i < n; ++i)
    scene.solids.push_back(solid(fmt::format("b{}", i), "world",
                                 {fixed({2.0 * i, 0, 0}), hinge(fmt::format("h{}", i), Vector3d::UnitY())},
                                 {link()}));
  return scene;
}

/// The paper's figure 1, with the masses of the benchmark scene "roundabout": a turntable free about z at 10
/// rad/s, and two arms hinged on it about y.
inline Scene roundabout() {
  Scene scene;
  scene.name = "roundabout";
  const Inertial arm = inertial(2, {0, 0, -0.25}, {1.0 / 24, 1.0 / 24, 0.0005});
  scene.solids = {solid("s1", "world", {hinge("dof1", Vector3d::UnitZ(), 0, 10)},
                        {inertial(10, {0, 0, 0}, {0.7, 0.7, 1.25})}),
                  solid("s2", "s1", {fixed({0.5, 0, 0}), hinge("dof2", Vector3d::UnitY(), 0.2)}, {arm}),
                  solid("s3", "s1", {fixed({-0.5, 0, 0}), hinge("dof3", Vector3d::UnitY(), -0.5)}, {arm})};
  return scene;
}

/// A wheel with a torsion spring of `stiffness` to the world.
inline Scene wheel(double stiffness, double speed) {
  Scene scene;
  scene.gravity.setZero();
  scene.solids = {solid("wheel", "world", {hinge("turn", Vector3d::UnitZ(), 0, speed)},
                        {inertial(1, {0, 0, 0}, {1, 1, 0.8})})};
  TorsionSpring spring;
  spring.a.solid = "wheel";
  spring.stiffness = stiffness;
  scene.efforts = {{"spring", spring}};
  return scene;
}

/// Rotations a, b and c about the z, y and z of one solid: at b = 0 the outer two share an axis, and
/// accelerations are undefined.
inline Scene aligning_turns() {
  Scene scene;
  scene.solids = {
      solid("s", "world",
            {hinge("a", Vector3d::UnitZ()), hinge("b", Vector3d::UnitY(), 1), hinge("c", Vector3d::UnitZ())},
            {inertial(1, {0, 0, 0}, {1, 2, 3})})};
  return scene;
}

/// Random numbers for scenes and states.
class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double number(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  int integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(engine_); }
  Vector3d vector(double size) { return {number(-size, size), number(-size, size), number(-size, size)}; }
  Vector3d direction() {
    for (;;) {
      const Vector3d v = vector(1);
      if (v.norm() > 0.1 && v.norm() < 1) return v.normalized();
    }
  }
  Quaternion turn() {
    const Vector3d axis = direction();
    const double angle = number(0, 3);
    Quaternion q;
    q << std::cos(angle / 2), std::sin(angle / 2) * axis;
    return q;
  }
  /// A physical inertial with all products of inertia, from the principal moments and axes of an ellipsoid.
  struct Principal {
    double mass;
    Vector3d centre, moments;
    Quaternion axes;
    Inertial inertial() const {
      const Matrix3d R = rotation_matrix(axes);
      return {mass, centre, R * moments.asDiagonal() * R.transpose()};
    }
  };
  Principal inertia() {
    const double mass = number(0.5, 3), a = number(0.05, 0.4), b = number(0.05, 0.4), c = number(0.05, 0.4);
    return {mass, vector(0.5), mass / 5 * Vector3d(b * b + c * c, a * a + c * c, a * a + b * b), turn()};
  }
  /// A state of the system: angles and lengths within 1, velocities within 2.
  State state(const System& system) {
    State state{.t = 0, .q = Eigen::VectorXd(system.nq), .v = Eigen::VectorXd(system.nv)};
    for (const CoordinateInfo& info : system.coordinates) {
      if (info.q_size == 4)
        state.q.segment<4>(info.q_index) = turn();
      else
        state.q[info.q_index] = number(-1, 1);
    }
    for (int i = 0; i < system.nv; ++i) state.v[i] = number(-2, 2);
    return state;
  }

 private:
  std::mt19937 engine_;
};

/// What a random tree may have besides hinges and slides.
struct Kinds {
  bool balls = false, drives = false;
};

/// Six solids in a random tree, with two switches each, and every third one driven if asked.
inline Scene random_tree(unsigned seed, Kinds kinds) {
  Random random(seed);
  Scene scene;
  const auto function = [&]() -> TimeFunction {
    if (random.integer(0, 1))
      return Polynomial{{random.number(-1, 1), random.number(-1, 1), random.number(-1, 1)}};
    return Sine{random.number(-1, 1), random.number(0.5, 2), random.number(-1, 1), random.number(-1, 1)};
  };
  for (int i = 0; i < 6; ++i) {
    std::vector<Switch> switches{fixed(random.vector(0.5), rotation_matrix(random.turn()))};
    for (int j = 0; j < 2; ++j) {
      const std::string name = fmt::format("c{}{}", i, j);
      // a ball goes with a slide, because a hinge at the same point would repeat one of its axes
      const int kind = i % 2 == 0 || !kinds.balls ? random.integer(0, 1) : j == 0 ? 1 : 2;
      Switch one = kind == 0   ? hinge(name, random.direction())
                   : kind == 1 ? slide(name, random.direction())
                               : ball(name);
      if (kinds.drives && (2 * i + j) % 3 == 1) {
        one.q.clear();
        one.v.clear();
        one.motion = kind == 2 ? Driven{{function(), function(), function()}} : Driven{{function()}};
      }
      switches.push_back(one);
    }
    scene.solids.push_back(solid(fmt::format("s{}", i),
                                 i ? fmt::format("s{}", random.integer(0, i - 1)) : "world", switches,
                                 {random.inertia().inertial()}));
  }
  return scene;
}

template <class T>
T need(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message());
  return std::move(*result);
}

inline System compiled(const Scene& scene) { return need(compile(scene)); }

inline SimulationSettings settings(const std::string& method, double end_time, double step,
                                   double tolerance = 1e-6) {
  SimulationSettings out;
  out.method = method;
  out.end_time = end_time;
  out.step = step;
  out.tolerance = tolerance;
  out.output_interval = end_time;
  return out;
}

inline Trajectory run(const System& system, const SimulationSettings& how) {
  return need(simulate(system, system.initial, how));
}

inline Trajectory run(const Scene& scene, const SimulationSettings& how) { return run(compiled(scene), how); }

/// A bead held by y = 0 and y = x z: on the line z = 0, except that at x = 0 it may leave along z.
inline Scene crossing(double speed, double push) {
  Scene scene;
  scene.gravity = {0, 0, push};
  scene.solids = {solid("bead", "world",
                        {slide("x", Vector3d::UnitX(), -0.5 * speed, speed), slide("y", Vector3d::UnitY()),
                         slide("z", Vector3d::UnitZ())},
                        {inertial(1, {0, 0, 0}, {0, 0, 0})})};
  FunctionConstraint saddle;
  saddle.coordinates = {{"x"}, {"y"}, {"z"}};
  saddle.function = [](double, const Eigen::VectorXd& x, FunctionDerivatives& h) {
    h.value = x[1] - x[0] * x[2];
    h.gradient << -x[2], 1, -x[0];
    h.hessian(0, 2) = h.hessian(2, 0) = -1;
  };
  scene.constraints = {{"level", CoordinateCoupling{{{"y"}}, {1}, constant(0)}}, {"saddle", saddle}};
  return scene;
}

/// Reads a scene of samples/.
inline Scene sample(const std::string& file) {
  return need(read_scene(source_folder() + "/samples/" + file));
}

/// A run by the scene's own settings, which must be trusted.
inline Trajectory run(const Scene& scene) {
  Trajectory out = need(simulate(compiled(scene)));
  EXPECT_TRUE(out.certificate.trusted) << scene.name << ": " << out.certificate.reason;
  return out;
}

/// The row of the trajectory's last time.
inline Eigen::VectorXd last(const Rows& rows) { return rows.row(rows.rows() - 1).transpose(); }

/// log2 of the factor by which an error falls when the step is halved.
inline double order(double coarse, double fine) { return std::log2(coarse / fine); }

}  // namespace borelli::test
