// Certificates of scenes with independent parts, each of which is judged by itself.
#include "dynamics/run/certifier.hpp"
#include "scenes.hpp"

namespace borelli::test::certifier_groups_test {
namespace {

/// A bar whose steps are too long, beside a weight of a ton in free fall, for which any method is exact.
Scene bar_beside_weight() {
  Scene scene = chain(1, false, 1);
  scene.solids.push_back(
      solid("weight", "world", {slide("fall", Vector3d::UnitZ())}, {inertial(1000, {0, 0, 0}, {1, 1, 1})}));
  return scene;
}

TEST(Certificate, HeavyNeighbourDoesNotHideABarsDrift) {
  const SimulationSettings how = settings("rk2", 5, 0.1);
  const Certificate alone = run(chain(1, false, 1), how).certificate;
  const Certificate beside = run(bar_beside_weight(), how).certificate;
  EXPECT_FALSE(alone.trusted);
  EXPECT_LT(beside.energy_drift, beside.energy_threshold * beside.energy_turnover);  // pooled, all looks well
  EXPECT_FALSE(beside.trusted);
  EXPECT_NE(beside.reason.find("the energy balance of 'l0' and the solids tied to it has an error"),
            std::string::npos)
      << beside.reason;
  EXPECT_EQ(beside.reason_time, alone.reason_time);
}

TEST(Certificate, CountsWorkForTheGroupItActsOn) {
  Scene scene = bar_beside_weight();  // the lines below add all that does work
  scene.solids.push_back(solid("carriage", "world", {driven(slide("ride", Vector3d::UnitX()), Sine{})}, {}));
  scene.solids.push_back(solid("bob", "carriage", {hinge("swing", Vector3d::UnitY(), 0.3)}, {link()}));
  scene.solids.push_back(
      solid("lift", "world", {slide("height", Vector3d::UnitZ())}, {inertial(3, {0, 0, 0}, {1, 1, 1})}));
  scene.efforts = {{"push", Force{{"weight", {0, 0, 0}}, {0, 0, 700}, Axes::world, Sine{}, {}}},
                   {"damper", CoordinateSpring{{"h0"}, 3, 0.5, 0}}};
  scene.constraints = {{"rise", CoordinateCoupling{{{"height"}}, {1}, Sine{0.5, 2, 0, 0}}}};
  SimulationSettings how = settings("rk4", 2, 0.002);
  how.energy_threshold = 1e-6;  // work booked on a wrong group would break two balances by joules
  for (const auto treatment : {ConstraintTreatment::projection, ConstraintTreatment::baumgarte}) {
    how.constraints = treatment;
    const System system = compiled(scene);
    EXPECT_EQ(system.groups, 4);
    const Certificate certificate = run(system, how).certificate;
    EXPECT_TRUE(certificate.trusted) << certificate.reason;
    EXPECT_GT(std::abs(certificate.work_drives), 0.1);
    EXPECT_GT(std::abs(certificate.work_constraints), 0.1);
    EXPECT_GT(std::abs(certificate.work_efforts), 0.1);
  }
}

}  // namespace
}  // namespace borelli::test::certifier_groups_test
