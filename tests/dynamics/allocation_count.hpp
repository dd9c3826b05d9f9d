// How often the test program has called malloc, by which Eigen and operator new both come; defined in
// allocation_test.cpp. Sanitizers have allocators of their own: nothing is counted there.
#pragma once

#include <atomic>

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define BORELLI_COUNTS_ALLOCATIONS
namespace borelli::test {
extern std::atomic<long> allocation_count;
}
#endif
