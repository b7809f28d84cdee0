#pragma once

namespace handgraft::test {

/// Calls of operator new in this program so far. Linking allocation_count.cpp replaces it.
long allocationCount();

}  // namespace handgraft::test
