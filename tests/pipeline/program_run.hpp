// Runs the borelli program like a user and keeps its output.
#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include "tests/paths.hpp"

namespace borelli {

/// A temporary folder for one test, deleted at its end.
class TestFolder {
 public:
  TestFolder()
      : path_(std::filesystem::temp_directory_path() /
              ("borelli_" + std::to_string(std::random_device{}()))) {
    std::filesystem::create_directories(path_);
  }
  ~TestFolder() { std::filesystem::remove_all(path_); }
  TestFolder(const TestFolder&) = delete;
  TestFolder& operator=(const TestFolder&) = delete;

  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
    return path_ / name;
  }
  /// Number of files in it and its subfolders, including hidden ones.
  int count() const {
    int files = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(path_))
      files += entry.is_regular_file();
    return files;
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

struct ProgramRun {
  int code = -1;  ///< exit code; -1: it was killed by a signal
  std::string out, err;
};

/// `before`: shell text before the program, such as "ulimit -f 20;" or a command that starts the program. The
/// tests' GLIBC_TUNABLES do not apply to the program.
inline ProgramRun run_program(const std::string& arguments, const std::string& before = "") {
  const TestFolder said;
  const std::string out = said / "out", err = said / "err";
  const int status = std::system(("unset GLIBC_TUNABLES; " + before + " " + test::program_path() + " >" +
                                  out + " 2>" + err + " " + arguments)
                                     .c_str());
  const auto text = [](const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return std::string{std::istreambuf_iterator<char>(file), {}};
  };
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text(out), text(err)};
}

}  // namespace borelli
