// How much memory this process may use, asked before each large allocation.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "error/error.hpp"

namespace borelli {

/// Bytes that the machine, and the control group this process belongs to, have free.
std::uint64_t free_memory();

/// Sets the most bytes this process may use in all; allocations beyond it that nobody asked for fail with
/// std::bad_alloc. Called once, before anything works. Without it the limit is three quarters of what is free
/// when it is first asked for.
void set_memory_limit(std::uint64_t bytes);
std::uint64_t memory_limit();

/// A size as a user writes it: a number and K, M, G or T, with or without B or iB (4G, 1.5 GiB, 500MB; of
/// 1000, with iB of 1024); nothing where it is none.
std::optional<std::uint64_t> bytes_from(std::string_view text);

/// "needs more than the 12 GB of memory that may be used (--max-memory)", about `where`: for who catches
/// std::bad_alloc.
tl::unexpected<Error> out_of_memory(const std::string& where, const std::string& what);

/// Asked before a large allocation: whether `bytes` more fit. (A double, so that products of absurd sizes do
/// not wrap around.) Errors: "`what` needs 4.6 GB of memory; 12 GB may be used (--max-memory), 0.2 GB of them
/// are in use", about `where`.
Result<void> admit_memory(const std::string& where, const std::string& what, double bytes);

}  // namespace borelli
