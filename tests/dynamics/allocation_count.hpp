// Counts the test program's allocations, by Eigen and by operator new; defined in allocation_test.cpp. Builds
// with sanitizers have other allocators and count nothing.
#pragma once

#include <atomic>

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define BORELLI_COUNTS_ALLOCATIONS
namespace borelli::test {
extern std::atomic<long> allocation_count;
}
#endif
