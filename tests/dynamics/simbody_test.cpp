// Closed loops against Simbody, which has its own recursion and its own solution for the multipliers. Needs
// Simbody.
#include <gtest/gtest.h>

#ifdef BORELLI_SIMBODY
#include <map>

#include "dynamics/constraints/assembly.hpp"
#include "dynamics/equations/evaluate.hpp"
#include "scenes.hpp"
#include "simbody_loop.hpp"

namespace borelli::test {
namespace {

/// Two chains from the world with coinciding ends, as a scene and in Simbody.
class Loop {
 public:
  void add(const std::string& name, const std::string& parent, const Vector3d& p, const Vector3d& axis,
           double length, const Vector3d& radii = Vector3d::Zero()) {
    const SimbodyLoop::Link link{length, {0.02 * length, 0, -0.5 * length}, {0.09, 0.08, 0.01}};
    theirs_.add(name, parent, p, axis, link, radii);
    scene.solids.push_back(solid(name, parent, {fixed(p), axis.isZero() ? ball(name) : hinge(name, axis)},
                                 {inertial(link.mass, link.centre, link.moments)}));
    if (!radii.isZero()) scene.solids.back().switches[1].kind = OnEllipsoid{radii};
  }
  void close(const std::string& a, const Vector3d& p_a, const std::string& b, const Vector3d& p_b) {
    theirs_.close(a, p_a, b, p_b);
    scene.constraints = {{"loop", PointOnPoint{{a, p_a}, {b, p_b}}}};
  }

  /// Compares both at random states on the constraint.
  void expect_agreement(Equations equations) {
    System system = compiled(scene);
    system.settings.equations = equations;
    Random random(7);
    for (int trial = 0; trial < 10; ++trial) {
      State state = system.initial;
      for (int i = 0; i < system.nv; ++i) state.v[i] = random.number(-2, 2);
      for (const CoordinateInfo& info : system.coordinates)
        if (info.q_size == 1) state.q[info.q_index] = start.at(info.name) + random.number(-0.2, 0.2);
      need(assemble(system, state));
      const Evaluation ours = need(evaluate(system, state));
      const auto parents_axes = [&](const CoordinateInfo& info, const Eigen::VectorXd& x) {
        const Eigen::VectorXd own = x.segment(info.v_index, info.v_size);
        if (info.q_size == 1) return own;
        return Eigen::VectorXd(rotation_matrix(Quaternion(state.q.segment<4>(info.q_index))) * own);
      };
      for (const CoordinateInfo& info : system.coordinates)
        theirs_.set(info.name, state.q.segment(info.q_index, info.q_size), parents_axes(info, state.v));
      EXPECT_LT(theirs_.solve(), 1e-11);  // assembled for them too
      const double largest = ours.acceleration.cwiseAbs().maxCoeff();
      // both are exact up to rounding times the loops' condition (1e3 to 1e5)
      for (const CoordinateInfo& info : system.coordinates)
        EXPECT_LT((parents_axes(info, ours.acceleration) - theirs_.acceleration(info.name)).norm(),
                  1e-9 * largest)
            << info.name;
      EXPECT_LT((theirs_.force() - ours.multipliers).norm(), 1e-9 * ours.multipliers.norm());
    }
  }

  Scene scene;
  std::map<std::string, double> start;

 private:
  SimbodyLoop theirs_;
};

// A planar loop: the row across the plane is dependent.
TEST(Simbody, AgreesOnAFourBar) {
  Loop loop;
  const Vector3d y = Vector3d::UnitY();
  loop.add("crank", "world", {0, 0, 0}, y, 0.4);
  loop.add("coupler", "crank", {0, 0, -0.4}, y, 1.2);
  loop.add("rocker", "world", {1, 0, 0}, y, 0.9);
  loop.start = {{"crank", 0.5}, {"coupler", -1.6}, {"rocker", 0.2}};
  loop.close("coupler", {0, 0, -1.2}, "rocker", {0, 0, -0.9});
  loop.expect_agreement(Equations::recursive);
  loop.expect_agreement(Equations::lagrange);
}

// In space: hinge, ball, hinge, the coupler free to turn about itself.
TEST(Simbody, AgreesOnASpatialFourBar) {
  Loop loop;
  loop.add("crank", "world", {0, 0, 0}, Vector3d::UnitY(), 0.4);
  loop.add("coupler", "crank", {0, 0, -0.4}, Vector3d::Zero(), 1.2);
  loop.add("rocker", "world", {1, 0.1, 0}, Vector3d(1, 2, 0.5).normalized(), 0.9);
  loop.start = {{"crank", 0.5}, {"rocker", 0.2}};
  loop.close("coupler", {0, 0, -1.2}, "rocker", {0, 0, -0.9});
  loop.scene.solids[1].switches[1].q = {std::cos(0.8), 0, -std::sin(0.8), 0};
  loop.expect_agreement(Equations::recursive);
  loop.expect_agreement(Equations::lagrange);
}

// A blade glides over an ellipsoid, an arm hangs from it by a ball, and its end is that of a rod.
TEST(Simbody, AgreesOverAnEllipsoid) {
  Loop loop;
  loop.add("blade", "world", {0, 0, 0}, Vector3d::Zero(), 0.5, {0.3, 0.2, 0.4});
  loop.add("arm", "blade", {0.1, 0, 0}, Vector3d::Zero(), 0.9);
  loop.add("rod", "world", {1, 0.1, 0}, Vector3d(1, 2, 0.5).normalized(), 0.9);
  loop.start = {{"rod", 0.2}};
  loop.close("arm", {0, 0, -0.9}, "rod", {0, 0, -0.9});
  loop.scene.solids[0].switches[1].q = {std::cos(0.4), std::sin(0.4), 0, 0};
  loop.scene.solids[1].switches[1].q = {std::cos(0.5), 0, -std::sin(0.5), 0};
  loop.expect_agreement(Equations::recursive);
  loop.expect_agreement(Equations::lagrange);
}

}  // namespace
}  // namespace borelli::test

#else
TEST(Simbody, AgreesOnAllModels) {
  GTEST_SKIP() << "Simbody (libsimbody-dev) was not there at configuration";
}
#endif
