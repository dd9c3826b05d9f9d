#include "segmentation/held_memory.hpp"

#include <cstddef>
#include <cstdint>
#include <cstdlib>

#ifdef __GLIBC__
#include <malloc.h>
#include <sys/mman.h>
#endif

namespace borelli {

void hold_freed_memory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_ARENA_MAX, 1);
  constexpr std::size_t huge_page = 2 << 20, huge = 1 << 30;
  mallopt(M_TRIM_THRESHOLD, static_cast<int>(huge) + (512 << 20));
  // held, though nothing is in it yet, and so what is asked for next lies in it
  void* const first = std::malloc(huge);
  if (!first) return;
  const auto begin = (reinterpret_cast<std::uintptr_t>(first) + huge_page - 1) / huge_page * huge_page;
  madvise(reinterpret_cast<void*>(begin), huge - huge_page, MADV_HUGEPAGE);
  std::free(first);
#endif
}

}  // namespace borelli
