#pragma once

namespace handgraft::test {

/// How often this thread has taken memory from the heap so far, by new or by malloc.
long allocationCount();

/// False where a sanitizer owns the allocator.
bool countsAllocations();

}  // namespace handgraft::test
