// Programs fed through a pipe: their input, their end, and errors if they fail.
#include "process/program_pipe.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>
#include <vector>

namespace borelli::test::program_pipe_test {
namespace {

namespace fs = std::filesystem;

class Pipe : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "borelli-pipe-XXXXXX").string();
    ASSERT_TRUE(mkdtemp(name.data()));
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string content(const std::string& name) const {
    std::ostringstream text;
    text << std::ifstream(folder_ / name, std::ios::binary).rdbuf();
    return text.str();
  }
  fs::path folder_;
};

TEST_F(Pipe, GivesAllBytesInOrder) {
  std::vector<std::uint8_t> bytes(3'000'000);  // more than a socket buffers
  for (std::size_t n = 0; n < bytes.size(); ++n) bytes[n] = static_cast<std::uint8_t>(n * n >> 5);
  auto program = ProgramPipe::start({"sh", "-c", "cat > \"$0\"", (folder_ / "out").string()});
  ASSERT_TRUE(program) << program.error().message();
  const std::span<const std::uint8_t> all = bytes;
  ASSERT_TRUE(program->write(all.first(1000)));
  ASSERT_TRUE(program->write(all.subspan(1000)));
  ASSERT_TRUE(program->finish());
  EXPECT_EQ(content("out"), std::string(bytes.begin(), bytes.end()));
}

TEST_F(Pipe, RepeatsTheLastLineOfAProgramThatFails) {
  auto program = ProgramPipe::start({"sh", "-c", "echo first >&2; echo 'no room' >&2; exit 3"});
  ASSERT_TRUE(program);
  const std::vector<std::uint8_t> bytes(1 << 20);
  Result<void> written;
  for (int n = 0; n < 100 && written; ++n) written = program->write(bytes);
  ASSERT_FALSE(written);  // SIGPIPE did not end this test
  EXPECT_EQ(written.error().message(), "sh: stopped early: no room");
  auto other = ProgramPipe::start({"sh", "-c", "exit 1"});
  ASSERT_TRUE(other);
  EXPECT_FALSE(other->finish());
}

TEST_F(Pipe, EndsTheProgramWithTheObject) {
  {
    auto program = ProgramPipe::start({"sh", "-c", "echo $$ > \"$0\"; sleep 100", (folder_ / "id").string()});
    ASSERT_TRUE(program);
    for (int n = 0; n < 500 && content("id").empty(); ++n)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  const pid_t process = std::atoi(content("id").c_str());
  ASSERT_GT(process, 0);
  EXPECT_NE(kill(process, 0), 0);
}

TEST_F(Pipe, SaysWhichPackageToInstall) {
  EXPECT_TRUE(program_is_there("sh", "dash"));
  const auto missing = program_is_there("no-such-program", "some-package");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().message(),
            "no-such-program: is not installed; install the Debian package 'some-package'");
  EXPECT_FALSE(ProgramPipe::start({"no-such-program"}));
}

}  // namespace
}  // namespace borelli::test::program_pipe_test
