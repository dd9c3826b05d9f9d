// Texts with known values, and texts with one fault each: the error names file, line and what was found.
#include "error/json_text.hpp"

#include <gtest/gtest.h>

namespace borelli {
namespace {

std::string repeated(const std::string& text, int count) {
  std::string out;
  for (int i = 0; i < count; ++i) out += text;
  return out;
}

TEST(JsonText, ParsesValuesAndCanKeepTheOrderOfMembers) {
  const auto read = parse_json(R"({"a": [1, -2.5, true, null], "b": {"c": "x\n"}})", "f.json");
  ASSERT_TRUE(read);
  EXPECT_EQ(*read, (nlohmann::json{{"a", {1, -2.5, true, nullptr}}, {"b", {{"c", "x\n"}}}}));
  const auto ordered = parse_ordered_json(R"({"b": 1, "a": 2})", "f.json");
  ASSERT_TRUE(ordered);
  EXPECT_EQ(ordered->begin().key(), "b");
  EXPECT_TRUE(parse_json(repeated("[", 100) + repeated("]", 100), "f.json"));
}

TEST(JsonText, ErrorsNameFileLineAndWrongWord) {
  for (const auto& [text, said] : std::initializer_list<std::pair<std::string, std::string>>{
           {"", "f.json:1: is empty, expected JSON"},
           {"{\"a\":\n [1, 2", "f.json:2: is not JSON: it ends too early and may be cut off"},
           {"{\"a\":\n\n }", "f.json:3: is not JSON: found '}'"},
           {"[1] 2", "f.json:1: is not JSON: found '2'"},
           {"\xff", "f.json:1: is not JSON: found '<ff>'"},
           {"[NaN]", "f.json:1: is not JSON: found 'N'"},
           {"[0, 1}", "f.json:1: is not JSON: found '}'"},
           {"{\"a\": 1 \"b c\": 2}", "f.json:1: is not JSON: found '\"b c\"'"},
           {"{true: 1}", "f.json:1: is not JSON: found 'true'"},
           {"{\"q\":\n [1e999]}", "f.json:2: the number 1e999 is too large"},
           {"{\"a\": 1, \"a\": 2}", "f.json: \"a\" appears twice"},
           {repeated("[", 1'000'000), "f.json: lists and objects are nested deeper than 100"},
           {repeated("{\"a\":", 1'000'000), "f.json: lists and objects are nested deeper than 100"}}) {
    const auto read = parse_json(text, "f.json");
    ASSERT_FALSE(read) << text.substr(0, 40);
    EXPECT_EQ(read.error().message(), said);
  }
}

// Quadratic insertion would take minutes.
TEST(JsonText, ReadsLargeObjectsInLinearTime) {
  std::string text = "{";
  for (int n = 0; n < 300'000; ++n) text += "\"" + std::to_string(n) + "\":0,";
  const auto ordered = parse_ordered_json(text + "\"last\":1}", "f.json");
  ASSERT_TRUE(ordered);
  EXPECT_EQ(ordered->size(), 300'001U);
  EXPECT_EQ(std::prev(ordered->end()).key(), "last");
  EXPECT_FALSE(parse_ordered_json(text + "\"7\":1}", "f.json"));
}

TEST(JsonText, ChecksTypesAgainstAPattern) {
  using nlohmann::json;
  const json pattern{{"name", ""}, {"stages", json::array({{{"seconds", 0}, {"any", nullptr}}})}};
  EXPECT_TRUE(check_kinds({{"name", "x"}, {"stages", json::array()}, {"more", 1}}, pattern, "f"));
  EXPECT_TRUE(check_kinds({{"stages", json::array({{{"seconds", 2.5}, {"any", 3}}})}}, pattern, "f"));
  for (const auto& [document, said] : std::initializer_list<std::pair<json, std::string>>{
           {{{"name", 1}}, "f: name is the number 1, expected a text"},
           {{{"stages", json::array({json::object(), {{"seconds", "x"}}})}},
            "f: stages[1].seconds is the text \"x\", expected a number"},
           {json::array({1}), "f: the document is a list of 1, expected an object"}}) {
    const auto fine = check_kinds(document, pattern, "f");
    ASSERT_FALSE(fine) << document;
    EXPECT_EQ(fine.error().message(), said);
  }
}

TEST(JsonText, InvalidUtf8IsReplaced) {
  const nlohmann::json value{{"name", "Gr\xfc\xdf"}};
  EXPECT_EQ(json_text(value, -1), "{\"name\":\"Gr\xef\xbf\xbd\xef\xbf\xbd\"}");
}

}  // namespace
}  // namespace borelli
