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

TEST(Csv, FieldsComeBackAsTheyWere) {
  for (const std::string field : {"plain", "a,b", "say \"x\"", "two\nlines", "# no comment", ""}) {
    const auto table = parse_csv("first,second\n" + csv_field(field) + ",x\n", "text");
    ASSERT_TRUE(table) << table.error().message();
    EXPECT_EQ(table->field(0, "first"), field);
  }
}

TEST(Csv, RefusesDamagedTables) {
  EXPECT_FALSE(parse_csv("", "text"));
  EXPECT_FALSE(parse_csv("# only a comment\n", "text"));
  EXPECT_FALSE(parse_csv("a,b\n\"open,1\n", "text"));
  const auto ragged = parse_csv("a,b\n1,2\n3,4,5\n", "text.csv");
  ASSERT_FALSE(ragged);
  EXPECT_EQ(ragged.error().message(),
            "text.csv: row 2 (\"3\" ...) has 3 fields, and the header names 2 columns");
}

}  // namespace
}  // namespace borelli
