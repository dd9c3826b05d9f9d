// An error of a chart's callback (a page that cannot be written) ends the chart at once.
#include <gtest/gtest.h>

#include "dynamics/formats/scene_file.hpp"
#include "pipeline/charts/work_precision.hpp"
#include "tests/paths.hpp"

namespace borelli::test::chart_callbacks_test {
namespace {

WorkPrecisionSettings two_methods() {
  WorkPrecisionSettings settings;
  settings.methods = {"rk4", "dop853"};
  settings.equations = {Equations::recursive};
  settings.repeats = 1;
  settings.budget = 0.01;
  return settings;
}

Scene pendulum() {
  Scene scene = read_scene(source_folder() + "/samples/pendulum.toml").value();
  scene.simulation.end_time = 0.5;
  return scene;
}

TEST(ChartCallbacks, ErrorAfterALadderEndsTheChart) {
  int ladders = 0, rounds = 0;
  WorkPrecisionObserver observer;
  observer.ladder_ends = [&](const auto&) -> Result<void> {
    ++ladders;
    return failure("chart.partial.json", "the disk is full");
  };
  observer.round_ends = [&](const auto&) {
    ++rounds;
    return Result<void>();
  };
  const auto chart = work_precision(pendulum(), two_methods(), observer);
  ASSERT_FALSE(chart);
  EXPECT_EQ(chart.error().message(), "chart.partial.json: the disk is full");
  EXPECT_EQ(ladders, 1);
  EXPECT_EQ(rounds, 0);
}

TEST(ChartCallbacks, ErrorAfterARoundEndsTheChart) {
  int ladders = 0, rounds = 0;
  WorkPrecisionObserver observer;
  observer.ladder_ends = [&](const auto&) {
    ++ladders;
    return Result<void>();
  };
  observer.round_ends = [&](const auto&) -> Result<void> {
    ++rounds;
    return failure("chart.html", "the disk is full");
  };
  const auto chart = work_precision(pendulum(), two_methods(), observer);
  ASSERT_FALSE(chart);
  EXPECT_EQ(chart.error().message(), "chart.html: the disk is full");
  EXPECT_EQ(ladders, 2);  // one per method, of the first of three rounds
  EXPECT_EQ(rounds, 1);
}

}  // namespace
}  // namespace borelli::test::chart_callbacks_test
