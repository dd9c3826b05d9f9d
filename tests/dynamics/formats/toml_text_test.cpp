// Deep nesting is refused before the library recurses into it. Faults are reported with their place.
#include "dynamics/formats/toml_text.hpp"

#include <gtest/gtest.h>

namespace borelli {
namespace {

std::string times(int count, const std::string& text) {
  std::string out;
  for (int i = 0; i < count; ++i) out += text;
  return out;
}

TEST(TomlText, RefusesDeepNestingWithItsLine) {
  for (const std::string& text :
       {"x = 1\n" + times(100'000, "a.") + "a = 1", "x = 1\n[" + times(100'000, "a.") + "a]",
        "x = 1\n[[" + times(100'000, "a . ") + "a]]", "x = 1\n" + times(100'000, "'a b'.") + "a = 1",
        "x = 1\na = " + times(100'000, "["), "x = 1\na = " + times(100'000, "{a ="),
        "x = 1\na = " + times(20, "{a.a.a.a.a.a = ") + "1" + times(20, "}"),
        "x = \"\"\"a\\\"\"\"\"\na = [" + times(100, "[") + times(100, "]") + "]"}) {
    const auto read = parse_toml(text, "f.toml");
    ASSERT_FALSE(read) << text.substr(0, 40);
    EXPECT_EQ(read.error().message(), "f.toml:2: tables and lists are nested deeper than 100");
  }
}

TEST(TomlText, ReadsTextThatOnlyLooksNested) {
  const auto read =
      parse_toml(times(99, "a.") + "a = 1\n# " + times(200, "[.") + "\nb = \"" + times(200, "{.") +
                     "\"\nc = '''\n" + times(200, "[.") + "'''\nd = [" + times(200, "1.5, ") + "]\ne = [" +
                     times(200, "{f.g = [1.5]}, ") + "]\n" + times(200, "[[h.i]]\nj.k = 1\n"),
                 "f.toml");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ((*read)["d"].as_array()->size(), 200u);
  EXPECT_EQ((*read)["h"]["i"].as_array()->size(), 200u);
}

TEST(TomlText, ReportsFaultsWithLineAndColumn) {
  const auto read = parse_toml("a = 1\nb =\n", "f.toml");
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().message().find("f.toml:2: is not TOML at column 4: expected value, saw "), 0u)
      << read.error().message();
  for (const auto& [text, words] :
       {std::pair{"a = 1e400", ": a value is too large, or not written as TOML writes it"},
        {"a = \"\xff\"", ": its bytes are not UTF-8"},
        {"a = \"x", ": the file ends too early"}}) {
    const auto bad = parse_toml(text, "f.toml");
    ASSERT_FALSE(bad) << text;
    const std::string said = bad.error().message();
    EXPECT_TRUE(said.starts_with("f.toml:1: is not TOML at column ") && said.ends_with(words)) << said;
  }
}

}  // namespace
}  // namespace borelli
