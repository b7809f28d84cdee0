#include "tests/core/optimize/allocation_count.h"

#include <cstdlib>

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define HANDGRAFT_COUNTS_ALLOCATIONS 1
#else
#define HANDGRAFT_COUNTS_ALLOCATIONS 0
#endif

namespace {

thread_local long count = 0;

}  // namespace

#if HANDGRAFT_COUNTS_ALLOCATIONS
// new and Eigen both end in malloc, which glibc lets a program replace.
extern "C" void* __libc_malloc(
    std::size_t size);  // NOLINT(bugprone-reserved-identifier,readability-identifier-naming)

extern "C" void* malloc(std::size_t size) {
  ++count;
  return __libc_malloc(size);
}
#endif

namespace handgraft::test {

long allocationCount() {
  return count;
}

bool countsAllocations() {
  return HANDGRAFT_COUNTS_ALLOCATIONS != 0;
}

}  // namespace handgraft::test
