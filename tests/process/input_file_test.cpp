// Files that are accepted and refused as input.
#include "process/input_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>

namespace borelli {
namespace {

namespace fs = std::filesystem;

class InputFile : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }
  std::string refusal(const fs::path& path) const {
    const auto read = read_input_file(path, 100);
    return read ? "was read" : read.error().what;
  }
  fs::path folder_ = fs::temp_directory_path() / ("borelli-input-" + std::to_string(getpid()));
};

TEST_F(InputFile, GivesTheFilesBytes) {
  const std::string bytes("a\0b\r\n\xff", 6);
  std::ofstream(folder_ / "a", std::ios::binary) << bytes;
  EXPECT_EQ(read_input_file(folder_ / "a").value(), bytes);
  fs::create_symlink(folder_ / "a", folder_ / "link");
  EXPECT_EQ(read_input_file(folder_ / "link").value(), bytes);
}

// at once, although nobody writes to the pipe and the devices are endless
TEST_F(InputFile, RefusesPipesDevicesFoldersAndLargeFiles) {
  ASSERT_EQ(mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  fs::create_symlink("/dev/zero", folder_ / "zero");
  std::ofstream(folder_ / "large") << std::string(101, 'x');
  std::ofstream(folder_ / "fits") << std::string(100, 'x');
  const std::string other = "is not a regular file but a pipe or a device";
  EXPECT_EQ(refusal(folder_ / "pipe"), other);
  EXPECT_EQ(refusal(folder_ / "zero"), other);
  EXPECT_EQ(refusal("/dev/random"), other);
  EXPECT_EQ(refusal(folder_), "is a folder, expected a file");
  EXPECT_EQ(refusal(folder_ / "none"), "no such file");
  EXPECT_EQ(refusal(folder_ / "fits"), "was read");
  EXPECT_NE(refusal(folder_ / "large").find("exceeds"), std::string::npos) << refusal(folder_ / "large");
  // the system reports no size
  EXPECT_NE(refusal("/proc/self/status").find("exceeds"), std::string::npos);
}

}  // namespace
}  // namespace borelli
