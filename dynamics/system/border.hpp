// Converts exceptions into Errors at the engine's public interface: a user's function may throw, memory may
// run out.
#pragma once

#include <fmt/core.h>

#include <exception>
#include <new>
#include <stdexcept>
#include <utility>

#include "dynamics/system/system.hpp"
#include "process/memory.hpp"

namespace borelli {

/// Checks `bytes` against the memory limit (process/memory.hpp) if they are 64 MB or more. A check costs as
/// much as one evaluation of a small scene, so smaller amounts are not checked. `what()` gives the purpose.
template <class What>
Result<void> admit_large(const System& system, double bytes, What&& what) {
  constexpr double large = 64e6;
  if (bytes < large) return {};
  return admit_memory(system.scene, what(), bytes);
}

/// Runs `work`, which returns a Result. Errors: those of `work`, lack of memory, and exceptions of user
/// functions.
template <class Work>
auto at_border(const System& system, Work&& work) -> decltype(work()) {
  const auto no_memory = [&] {
    return failure(system.scene,
                   fmt::format("not enough memory for {} coordinates, {} constraint rows and {} contacts "
                               "(--max-memory)",
                               system.nv, system.rows, system.contacts.size()));
  };
  try {
    return std::forward<Work>(work)();
  } catch (const std::bad_alloc&) {
    return no_memory();
  } catch (const std::length_error&) {  // more than any vector holds
    return no_memory();
  } catch (const std::exception& thrown) {
    return failure(system.scene, fmt::format("a user's function threw: {}", thrown.what()));
  } catch (...) {
    return failure(system.scene, "a user's function threw something other than a std::exception");
  }
}

}  // namespace borelli
