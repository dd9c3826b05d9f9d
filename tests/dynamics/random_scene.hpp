// A random scene with all elements of scenes.
#pragma once

#include "scenes.hpp"

namespace borelli::test {

/// A random scene: one to three trees of solids, some welded, some without mass, with none to three switches
/// each (all kinds; free, driven, locked), springs, forces and (if asked) constraints.
class RandomScene {
 public:
  RandomScene(unsigned seed, int solids, bool constrained) : random_(seed) {
    for (int i = 0; i < solids; ++i) add_solid(i, solids);
    add_efforts(solids);
    if (constrained) add_constraints(solids);
  }
  Scene scene;

 private:
  TimeFunction function() {
    if (random_.integer(0, 1))
      return Polynomial{{random_.number(-1, 1), random_.number(-1, 1), random_.number(-1, 1)}};
    return Sine{random_.number(-1, 1), random_.number(0.5, 2), random_.number(-1, 1), random_.number(-1, 1)};
  }

  void add_solid(int i, int solids) {
    std::vector<Switch> switches;
    if (random_.integer(0, 3))
      switches.push_back(fixed(random_.vector(0.5), rotation_matrix(random_.turn())));
    // the last solid of each branch has mass, so that every coordinate moves mass
    const bool massless = i % 4 == 1 && i + 1 < solids;
    const bool welded = i % 5 == 3;
    const int count = welded ? 0 : massless ? 1 : random_.integer(1, 3);
    bool turned = false, balled = false;
    for (int j = 0; j < count; ++j) {
      const std::string name = fmt::format("c{}{}", i, j);
      int kind = random_.integer(0, 2);
      if (balled || (kind == 2 && turned)) kind = 1;  // no two rotations about one axis through one point
      Switch one = kind == 0   ? hinge(name, random_.direction())
                   : kind == 1 ? slide(name, random_.direction())
                               : ball(name);
      turned = turned || kind == 0;
      balled = balled || kind == 2;
      const int motion = random_.integer(0, 6);
      if (motion == 0) {
        one.q.clear();
        one.v.clear();
        one.motion = kind == 2 ? Driven{{function(), function(), function()}} : Driven{{function()}};
      } else if (motion == 1) {
        one.motion = Locked{};
      }
      if (motion > 1 && kind < 2) scalars_.push_back(name);
      switches.push_back(one);
      if (random_.integer(0, 2) == 0) switches.push_back(fixed(random_.vector(0.3)));
    }
    std::string parent = "world";
    if (i > 0 && i % 4 == 2)
      parent = fmt::format("s{}", i - 1);  // carried by the massless solid
    else if (i > 0 && random_.integer(0, 5))
      parent = fmt::format("s{}", random_.integer(0, i - 1));
    std::vector<Inertial> inertials;
    if (!massless) inertials.push_back(random_.inertia().inertial());
    scene.solids.push_back(solid(fmt::format("s{}", i), parent, switches, inertials));
  }

  SolidPoint point(int solids) {
    return {random_.integer(0, 4) ? fmt::format("s{}", random_.integer(0, solids - 1)) : "world",
            random_.vector(1)};
  }

  void add_efforts(int solids) {
    scene.efforts = {
        {"push", Force{point(solids), random_.vector(3), Axes::solid, function(), point(solids)}},
        {"twist", Torque{{fmt::format("s{}", solids - 1)}, random_.vector(3), Axes::world, function(), {}}},
        {"spring", PointSpring{point(solids), point(solids), 20, 1, 0.3}},
        {"torsion", TorsionSpring{{fmt::format("s{}", solids - 1)}, {"s0"}, 3, 0.2, random_.vector(0.3)}}};
    if (!scalars_.empty())
      scene.efforts.push_back({"coordinate", CoordinateSpring{{scalars_[0]}, 5, 0.1, 0}});
  }

  void add_constraints(int solids) {
    const std::string last = fmt::format("s{}", solids - 1), middle = fmt::format("s{}", solids / 2);
    scene.constraints = {
        {"rod", Distance{{last, random_.vector(1)}, {"world", {2, 1, 0}}, Polynomial{{2, 0.3}}}},
        {"table", PointOnPlane{{middle, random_.vector(1)},
                               {{"s0", random_.vector(1)}, random_.direction()},
                               Polynomial{{0.1, 0.2}}}}};
    if (scalars_.size() > 3)
      scene.constraints.push_back(
          {"gear", CoordinateCoupling{{{scalars_[0]}, {scalars_.back()}}, {1, -2}, Polynomial{{0, 1}}}});
    if (solids > 8)
      scene.constraints.push_back(
          {"pin", PointOnPoint{{last, random_.vector(0.5)}, {middle, Vector3d::Zero()}}});
  }

  Random random_;
  std::vector<std::string> scalars_;
};

}  // namespace borelli::test
