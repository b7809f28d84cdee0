#include "core/optimize/minima.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace handgraft::optimize {

bool isSameMinimum(const hand::HandModel& model, const Minimum& a, const Minimum& b) {
  constexpr double kObjective = 1e-3;  // share
  constexpr double kAngle = 0.02;      // rad
  constexpr double kLength = 1e-3;     // m
  const double low = std::min(a.terms.objective, b.terms.objective);
  if (std::abs(a.terms.objective - b.terms.objective) > kObjective * low) return false;
  if ((a.pose.X_WH.translation() - b.pose.X_WH.translation()).norm() > kLength) return false;
  const Eigen::Matrix3d turn = a.pose.X_WH.linear().transpose() * b.pose.X_WH.linear();
  if (vectorFromRotation(turn).norm() > kAngle) return false;
  for (int j = 0; j < model.dofCount(); ++j) {
    const bool slides = model.dofJoint(j).type == hand::JointType::kPrismatic;
    if (std::abs(a.pose.q[j] - b.pose.q[j]) > (slides ? kLength : kAngle)) return false;
  }
  return true;
}

void rankMinima(const hand::HandModel& model,
                const std::vector<LocalResult>& results,
                const std::string& solver,
                std::vector<Minimum>& minima) {
  // One left before its end is none, unless no end is as good as it.
  double best_end = std::numeric_limits<double>::infinity();
  for (const LocalResult& result : results) {
    if (result.outcome == Outcome::kEvaluationLimit) continue;
    best_end = std::min(best_end, result.terms.objective);
  }
  for (std::size_t i = 0; i < results.size(); ++i) {
    const LocalResult& result = results[i];
    const bool left = result.outcome == Outcome::kEvaluationLimit;
    if (left && result.terms.objective >= best_end) continue;
    minima.push_back({result.pose, result.terms, result.outcome, solver, static_cast<int>(i)});
  }
  std::stable_sort(minima.begin(), minima.end(), [](const Minimum& a, const Minimum& b) {
    return a.terms.objective < b.terms.objective;
  });
  std::vector<Minimum> distinct;
  for (Minimum& minimum : minima) {
    const auto same = std::find_if(distinct.begin(), distinct.end(), [&](const Minimum& other) {
      return isSameMinimum(model, minimum, other);
    });
    if (same != distinct.end()) {
      same->hits += minimum.hits;
    } else if (distinct.size() < kMostMinima) {
      distinct.push_back(std::move(minimum));
    }
  }
  minima = std::move(distinct);
}

}  // namespace handgraft::optimize
