#pragma once

#include <cstdio>
#include <cstdlib>

namespace handgraft::fuzz {

/// Ends the process, so that libFuzzer keeps the input, with a line that says which promise of
/// a header broke.
inline void require(bool promise, const char* what, const char* file, int line) {
  if (promise) return;
  std::fprintf(stderr, "%s:%d: broken promise: %s\n", file, line, what);
  std::abort();
}

}  // namespace handgraft::fuzz

#define HANDGRAFT_PROMISE(condition) \
  ::handgraft::fuzz::require(static_cast<bool>(condition), #condition, __FILE__, __LINE__)
