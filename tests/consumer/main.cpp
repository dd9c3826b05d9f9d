// Uses public names of two folders, and has Eigen's types made here and freed there and the other way about;
// answers 0 when they do what they say.
#include <cmath>
#include <cstdio>
#include <numbers>

#include "dynamics/ensemble.hpp"
#include "dynamics/evaluate.hpp"
#include "dynamics/linearize.hpp"
#include "dynamics/shape.hpp"
#include "dynamics/simulate.hpp"
#include "segmentation/cuts.hpp"

namespace {

bool fails(const char* what) {
  std::fprintf(stderr, "%s\n", what);
  return false;
}

bool near(double x, double expected, double room) { return std::abs(x - expected) < room; }

// A bar of 1 kg and 1 m on a hinge, hanging a little aside: it swings with (3 g / 2 l)^1/2.
borelli::Scene pendulum(double angle) {
  borelli::Scene scene;
  borelli::Solid bar;
  bar.name = "bar";
  borelli::Switch hinge;
  hinge.kind = borelli::Rotation{Eigen::Vector3d::UnitY()};
  hinge.q = {angle};
  bar.switches = {hinge};
  borelli::Inertial inertial;
  inertial.mass = 1;
  inertial.centre = {0, 0, -0.5};
  inertial.tensor = Eigen::Vector3d(1. / 12, 1. / 12, 0).asDiagonal();
  bar.inertials = {inertial};
  scene.solids.push_back(bar);
  scene.simulation.end_time = 1;
  return scene;
}

bool dynamics_works() {
  const auto system = borelli::compile(pendulum(0.5));
  if (!system) return fails(system.error().message().c_str());
  borelli::System copy = *system;  // its types are copied, moved and freed here
  const borelli::System moved = std::move(copy);
  const auto now = borelli::evaluate(moved, moved.initial);
  if (!now || !near(now->acceleration[0], -1.5 * 9.81 * std::sin(0.5), 1e-12)) return fails("evaluate");
  borelli::State hanging{0, Eigen::VectorXd::Zero(1), Eigen::VectorXd::Zero(1)};
  const auto linear = borelli::linearize(moved, hanging);
  if (!linear || linear->modes.empty()) return fails("linearize");
  auto motion = borelli::simulate(moved);
  if (!motion || !motion->certificate.trusted) return fails("simulate");
  const borelli::Trajectory kept = *motion;
  const auto members = std::vector<borelli::Member>(20, {moved.initial, {}, {}});
  const auto endings = borelli::simulate_ensemble(moved, members, moved.settings, 1);
  if (!endings) return fails(endings.error().message().c_str());
  for (const auto& ending : *endings)
    if (ending.state.q.size() != 1 || !near(ending.state.q[0], kept.q(kept.q.rows() - 1, 0), 1e-6))
      return fails("simulate_ensemble");
  // products in Eigen's blocks, whose code here and in the library has the same names
  const Eigen::MatrixXd a = Eigen::MatrixXd::Constant(300, 300, 2.);
  if (!near((a * a)(299, 299), 1200, 1e-9)) return fails("product");
  return true;
}

}  // namespace

int main() {
  const bool no_cuts = borelli::cut_planes({}).empty();
  const auto ball = borelli::inertial_of_density({.form = borelli::Sphere{0.5}}, 1000);
  const bool weighs_right = ball && std::abs(ball->mass - 1000 * std::numbers::pi / 6) < 1e-9;
  return no_cuts && weighs_right && dynamics_works() ? 0 : 1;
}
