#pragma once

namespace handgraft::test {

/// Calls of operator new by this thread so far. Linking allocation_count.cpp replaces it.
long allocationCount();

}  // namespace handgraft::test
