// Limits of stability against closed forms, and outcomes against known properties of the methods.
#include "pipeline/charts/stability_page.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>

#include "dynamics/formats/scene_file.hpp"
#include "dynamics/run/simulate.hpp"
#include "pipeline/charts/scene_number.hpp"
#include "process/input_file.hpp"
#include "tests/paths.hpp"

namespace borelli::stability_test {
namespace {

// 1 kg on a spring of stiffness k without gravity: it swings at sqrt(k) rad/s.
const std::string oscillator = R"(name = "oscillator"
gravity = [0, 0, 0]
[simulation]
end_time = 5
[[solid]]
name = "mass"
joint = {translation = "x", name = "x", value = 1, velocity = 0}
mass = 1
centre = [0, 0, 0]
tensor = [1, 1, 1]
[[effort]]
name = "spring"
kind = "coordinate_spring"
on = "x"
stiffness = 4
damping = 0
)";

Sweep sweep(const std::string& text, const std::string& path, const std::string& values) {
  return sweep_of_number(text, "oscillator.toml", {path}, parse_ladder(values, "values").value()).value();
}

StabilityMap mapped(Sweep columns, const std::vector<std::string>& methods, const std::string& steps) {
  StabilitySettings settings;
  settings.methods = methods;
  settings.steps = parse_ladder(steps, "steps").value();
  settings.lengths.most = 2000;
  return stability_map(std::move(columns), settings).value();
}

TEST(Stability, ContinuesFromKnownResults) {
  StabilitySettings settings;
  settings.methods = {"rk4", "verlet", "dopri5"};
  settings.steps = parse_ladder("1e-2:10:5", "steps").value();
  settings.lengths.most = 500;
  const Sweep columns = sweep(oscillator, "spring.stiffness", "4,100");
  StabilityObserver first, second;
  int climbed = 0;
  first.column_ends = [&](const StabilityMap& so_far) {
    if (++climbed == 3) second.known_cells = so_far.cells, second.known_limits = so_far.limits;
    return Result<void>();
  };
  const StabilityMap whole = stability_map(columns, settings, first).value();
  EXPECT_EQ(climbed, 6);
  int more = 0;
  second.column_ends = [&](const StabilityMap&) {
    ++more;
    return Result<void>();
  };
  const StabilityMap again = stability_map(columns, settings, second).value();
  EXPECT_EQ(more, 3);
  EXPECT_EQ(stability_csv(again), stability_csv(whole));
  EXPECT_EQ(stability_limits_csv(again), stability_limits_csv(whole));
}

TEST(Stability, EndsAtOnceWithTheErrorOfItsObserver) {
  StabilitySettings settings;
  settings.methods = {"rk4", "verlet"};
  settings.steps = parse_ladder("1e-2:10:5", "steps").value();
  settings.lengths.most = 500;
  StabilityObserver observer;
  int climbed = 0;
  observer.column_ends = [&](const StabilityMap&) -> Result<void> {
    ++climbed;
    return failure("the disk", "is full");
  };
  const auto map = stability_map(sweep(oscillator, "spring.stiffness", "4,100"), settings, observer);
  ASSERT_FALSE(map);
  EXPECT_EQ(map.error().message(), "the disk: is full");
  EXPECT_EQ(climbed, 1);
}

TEST(Stability, LimitsOfAnUndampedSpringMatchTheory) {
  const StabilityMap map =
      mapped(sweep(oscillator, "spring.stiffness", "4,1e4,1e8"),
             {"rk4", "verlet", "semi_implicit_euler", "implicit_midpoint", "gauss4"}, "1e-5:10");
  const double reach[] = {std::sqrt(8.), 2, 2};  // limits of h omega
  ASSERT_EQ(map.limits.size(), 15u);
  for (const StabilityLimit& limit : map.limits) {
    const double omega = std::sqrt(map.sweep.values.values[limit.column]);
    ASSERT_TRUE(limit.linear);
    if (limit.method < 3) {
      // 200 steps detect the limit to 1 %
      EXPECT_NEAR(limit.stable * omega / reach[limit.method], 1, 0.01) << map.methods[limit.method];
      EXPECT_NEAR(*limit.linear * omega / reach[limit.method], 1, 1e-6);
    } else {
      EXPECT_TRUE(std::isinf(limit.stable)) << map.methods[limit.method];
      EXPECT_TRUE(std::isinf(*limit.linear));
    }
    EXPECT_FALSE(limit.trusted >= limit.stable);  // a stable run need not be accurate
  }
}

TEST(Stability, DampingLimitsTheStepOfADampedSpring) {
  std::string text = oscillator;
  text.replace(text.find("velocity = 0"), 12, "velocity = 1");
  const StabilityMap map =
      mapped(sweep(text, "spring.damping", "100,1e4"), {"rk4", "euler", "gauss4"}, "1e-5:10");
  // where |R(z)| = 1 on the negative axis: 1 + z + z^2/2 + z^3/6 + z^4/24, and 1 + z
  const double reach[] = {2.785293563405282, 2};
  for (const StabilityLimit& limit : map.limits) {
    const double c = map.sweep.values.values[limit.column];
    const double fast = (c + std::sqrt(c * c - 16)) / 2;
    if (limit.method == 2) {
      EXPECT_TRUE(std::isinf(limit.stable));
      continue;
    }
    EXPECT_NEAR(limit.stable * fast / reach[limit.method], 1, 0.02) << map.methods[limit.method];
    EXPECT_NEAR(*limit.linear * fast / reach[limit.method], 1, 1e-6);
  }
}

TEST(Stability, ReportsMotionThatGrowsByItself) {
  // x = cosh t grows by e^5 in five seconds, by e^50 with 100 times the force, and not at all on a spring
  const auto words_of = [](const std::string& values) {
    return own_growth_words(mapped(sweep(oscillator, "spring.stiffness", values), {"rk4"}, "1e-2:1e-1"));
  };
  EXPECT_EQ(words_of("4,100"), "");
  EXPECT_EQ(words_of("-1,4"), "");
  const std::string words = words_of("-1,-100,4");
  EXPECT_NE(words.find("with spring.stiffness = -100 by e^50 in"), std::string::npos) << words;
}

TEST(Stability, IgnoresFailuresAfterTheScenesEnd) {
  // a rod of 1 m between a slider driven at 1 m/s and a perpendicular one: it is fully extended after 1 s,
  // and 200 steps of 6 ms go beyond that
  const std::string text = R"(name = "rod"
gravity = [0, 0, 0]
[simulation]
method = "rk4"
[[solid]]
name = "drive"
joint = {translation = "x", name = "x", driven = [0, 1]}
mass = 1
centre = [0, 0, 0]
tensor = [0, 0, 0]
[[solid]]
name = "slider"
joint = {translation = "y", name = "y", value = 1}
mass = 1
centre = [0, 0, 0]
tensor = [0, 0, 0]
[[constraint]]
name = "rod"
kind = "distance"
a = "drive"
b = "slider"
distance = 1
)";
  for (const auto& [end, fails] : {std::pair(0.9, false), std::pair(1.1, true)}) {
    const System system = compile(parse_scene(text, "rod.toml").value()).value();
    SimulationSettings how = system.settings;
    how.end_time = end;
    const Tried tried = try_run(system, how, 0.006);
    EXPECT_EQ(is_unstable(tried.outcome), fails) << tried.reason;
  }
}

TEST(Stability, EulerGrowsAtAnyStepAndMidpointSlowly) {
  const StabilityMap map = mapped(sweep(oscillator, "spring.stiffness", "4"), {"euler", "rk2"}, "1e-3:1");
  EXPECT_TRUE(std::isnan(map.limits[0].stable));
  EXPECT_EQ(map.limits[0].linear, 0);
  EXPECT_EQ(map.cells[0].tried.outcome, Outcome::energy_growth);
  // its energy grows by (h omega)^4 / 4 per step, which is less than 1e-3 in 2000 steps of 1e-2 s
  EXPECT_EQ(map.limits[1].linear, 0);
  EXPECT_GT(map.limits[1].stable, 5e-3);
  EXPECT_LT(map.limits[1].stable, 5e-2);
}

// The step h for q'' + c q' + k q = 0 at which |R(h lambda)| = 1, for Runge-Kutta methods with as many stages
// as their order.
double reach(int order, double c, double k) {
  const std::complex<double> lambda =
      (-c + std::sqrt(std::complex<double>(c * c - 4 * k, 0))) / 2. - 1e-300;  // if equal in size, one
  const std::complex<double> other = -c - lambda;
  const auto grows = [&](double h) {
    double most = 0;
    for (const auto& l : {lambda, other}) {
      std::complex<double> sum = 1, term = 1;
      for (int i = 1; i <= order; ++i) sum += term *= h * l / double(i);
      most = std::max(most, std::abs(sum));
    }
    return most > 1;
  };
  double low = 1e-9, high = 1;
  while (!grows(high)) high *= 2;
  // finds the first crossing in small ratios
  for (double h = low; h < high; h *= 1.001)
    if (grows(h)) {
      high = h;
      break;
    } else {
      low = h;
    }
  for (int i = 0; i < 60; ++i) (grows((low + high) / 2) ? high : low) = (low + high) / 2;
  return low;
}

// Two masses, one on a damped spring of increasing stiffness. Errors added before the motion has died away
// are no instability.
TEST(Stability, DampedMotionsAreStableUpToTheTheoreticalLimit) {
  std::string text = oscillator;
  text.replace(text.find("damping = 0"), 11, "damping = 3");
  text.replace(text.find("stiffness = 4"), 13, "stiffness = 40");
  text.replace(text.find("end_time = 5"), 12, "end_time = 10");
  text += R"([[solid]]
name = "second"
joint = {translation = "y", name = "y", value = -0.5}
mass = 0.25
centre = [0, 0, 0]
tensor = [1, 1, 1]
[[effort]]
name = "damper"
kind = "coordinate_spring"
on = "y"
stiffness = 4
damping = 1
)";
  StabilitySettings settings;
  settings.methods = {"euler", "rk2", "rk4"};
  settings.steps = parse_ladder("1e-4:1:21", "steps").value();
  const StabilityMap map = stability_map(sweep(text, "damper.stiffness", "4,400,4e4,4e6"), settings).value();
  const int orders[] = {1, 2, 4};
  for (const StabilityLimit& limit : map.limits) {
    const double k = map.sweep.values.values[limit.column];
    const double theory = std::min(reach(orders[limit.method], 3, 40), reach(orders[limit.method], 4, 4 * k));
    const std::string what = fmt::format("{} at {:g}", map.methods[limit.method], k);
    if (theory < 1e-4) {  // below all steps that were tried
      EXPECT_TRUE(std::isnan(limit.stable)) << what;
      EXPECT_TRUE(limit.known) << what;
      continue;
    }
    // 200 steps detect the limit to 1 %, or to 5 % if two modes are mixed
    EXPECT_NEAR(limit.stable / theory, 1, 0.05) << what << " in " << limit.over;
  }
}

TEST(Stability, LimitsFoundInPartOfTheTimeAreMarked) {
  StabilityMap map;
  map.sweep.scene = "x", map.sweep.parameter = "k";
  map.sweep.values = {{1, 10}, true};
  map.sweep.names = {"1", "10"};
  map.methods = {"rk4"};
  map.steps = {{0.01, 0.1}, true};
  map.tolerances = {{1e-3}, true};
  map.limits = {{0, 0, 0.03, NAN}, {0, 1, 0.02, NAN, {}, 0.5}};
  map.sweep.scenes.resize(2, tl::unexpected(Error{"x", "not read"}));
  const auto plots = stability_plots(map);
  ASSERT_FALSE(plots.empty());
  const Plot& limits = plots.front().second;
  ASSERT_EQ(limits.curves.size(), 1u);
  EXPECT_EQ(limits.curves[0].hollow, (std::vector<bool>{false, true}));
  const auto says = [](const Plot& plot) {
    return std::any_of(plot.notes.begin(), plot.notes.end(),
                       [](const std::string& note) { return note.find("Empty dots") != std::string::npos; });
  };
  EXPECT_TRUE(says(limits));
  map.limits[1].over = 0;
  EXPECT_FALSE(says(stability_plots(map).front().second));
}

// The cube drops at once and hits the spring later. A run cut off by the limit on steps does not reach the
// impact, so it gives no limit of stability.
TEST(Stability, TruncatedRunGivesNoLimit) {
  const std::string text = with_number(read_input_file(test::source_folder() + "/samples/shock.toml").value(),
                                       "shock.toml", "solid[cube].shape.mass", 1e6)
                               .value();
  // a longer run shows it: that step fails after half a second
  const System system = compile(parse_scene(text, "shock.toml").value()).value();
  SimulationSettings how = system.settings;
  how.method = "rk4";
  how.step = 1e-4;
  const auto whole = simulate(system, system.initial, how);
  ASSERT_FALSE(whole && whole->certificate.trusted);
  StabilitySettings settings;
  settings.methods = {"rk4"};
  settings.steps = parse_ladder("1e-4:1e-2:5", "steps").value();
  settings.lengths.most = 1000;
  const StabilityMap map =
      stability_map(sweep_of_number(text, "shock.toml", {"solid[cube].shape.mass"}, {{1e6}, false}).value(),
                    settings)
          .value();
  EXPECT_EQ(map.cells[0].tried.outcome, Outcome::unfinished);
  EXPECT_NE(map.cells[0].tried.reason.find("stopped at 0.0999 s of 5 s"), std::string::npos)
      << map.cells[0].tried.reason;
  EXPECT_FALSE(map.limits[0].known);
  EXPECT_TRUE(std::isnan(map.limits[0].stable));
  EXPECT_EQ(stable_words(map, map.limits[0]), "not known");
  EXPECT_NE(stability_limits_csv(map).find(",no,"), std::string::npos);
}

// dopri5 needs more steps for smaller tolerances, as their fifth root, so runs with small tolerances are cut
// off.
TEST(Stability, ReportsTheToleranceOfTruncatedRuns) {
  StabilitySettings settings;
  settings.methods = {"dopri5"};
  settings.tolerances = parse_ladder("1e-12:1e-4:9", "tolerances").value();
  settings.lengths = {8, 100};
  const StabilityMap map = stability_map(sweep(oscillator, "spring.stiffness", "4"), settings).value();
  double cut = 0;
  for (const StabilityCell& cell : map.cells) {
    const SimulationSettings how{.end_time = 5, .method = "dopri5", .tolerance = cell.setting};
    const System system = compile(*map.sweep.scenes[0]).value();
    const Certificate whole = simulate(system, system.initial, how).value().certificate;
    const bool longer = whole.steps_accepted + whole.steps_rejected > 100;
    EXPECT_EQ(cell.tried.outcome == Outcome::unfinished, longer) << cell.setting;
    if (longer) cut = cell.setting;
  }
  EXPECT_GT(cut, 1e-11);
  EXPECT_LT(cut, 1e-4);
  EXPECT_TRUE(std::isinf(map.limits[0].stable));
  EXPECT_EQ(map.limits[0].unseen, cut);
  EXPECT_EQ(stable_words(map, map.limits[0]), fmt::format("all above {:.3g}", cut));
}

TEST(Stability, EachOutcomeOccursInAnExample) {
  const auto outcome = [](const std::string& text, const char* method, double setting,
                          ConstraintTreatment constraints = ConstraintTreatment::projection,
                          RunLengths lengths = {}) {
    const System system = compile(parse_scene(text, "a.toml").value()).value();
    SimulationSettings how = system.settings;
    how.method = method;
    how.constraints = constraints;
    const Tried tried = try_run(system, how, setting, lengths);
    EXPECT_EQ(tried.reason.empty(), tried.outcome == Outcome::stable) << tried.reason;
    return tried.outcome;
  };
  const auto sample = [](const char* name) {
    return write_scene(read_scene(test::source_folder() + "/samples/" + name).value()).value();
  };
  EXPECT_EQ(outcome(oscillator, "rk4", 0.01), Outcome::stable);
  EXPECT_EQ(outcome(oscillator, "rk4", 2), Outcome::blow_up);
  EXPECT_EQ(outcome(oscillator, "rk4", 1.2), Outcome::energy_loss);  // nearly all
  EXPECT_EQ(outcome(oscillator, "rk4", 0.2), Outcome::energy_loss);  // a part
  EXPECT_EQ(outcome(oscillator, "rk4", 1.42), Outcome::energy_growth);
  EXPECT_EQ(outcome(oscillator, "semi_implicit_euler", 0.5), Outcome::inaccurate);  // oscillates
  EXPECT_EQ(outcome(oscillator, "dopri5", 1e-8, {}, {200, 20}), Outcome::unfinished);
  EXPECT_EQ(outcome(oscillator, "rk4", 1e-3, {}, {200, 1000}), Outcome::unfinished);
  EXPECT_EQ(outcome(sample("a01.toml"), "cvode", 1e-6), Outcome::refused);
  const std::string held =
      with_number(with_number(sample("a01.toml"), "a", "simulation.baumgarte_alpha", 0).value(), "a",
                  "simulation.baumgarte_beta", 0)
          .value();
  EXPECT_EQ(outcome(held, "rk4", 0.05, ConstraintTreatment::baumgarte), Outcome::constraint_drift);
  EXPECT_EQ(outcome(sample("painleve_rod.toml"), "dop853", 1e-8), Outcome::not_solved);
}

TEST(Stability, BaumgartesGainsLimitTheStep) {
  // h'' + 2 a h' + a^2 h = 0 has the double eigenvalue -a, which RK4 bears up to a step of 2.785 / a
  const std::string text =
      write_scene(read_scene(test::source_folder() + "/samples/a01.toml").value()).value();
  for (const double gain : {100., 300., 1000.}) {
    const Sweep gains =
        sweep_of_number(text, "a01.toml", {"simulation.baumgarte_alpha", "simulation.baumgarte_beta"},
                        {{gain}, false})
            .value();
    StabilitySettings settings;
    settings.methods = {"rk4"};
    settings.constraints = ConstraintTreatment::baumgarte;
    settings.steps = {{0.2 / gain, 2.6 / gain, 2.95 / gain}, true};
    settings.lengths.most = 60000;
    const StabilityMap map = stability_map(gains, settings).value();
    EXPECT_EQ(map.cells[0].tried.outcome, Outcome::stable) << map.cells[0].tried.reason;
    EXPECT_NE(map.cells[1].tried.outcome, Outcome::blow_up) << map.cells[1].tried.reason;
    EXPECT_EQ(map.cells[2].tried.outcome, Outcome::blow_up) << map.cells[2].tried.reason;
    EXPECT_FALSE(map.limits[0].linear);  // constraint errors are not linearised
  }
}

TEST(Stability, IsReproducible) {
  const auto once = [] {
    return mapped(sweep(oscillator, "spring.stiffness", "1:100:3"), {"rk4", "gbs", "moreau"}, "1e-2:3:5");
  };
  const StabilityMap a = once(), b = once();
  EXPECT_EQ(stability_csv(a), stability_csv(b));
  EXPECT_EQ(stability_limits_csv(a), stability_limits_csv(b));
  EXPECT_EQ(stability_page(a), stability_page(b));
}

TEST(Stability, InvalidColumnIsRefusedAndTheOthersRun) {
  const StabilityMap map = mapped(sweep(oscillator, "mass.mass", "-1,1"), {"rk4"}, "1e-2,1e-1");
  ASSERT_EQ(map.cells.size(), 4u);
  EXPECT_EQ(map.cells[0].tried.outcome, Outcome::refused);
  EXPECT_NE(map.cells[0].tried.reason.find("mass"), std::string::npos) << map.cells[0].tried.reason;
  EXPECT_EQ(map.cells[2].tried.outcome, Outcome::stable);
  EXPECT_TRUE(std::isnan(map.limits[0].stable));
  EXPECT_FALSE(stability_map(sweep(oscillator, "mass.mass", "-2,-1"), {}));
}

TEST(Stability, FailingScenesAreWrittenWithTheirFailure) {
  StabilitySettings settings;
  settings.methods = {"rk4"};
  settings.steps = parse_ladder("1e-2:3:8", "steps").value();
  const StabilityMap map = stability_map(sweep(oscillator, "spring.stiffness", "4,100"), settings).value();
  const auto failing = failing_scenes(map, settings);
  ASSERT_FALSE(failing.empty());
  for (const auto& [name, text] : failing) {
    EXPECT_TRUE(text.starts_with("# fails: rk4 at ")) << name;
    const Scene scene = parse_scene(text, name).value();
    const System system = compile(scene).value();
    const Tried again = try_run(system, scene.simulation, scene.simulation.step);
    EXPECT_NE(text.find(std::string("by ") + name_of(again.outcome) + ": " + again.reason), std::string::npos)
        << name;
  }
}

}  // namespace
}  // namespace borelli::stability_test
