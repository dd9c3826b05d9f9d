#include "pipeline/files/whole_file.hpp"
#include "process/input_file.hpp"

#include <fmt/core.h>
#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <thread>
#include <vector>

namespace {

std::function<void(const std::filesystem::path&)> at_sync;  // called with the file before each flush

}  // namespace

// Takes the C library's place in this program.
extern "C" int fsync(int file) {
  if (at_sync) at_sync(std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(file)));
  return static_cast<int>(syscall(SYS_fsync, file));
}

namespace borelli {
namespace {

namespace fs = std::filesystem;

struct WholeFile : testing::Test {
  fs::path above = fs::path(testing::TempDir()) / ("whole_file_test_" + std::to_string(::getpid()));
  fs::path folder = above / "folder";
  void SetUp() override { fs::remove_all(above), fs::create_directories(above); }
  void TearDown() override { fs::remove_all(above); }
  std::size_t files() const {
    if (!fs::exists(folder)) return 0;
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), {}));
  }
};

TEST_F(WholeFile, RoundTripsBytesAndCreatesTheFolder) {
  const std::string bytes("a\0b\r\n\xff", 6);
  ASSERT_TRUE(write_whole(folder / "deep" / "file.bin", bytes));
  EXPECT_EQ(read_input_file(folder / "deep" / "file.bin").value(), bytes);
}

TEST_F(WholeFile, FailedWriteLeavesTheOldFileAndNothingElse) {
  ASSERT_TRUE(write_whole(folder / "file.nii.gz", "old"));
  const auto done = write_whole(folder / "file.nii.gz", [](const fs::path& beside) -> Result<void> {
    EXPECT_TRUE(beside.string().ends_with(".nii.gz"));
    std::ofstream(beside) << "half";
    return failure("here", "stopped half way");
  });
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().what, "stopped half way");
  EXPECT_EQ(read_input_file(folder / "file.nii.gz").value(), "old");
  EXPECT_EQ(files(), 1u);
}

// A machine that stops leaves each file whole or as it was: contents are flushed before the rename, the
// folder after it.
TEST_F(WholeFile, FlushesContentsBeforeTheRename) {
  fs::create_directories(folder);
  std::vector<std::string> flushed;
  at_sync = [&](const fs::path& path) {
    std::string line = path == folder ? "folder" : read_input_file(path).value_or("unreadable");
    for (const char* name : {"one", "a", "b"})
      if (fs::exists(folder / name)) line += fmt::format(", {} there", name);
    flushed.push_back(line);
  };
  EXPECT_TRUE(write_whole(folder / "one", "contents"));
  EXPECT_EQ(flushed, (std::vector<std::string>{"contents", "folder, one there"}));
  flushed.clear(), fs::remove(folder / "one");
  EXPECT_TRUE(write_whole_set(folder, {"a", "b"}, [](const fs::path& beside) -> Result<void> {
    std::ofstream(beside / "b") << "of b";
    std::ofstream(beside / "a") << "of a";
    return {};
  }));
  at_sync = nullptr;
  EXPECT_EQ(flushed, (std::vector<std::string>{"of a", "of b", "folder, a there, b there"}));
}

TEST_F(WholeFile, FailedWriteRemovesTheFoldersItCreated) {
  fs::create_directories(folder);
  const auto fail = [](const fs::path&) -> Result<void> { return failure("here", "stopped half way"); };
  EXPECT_FALSE(write_whole(folder / "new" / "deep" / "file.txt", fail));
  EXPECT_EQ(files(), 0u);
  EXPECT_FALSE(write_whole_set(folder / "new" / "deep", {"a", "b"}, fail));
  EXPECT_EQ(files(), 0u);
  // a folder that was there, or that holds another file, stays
  EXPECT_FALSE(write_whole(folder / "file.txt", fail));
  EXPECT_TRUE(fs::exists(folder));
  EXPECT_FALSE(write_whole(folder / "new" / "file.txt", [&](const fs::path& beside) -> Result<void> {
    std::ofstream(beside.parent_path() / "another") << "of another writer";
    return failure("here", "stopped half way");
  }));
  EXPECT_TRUE(fs::exists(folder / "new" / "another"));
}

// As programs do that start together: each checks the folder first, then writes its own file.
TEST_F(WholeFile, WritersThatStartTogetherShareANewFolder) {
  for (int round = 0; round < 100; ++round) {
    fs::remove_all(folder);
    std::atomic<int> written = 0;
    std::vector<std::thread> writers;
    for (int n = 0; n < 8; ++n)
      writers.emplace_back([&, n] {
        const fs::path path = folder / "new" / "deep" / std::to_string(n);
        if (check_writable(path) && write_whole(path, "x")) ++written;
      });
    for (std::thread& writer : writers) writer.join();
    ASSERT_EQ(written, 8) << "round " << round;
  }
}

TEST_F(WholeFile, FullDiskIsNamed) {
  // a folder that is a device file: every write to /dev/full answers "no space left on device"
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  fs::create_directories(folder);
  const fs::path beside = folder / (".partial-" + std::to_string(::getpid()) + "-file.txt");
  fs::create_symlink("/dev/full", beside);
  const auto done = write_whole(folder / "file.txt", std::string(1 << 16, 'x'));
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().what.find("No space left on device"), std::string::npos);
  EXPECT_EQ(done.error().where, folder / "file.txt");  // not the temporary file's name
  EXPECT_EQ(files(), 0u);
}

TEST_F(WholeFile, WriterErrorsNameTheRequestedFile) {
  const auto done = write_whole(folder / "file.txt", [](const fs::path& beside) -> Result<void> {
    return failure("writer", "cannot open " + beside.string() + " for it");
  });
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().what, "cannot open " + (folder / "file.txt").string() + " for it");
}

TEST_F(WholeFile, RemovesItsPartialFilesAtTheEnd) {
  fs::create_directories(folder);
  std::ofstream(folder / ".partial-0-another") << "not of this process";
  const pid_t writer = fork();
  if (writer == 0) {
    const auto inner = [&](const fs::path& beside) -> Result<void> {
      std::ofstream(beside) << "half";
      stop_writing();
      _exit(fs::exists(beside) ? 1 : 0);
    };
    const auto outer = [&](const fs::path& beside) -> Result<void> {
      std::ofstream(beside) << "half";
      return write_whole(folder / "inner.txt", inner);
    };
    static_cast<void>(write_whole(folder / "outer.txt", outer));
    _exit(2);
  }
  int status = 0;
  waitpid(writer, &status, 0);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_EQ(files(), 1u);  // the other process's file
  EXPECT_TRUE(fs::exists(folder / ".partial-0-another"));
}

TEST_F(WholeFile, SweepsPartialFilesOfDeadWritersOnly) {
  fs::create_directories(folder);
  const auto count_partial = [&] {
    int count = 0;
    for (const auto& entry : fs::directory_iterator(folder))
      count += entry.path().filename().string().starts_with(".partial-");
    return count;
  };
  const auto wait_for = [&](int partial) {
    for (int i = 0; i < 5000 && count_partial() != partial; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ASSERT_EQ(count_partial(), partial);
  };
  const auto writer_of = [&](bool of_a_set) {
    const pid_t writer = fork();
    if (writer != 0) return writer;
    const auto fill = [&](const fs::path& beside) -> Result<void> {
      std::ofstream(of_a_set ? beside / "a.txt" : beside) << "half";
      for (;;) pause();
    };
    static_cast<void>(of_a_set ? write_whole_set(folder, {"a.txt", "b.txt"}, fill)
                               : write_whole(folder / "a.txt", fill));
    _exit(0);
  };
  for (const bool of_a_set : {false, true}) {
    const pid_t writer = writer_of(of_a_set);
    wait_for(1);
    ASSERT_TRUE(write_whole(folder / "a.txt", "whole"));
    sweep_partial_files_below(above);
    EXPECT_EQ(count_partial(), 1);
    kill(writer, SIGKILL);
    waitpid(writer, nullptr, 0);
    ASSERT_TRUE(write_whole(folder / "b.txt", "another file"));
    EXPECT_EQ(count_partial(), 1);
    if (of_a_set)
      sweep_partial_files_below(above);
    else
      ASSERT_TRUE(write_whole(folder / "a.txt", "whole"));
    EXPECT_EQ(count_partial(), 0);
    EXPECT_EQ(read_input_file(folder / "a.txt").value(), "whole");
  }
}

TEST_F(WholeFile, WritesASetOfFilesCompletelyOrNotAtAll) {
  const auto fill = [](bool well) {
    return [well](const fs::path& beside) -> Result<void> {
      if (auto done = write_bytes(beside / "a.txt", "a"); !done) return done;
      return well ? write_bytes(beside / "b.txt", "b") : failure(beside.string() + "/b.txt", "is too much");
    };
  };
  const auto failed = write_whole_set(folder, {"a.txt", "b.txt"}, fill(false));
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().where, folder / "b.txt");
  EXPECT_EQ(files(), 0u);
  ASSERT_TRUE(write_whole_set(folder, {"a.txt", "b.txt"}, fill(true)));
  EXPECT_EQ(read_input_file(folder / "b.txt").value(), "b");
  EXPECT_EQ(files(), 2u);
}

TEST_F(WholeFile, SignalLeavesNoPartialFileOfAnyThread) {
  fs::create_directories(folder);
  for (int trial = 0; trial < 20; ++trial) {
    const pid_t writer = fork();
    if (writer == 0) {
      struct sigaction action {};
      action.sa_handler = [](int signal) { stop_writing(), raise(signal); };
      action.sa_flags = static_cast<int>(SA_RESETHAND);
      sigaction(SIGTERM, &action, nullptr);
      const auto write = [&](int thread) {
        for (int n = 0;; n = (n + 1) % 10)
          static_cast<void>(write_whole(folder / fmt::format("{}_{}", thread, n), std::string(200000, 'x')));
      };
      const std::jthread other(write, 1);
      write(0);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    kill(writer, SIGTERM);
    int status = 0;
    waitpid(writer, &status, 0);
    EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGTERM);
    for (const auto& entry : fs::directory_iterator(folder)) {
      EXPECT_FALSE(entry.path().filename().string().starts_with(".")) << entry;
      EXPECT_EQ(entry.file_size(), 200000u) << entry;
    }
  }
}

TEST_F(WholeFile, ChecksFoldersBeforeWriting) {
  fs::create_directories(folder / "sub");
  std::ofstream(folder / "file") << "";
  EXPECT_TRUE(check_writable(folder / "sub" / "new" / "deep" / "file.txt"));
  EXPECT_TRUE(check_writable("file.txt"));
  EXPECT_EQ(check_writable(folder / "sub").error().kind, Error::Kind::use);
  EXPECT_NE(check_writable(folder / "file" / "x").error().what.find("is not a folder"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder / "sub" / "new"));  // the check creates nothing
  fs::permissions(folder / "sub", fs::perms::owner_read | fs::perms::owner_exec);
  if (::geteuid() != 0) {  // root may write everywhere
    EXPECT_NE(check_writable(folder / "sub" / "x").error().what.find("Permission denied"), std::string::npos);
  }
  fs::permissions(folder / "sub", fs::perms::owner_all);
}

TEST_F(WholeFile, FolderInPlaceOfAFileIsBadUse) {
  fs::create_directories(folder / "sub");
  EXPECT_EQ(write_whole(folder / "sub", "x").error().kind, Error::Kind::use);
  EXPECT_EQ(read_input_file(folder / "sub").error().kind, Error::Kind::use);
  EXPECT_EQ(read_input_file(folder / "nothing").error().kind, Error::Kind::use);
}

}  // namespace
}  // namespace borelli
