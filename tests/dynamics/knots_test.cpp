// Steps end at the knots of tables, so that motions under table forces are as exact as under other forces;
// reference: the table's own integral.
#include "dynamics/system/knots.hpp"

#include <cmath>
#include <limits>
#include <random>

#include "scenes.hpp"

namespace borelli::test {
namespace {

Scene pushed(const TimeFunction& factor) {
  Scene scene;
  scene.solids = {
      solid("bead", "world", {slide("x", Vector3d::UnitX(), 0)}, {inertial(1, {0, 0, 0}, {0, 0, 0})})};
  scene.efforts = {{"push", Force{.at = {"bead", {0, 0, 0}}, .force = {1, 0, 0}, .factor = factor}}};
  return scene;
}

std::vector<double> all_after(const Knots& knots, double t, double end) {
  std::vector<double> out;
  for (t = knots.after(t); t < end; t = knots.after(t)) out.push_back(t);
  return out;
}

TEST(Knots, LieAtTheEndsAndMiddlesOfTablePieces) {
  const System once = compiled(pushed(Table({1, 2, 4}, {0, 1, 0})));
  const Knots knots(once, once.parameters);
  EXPECT_EQ(all_after(knots, 0, 100), (std::vector<double>{1, 1.5, 2, 3, 4}));
  EXPECT_EQ(knots.after(4), std::numeric_limits<double>::infinity());
  EXPECT_GE(knots.count(0, 100), 5);
  const System again = compiled(pushed(Table({0, 0.1, 0.2, 0.4}, {0, 1, 2, 0}, SplineEnds::periodic)));
  const Knots rounds(again, again.parameters);
  const std::vector<double> found = all_after(rounds, -0.01, 400 - 1e-9);
  ASSERT_EQ(found.size(), 6000u);
  EXPECT_GE(rounds.count(0, 400), 6000);
  for (std::size_t i = 0; i < found.size(); ++i) {
    constexpr double within[] = {0, 0.05, 0.1, 0.15, 0.2, 0.3};
    EXPECT_NEAR(found[i], 0.4 * double(i / 6) + within[i % 6], 1e-12);
  }
  const System none = compiled(pushed(Sine{}));
  EXPECT_EQ(Knots(none, none.parameters).after(0), std::numeric_limits<double>::infinity());
}

/// Speed and position at time t of 1 kg started at rest, by Gauss' three-point rule, which is exact on each
/// piece.
std::array<double, 2> pushed_by(const Table& table, double t) {
  double speed = 0, place = 0;
  for (std::size_t i = 0; i + 1 < table.times.size() && table.times[i] < t; ++i) {
    const double from = table.times[i], to = std::min(t, table.times[i + 1]), h = to - from;
    for (const auto& [node, weight] : {std::pair(-std::sqrt(0.6), 5.), {0., 8.}, {std::sqrt(0.6), 5.}}) {
      const double s = from + h * (1 + node) / 2, part = weight / 18 * h * table(s).value;
      speed += part;
      place += (t - s) * part;
    }
  }
  return {place, speed};
}

TEST(Knots, KeepTheErrorOfTablesInTolerance) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> value(-10, 10), width(0.05, 0.6);
  std::vector<double> times{0}, values{value(random)};
  while (times.back() < 10) {
    times.push_back(times.back() + width(random));
    values.push_back(value(random));
  }
  const Table table(times, values);
  const System system = compiled(pushed(table));
  for (const char* method : {"dopri5", "dop853", "gbs", "gauss16", "rk4_adaptive"}) {
    SCOPED_TRACE(method);
    SimulationSettings how = settings(method, 10, 0.01, 1e-11);
    how.output_interval = 0.1;
    how.energy_threshold = 1e-3;  // work between steps is interpolated
    const Trajectory t = run(system, how);
    for (std::size_t i = 0; i < t.times.size(); ++i) {
      const auto [place, speed] = pushed_by(table, t.times[i]);
      const auto row = Eigen::Index(i);
      EXPECT_NEAR(t.q(row, 0), place, 3e-9);
      EXPECT_NEAR(t.v(row, 0), speed, 3e-9);
    }
  }
}

// A pulse of 30 us late in a long run: steps are short only there.
TEST(Knots, ShortPieceShortensOnlyItsOwnSteps) {
  const Table pulse({9, 9.00001, 9.00002, 9.00003}, {0, 1e5, 1e5, 0}, SplineEnds::clamped);
  const System system = compiled(pushed(pulse));
  const Trajectory t = run(system, settings("dop853", 10, 0.01, 1e-10));
  EXPECT_TRUE(t.certificate.trusted) << t.certificate.reason;
  EXPECT_LT(t.certificate.evaluations, 1000);
  const auto [place, speed] = pushed_by(pulse, 10);
  EXPECT_GT(speed, 1);
  EXPECT_NEAR(last(t.q)[0], place, 1e-8);
  EXPECT_NEAR(last(t.v)[0], speed, 1e-8);
}

}  // namespace
}  // namespace borelli::test
