// Plots are read back with an independent XML parser; positions are measured by the plot's own ticks.
#include "pipeline/charts/plot.hpp"

#include <gtest/gtest.h>
#include <tinyxml2.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <sstream>

namespace borelli {
namespace {

struct Drawn {
  std::map<std::string, double> x_ticks, y_ticks;             // tick text -> pixel
  std::vector<std::vector<std::pair<double, double>>> lines;  // polylines, in pixels
  std::vector<std::string> texts;
};

void gather(const tinyxml2::XMLElement* element, Drawn& drawn) {
  for (; element; element = element->NextSiblingElement()) {
    const std::string name = element->Name();
    if (name == "text" && element->GetText()) {
      const std::string text = element->GetText(),
                        anchor = element->Attribute("text-anchor", "end") ? "end" : "";
      drawn.texts.push_back(text);
      if (anchor == "end")
        drawn.y_ticks[text] = element->DoubleAttribute("y") - 4;  // text sits 4 px below its tick
      else if (element->Attribute("text-anchor", "middle") && !element->Attribute("transform"))
        drawn.x_ticks[text] = element->DoubleAttribute("x");
    } else if (name == "polyline") {
      std::istringstream points(element->Attribute("points"));
      std::vector<std::pair<double, double>> line;
      double u, v;
      char comma;
      while (points >> u >> comma >> v) line.emplace_back(u, v);
      drawn.lines.push_back(line);
    }
    gather(element->FirstChildElement(), drawn);
  }
}

Drawn drawn(const Plot& plot) {
  tinyxml2::XMLDocument document;
  EXPECT_EQ(document.Parse(svg(plot).c_str()), tinyxml2::XML_SUCCESS) << document.ErrorStr();
  Drawn out;
  gather(document.RootElement(), out);
  return out;
}

// pixels are written with two decimals
constexpr double pixel = 0.011;

TEST(Plot, CurvesMatchTheTicks) {
  Plot plot{"t", {"time (s)"}, {"energy (J)"}, {{"a", {0, 1, 2, 4}, {-20, 0, 40, 60}}}, {}};
  const Drawn d = drawn(plot);
  ASSERT_EQ(d.lines.size(), 1u);
  const std::vector<std::pair<std::string, std::string>> expected{
      {"0", "−20"}, {"1", "0"}, {"2", "40"}, {"4", "60"}};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    ASSERT_TRUE(d.x_ticks.count(expected[i].first)) << expected[i].first;
    ASSERT_TRUE(d.y_ticks.count(expected[i].second)) << expected[i].second;
    EXPECT_NEAR(d.lines[0][i].first, d.x_ticks.at(expected[i].first), pixel);
    EXPECT_NEAR(d.lines[0][i].second, d.y_ticks.at(expected[i].second), pixel);
  }
}

TEST(Plot, LogarithmicAxisHasEvenDecades) {
  Plot plot{"t", {"time (s)"}, {"step (s)", true}, {{"a", {0, 1, 2, 3}, {1e-6, 1e-4, 1, 0}}}, {}};
  const Drawn d = drawn(plot);
  ASSERT_EQ(d.lines.size(), 1u);
  ASSERT_EQ(d.lines[0].size(), 3u);  // a logarithmic axis omits the zero
  EXPECT_NEAR(d.lines[0][0].second, d.y_ticks.at("10⁻⁶"), pixel);
  EXPECT_NEAR(d.lines[0][1].second, d.y_ticks.at("10⁻⁴"), pixel);
  EXPECT_NEAR(d.lines[0][2].second, d.y_ticks.at("1"), pixel);
  EXPECT_NEAR(d.y_ticks.at("10⁻⁶") - d.y_ticks.at("10⁻⁴"), d.y_ticks.at("10⁻⁴") - d.y_ticks.at("10⁻²"),
              2 * pixel);
}

TEST(Plot, ThinningKeepsSpikesAndGaps) {
  Curve curve{"a"};
  for (int i = 0; i < 100000; ++i) {
    curve.x.push_back(i);
    curve.y.push_back(i == 77777 ? 5 : 0);
  }
  curve.y[50000] = std::numeric_limits<double>::quiet_NaN();
  const Drawn d = drawn({"t", {"x"}, {"y"}, {curve}, {}});
  ASSERT_EQ(d.lines.size(), 2u);
  EXPECT_LT(d.lines[0].size() + d.lines[1].size(), 10000u);
  double highest = 1e9;
  for (const auto& p : d.lines[1]) highest = std::min(highest, p.second);
  EXPECT_NEAR(highest, d.y_ticks.at("5"), pixel);
}

TEST(Plot, HandlesDivergedValuesAndMarkupInNames) {
  const double inf = std::numeric_limits<double>::infinity();
  const Drawn d =
      drawn({"a < b & c > d", {"x"}, {"y", false, 0, 1}, {{"k<1>", {0, 1, 2}, {0, 1e300, inf}}}, {"n & m"}});
  ASSERT_EQ(d.lines.size(), 1u);
  for (const auto& p : d.lines[0]) EXPECT_LT(std::abs(p.second), 1e4);
  for (const char* text : {"a < b & c > d", "k<1>", "n & m"})
    EXPECT_NE(std::find(d.texts.begin(), d.texts.end(), text), d.texts.end()) << text;
  EXPECT_TRUE(drawn({"empty", {"x"}, {"y"}, {}, {}}).lines.empty());
}

TEST(Plot, CsvKeepsEveryDigit) {
  const Plot plot{
      "t", {"x"}, {"y"}, {{"a", {0.1, 1. / 3}, {1e-300, M_PI}}, {"b, c", {0.1, 1. / 3}, {2, -3}}}, {"note"}};
  std::istringstream lines(csv(plot));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "# t");
  std::getline(lines, line);
  EXPECT_EQ(line, "# note");
  std::getline(lines, line);
  EXPECT_EQ(line, "x,a,\"b, c\"");
  for (int i = 0; i < 2; ++i) {
    double x, a, b;
    std::getline(lines, line);
    ASSERT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf", &x, &a, &b), 3) << line;
    EXPECT_EQ(x, plot.curves[0].x[i]);
    EXPECT_EQ(a, plot.curves[0].y[i]);
    EXPECT_EQ(b, plot.curves[1].y[i]);
  }
}

TEST(Plot, CsvContainsNoFormula) {
  Plot plot;
  plot.title = "a, \"=1+1\",=2";
  plot.x.label = "t";
  plot.y.label = "x";
  plot.curves = {{"=cmd", {0, 1}, {-1, 2}}};
  const std::string text = csv(plot);
  EXPECT_EQ(text, "# a, \"=1+1\",'=2\nt,'=cmd\n0,-1\n1,2\n");
}

TEST(Plot, CsvOfCurvesWithDifferentTimesIsLong) {
  const Plot plot{"t", {"x"}, {"y"}, {{"a", {0, 1}, {2, 3}}, {"b", {0}, {4}}}, {}};
  EXPECT_EQ(csv(plot), "# t\ncurve,x,y\na,0,2\na,1,3\nb,0,4\n");
}

// collects the numbers of grey curves (the middle of their digits) and the dots
void gather_marks(const tinyxml2::XMLElement* element,
                  std::map<std::string, std::pair<double, double>>& numbers,
                  std::vector<std::pair<double, double>>& dots) {
  for (; element; element = element->NextSiblingElement()) {
    const std::string name = element->Name();
    if (name == "text" && element->Attribute("class", "number"))
      numbers[element->GetText()] = {element->DoubleAttribute("x"), element->DoubleAttribute("y") - 3};
    if (name == "circle") dots.emplace_back(element->DoubleAttribute("cx"), element->DoubleAttribute("cy"));
    gather_marks(element->FirstChildElement(), numbers, dots);
  }
}

TEST(Plot, NumbersOfGreyCurvesDoNotOverlap) {
  // curves that all end near the right edge, close to each other and to a labelled one
  Plot plot{"t", {.label = "x"}, {.label = "y"}, {}};
  const auto add = [&](std::size_t number, double shift) {
    Curve curve{.name = "c" + std::to_string(number), .marks = true, .faint = number > 0, .number = number};
    for (int i = 0; i <= 10; ++i) curve.x.push_back(i), curve.y.push_back(i + shift);
    plot.curves.push_back(curve);
  };
  for (std::size_t n = 0; n <= 12; ++n) add(n, 0.15 * double(n));
  tinyxml2::XMLDocument document;
  ASSERT_EQ(document.Parse(svg(plot).c_str()), tinyxml2::XML_SUCCESS);
  std::map<std::string, std::pair<double, double>> numbers;
  std::vector<std::pair<double, double>> dots;
  gather_marks(document.RootElement(), numbers, dots);
  EXPECT_EQ(numbers.size(), 12u);  // there is room for all
  EXPECT_GE(dots.size(), 13u * 11);
  // digits of 9 px are 5 wide and 6.6 high, dots have a radius of 3.2
  for (const auto& [number, at] : numbers) {
    const double half = 2.5 * double(number.size());
    for (const auto& dot : dots)
      EXPECT_TRUE(std::abs(dot.first - at.first) > half + 3.2 || std::abs(dot.second - at.second) > 6.5)
          << number << " stands on a dot";
    for (const auto& [other, there] : numbers)
      EXPECT_TRUE(other == number || std::abs(there.first - at.first) > half + 2.5 * double(other.size()) ||
                  std::abs(there.second - at.second) > 6.6)
          << number << " and " << other;
  }
}

TEST(Plot, TilesFillTheirRangeInTheirColour) {
  Plot plot{.title = "map",
            .x = {.label = "k", .logarithmic = true, .low = 1, .high = 100},
            .y = {.label = "step (s)", .logarithmic = true, .low = 0.01, .high = 1},
            .curves = {}};
  plot.kinds = {"good", "unseen", "bad"};
  plot.tiles = {{1, 10, 0.01, 0.1, 0, "a tip"}, {10, 100, 0.1, 1, 2, ""}};
  tinyxml2::XMLDocument document;
  ASSERT_EQ(document.Parse(svg(plot).c_str()), tinyxml2::XML_SUCCESS);
  const Drawn d = drawn(plot);
  std::map<std::string, const tinyxml2::XMLElement*> tiles;
  for (const auto* g = document.RootElement()->FirstChildElement("g"); g; g = g->NextSiblingElement("g"))
    if (const auto* rect = g->FirstChildElement("rect"); rect && rect->Attribute("class", "tile"))
      tiles[g->Attribute("data-curve")] = rect;
  ASSERT_EQ(tiles.size(), 2u);
  const auto* good = tiles["good"];
  EXPECT_NEAR(good->DoubleAttribute("x"), d.x_ticks.at("1"), pixel);
  EXPECT_NEAR(good->DoubleAttribute("x") + good->DoubleAttribute("width"), d.x_ticks.at("10"), 2 * pixel);
  EXPECT_NEAR(good->DoubleAttribute("y"), d.y_ticks.at("0.1"), pixel);
  EXPECT_NEAR(good->DoubleAttribute("y") + good->DoubleAttribute("height"), d.y_ticks.at("10⁻²"), 2 * pixel);
  EXPECT_STREQ(good->FirstChildElement("title")->GetText(), "a tip");
  const auto* bad = tiles["bad"];
  EXPECT_NEAR(bad->DoubleAttribute("x"), d.x_ticks.at("10"), pixel);
  EXPECT_NEAR(bad->DoubleAttribute("y"), d.y_ticks.at("1"), pixel);
  // the legend names the curves that exist
  EXPECT_EQ(std::count(d.texts.begin(), d.texts.end(), "good"), 1);
  EXPECT_EQ(std::count(d.texts.begin(), d.texts.end(), "unseen"), 0);
}

}  // namespace
}  // namespace borelli
