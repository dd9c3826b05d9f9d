#include "pipeline/recordings/c3d_numbers.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>

namespace borelli::test::c3d_numbers_test {
namespace {

std::string raw(std::initializer_list<int> bytes) {
  std::string out;
  for (const int byte : bytes) out += static_cast<char>(byte);
  return out;
}

TEST(C3dNumbers, ProcessorIsByteEightyFourAndOn) {
  EXPECT_EQ(c3d_processor(84), C3dProcessor::intel);
  EXPECT_EQ(c3d_processor(85), C3dProcessor::dec);
  EXPECT_EQ(c3d_processor(86), C3dProcessor::mips);
  EXPECT_FALSE(c3d_processor(83));
  EXPECT_FALSE(c3d_processor(0));
}

TEST(C3dNumbers, IntegersAreLowByteFirstExceptOnMips) {
  const std::string bytes = raw({0x34, 0xf2});
  EXPECT_EQ(c3d_word(bytes.data(), C3dProcessor::intel), 0xf234);
  EXPECT_EQ(c3d_word(bytes.data(), C3dProcessor::dec), 0xf234);
  EXPECT_EQ(c3d_word(bytes.data(), C3dProcessor::mips), 0x34f2);
  EXPECT_EQ(c3d_integer(bytes.data(), C3dProcessor::intel), 0xf234 - 0x10000);
}

// The bytes of VAX F floating that the test program of USGS's libvaxdata (Open-File Report 2005-1424) prints.
TEST(C3dNumbers, VaxNumbersAreThoseOfPublishedBytes) {
  const std::pair<std::string, double> published[] = {{raw({0x80, 0x40, 0, 0}), 1},
                                                      {raw({0x80, 0xc0, 0, 0}), -1},
                                                      {raw({0x60, 0x41, 0, 0}), 3.5},
                                                      {raw({0x60, 0xc1, 0, 0}), -3.5},
                                                      {raw({0x49, 0x41, 0xd0, 0x0f}), 3.14159},
                                                      {raw({0x49, 0xc1, 0xd0, 0x0f}), -3.14159},
                                                      {raw({0xf0, 0x7d, 0xc2, 0xbd}), 1e37},
                                                      {raw({0x08, 0x03, 0xea, 0x1c}), 1e-37},
                                                      {raw({0x9e, 0x40, 0x52, 0x06}), 1.23456789}};
  for (const auto& [bytes, value] : published)
    EXPECT_NEAR(c3d_real(bytes.data(), C3dProcessor::dec), value, std::abs(value) * 6e-8) << value;
  EXPECT_EQ(c3d_real(raw({0, 0, 0, 0}).data(), C3dProcessor::dec), 0);
  EXPECT_EQ(c3d_real(raw({0x7f, 0, 1, 2}).data(), C3dProcessor::dec), 0);             // exponent 0: zero
  EXPECT_TRUE(std::isnan(c3d_real(raw({0, 0x80, 0, 0}).data(), C3dProcessor::dec)));  // reserved operand
}

TEST(C3dNumbers, ReadsIeeeFloatsInBothByteOrders) {
  for (const float value :
       {0.0F, 1.0F, -2.5F, 3.14159F, 1e-38F, -3e38F, std::numeric_limits<float>::infinity()}) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    const auto byte = [&](int i) { return static_cast<int>(bits >> (8 * i) & 0xff); };
    EXPECT_EQ(c3d_real(raw({byte(0), byte(1), byte(2), byte(3)}).data(), C3dProcessor::intel), value);
    EXPECT_EQ(c3d_real(raw({byte(3), byte(2), byte(1), byte(0)}).data(), C3dProcessor::mips), value);
  }
}

}  // namespace
}  // namespace borelli::test::c3d_numbers_test
