#pragma once

#include <functional>

namespace handgraft {

/// Calls `work(0)` to `work(count - 1)`, each once, on several threads; returns when all are
/// done.
///
/// For what is done once and long: threads are made for the call. The calls must not depend on
/// one another; then results do not depend on the number of threads. Errors: what the call of
/// the lowest number threw; none of a higher one begins after that.
/// `threads`: at most, this one among them; 0: as many as there are processors, four at most.
void parallelFor(int count, const std::function<void(int)>& work, int threads = 0);

}  // namespace handgraft
