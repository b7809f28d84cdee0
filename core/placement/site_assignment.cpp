#include "core/placement/site_assignment.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/optimize/objective.h"
#include "core/optimize/solver.h"

namespace handgraft::placement {
namespace {

constexpr std::size_t kLookedAt = 240;  // assignments that are worth a solve
constexpr std::size_t kShortList = 24;  // and several
constexpr int kStartsEach = 3;          // of each of these
constexpr double kSkippedSite =
    0.05;  // charge for a site passed over; hands use thumb, index first

using Assignment = std::vector<int>;

/// All assignments of as many patches as can be.
class Enumeration {
 public:
  Enumeration(int patches, int sites, const std::vector<std::vector<bool>>& permitted)
      : patches_(patches), permitted_(permitted), taken_(sites, false), current_(patches, -1) {}

  std::vector<Assignment> run() {
    extend(0, 0);
    return std::move(best_);
  }

 private:
  void extend(int patch, int used) {
    if (used + patches_ - patch < most_) return;
    if (patch == patches_) {
      if (used > most_) best_.clear();
      most_ = used;
      best_.push_back(current_);
      return;
    }
    for (std::size_t site = 0; site < taken_.size(); ++site) {
      if (taken_[site] || !permitted_[patch][site]) continue;
      taken_[site] = true;
      current_[patch] = static_cast<int>(site);
      extend(patch + 1, used + 1);
      current_[patch] = -1;
      taken_[site] = false;
    }
    extend(patch + 1, used);
  }

  int patches_;
  const std::vector<std::vector<bool>>& permitted_;
  std::vector<bool> taken_;
  Assignment current_;
  int most_ = 0;
  std::vector<Assignment> best_;
};

std::vector<Anchor> anchorsOf(const Assignment& assignment,
                              const std::vector<Anchor>& fixed,
                              const std::vector<Anchor>& patches_O,
                              const std::vector<Anchor>& sites_L) {
  std::vector<Anchor> anchors = fixed;
  for (std::size_t p = 0; p < assignment.size(); ++p) {
    if (assignment[p] < 0) continue;
    Anchor anchor = sites_L[assignment[p]];
    anchor.p_O = patches_O[p].p_O;
    anchor.n_O = patches_O[p].n_O;
    anchor.direction_O = patches_O[p].direction_O;
    anchors.push_back(anchor);
  }
  return anchors;
}

/// Objective with the hand as a rigid body, at rest or half curled, whichever fits better.
double rigidResidual(const std::shared_ptr<const hand::HandModel>& model,
                     const std::vector<Anchor>& anchors,
                     const Pose& X_WO) {
  optimize::PoseProblem problem = anchorProblem(model, anchors, X_WO);
  optimize::Objective objective(problem);
  double best = std::numeric_limits<double>::infinity();
  for (const double share : {0.0, 0.5}) {
    const Eigen::VectorXd q = curledPose(*model, share);
    best = std::min(best, objective.evaluate({optimize::alignRoot(problem, q), q}).objective);
  }
  return best;
}

/// Sites passed over before the last one used.
int skippedSites(const Assignment& assignment) {
  const int last = *std::max_element(assignment.begin(), assignment.end());
  const auto used = std::count_if(assignment.begin(), assignment.end(), [](int site) {
    return site >= 0;
  });
  return last + 1 - static_cast<int>(used);
}

}  // namespace

std::vector<std::vector<int>> assignSites(const HandPoseGuesser& placer,
                                          const std::shared_ptr<const hand::HandModel>& model,
                                          const std::vector<Anchor>& fixed,
                                          const std::vector<Anchor>& patches_O,
                                          const std::vector<Anchor>& sites_L,
                                          const std::vector<std::vector<bool>>& permitted,
                                          const Pose& X_WO,
                                          std::size_t most,
                                          const Progress& progress) {
  const int patches = std::min<int>(kMostAssigned, static_cast<int>(patches_O.size()));
  const int sites = std::min<int>(kMostCandidates, static_cast<int>(sites_L.size()));
  const std::vector<int> none(patches_O.size(), -1);
  const std::vector<Assignment> all = Enumeration(patches, sites, permitted).run();

  // === Rank by a rigid hand, which knows nothing of a thumb that is opposed, then by a solve
  std::vector<std::pair<double, std::size_t>> ranking;
  const auto rank_by = [&](std::size_t most, const auto& score) {
    for (auto& [value, i] : ranking) {
      progress.checkpoint();
      value = score(anchorsOf(all[i], fixed, patches_O, sites_L)) +
              kSkippedSite * skippedSites(all[i]);
    }
    std::sort(ranking.begin(), ranking.end());
    ranking.resize(std::min(ranking.size(), most));
  };
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (anchorsOf(all[i], fixed, patches_O, sites_L).empty()) return {none};
    ranking.emplace_back(0.0, i);
  }
  rank_by(kLookedAt, [&](const std::vector<Anchor>& anchors) {
    return rigidResidual(model, anchors, X_WO);
  });
  for (const auto& [kept, starts] : {std::pair(kShortList, 1), std::pair(most, kStartsEach)}) {
    rank_by(kept, [&, starts = starts](const std::vector<Anchor>& anchors) {
      return placer.place(anchors, X_WO, starts, progress).front().score;
    });
  }
  std::vector<std::vector<int>> answers;
  for (const auto& [score, index] : ranking)
    std::copy(all[index].begin(), all[index].end(), answers.emplace_back(none).begin());
  if (answers.empty()) answers.push_back(none);
  return answers;
}

}  // namespace handgraft::placement
