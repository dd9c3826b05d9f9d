#include "process/memory.hpp"

#include <gtest/gtest.h>
#include <sys/sysinfo.h>

#include <vector>

namespace borelli {
namespace {

TEST(Memory, FreeMemoryIsBelowTheMachines) {
  struct sysinfo machine {};
  ASSERT_EQ(sysinfo(&machine), 0);
  EXPECT_GT(free_memory(), 1U << 20);
  EXPECT_LE(free_memory(), machine.totalram * machine.mem_unit);
}

TEST(Memory, AdmitsWhatFitsAndNamesTheRest) {
  const std::uint64_t before = memory_limit();
  set_memory_limit(std::uint64_t{8} << 30);
  EXPECT_TRUE(admit_memory("scan.nii", "its grid", 1e9));
  const auto refused = admit_memory("scan.nii", "its grid", 2e12);  // 10^12 voxels of two bytes
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().where, "scan.nii");
  EXPECT_EQ(
      refused.error().what.find("its grid needs 2e+03 GB of memory; 8.59 GB may be used (--max-memory), "),
      0U)
      << refused.error().what;
  set_memory_limit(before);
}

TEST(Memory, ReadsSizesAsUsersWriteThem) {
  EXPECT_EQ(bytes_from("4G"), 4'000'000'000U);
  EXPECT_EQ(bytes_from("1.5 GiB"), std::uint64_t{3} << 29);
  EXPECT_EQ(bytes_from("500mb"), 500'000'000U);
  EXPECT_EQ(bytes_from("64K"), 64'000U);
  EXPECT_EQ(bytes_from("1048576"), 1048576U);
  for (const char* none : {"", "G", "4X", "4GG", "-4G", "nan", "inf", "1e30T", "4 G B x"})
    EXPECT_FALSE(bytes_from(none)) << none;
}

TEST(Memory, CountsMemoryInUse) {
  const std::uint64_t before = memory_limit();
  set_memory_limit(std::uint64_t{200} << 20);
  EXPECT_TRUE(admit_memory("", "as much", 120e6));
  const std::vector<char> used(std::size_t{100} << 20, 'x');
  EXPECT_FALSE(admit_memory("", "as much again", 120e6));
  EXPECT_EQ(used.back(), 'x');  // keeps the compiler from removing it
  set_memory_limit(before);
}

}  // namespace
}  // namespace borelli
