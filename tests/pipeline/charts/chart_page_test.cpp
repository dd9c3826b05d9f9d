#include "pipeline/charts/chart_page.hpp"

#include <gtest/gtest.h>

namespace borelli {
namespace {

TEST(ChartPage, PolicyForbidsLoadingAnything) {
  const std::string page = chart_page("a", "b", {"w < x"}, {"c"}, {}, "<p>d</p>");
  EXPECT_NE(page.find("Warning: w &lt; x"), std::string::npos);
  const auto policy = page.find("<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none';");
  ASSERT_NE(policy, std::string::npos);
  for (const char* later : {"<style", "<script", "<body"}) {
    ASSERT_NE(page.find(later), std::string::npos) << later;
    EXPECT_LT(policy, page.find(later)) << later;
  }
  EXPECT_EQ(page.find("src="), std::string::npos);
}

TEST(ChartPage, CsvTextIsNeverAFormula) {
  EXPECT_EQ(csv_text("=1+\"1\""), "\"'=1+\"\"1\"\"\"");
  EXPECT_EQ(csv_text("off by -1"), "\"off by -1\"");
}

}  // namespace
}  // namespace borelli
