// Lines, cells and numbers of motion files.
#include "pipeline/recordings/text_rows.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/recordings/length_unit.hpp"

namespace borelli::test::text_rows_test {
namespace {

using Cells = std::vector<std::string_view>;

TEST(TextRows, LinesEndAsOnAnySystem) {
  TextRows rows(
      "\xef\xbb\xbf"
      "a\nb\r\n\rc");
  Cells lines;
  while (rows.next()) lines.push_back(rows.line());
  EXPECT_EQ(lines, (Cells{"a", "b", "", "c"}));
  EXPECT_EQ(rows.number(), 4);
}

TEST(TextRows, EmptyCellsBetweenTabsCountAndThoseAtTheEndDoNot) {
  EXPECT_EQ(tab_cells("\ta\t\t b \t\t "), (Cells{"", "a", "", "b"}));
  EXPECT_EQ(tab_cells("  "), Cells{});
  EXPECT_EQ(blank_words(" \ta  b\t"), (Cells{"a", "b"}));
}

TEST(TextRows, NumbersAreFiniteAndWhole) {
  EXPECT_EQ(finite_number("+1.5e-3"), 1.5e-3);
  EXPECT_EQ(finite_number("-0.017"), -0.017);
  EXPECT_EQ(finite_number("1e-400"), 0);
  for (const char* word : {"", "+", "1,5", "1.5x", "inf", "nan", "1e400", "0x10", "--1", "1e"})
    EXPECT_FALSE(finite_number(word)) << word;
  EXPECT_EQ(integer_number("-12"), -12);
  for (const char* word : {"", "1.0", "99999999999999999999", "a"})
    EXPECT_FALSE(integer_number(word)) << word;
}

TEST(TextRows, NaNIsAGapHoweverItIsSpelt) {
  for (const char* word : {"", "nan", "NaN", "-NAN", "-nan(ind)", "1.#QNAN", "-1.#IND", "1.#QNAN0"})
    EXPECT_TRUE(is_gap(word)) << word;
  for (const char* word : {"0", "inf", "none", "1.#INF", "banana"}) EXPECT_FALSE(is_gap(word)) << word;
}

TEST(TextRows, ADecimalSurvivesAChangeOfUnit) {
  for (int i = 1; i < 20000; ++i) {
    const double given = i * 0.123457;
    const std::string text = decimal_text(given);
    const double value = finite_number(text).value();
    EXPECT_EQ(decimal_text(value / 1000 * 1000), text);
    EXPECT_EQ(decimal_text(value / (1 / 0.0254) * (1 / 0.0254)), text);
  }
  EXPECT_EQ(decimal_text(std::nan("")), "NaN");
}

TEST(LengthUnit, NamesInEveryForm) {
  EXPECT_EQ(per_metre("mm"), 1000);
  EXPECT_EQ(per_metre(" Millimeters "), 1000);
  EXPECT_EQ(per_metre("METRES"), 1);
  EXPECT_EQ(per_metre("inches"), 1 / 0.0254);
  EXPECT_EQ(per_metre("feet"), 1 / 0.3048);
  EXPECT_EQ(per_metre("dm"), 10);
  for (const char* word : {"", "s", "ms", "miles", "m m"}) EXPECT_FALSE(per_metre(word)) << word;
}

}  // namespace
}  // namespace borelli::test::text_rows_test
