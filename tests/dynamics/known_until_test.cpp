// What a certificate vouches for: conservation always, the state only with an accuracy and up to a time.
#include "dynamics/formats/model_file.hpp"
#include "dynamics/run/certifier.hpp"
#include "scenes.hpp"
#include "test_folder.hpp"

namespace borelli::test::known_until_test {
namespace {

const char* const hinge_and_ball = R"(<mujoco><option timestep="0.01"/><worldbody>
  <body name="arm" pos="0.8 0 3"><joint name="swing" type="hinge" axis="0 1 0" pos="-0.8 0 0"/>
    <geom type="box" size="0.8 0.1 0.1" mass="2"/>
    <body name="hand" pos="0.8 0.8 0" euler="0 0 90"><joint name="wrist" type="ball" pos="-0.8 0 0"/>
      <geom type="box" size="0.8 0.1 0.1" mass="2"/></body></body></worldbody></mujoco>)";

// A chaotic motion: two runs that keep the energy to 1e-7 end in unrelated states.
TEST(Certificate, VouchesForConservationNotForTheState) {
  const Folder folder;
  const Scene scene = need(read_model(folder.write("hinge_and_ball.xml", hinge_and_ball))).scene;
  const System system = compiled(scene);
  const Trajectory a = run(system, settings("dop853", 60, 0.01, 1e-8)),
                   b = run(system, settings("dop853", 60, 0.01, 1e-10));
  EXPECT_TRUE(a.certificate.trusted) << a.certificate.reason;
  EXPECT_TRUE(b.certificate.trusted) << b.certificate.reason;
  EXPECT_GT((last(a.q) - last(b.q)).norm(), 0.1);
  for (const Trajectory* path : {&a, &b}) {
    EXPECT_NE(vouches_for(path->certificate).find("not the state"), std::string::npos);
    EXPECT_TRUE(std::isnan(path->certificate.known_until));
  }
}

// With an accuracy the certificate gives the time up to which the state is known. Another method agrees
// there.
TEST(Certificate, AccuracyReportsUntilWhenTheStateIsKnown) {
  const Folder folder;
  const Scene scene = need(read_model(folder.write("hinge_and_ball.xml", hinge_and_ball))).scene;
  const System system = compiled(scene);
  SimulationSettings how = settings("dop853", 60, 0.01);
  how.output_interval = 0.5;
  how.accuracy = 1e-4;
  const Trajectory path = run(system, how);
  const Certificate& c = path.certificate;
  EXPECT_FALSE(c.trusted);
  EXPECT_GT(c.known_until, 1);
  EXPECT_LT(c.known_until, 60);
  EXPECT_NE(
      c.reason.find(fmt::format("the state is known to that accuracy up to t = {:.6g} s", c.known_until)),
      std::string::npos)
      << c.reason;
  const Trajectory until = run(system, settings("gbs", c.known_until, 0.01, 1e-13));
  int compared = 0;
  for (std::size_t i = 0; i < path.times.size(); ++i)
    if (std::abs(path.times[i] - c.known_until) < 1e-9) {
      EXPECT_LT((path.q.row(Eigen::Index(i)).transpose() - last(until.q)).cwiseAbs().maxCoeff(), 1e-3);
      ++compared;
    }
  EXPECT_EQ(compared, 1);
  how.end_time = 2;
  const Certificate early = run(system, how).certificate;
  EXPECT_TRUE(early.trusted) << early.reason;
  EXPECT_EQ(early.known_until, 2);
  EXPECT_EQ(vouches_for(early), "energy, momenta and constraints, and the state to 0.0001 up to t = 2 s");
}

}  // namespace
}  // namespace borelli::test::known_until_test
