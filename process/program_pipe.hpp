// Runs another program and feeds its standard input.
#pragma once

#include <sys/types.h>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "error/error.hpp"

namespace borelli {

/// Whether a program is in one of PATH's folders. Errors: about `name`, naming the Debian package to install.
Result<void> program_is_there(const std::string& name, const std::string& package);

/// A running program that reads our bytes. It ends with this object, and with this process even if that is
/// killed. A ^C of the terminal does not reach it.
class ProgramPipe {
 public:
  /// Starts command[0], found in PATH, with the further words as its arguments. Its output is discarded.
  /// Errors: the program cannot be started.
  static Result<ProgramPipe> start(const std::vector<std::string>& command);

  /// Errors: the program ended; in the last line that it wrote to its standard error.
  Result<void> write(std::span<const std::uint8_t> bytes);
  /// Closes its input and waits for its end. Errors: as `write`, if it did not succeed.
  Result<void> finish();

  ProgramPipe(ProgramPipe&& other) noexcept;
  ProgramPipe& operator=(ProgramPipe&&) = delete;
  ~ProgramPipe();  ///< kills the program unless `finish` was called

 private:
  ProgramPipe(std::string name, pid_t process, int input, int errors)
      : name_(std::move(name)), process_(process), input_(input), errors_(errors) {}
  tl::unexpected<Error> complaint();

  std::string name_;
  pid_t process_;
  int input_, errors_;  // file descriptors
};

}  // namespace borelli
