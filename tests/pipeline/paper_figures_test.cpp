// The paper's figures show what the paper states: Euler gains energy, Runge-Kutta does not, and the adaptive
// method shortens its step only at the shocks.
#include "pipeline/paper/paper_figures.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace borelli {
namespace {

const std::vector<PaperFigure>& figures() {
  static const auto all = [] {
    PaperFigureSettings s;
    s.shock_end = 1;  // the first shock, at about 0.45 s
    s.shock_step = 2e-4;
    s.shock_ratios.mass_ratios = {1, 20, 200};
    s.shock_ratios.end = 1;
    s.bars_end = 0.5;
    s.counts = {3, 7};
    s.repeats = 3;
    return paper_figures(s);
  }();
  EXPECT_TRUE(all) << all.error().message();
  static const std::vector<PaperFigure> none;
  return all ? *all : none;
}

const Plot& figure(const std::string& name) {
  static const Plot empty;
  for (const PaperFigure& f : figures())
    if (f.name == name) return f.plot;
  ADD_FAILURE() << "no " << name;
  return empty;
}

// Largest distance of the total energy from its start.
double strays(const std::string& name) {
  double most = 0;
  for (const double e : figure(name).curves.at(1).y)
    most = std::max(most, std::abs(e - figure(name).curves[1].y[0]));
  return most;
}

TEST(PaperFigures, AreComplete) {
  for (const char* name : {"figure_2", "figure_3", "figure_4", "figure_6", "figure_7", "figure_8",
                           "figures_6_7_8_cost", "figure_10"}) {
    const Plot& plot = figure(name);
    EXPECT_FALSE(plot.curves.empty());
    const bool of_time = name != std::string("figure_10") && name != std::string("figures_6_7_8_cost");
    EXPECT_EQ(plot.x.label.find("(s)") != std::string::npos, of_time) << plot.x.label;
    EXPECT_EQ(plot.y.label.find('(') == std::string::npos, name == std::string("figures_6_7_8_cost"))
        << "an axis without its unit";
    EXPECT_FALSE(plot.notes.empty());
  }
}

TEST(PaperFigures, EulerGainsEnergyAndIsMarkedUntrusted) {
  const std::vector<double>& total = figure("figure_2").curves.at(1).y;
  // means of the first and last second, J, of about 89 J
  const std::size_t second = total.size() / 5;
  double begin = 0, end = 0;
  for (std::size_t i = 0; i < second; ++i)
    begin += total[i] / static_cast<double>(second),
        end += total[total.size() - 1 - i] / static_cast<double>(second);
  EXPECT_GT(end - begin, 4);  // measured: 6.6
  EXPECT_NE(figure("figure_2").notes.at(0).find("UNTRUSTED"), std::string::npos);
  EXPECT_EQ(figure("figure_4").notes.at(0).find("UNTRUSTED"), std::string::npos);
}

TEST(PaperFigures, HigherOrderDriftsLess) {
  // measured: Euler 8.9, RK2 0.12, RK4 1.2e-4 J; each higher order gains more than a factor of ten at this
  // step
  EXPECT_GT(strays("figure_2"), 10 * strays("figure_3"));
  EXPECT_GT(strays("figure_3"), 100 * strays("figure_4"));
}

TEST(PaperFigures, KineticAndPotentialAddUpToTheTotal) {
  for (const char* name : {"figure_2", "figure_3", "figure_4", "figure_6", "figure_7"}) {
    const auto& c = figure(name).curves;
    for (std::size_t i = 0; i < c[0].y.size(); i += 10) EXPECT_DOUBLE_EQ(c[0].y[i] + c[2].y[i], c[1].y[i]);
  }
}

TEST(PaperFigures, AdaptiveStepsAreShortOnlyAtTheShock) {
  const Curve& steps = figure("figure_8").curves.at(0);
  const auto smallest = std::min_element(steps.y.begin() + 5, steps.y.end()) - steps.y.begin();
  // the cube falls 1 m almost freely in sqrt(2 / g); the bar has less than 1 % of the inertia
  EXPECT_NEAR(steps.x[static_cast<std::size_t>(smallest)], std::sqrt(2 / 9.81), 0.01);
  const double largest = *std::max_element(steps.y.begin(), steps.y.end());
  EXPECT_GT(largest, 100 * steps.y[static_cast<std::size_t>(smallest)]);
  EXPECT_LT(strays("figure_7"),
            0.1 * strays("figure_6"));  // still it keeps the energy better than the fixed step
}

TEST(PaperFigures, FixedStepsCostMoreForHeavierCubes) {
  const auto& curves = figure("figures_6_7_8_cost").curves;
  ASSERT_EQ(curves.size(), 5u);
  std::vector<double> ratio;
  for (std::size_t i = 0; i < 3; ++i) ratio.push_back(curves[0].y.at(i) / curves[1].y.at(i));
  EXPECT_GT(ratio[0], 1);
  EXPECT_GT(ratio[1], 3 * ratio[0]);
  EXPECT_GT(ratio[2], 3 * ratio[1]);
  EXPECT_GT(ratio[2],
            30);  // with cubes of 200 kg; the paper's authors measured 40 in CPU time, without their masses
  // at least one of today's methods is faster than the paper's adaptive one
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_LT(std::min({curves[2].y.at(i), curves[3].y.at(i), curves[4].y.at(i)}), curves[1].y.at(i));
}

TEST(PaperFigures, ExecutionTimesGrowWithN) {
  const Plot& plot = figure("figure_10");
  ASSERT_EQ(plot.curves.size(), 4u);
  for (const Curve& c : plot.curves) {
    ASSERT_EQ(c.y.size(), 2u);
    EXPECT_GT(c.y[0], 0) << c.name;
  }
  // an n-pendulum's equations cost more than n bars' (7 of each, the same fixed steps)
  EXPECT_GT(plot.curves[2].y[1], plot.curves[0].y[1]);
}

}  // namespace
}  // namespace borelli
