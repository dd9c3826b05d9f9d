#include "pipeline/paper/paper_scenes.hpp"

#include <fmt/core.h>

#include <numbers>
#include <stdexcept>

#include "dynamics/formats/scene_file.hpp"

namespace borelli {

namespace data {
extern const char* const roundabout;
extern const char* const shock;
}  // namespace data

namespace {

// Built-in scenes; tests read them, so an error here is a bug.
Scene built_in(const char* text, const char* name) {
  auto scene = parse_scene(text, name);
  if (!scene) throw std::logic_error(scene.error().message());
  return *scene;
}

// A bar that hangs from a hinge about y at `hinge` in its parent.
Solid bar(int number, const std::string& parent, const Eigen::Vector3d& hinge, double angle) {
  Solid solid;
  solid.name = fmt::format("bar {}", number);
  solid.parent = parent;
  if (hinge != Eigen::Vector3d::Zero())
    solid.switches.push_back({Fixed{{Eigen::Matrix3d::Identity(), hinge}}});
  Switch swing{Rotation{Eigen::Vector3d::UnitY()}, fmt::format("swing {}", number)};
  if (angle != 0) swing.q = {angle};
  solid.switches.push_back(swing);
  Inertial inertial;
  inertial.mass = 1;
  inertial.centre = {0, 0, -0.5};
  inertial.tensor.diagonal() << 1. / 12, 1. / 12, 0.001;
  solid.inertials = {inertial};
  return solid;
}

Scene ten_seconds(std::string name) {
  Scene scene;
  scene.name = std::move(name);
  scene.simulation.end_time = 10;
  scene.simulation.step = 0.001;
  return scene;
}

constexpr double level = std::numbers::pi / 2;

}  // namespace

Scene roundabout() { return built_in(data::roundabout, "roundabout.toml"); }

Scene shock() { return built_in(data::shock, "shock.toml"); }

Scene bars(int n) {
  Scene scene = ten_seconds(fmt::format("{} independent bars", n));
  for (int i = 1; i <= n; ++i) scene.solids.push_back(bar(i, world_name, {2. * (i - 1), 0, 0}, level));
  return scene;
}

Scene pendulum(int n) {
  Scene scene = ten_seconds(fmt::format("pendulum of {} bars", n));
  for (int i = 1; i <= n; ++i)
    scene.solids.push_back(bar(i, i == 1 ? world_name : fmt::format("bar {}", i - 1),
                               i == 1 ? Eigen::Vector3d(0, 0, 0) : Eigen::Vector3d(0, 0, -1),
                               i == 1 ? level : 0));
  return scene;
}

}  // namespace borelli
