// Shared libraries of ours that are loaded at their first use.
//
// VTK, ITK, GDCM, HDF5 and librsvg bring 120 shared libraries; to load them takes 0.2 s of processor time,
// while most verbs need none of them. So the code that calls one lies in a shared library of its own (a
// folder on_demand/<library>), which offers a table of functions:
//
//   struct SomeFunctions {                                // on_demand/some.hpp
//     static constexpr const char* library = "borelli_some";
//     int (*answer)(int);
//   };
//   BORELLI_ON_DEMAND(SomeFunctions){.answer = ...};      // on_demand/some/some.cpp, the library
//   if (auto some = on_demand<SomeFunctions>()) (*some)->answer(6);   // anywhere
//
// Such a library keeps no state that the program shares (the memory limit, the number of threads): a static
// library that both link has its variables twice.
#pragma once

#include "error/error.hpp"

namespace borelli {

/// The table that `library` offers; the library stays loaded. The dynamic loader looks for it on the run path
/// of the program: beside it in the build folder, in lib/borelli where it is installed. Errors: not found, or
/// not loadable.
Result<const void*> load_on_demand(const char* library);

/// The functions of a library, which is loaded by the first call. Load it before a child process is to use
/// it: the child's own would be lost with it.
template <class Functions>
Result<const Functions*> on_demand() {
  static const Result<const void*> table = load_on_demand(Functions::library);
  return table.map([](const void* found) { return static_cast<const Functions*>(found); });
}

}  // namespace borelli

/// Defines the table that a library offers. Its type is the library's and the program's, of one version.
#define BORELLI_ON_DEMAND(Functions)                                           \
  extern "C" [[gnu::visibility("default")]] const Functions borelli_functions; \
  const Functions borelli_functions
