// Motions of bodies whose convex shapes touch, against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include <fmt/ranges.h>

#include "convex_bodies.hpp"
#include "dynamics/contacts/pass_through.hpp"

namespace borelli::test::convex_contact_test {
namespace {

constexpr double g = 9.81;

TEST(ConvexContacts, BoxSlidesOnAFixedBoxByCoulombsLaw) {
  const double tilt = 0.5;
  const Form table = Box{{20, 2, 1}}, block = Box{{0.4, 0.4, 0.2}};
  for (const double friction : {0.3, 0.7}) {  // tan(0.5) = 0.546
    Scene scene;
    scene.gravity = {g * std::sin(tilt), 0, -g * std::cos(tilt)};
    scene.solids = {body_of("block", 2, block, {Matrix3d::Identity(), {0, 0, 0.6}})};
    scene.constraints = {meets("block", block, world_name, table, friction)};
    const Trajectory path = run(scene, settings("moreau", 1, 1e-3));
    const double a = std::max(0., g * (std::sin(tilt) - friction * std::cos(tilt)));
    EXPECT_NEAR(last(path.q)[0], a / 2, 1e-6) << friction;
    EXPECT_NEAR(last(path.q)[2], 0.6, 1e-6) << friction;
    EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
    EXPECT_NEAR(path.certificate.work_events, -2 * g * std::cos(tilt) * friction * a / 2, 1e-5) << friction;
  }
}

// A block of width w and height h that cannot slide tips if the slope exceeds w / h.
TEST(ConvexContacts, BoxTipsBeyondWidthOverHeight) {
  const double w = 0.2, h = 0.4;
  const Form table = Box{{5, 5, 1}}, block = Box{{w, 0.3, h}};
  for (const double factor : {0.98, 1.02}) {
    const double tilt = std::atan(factor * w / h);
    Scene scene;
    scene.gravity = {g * std::sin(tilt), 0, -g * std::cos(tilt)};
    scene.solids = {body_of("block", 2, block, {Matrix3d::Identity(), {0, 0, 0.5 + h / 2}})};
    scene.constraints = {meets("block", block, world_name, table, 2)};
    const Trajectory path = run(scene, settings("moreau", 0.5, 1e-3));
    const double turned = std::abs(last(path.q)[5]);  // the quaternion's y
    if (factor < 1)
      EXPECT_LT(turned, 1e-6);
    else
      // about the edge I angle'' = m g (h/2 sin - w/2 cos), so the angle grows as cosh: at least a t^2 / 2
      EXPECT_GT(2 * turned, 0.5 * g * (h / 2 * std::sin(tilt) - w / 2 * std::cos(tilt)) /
                                ((w * w + h * h) / 3) * 0.25 * 0.98);
    EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
  }
}

TEST(ConvexContacts, CylinderRollsDownASlopeAtTwoThirds) {
  const double tilt = 0.2, radius = 0.1;
  const Form log = Cylinder{radius, 0.5};
  const Pose lying{rotation_about(Vector3d::UnitX(), std::numbers::pi / 2), {0, 0, radius}};
  for (const bool on_box : {false, true}) {
    Scene scene;
    scene.gravity = {g * std::sin(tilt), 0, -g * std::cos(tilt)};
    scene.solids = {body_of("log", 3, log, lying)};
    if (on_box) {
      scene.solids[0].switches[2].q = {0.5 + radius};
      scene.constraints = {meets("log", log, world_name, Box{{10, 10, 1}}, 0.5)};
    } else {
      scene.constraints = {on_floor("log", log, 0.5)};
    }
    const Trajectory path = run(scene, settings("moreau", 1, 1e-3));
    EXPECT_NEAR(last(path.v)[0], 2. / 3 * g * std::sin(tilt), 1e-5) << on_box;
    EXPECT_NEAR(last(path.q)[0], 1. / 3 * g * std::sin(tilt), 1e-5) << on_box;
    EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
  }
}

// An ellipsoid rests on the end of its shortest half axis c. Rocking in the plane of a and c without slip,
// the potential of small turns is m g (a^2 / c - c) / 2 angle^2, the inertia about the contact I + m c^2.
TEST(ConvexContacts, EllipsoidRocksWithTheClosedPeriod) {
  const double a = 0.3, b = 0.2, c = 0.15, m = 2, start = 0.01;
  const Form egg = Ellipsoid{{a, b, c}};
  const double I = m * (a * a + c * c) / 5;
  const double period = 2 * std::numbers::pi * std::sqrt((I + m * c * c) / (m * g * (a * a / c - c)));
  Scene scene;
  const Matrix3d R = rotation_about(Vector3d::UnitY(), start);
  const double height = Vector3d(R.transpose() * Vector3d::UnitZ()).cwiseProduct(Vector3d(a, b, c)).norm();
  scene.solids = {body_of("egg", m, egg, {R, {0, 0, height}})};
  scene.constraints = {on_floor("egg", egg, 1)};
  SimulationSettings how = settings("moreau", 3.5 * period, 1e-3 * period);
  how.output_interval = how.step;
  const Trajectory path = run(scene, how);
  EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
  std::vector<double> passes;  // falling through zero
  for (Eigen::Index row = 1; row < path.q.rows(); ++row) {
    const double before = path.q(row - 1, 5), now = path.q(row, 5);
    if (before > 0 && now <= 0)
      passes.push_back(path.times[std::size_t(row)] - how.step * now / (now - before));
  }
  ASSERT_GE(passes.size(), 3u);
  // amplitude 0.01: the period differs by about its square; the scheme's step is a thousandth of a period
  EXPECT_NEAR((passes[2] - passes[0]) / 2, period, 1e-3 * period);
}

TEST(ConvexContacts, StackOfFiveBoxesRestsAndCarriesItsWeight) {
  const Form brick = Box{{0.4, 0.3, 0.2}};
  Scene scene;
  for (int i = 0; i < 5; ++i) {
    // turned about the vertical: the shared areas have eight corners
    scene.solids.push_back(body_of(fmt::format("b{}", i), 1 + i, brick,
                                   {rotation_about(Vector3d::UnitZ(), 0.4 * i), {0, 0, 0.1 + 0.2 * i}}));
    scene.constraints.push_back(
        i == 0 ? on_floor("b0", brick, 0.5)
               : meets(fmt::format("b{}", i), brick, fmt::format("b{}", i - 1), brick, 0.5));
  }
  SimulationSettings how = settings("moreau", 1, 2e-3);
  how.output_interval = 0.1;
  const Trajectory path = run(scene, how);
  EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
  EXPECT_LT((path.q.bottomRows(1) - path.q.topRows(1)).cwiseAbs().maxCoeff(), 1e-6);
  const System system = compiled(scene);
  for (int i = 0; i < 5; ++i) {
    double above = 0, force = 0;
    for (int j = i; j < 5; ++j) above += 1 + j;
    for (const Contact& c : system.contacts)
      if (c.constraint == i) force += path.multipliers(path.multipliers.rows() - 1, c.row);
    EXPECT_NEAR(force, above * g, 1e-5 * above * g) << i;
  }
}

TEST(ConvexContacts, HeapOfAllShapesLosesEnergyAndPassesNothing) {
  const std::vector<Form> forms{Box{{0.3, 0.2, 0.2}}, Cylinder{0.1, 0.3}, Ellipsoid{{0.15, 0.1, 0.1}},
                                Capsule{0.08, 0.2}, Box{{0.2, 0.2, 0.3}}};
  Scene scene;
  for (std::size_t i = 0; i < forms.size(); ++i) {
    const std::string name = fmt::format("s{}", i);
    scene.solids.push_back(body_of(name, 1, forms[i],
                                   {rotation_about(Vector3d(1, 2, 3).normalized(), double(i)),
                                    {0.05 * double(i % 2), 0.03 * double(i), 0.3 + 0.45 * double(i)}}));
    scene.constraints.push_back(on_floor(name, forms[i], 0.4));
    for (std::size_t j = 0; j < i; ++j)
      scene.constraints.push_back(meets(name, forms[i], fmt::format("s{}", j), forms[j], 0.4));
  }
  SimulationSettings how = settings("moreau", 1.5, 1e-3);
  how.output_interval = 0.05;
  const Trajectory path = run(scene, how);
  EXPECT_TRUE(path.certificate.trusted) << path.certificate.reason;
  const double start = path.kinetic[0] + path.potential[0];
  for (std::size_t row = 0; row < path.times.size(); ++row)
    EXPECT_LE(path.kinetic[Eigen::Index(row)] + path.potential[Eigen::Index(row)],
              start + 1e-3 * std::abs(start));
}

TEST(ConvexContacts, MethodsBetweenEventsRefuseThem) {
  Scene scene;
  scene.solids = {body_of("egg", 1, Sphere{0.1}, {Matrix3d::Identity(), {0, 0, 1}})};
  scene.constraints = {on_floor("egg", Ellipsoid{{0.1, 0.1, 0.1}}, 0)};
  scene.simulation = settings("dop853", 1, 1e-2);
  const auto path = simulate(compiled(scene));
  ASSERT_FALSE(path);
  EXPECT_EQ(path.error().message(),
            "constraint 'egg on floor': contacts of convex shapes need the method moreau; found dop853");
}

TEST(ConvexContacts, ImpossibleShapesAreRefused) {
  Scene scene;
  scene.solids = {body_of("egg", 1, Sphere{0.1}, {Matrix3d::Identity(), {0, 0, 1}})};
  scene.constraints = {on_floor("egg", Cone{0.1, 0.2}, 0)};
  EXPECT_NE(compile(scene).error().message().find("a cone cannot be in a contact"), std::string::npos);
  scene.constraints = {on_floor("egg", Box{{0.1, -1, 0.2}}, 0)};
  EXPECT_FALSE(compile(scene));
  scene.constraints = {on_floor("egg", ClosedMesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {}}, 0)};
  EXPECT_FALSE(compile(scene));
}

}  // namespace
}  // namespace borelli::test::convex_contact_test
