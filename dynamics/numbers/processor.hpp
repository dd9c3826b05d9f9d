// Functions compiled for several processors. The version to run is chosen at program start or at the call.
// All callees whose source is visible are inlined, and so compiled for the same processor.
#pragma once

#include <algorithm>
#include <vector>

#include "dynamics/numbers/lanes.hpp"

#if defined(__x86_64__) && defined(__GLIBC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
/// Compiles a function three times: for processors with AVX-512, with fused multiply-add, and for any.
/// (Scalar code gains because AVX-512 has twice as many registers, not because they are wider.)
#define BORELLI_INLINED_FOR_PROCESSOR \
  [[gnu::flatten, gnu::target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")]]
#else
#define BORELLI_INLINED_FOR_PROCESSOR
#endif

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define BORELLI_REGISTERS 1
// (noipa: the function sees other types than its callers, so interprocedural analysis would be wrong)
#define BORELLI_FOR_REGISTERS(processor) [[gnu::noipa, gnu::flatten, gnu::target(processor)]]
#endif

namespace borelli {

/// Numbers per register that in_registers uses: 8 (AVX-512), 4 (AVX2) or 2. Tests and benchmarks of the code
/// for lesser processors may lower it, before any thread computes.
inline int register_width = [] {
#ifdef BORELLI_REGISTERS
  __builtin_cpu_init();
  if (__builtin_cpu_supports("x86-64-v4")) return 8;
  if (__builtin_cpu_supports("x86-64-v3")) return 4;
#endif
  return 2;
}();

/// T with its lanes in registers of `width`. T is a lane type, a template of one, a vector of them, or a
/// pointer to one.
template <int width, class T>
struct InRegisters {
  using Type = T;
};
template <int width, int N, int before>
struct InRegisters<width, LanesOf<N, before>> {
  using Type = LanesOf<N, std::min(N, width)>;
};
template <int width, template <class> class Of, class T>
struct InRegisters<width, Of<T>> {
  using Type = Of<typename InRegisters<width, T>::Type>;
};
template <int width, class T>
struct InRegisters<width, std::vector<T>> {
  using Type = std::vector<typename InRegisters<width, T>::Type>;
};
template <int width, class T>
struct InRegisters<width, const T> {
  using Type = const typename InRegisters<width, T>::Type;
};
template <int width, class T>
struct InRegisters<width, T*> {
  using Type = typename InRegisters<width, T>::Type*;
};

/// The same object, seen with its lanes in registers of `width`: the memory layout is equal.
template <int width, class T>
auto& as_in_registers(T& x) {
  return reinterpret_cast<typename InRegisters<width, T>::Type&>(x);
}

#ifdef BORELLI_REGISTERS
template <class Work, class... Of>
BORELLI_FOR_REGISTERS("arch=x86-64-v4")
auto in_registers_of_eight(const Work& work, Of&... of) {
  return work.template operator()<8>(as_in_registers<8>(of)...);
}
template <class Work, class... Of>
BORELLI_FOR_REGISTERS("arch=x86-64-v3")
auto in_registers_of_four(const Work& work, Of&... of) {
  return work.template operator()<4>(as_in_registers<4>(of)...);
}
#endif

/// Calls work<width>(of...) in code for the running processor; `width` is 8, 4 or 2. Arguments made of lanes
/// (LanesOf) are passed with their lanes in registers of `width`.
template <class Work, class... Of>
auto in_registers(const Work& work, Of&&... of) {
#ifdef BORELLI_REGISTERS
  if (register_width == 8) return in_registers_of_eight(work, of...);
  if (register_width == 4) return in_registers_of_four(work, of...);
#endif
  return work.template operator()<2>(as_in_registers<2>(of)...);
}

}  // namespace borelli
