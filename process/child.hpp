// Runs work in a child process, so that a library that crashes or hangs on damaged bytes cannot end this one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "error/error.hpp"

namespace borelli {

struct ChildLimits {
  double seconds = 30;                           ///< wall-clock time
  double processor_seconds = 0;                  ///< of the child; 0: as many as it takes
  std::uint64_t bytes = std::uint64_t{1} << 30;  ///< memory beyond what this process has mapped
};

/// Forks and runs `work` in the child, with stdout and stderr closed to it. Memory that the child writes is
/// its own: results come back through SharedBytes. `work` starts no thread and takes no lock that another
/// thread of this process may hold.
/// Errors: the one that `work` answered; "`doing` crashed (segmentation fault)", "... took more than 30 s",
/// "... took more than 1024 MiB of memory", all about `where`. Any thread may call it.
Result<void> in_child(const std::string& where, const std::string& doing, const ChildLimits& limits,
                      const std::function<Result<void>()>& work);

/// Zeroed bytes that a child of this process shares with it.
class SharedBytes {
 public:
  /// Errors: no memory, about `where`.
  static Result<SharedBytes> make(const std::string& where, std::size_t size);

  std::span<std::byte> bytes() const { return {start_, size_}; }

  SharedBytes(SharedBytes&& other) noexcept;
  SharedBytes& operator=(SharedBytes&&) = delete;
  ~SharedBytes();

 private:
  SharedBytes(std::byte* start, std::size_t size) : start_(start), size_(size) {}

  std::byte* start_;
  std::size_t size_;
};

}  // namespace borelli
