#include "inertia/csv.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace borelli {
namespace {

TEST(Csv, ReadsCommentsHeaderAndQuotedFields) {
  const auto table = parse_csv(
      "# made by hand\r\npart,note,mass\n\"thigh, left\",\"says \"\"cut\"\"\nhere\",1.5e1\n#x\na,,\n",
      "text");
  ASSERT_TRUE(table) << table.error().message();
  EXPECT_EQ(table->comments, (std::vector<std::string>{"made by hand", "x"}));
  EXPECT_EQ(table->columns, (std::vector<std::string>{"part", "note", "mass"}));
  ASSERT_EQ(table->rows.size(), 2u);
  EXPECT_EQ(table->field(0, "part"), "thigh, left");
  EXPECT_EQ(table->field(0, "note"), "says \"cut\"\nhere");
  EXPECT_EQ(table->number(0, "mass"), 15);
  EXPECT_TRUE(std::isnan(table->number(1, "mass")));
  EXPECT_TRUE(std::isnan(table->number(0, "part")));
  EXPECT_EQ(table->field(0, "no such column"), "");
}

TEST(Csv, FieldsRoundTrip) {
  for (const std::string field : {"plain", "a,b", "say \"x\"", "two\nlines", "# no comment", "", "=1+1",
                                  "@SUM(A1)", "-2", "'=1+1", "''+x", "'s", "\tx", "\rx"}) {
    const auto table = parse_csv("first,second\n" + csv_field(field) + ",x\n", "text");
    ASSERT_TRUE(table) << table.error().message();
    EXPECT_EQ(table->field(0, "first"), field);
  }
}

// Spreadsheets treat a cell that starts with one of these characters as a formula (OWASP, CSV injection).
TEST(Csv, FormulasAreWrittenAsText) {
  for (const std::string formula :
       {"=1+1", "+1", "-1", "@SUM(A1)", "\t=1", "\r=1", "=HYPERLINK(\"x\",\"y\")"}) {
    const std::string field = csv_field(formula);
    const std::string cell = field.starts_with('"') ? field.substr(1) : field;
    EXPECT_TRUE(cell.starts_with('\'')) << field;
  }
  EXPECT_EQ(csv_field("knee's -1"), "knee's -1");
  const auto numbers = parse_csv("name,x\n'-a,-1.5\n", "text");
  ASSERT_TRUE(numbers);
  EXPECT_EQ(numbers->field(0, "name"), "-a");
  EXPECT_EQ(numbers->number(0, "x"), -1.5);
}

TEST(Csv, RefusesDamagedTables) {
  EXPECT_FALSE(parse_csv("", "text"));
  EXPECT_FALSE(parse_csv("# only a comment\n", "text"));
  EXPECT_FALSE(parse_csv("a,b\n\"open,1\n", "text"));
  const auto ragged = parse_csv("a,b\n1,2\n3,4,5\n", "text.csv");
  ASSERT_FALSE(ragged);
  EXPECT_EQ(ragged.error().message(),
            "text.csv: row 2 (\"3\" ...) has 3 fields, but the header names 2 columns");
  EXPECT_EQ(parse_csv("a,b\n\"1\n2" + std::string(100, 'x') + "\"\n", "text.csv").error().message(),
            "text.csv: row 1 (\"1<0a>2" + std::string(37, 'x') +
                "...\" ...) has 1 fields, but the header names 2 columns");
}

}  // namespace
}  // namespace borelli
