#include "pipeline/recordings/c3d_parameters.hpp"

#include <gtest/gtest.h>

#include "tests/pipeline/recordings/c3d_trial.hpp"
#include "tests/pipeline/recordings/c3d_writer.hpp"

namespace borelli::test::c3d_parameters_test {
namespace {

using test::C3dWriter;

C3dParameters parameters_of(const C3dWriter& writer, std::vector<std::string>& warnings) {
  const std::string bytes = writer.bytes();
  const std::size_t start = static_cast<std::size_t>(512 * (writer.parameter_block - 1));
  auto read =
      read_c3d_parameters(bytes, start, bytes.size(),
                          *c3d_processor(static_cast<std::uint8_t>(writer.processor)), "a.c3d", warnings);
  EXPECT_TRUE(read);
  return std::move(*read);
}

class C3dParametersOf : public testing::TestWithParam<C3dWriter::Processor> {};

TEST_P(C3dParametersOf, EveryTypeAndDimensionComesBack) {
  for (const bool locked : {false, true})
    for (const std::string order : {"first", "last"}) {
      C3dWriter writer;
      writer.processor = GetParam();
      writer.locked = locked;
      writer.group_order = order;
      writer.parameter_block = locked ? 3 : 2;
      writer.text("POINT:LABELS", {"LASI", "a long one", ""});
      writer.text("POINT:LABELS2", {"other"});
      writer.line("POINT:UNITS", "mm  ");
      writer.bytes_of("SEG:BYTES", {1, -2, 127}, {3});
      writer.integers("ANALOG:OFFSET", {-32768, 0, 32767, -1}, {4});
      writer.reals("SEG:LIMITS", {-1.5, 2.25, 1e20, 4, 5, 6}, {3, 2});
      writer.reals("SEG:SEVEN", std::vector<double>(64, 0.5), {2, 2, 2, 2, 2, 2, 1});
      writer.integers("SEG:NONE", {}, {0});
      writer.real_number("POINT:RATE", 119.88);
      std::vector<std::string> warnings;
      const C3dParameters read = parameters_of(writer, warnings);
      EXPECT_TRUE(warnings.empty()) << warnings[0];
      EXPECT_EQ(read.texts("POINT", "LABELS"), (std::vector<std::string>{"LASI", "a long one", "", "other"}));
      EXPECT_EQ(read.line("POINT", "UNITS"), "mm");
      EXPECT_EQ(read.numbers("SEG", "BYTES"), (std::vector<double>{1, -2, 127}));
      EXPECT_EQ(read.numbers("ANALOG", "OFFSET"), (std::vector<double>{-32768, 0, 32767, -1}));
      EXPECT_EQ(read.numbers("SEG", "LIMITS"), (std::vector<double>{-1.5, 2.25, 1e20F, 4, 5, 6}));
      EXPECT_EQ(read.find("SEG", "LIMITS")->dimensions, (std::vector<int>{3, 2}));
      EXPECT_EQ(read.find("SEG", "SEVEN")->dimensions.size(), 7);
      EXPECT_EQ(read.numbers("SEG", "SEVEN"), std::vector<double>(64, 0.5));
      EXPECT_TRUE(read.numbers("SEG", "NONE").empty());
      EXPECT_EQ(read.number("POINT", "RATE"), 119.88F);
      EXPECT_EQ(read.find("POINT", "ABSENT"), nullptr);
      EXPECT_EQ(read.find("ABSENT", "POINT"), nullptr);
      EXPECT_FALSE(read.number("SEG", "NONE"));
    }
}
INSTANTIATE_TEST_SUITE_P(C3dParameters, C3dParametersOf,
                         testing::Values(C3dWriter::intel, C3dWriter::dec, C3dWriter::mips));

TEST(C3dParameters, CountsAreUnsigned) {
  C3dWriter writer;
  writer.integer("POINT:FRAMES", 40000);
  writer.bytes_of("POINT:BYTE", {200}, {});
  writer.real_number("POINT:LONG_FRAMES", 100000.5);
  writer.real_number("POINT:LESS", -1);
  std::vector<std::string> warnings;
  const C3dParameters read = parameters_of(writer, warnings);
  EXPECT_EQ(read.number("POINT", "FRAMES"), 40000 - 65536);
  EXPECT_EQ(read.count("POINT", "FRAMES"), 40000);
  EXPECT_EQ(read.count("POINT", "BYTE"), 200);
  EXPECT_EQ(read.count("POINT", "LONG_FRAMES"), 100000);
  EXPECT_FALSE(read.count("POINT", "LESS"));
}

TEST(C3dParameters, WhatCannotBeReadIsLeftOutAndNamed) {
  C3dWriter writer;
  writer.add("POINT:STRANGE", 3, {}, "abc");
  writer.add("POINT:EIGHT", 2, {1, 1, 1, 1, 1, 1, 1, 1}, "ab");
  writer.add("POINT:GREEDY", 4, {255, 255, 255}, "abcd");
  writer.integer("POINT:GOOD", 7);
  std::vector<std::string> warnings;
  const C3dParameters read = parameters_of(writer, warnings);
  EXPECT_EQ(read.number("POINT", "GOOD"), 7);
  EXPECT_TRUE(test::has_warning(warnings, "STRANGE has unknown type 3"));
  EXPECT_TRUE(test::has_warning(warnings, "EIGHT has 8 dimensions"));
  EXPECT_TRUE(test::has_warning(warnings, "GREEDY overlaps the next one"));
  EXPECT_EQ(read.find("POINT", "GREEDY"), nullptr);
}

TEST(C3dParameters, SectionThatIsCutShortIsRefused) {
  C3dWriter writer;
  writer.text("POINT:LABELS", {"LASI", "RASI"});
  const std::string bytes = writer.bytes();
  for (const std::size_t size : {517, 525, 534, 545, 552}) {
    std::vector<std::string> warnings;
    const auto read =
        read_c3d_parameters(bytes.substr(0, size), 512, 1024, C3dProcessor::intel, "a.c3d", warnings);
    ASSERT_FALSE(read) << size;
    EXPECT_NE(read.error().message().find("a.c3d: ends in the parameter"), std::string::npos);
  }
}

TEST(C3dParameters, GarbageBehindTheSectionIsNoParameter) {
  C3dWriter writer;
  writer.integer("POINT:USED", 3);
  std::string bytes = writer.bytes();
  const auto end = bytes.find("DATA_START") + std::string("DATA_START").size();
  bytes[end] = 30;  // the next record is said to be further on, where bytes without sense stand
  bytes.replace(end + 30, 6, "\x03\x02\x01\x07\x05\x01");
  std::vector<std::string> warnings;
  const auto read = read_c3d_parameters(bytes, 512, 1024, C3dProcessor::intel, "a.c3d", warnings);
  EXPECT_EQ(read->number("POINT", "USED"), 3);
  EXPECT_TRUE(test::has_warning(warnings, "damaged from byte"));
}

}  // namespace
}  // namespace borelli::test::c3d_parameters_test
