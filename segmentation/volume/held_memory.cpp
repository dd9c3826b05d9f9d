#include "segmentation/volume/held_memory.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <system_error>
#include <thread>

#ifdef __GLIBC__
#include <malloc.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>
#endif

namespace borelli {

#ifdef __GLIBC__
namespace {

constexpr std::size_t huge_page = 2 << 20, huge = 1 << 30;
unsigned char* held = nullptr;  // whole huge pages: `huge` bytes less one page

}  // namespace
#endif

void hold_freed_memory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_ARENA_MAX, 1);
  mallopt(M_TRIM_THRESHOLD, static_cast<int>(huge) + (512 << 20));
  // allocated and freed once, so that later allocations come from this block
  void* const first = std::malloc(huge);
  if (!first) return;
  const auto begin = (reinterpret_cast<std::uintptr_t>(first) + huge_page - 1) / huge_page * huge_page;
  held = reinterpret_cast<unsigned char*>(begin);
  madvise(held, huge - huge_page, MADV_HUGEPAGE);
  std::free(first);
#endif
}

void map_ahead([[maybe_unused]] std::size_t bytes) {
#if defined(__GLIBC__) && defined(MADV_POPULATE_WRITE)
  if (!held) return;
  const std::size_t end = std::min(mallinfo2().uordblks + bytes, huge - huge_page);
  // page by page, so that no thread waits long for the kernel's memory map lock; mapped pages cost nothing
  try {
    std::thread([end] {
      setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), 19);
      for (std::size_t o = 0; o + huge_page <= end; o += huge_page)
        if (madvise(held + o, huge_page, MADV_POPULATE_WRITE) != 0) return;
    }).detach();
  } catch (const std::system_error&) {  // pages are then mapped at first touch
  }
#endif
}

}  // namespace borelli
