// The same random tree for this engine and for MuJoCo. Needs MuJoCo.
#pragma once

#include "mujoco_model.hpp"

namespace borelli::test {

enum class Joints { hinges, balls, mixed, free };

inline std::string numbers(const Eigen::VectorXd& v) {
  std::string out;
  for (double x : v) out += fmt::format("{:.17g} ", x);
  return out;
}

/// A random tree as a scene and as MJCF.
struct Twin {
  Scene scene;
  std::string xml;
};

class TwinMaker {
 public:
  TwinMaker(unsigned seed, Joints joints, int count) : random_(seed), joints_(joints), count_(count) {
    for (int i = 0; i < count; ++i) {
      const int parent = i == 0 ? -1 : random_.integer(std::max(0, i - 3), i - 1);
      parents_.push_back(parent);
      bodies_.push_back(make_body(i, parent));
    }
  }

  Twin make() {
    twin_.xml =
        "<mujoco><compiler angle='radian' inertiafromgeom='false'/><option gravity='0 0 -9.81'>"
        "<flag contact='disable' constraint='disable'/></option><worldbody>";
    write(-1);
    twin_.xml += "</worldbody></mujoco>";
    return twin_;
  }

 private:
  // coordinates must come in MuJoCo's order, depth first: so the scene's solids are added as they are written
  void write(int parent) {
    for (int i = 0; i < count_; ++i) {
      if (parents_[i] != parent) continue;
      twin_.scene.solids.push_back(bodies_[i].first);
      twin_.xml += bodies_[i].second;
      write(i);
      twin_.xml += "</body>";
    }
  }

  std::pair<Solid, std::string> make_body(int i, int parent) {
    const std::string name = fmt::format("b{}", i);
    const Random::Principal own = random_.inertia();
    Pose X{rotation_matrix(random_.turn()), random_.vector(0.5)};
    const bool floats = joints_ == Joints::free && i == 0;
    if (floats) X = Pose{};
    std::string xml =
        fmt::format("<body name='{}' pos='{}' quat='{}'>", name, numbers(X.p), numbers(quaternion(X.R)));
    std::vector<Switch> switches{fixed(X.p, X.R)};
    if (floats) {
      xml += "<freejoint/>";
      switches = free_switches(name);
    } else {
      add_joints(name, switches, xml);
    }
    // by principal axes: MuJoCo's own diagonalisation of a full tensor is good to 1e-9 only
    xml += fmt::format("<inertial pos='{}' quat='{}' mass='{:.17g}' diaginertia='{}'/>", numbers(own.centre),
                       numbers(own.axes), own.mass, numbers(own.moments));
    return {solid(name, parent < 0 ? "world" : fmt::format("b{}", parent), switches, {own.inertial()}), xml};
  }

  void add_joints(const std::string& name, std::vector<Switch>& switches, std::string& xml) {
    int kind = joints_ == Joints::hinges ? 0 : joints_ == Joints::balls ? 1 : random_.integer(0, 3);
    if (joints_ == Joints::free) kind = random_.integer(0, 1);
    if (kind == 1) {
      switches.push_back(ball(name));
      xml += "<joint type='ball'/>";
      return;
    }
    const int hinges = kind == 2 ? 2 : kind == 3 ? 0 : 1, slides = kind >= 2 ? 1 : 0;
    for (int j = 0; j < slides + hinges; ++j) {
      const Vector3d axis = random_.direction();
      const std::string coordinate = fmt::format("{}.{}", name, j);
      switches.push_back(j < slides ? slide(coordinate, axis) : hinge(coordinate, axis));
      xml += fmt::format("<joint type='{}' axis='{}'/>", j < slides ? "slide" : "hinge", numbers(axis));
    }
  }

  Random random_;
  Joints joints_;
  int count_;
  std::vector<int> parents_;
  std::vector<std::pair<Solid, std::string>> bodies_;
  Twin twin_;
};

}  // namespace borelli::test
