// Uses public names of two folders. Eigen's types cross the library's border in both directions: allocated on
// one side, freed on the other. Exit code 0: every check holds.
#include <cmath>
#include <cstdio>
#include <numbers>

#include "dynamics/constraints/linearize.hpp"
#include "dynamics/equations/evaluate.hpp"
#include "dynamics/run/ensemble.hpp"
#include "dynamics/run/simulate.hpp"
#include "dynamics/scene/shape.hpp"
#include "segmentation/vocabulary/cuts.hpp"

namespace {

bool fail(const char* what) {
  std::fprintf(stderr, "%s\n", what);
  return false;
}

bool near(double x, double expected, double tolerance) { return std::abs(x - expected) < tolerance; }

// A bar of 1 kg and 1 m that hangs on a hinge, turned by `angle` (rad).
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
  if (!system) return fail(system.error().message().c_str());
  borelli::System copy = *system;  // copied, moved and freed on this side
  const borelli::System moved = std::move(copy);
  const auto now = borelli::evaluate(moved, moved.initial);
  if (!now || !near(now->acceleration[0], -1.5 * 9.81 * std::sin(0.5), 1e-12)) return fail("evaluate");
  borelli::State hanging{0, Eigen::VectorXd::Zero(1), Eigen::VectorXd::Zero(1)};
  const auto linear = borelli::linearize(moved, hanging);
  if (!linear || linear->modes.empty()) return fail("linearize");
  auto motion = borelli::simulate(moved);
  if (!motion || !motion->certificate.trusted) return fail("simulate");
  const borelli::Trajectory kept = *motion;
  const auto members = std::vector<borelli::Member>(20, {moved.initial, {}, {}});
  const auto endings = borelli::simulate_ensemble(moved, members, moved.settings, 1);
  if (!endings) return fail(endings.error().message().c_str());
  for (const auto& ending : *endings)
    if (ending.state.q.size() != 1 || !near(ending.state.q[0], kept.q(kept.q.rows() - 1, 0), 1e-6))
      return fail("simulate_ensemble");
  // Eigen's blocked product: its functions exist under the same names here and in the library
  const Eigen::MatrixXd a = Eigen::MatrixXd::Constant(300, 300, 2.);
  if (!near((a * a)(299, 299), 1200, 1e-9)) return fail("product");
  return true;
}

}  // namespace

int main() {
  const bool no_cuts = borelli::cut_planes({}).empty();
  const auto ball = borelli::inertial_of_density({.form = borelli::Sphere{0.5}}, 1000);
  const bool weighs_right = ball && std::abs(ball->mass - 1000 * std::numbers::pi / 6) < 1e-9;
  return no_cuts && weighs_right && dynamics_works() ? 0 : 1;
}
