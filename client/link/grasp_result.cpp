#include "client/link/grasp_result.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace handgraft::client {

namespace {

void requireCount(const char* what, std::size_t is, std::size_t should) {
  if (is == should) return;
  throw TransportError(fmt::format("the server sent {} {} for {}", is, what, should));
}

template <class Numbers>
bool allFinite(const Numbers& numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double x) {
    return std::isfinite(x);
  });
}

void requireFinite(const v1::Pose& pose) {
  if (allFinite(pose.p_m()) && allFinite(pose.q_wxyz())) return;
  throw TransportError("the server sent a pose that is not finite");
}

}  // namespace

void requireConsistent(const GraspResult& result) {
  const v1::PoseSolution& solution = result.solution;
  requireCount("joint values", solution.joint_positions().size(), result.hand.joints().size());
  requireCount("link poses", solution.X_WL().size(), result.hand.links().size());
  if (!allFinite(solution.joint_positions())) {
    throw TransportError("the server sent a joint value that is not finite");
  }
  requireFinite(solution.X_WH());
  requireFinite(solution.X_WO());
  for (const v1::Pose& X_WL : solution.X_WL())
    requireFinite(X_WL);
  for (const v1::PatchFit& fit : solution.patches()) {
    requireCount("coordinates on the object", fit.object_W_m().size(), fit.hand_W_m().size());
    requireCount("coordinates left over", fit.hand_W_m().size() % 3, 0);
  }
}

const v1::PatchReport* reportOf(const GraspResult& result, const std::string& patch) {
  for (const v1::PatchReport& report : result.transfer.patches()) {
    if (report.name() == patch) return &report;
  }
  return nullptr;
}

}  // namespace handgraft::client
