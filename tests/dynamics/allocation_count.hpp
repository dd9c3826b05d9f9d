// How often the test program has asked for memory, as Eigen and operator new both do; defined in
// allocation_test.cpp. Sanitizers have allocators of their own: nothing is counted there.
#pragma once

#include <atomic>

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define BORELLI_COUNTS_ALLOCATIONS
namespace borelli::test {
extern std::atomic<long> allocation_count;
}
#endif
