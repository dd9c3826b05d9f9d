// The section on joint moments, against pendulums whose moments are known in closed form.
#include "pipeline/report/effort_section.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <regex>
#include <vector>

#include "tests/pipeline/pendulum_efforts.hpp"

namespace borelli::test::effort_section_test {
namespace {

using nlohmann::json;

/// The text of a table's cells, row by row, without the header.
std::vector<std::vector<std::string>> rows_of(const std::string& html, const std::string& table) {
  const auto from = html.find("class=\"numbers " + table + "\"");
  const std::string body = html.substr(from, html.find("</table>", from) - from);
  std::vector<std::vector<std::string>> rows;
  const std::regex row("<tr><th scope=\"row\">(.*)</tr>"), cell("([^<>]*)</t[hd]>");
  for (auto at = std::sregex_iterator(body.begin(), body.end(), row); at != std::sregex_iterator(); ++at) {
    const std::string cells = (*at)[1].str();
    rows.emplace_back();
    for (auto c = std::sregex_iterator(cells.begin(), cells.end(), cell); c != std::sregex_iterator(); ++c)
      rows.back().push_back((*c)[1]);
  }
  return rows;
}

/// Size of the largest power, from samples a thousand times as dense as the data's.
double largest_power(const Pendulum& shank) {
  double largest = 0;
  for (int i = 0; i <= 200'000; ++i) largest = std::max(largest, std::abs(shank.power(i * 1e-5)));
  return largest;
}

double number_in(std::string text) {
  if (text.starts_with("−")) text.replace(0, std::string("−").size(), "-");
  return std::stod(text);
}

TEST(EffortSection, TabulatesPeaksOfPendulums) {
  const auto made = effort_section(pendulum_efforts("swing.trc"));
  ASSERT_TRUE(made) << made.error().message();
  const auto rows = rows_of(made->html, "peaks");
  ASSERT_EQ(rows.size(), 5u);
  // the knees come before the hip, left before right, in contrast to the data
  const std::vector<std::pair<std::string, Pendulum>> knees{{"Left knee, flexion", left_shank()},
                                                            {"Right knee, flexion", right_shank()}};
  for (std::size_t i = 0; i < 2; ++i) {
    const auto& [label, shank] = knees[i];
    const double peak = shank.peak();
    EXPECT_EQ(rows[i][0], label);
    EXPECT_EQ(rows[i][1], fmt::format("{:.2f} ± {:.2f}", peak, 0.1 * peak));
    EXPECT_EQ(rows[i][2], fmt::format("{:.3f} ± {:.3f}", peak / 50, 0.1 * peak / 50));
    EXPECT_EQ(rows[i][3], fmt::format("{:.2f}", shank.start + 0.5));
    // half a sample (0.005 s) beside the peak costs under 0.1 %, the table's three digits 0.5 %
    const double power = number_in(rows[i][4]), largest = largest_power(shank);
    EXPECT_NEAR(std::abs(power), largest, 0.006 * largest);
    // upward and downward swings have the same peak size; the sign must match the named time
    EXPECT_NEAR(shank.power(number_in(rows[i][5])), power, 0.006 * largest);
    EXPECT_EQ(rows[i][6], "joint centres, 60 %");
  }
  EXPECT_EQ(rows[2],
            (std::vector<std::string>{"Left hip, flexion", "−3.00", "−0.060", "0.00", "0", "0.00", "–"}));
  EXPECT_EQ(rows[4][0], "Left hip, internal rotation");
  EXPECT_EQ(rows[4][1], "−9.00");
}

TEST(EffortSection, ComparesResidualsWithTheAdvice) {
  const auto made = effort_section(pendulum_efforts("swing.trc"));
  ASSERT_TRUE(made);
  const auto rows = rows_of(made->html, "residuals");
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[1], (std::vector<std::string>{"lower_trunk_z", "1.20 N", "3.40 N", "0.34 %", "within 5 %"}));
  EXPECT_EQ(rows[2], (std::vector<std::string>{"lower_trunk_turn.x", "0.500 N m", "1.50 N m", "–", "–"}));
  EXPECT_NE(made->html.find("<td class=\"number\">6.1 %</td><td class=\"number\"><strong>above 5 %</strong>"),
            std::string::npos);
}

TEST(EffortSection, EscapesNames) {
  const auto made = effort_section(pendulum_efforts("<b id=x>.trc"));
  ASSERT_TRUE(made);
  EXPECT_EQ(made->html.find("<b id"), std::string::npos);
  EXPECT_NE(made->html.find("&lt;b id=x&gt;.trc"), std::string::npos);
}

TEST(EffortSection, KeepsThePeaksOfCurvesThatItThins) {
  json efforts = pendulum_efforts("swing.trc");
  json& moment = efforts["coordinates"][0]["moment"];
  json& times = efforts["times"];
  const std::size_t count = 20'000;
  for (json& c : efforts["coordinates"])
    for (const char* key : {"angle_deg", "moment", "deviation", "power"})
      if (c.contains(key)) c[key] = std::vector<double>(count, 0.123456789);
  for (json& f : efforts["forces"]) {
    f["force"] = std::vector<std::vector<double>>(count, {1, 2, 3});
    f["point"] = std::vector<json>(count);
  }
  times = json::array();
  for (std::size_t i = 0; i < count; ++i) times.push_back(5 + 0.001 * double(i));
  moment[7] = -321.5;
  const auto made = effort_section(efforts);
  ASSERT_TRUE(made) << made.error().message();
  EXPECT_LE(made->page["times"].size(), 1502u);
  EXPECT_GE(made->page["times"].size(), 1400u);
  EXPECT_EQ(made->page["times"].back(), times.back());
  EXPECT_EQ(made->page["forces"][0]["point"].size(), made->page["times"].size());
  const json& hip = made->page["coordinates"][2];
  EXPECT_EQ(hip["label"], "left hip, flexion");
  EXPECT_EQ(hip["moment"].size(), made->page["times"].size());
  EXPECT_EQ(hip["moment"][0], 0.12346);
  EXPECT_EQ(hip["peak"]["moment"], -321.5);
  EXPECT_EQ(hip["peak"]["time"], times[7]);
}

TEST(EffortSection, NamesWhatIsMissing) {
  json efforts = pendulum_efforts("swing.trc");
  efforts["coordinates"][3]["moment"].erase(0);
  EXPECT_EQ(
      effort_section(efforts).error().message(),
      "motion/efforts.json: coordinate 'knee_right': 'moment' has 200 values; expected one for each of the "
      "201 times");
  efforts = pendulum_efforts("swing.trc");
  efforts["forces"][0].erase("point");
  EXPECT_EQ(effort_section(efforts).error().message(),
            "motion/efforts.json: force 'foot_left on plate 1': 'point' is missing");
  efforts["times"] = json::array();
  EXPECT_EQ(effort_section(efforts).error().message(), "motion/efforts.json: 'times' is missing or empty");
  EXPECT_FALSE(effort_section(json("text")));
}

}  // namespace
}  // namespace borelli::test::effort_section_test
