// Open roots that slide over the hand to where it would touch best.
#include <algorithm>
#include <utility>

#include "core/optimize/pose_solver.h"
#include "core/placement/place_slider.h"
#include "core/session/derived_state_search.h"

namespace handgraft::session {
namespace {

using optimize::Minimum;
using optimize::PoseProblem;
using optimize::SolveOptions;
using optimize::SolveReport;

constexpr int kSlides = 12;
constexpr double kSmallGain = 0.01;  // of the cost: taken, but as good as none

}  // namespace

double costOf(const PoseProblem& posed, const SolveReport& solved) {
  return solved.terms.objective - placement::kLost * placement::kLost * posed.weights.distance *
                                      static_cast<double>(posed.pairs.size());
}

bool DerivedState::slides() const {
  return std::any_of(patches_.begin(), patches_.end(), [](const SessionPatch& item) {
    return item.placement && item.root_is_open;
  });
}

std::vector<Minimum> DerivedState::slideFreely(SolverSettings solving,
                                               SolveOptions options,
                                               const Progress& progress) {
  if (!slides()) return {};
  solving.avoid_penetration = false;
  options.on_improvement = nullptr;
  SolveReport report = optimize::solve(problem(solving), options, progress);
  std::vector<Minimum> found = std::move(report.minima);
  slideRoots(report, solving, options, progress, kWorseSlides);
  // The best has gone on with the patches since.
  found.front().pose = report.pose;
  return found;
}

void DerivedState::slideRoots(SolveReport& report,
                              const SolverSettings& solving,
                              SolveOptions options,
                              const Progress& progress,
                              int worse_at_most) {
  // A slide is a step from where the hand is: it needs no other start.
  options.starts = 1;
  Search best(*this);
  double least = costOf(problem(solving), report);
  SolveReport present = report;
  // A step that moves all roots at once may first make things worse, so a few in a row may.
  for (int i = 0, worse = 0; i < kSlides && worse < worse_at_most; ++i) {
    if (!takePlacesFrom(present.pose)) break;
    transfer(progress);
    start_ = present.pose;
    const PoseProblem slid = problem(solving);
    if (slid.pairs.empty()) break;
    present = optimize::solve(slid, options, progress);
    const double now = costOf(slid, present);
    ++worse;
    if (!(now < least)) continue;
    if (now < (1.0 - kSmallGain) * least) worse = 0;
    best.keep();
    least = now;
    report = present;
  }
}

}  // namespace handgraft::session
