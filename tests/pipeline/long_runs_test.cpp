// Energy drift over long runs against the theory of each method.
#include "pipeline/charts/long_runs.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "dynamics/formats/scene_file.hpp"
#include "tests/paths.hpp"

namespace borelli {
namespace {

// 1 kg on a spring of 1 N/m: one radian a second.
Scene oscillator() {
  Scene scene;
  scene.name = "oscillator";
  scene.gravity.setZero();
  Solid mass;
  mass.name = "mass";
  mass.switches = {{.kind = Translation{Eigen::Vector3d::UnitX()},
                    .coordinate = "x",
                    .motion = {},
                    .q = {1},
                    .v = {0},
                    .ranges = {}}};
  mass.inertials = {{1, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity()}};
  scene.solids = {mass};
  scene.efforts = {{"spring", CoordinateSpring{{"x"}, 1, 0, 0}}};
  return scene;
}

TEST(LongRuns, EnergyDriftsOrStaysBoundedAsInTheory) {
  const double h = 0.05;
  const LongRuns runs =
      long_runs(oscillator(),
                {.methods = {"rk4", "semi_implicit_euler", "verlet", "implicit_midpoint", "rk2"},
                 .steps = 100000,
                 .step = h})
          .value();
  EXPECT_DOUBLE_EQ(runs.end, 5000);
  // |R(ih)|^2 = 1 - h^6/72 + h^8/576 per step: the energy falls at this rate at first
  const LongRun& rk4 = runs.runs[0];
  EXPECT_TRUE(rk4.secular);
  const double rate = (std::pow(h, 6) / 72 - std::pow(h, 8) / 576) / h;
  for (std::size_t i = 1; i < rk4.times.size(); ++i)
    EXPECT_NEAR(rk4.energy[i], std::expm1(-rate * rk4.times[i]), 2e-3 * rate * rk4.times[i]);
  EXPECT_NEAR(rk4.drift, -rate, 0.03 * rate);  // mean rate, which slows by a hundredth
  // p^2 + x^2 - h p x is conserved: E oscillates by h/2, relative
  EXPECT_FALSE(runs.runs[1].secular);
  EXPECT_NEAR(runs.runs[1].swing, h, 0.02 * h);
  // (1 - h^2/4) x^2 + p^2 is conserved: E oscillates by h^2/4
  EXPECT_FALSE(runs.runs[2].secular);
  EXPECT_NEAR(runs.runs[2].swing, h * h / 4, 0.02 * h * h / 4);
  // it conserves a quadratic energy to rounding
  EXPECT_LT(std::abs(runs.runs[3].energy.back()), 1e-9);
  // |R(ih)|^2 = 1 + h^4/4: its energy grows
  EXPECT_TRUE(runs.runs[4].secular);
  EXPECT_GT(runs.runs[4].drift, 0);
  for (const LongRun& run : runs.runs) EXPECT_TRUE(run.momentum.empty());  // the world holds the spring
}

// Gauss methods keep a quadratic energy: what is left is rounding.
TEST(LongRuns, RoundingIsNoDrift) {
  for (const long steps : {1000L, 5000L, 20000L}) {
    const LongRuns runs =
        long_runs(oscillator(),
                  {.methods = {"implicit_midpoint", "gauss4", "gauss6"}, .steps = steps, .step = 0.01})
            .value();
    for (const LongRun& run : runs.runs)
      EXPECT_FALSE(run.secular) << run.method << ", " << steps << " steps: " << run.drift;
  }
}

TEST(LongRuns, FindsDriftBelowTheSwingAndLargeErrors) {
  // generalized_alpha dissipates 2.7e-7 of the energy over 200 s, less than it oscillates
  const LongRun alpha =
      long_runs(oscillator(), {.methods = {"generalized_alpha"}, .steps = 20000, .step = 0.01})
          .value()
          .runs[0];
  EXPECT_TRUE(alpha.secular);
  EXPECT_LT(alpha.drift, 0);
  EXPECT_LT(-alpha.drift * 200, alpha.swing);
  // close to its limit of h = 2, E varies between 1 - h/2 and 1 + h/2 of itself: bounded, but not reliable
  const LongRun coarse =
      long_runs(oscillator(), {.methods = {"semi_implicit_euler"}, .steps = 20000, .step = 1})
          .value()
          .runs[0];
  EXPECT_FALSE(coarse.secular);
  EXPECT_TRUE(coarse.large());
}

TEST(LongRuns, FollowMomentaOfAFreeSolid) {
  const Scene plate = read_scene(test::source_folder() + "/samples/spinning_plate.toml").value();
  const LongRuns runs =
      long_runs(plate, {.methods = {"rk4", "implicit_midpoint"}, .steps = 2000, .step = 0.01}).value();
  for (const LongRun& run : runs.runs) {
    ASSERT_EQ(run.momentum.size(), run.times.size()) << run.method << ": " << run.reason;
    EXPECT_LT(run.momentum.back(), 1e-2);
    EXPECT_GT(run.momentum.back(), 0);
  }
  const auto plots = long_run_plots(runs);
  EXPECT_EQ(plots.back().first, "momentum");
  EXPECT_EQ(plots.back().second.curves.size(), 2u);
}

TEST(LongRuns, FailingMethodIsNamedAndTheOthersRun) {
  const LongRuns runs =
      long_runs(oscillator(), {.methods = {"rk4", "dop853"}, .steps = 1000, .step = 3.5}).value();
  EXPECT_NE(runs.runs[0].reason.find("has grown"), std::string::npos) << runs.runs[0].reason;
  EXPECT_TRUE(runs.runs[0].energy.empty());
  EXPECT_FALSE(runs.runs[1].energy.empty());
  EXPECT_NE(long_runs_csv(runs).find("rk4,failed,"), std::string::npos);
}

}  // namespace
}  // namespace borelli
