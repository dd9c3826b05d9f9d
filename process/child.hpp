// Runs work in a child process: a library that crashes or hangs on damaged bytes then cannot end this one.
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
  double processor_seconds = 0;                  ///< CPU time of the child; 0: no limit
  std::uint64_t bytes = std::uint64_t{1} << 30;  ///< memory on top of what the parent has mapped
};

/// Forks a child that runs `work`, with stdout and stderr discarded. The child writes to its own copy of
/// memory: results come back through SharedBytes. `work` must not take a lock that another thread of this
/// process may hold. It may start one thread per processor. Any thread may call this.
/// Errors: the error of `work`; about `where`: "`doing` crashed (segmentation fault)", "... took more than
/// 30 s", "... took more than 1024 MiB of memory".
Result<void> in_child(const std::string& where, const std::string& doing, const ChildLimits& limits,
                      const std::function<Result<void>()>& work);

/// Zeroed bytes that a child of this process shares with it.
class SharedBytes {
 public:
  /// Errors: out of memory, about `where`.
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
