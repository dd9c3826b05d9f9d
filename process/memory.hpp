// How much memory this process may use, asked before each large allocation.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "error/error.hpp"

namespace borelli {

/// Bytes free on the machine and in the control group of this process, whichever is less.
std::uint64_t free_memory();

/// Sets the most bytes this process may use. Allocations beyond it that admit_memory did not check fail with
/// std::bad_alloc. Call it once, before any work. Without it the limit is three quarters of the memory that
/// is free at the first call of memory_limit.
void set_memory_limit(std::uint64_t bytes);
std::uint64_t memory_limit();

/// Bytes from a size as a user writes it: a number and K, M, G or T, with or without B or iB (4G, 500MB,
/// 1.5 GiB). Units are powers of 1000, with iB of 1024. Nothing if the text is not a size.
std::optional<std::uint64_t> bytes_from(std::string_view text);

/// The error for a caught std::bad_alloc: "`what` needs more than the 12 GB of memory that may be used
/// (--max-memory)", about `where`.
tl::unexpected<Error> out_of_memory(const std::string& where, const std::string& what);

/// Checks before a large allocation that `bytes` more fit; a double, so that products of absurd sizes do not
/// overflow. Errors: "`what` needs 4.6 GB of memory; 12 GB may be used (--max-memory), 0.2 GB of them are in
/// use", about `where`.
Result<void> admit_memory(const std::string& where, const std::string& what, double bytes);

}  // namespace borelli
