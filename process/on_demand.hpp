// Loads our own shared libraries at their first use.
//
// VTK, ITK, GDCM, HDF5 and librsvg bring 120 shared libraries; loading them takes 0.2 s of CPU time, and most
// verbs need none of them. The code that calls one of them is therefore a shared library of its own (a folder
// on_demand/<library>). It exports a table of functions:
//
//   struct SomeFunctions {                                // on_demand/some.hpp
//     static constexpr const char* library = "borelli_some";
//     int (*answer)(int);
//   };
//   BORELLI_ON_DEMAND(SomeFunctions){.answer = ...};      // on_demand/some/some.cpp, the library
//   if (auto some = on_demand<SomeFunctions>()) (*some)->answer(6);   // anywhere
//
// Such a library must not rely on the program's global state (memory limit, number of threads): a static
// library linked into both has two copies of its variables.
#pragma once

#include "error/error.hpp"

namespace borelli {

/// The function table that `library` exports; the library stays loaded. The dynamic loader searches the run
/// path of the program: beside it in the build folder, in lib/borelli once installed. Errors: not found, or
/// not loadable.
Result<const void*> load_on_demand(const char* library);

/// The functions of a library; the first call loads it. Call this before forking a child process that uses
/// the library: a library loaded in the child is lost when the child ends.
template <class Functions>
Result<const Functions*> on_demand() {
  static const Result<const void*> table = load_on_demand(Functions::library);
  return table.map([](const void* found) { return static_cast<const Functions*>(found); });
}

}  // namespace borelli

/// Defines the table that a library exports. Library and program must use the same version of its type.
#define BORELLI_ON_DEMAND(Functions)                                           \
  extern "C" [[gnu::visibility("default")]] const Functions borelli_functions; \
  const Functions borelli_functions
