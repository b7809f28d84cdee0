#include "core/transfer/suggestion.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <tuple>
#include <utility>

#include "core/base/error.h"

namespace handgraft::transfer {
namespace {

constexpr double kLeastReach = 1e-4;  // m
constexpr double kMostReach = 0.1;    // m
constexpr int kMostSuggestions = 100;

constexpr double kPi = std::numbers::pi;
constexpr int kRings = 4;                 // of roots about the present one, 6 k on ring k
constexpr double kTurn = kPi / 12.0;      // between directions tried
constexpr int kTurns = 2;                 // to either side
constexpr int kSeeds = 3;                 // refined, of the coarse candidates
constexpr int kHalvings = 3;              // of the step: ends at a 32nd of the reach
constexpr int kMostSteps = 12;            // between two halvings
constexpr double kDistortionStep = 0.02;  // smaller differences are not worth a longer way
constexpr double kSameTurn = kPi / 18.0;
constexpr double kSameRoot = 0.125;  // of the reach

/// Where a candidate lies: its root in the log map of the present one, and its turn.
struct Variant {
  Eigen::Vector2d uv_T = Eigen::Vector2d::Zero();
  double turn = 0.0;
};

struct Candidate {
  Variant variant;
  Suggestion suggestion;
  std::tuple<std::size_t, double, double> rank;  ///< lost, distortion in steps, change in m
};

class Search {
 public:
  Search(const Surfaces& surfaces,
         StagedTransfer staged,
         const contact::Patch& patch,
         const PatchPlacement& present,
         double reach_m,
         const TransferOptions& options)
      : surfaces_(surfaces),
        staged_(std::move(staged)),
        patch_(patch),
        present_(present),
        reach_m_(reach_m),
        options_(options),
        present_lost_(staged_.lay(surfaces, patch, present, options).lost.size()) {}

  [[nodiscard]] std::size_t presentLost() const { return present_lost_; }

  /// Finds candidates that lose fewer points than the present placement.
  void run(const Progress& progress) {
    around_.emplace(surfaces_.skin_S, present_, reach_m_, options_.method);
    constexpr const char* kStage = "trying places nearby";
    std::vector<Variant> grid(1);
    for (int ring = 1; ring <= kRings; ++ring) {
      for (int k = 0; k < 6 * ring; ++k) {
        const double angle = 2.0 * kPi * k / (6 * ring);
        grid.push_back(
            {reach_m_ * ring / kRings * Eigen::Vector2d(std::cos(angle), std::sin(angle)),
             0.0});
      }
    }
    for (std::size_t i = 0; i < grid.size(); ++i) {
      progress.report(kStage, 0.7 * static_cast<double>(i) / static_cast<double>(grid.size()));
      for (int turn = -kTurns; turn <= kTurns; ++turn) {
        progress.checkpoint();
        keep(candidateAt({grid[i].uv_T, turn * kTurn}));
      }
    }
    sort();
    const std::vector<Candidate> seeds = distinct(kSeeds);
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      progress.report(kStage, 0.7 + 0.3 * static_cast<double>(i) / kSeeds);
      refine(seeds[i], progress);
    }
    sort();
  }

  /// The first `count` of the candidates found that differ from each other.
  [[nodiscard]] std::vector<Candidate> distinct(int count) const {
    std::vector<Candidate> chosen;
    for (const Candidate& candidate : found_) {
      if (std::ssize(chosen) == count) break;
      const bool is_new = std::none_of(chosen.begin(), chosen.end(), [&](const Candidate& c) {
        return (c.variant.uv_T - candidate.variant.uv_T).norm() < kSameRoot * reach_m_ &&
               std::abs(c.variant.turn - candidate.variant.turn) < kSameTurn;
      });
      if (is_new) chosen.push_back(candidate);
    }
    return chosen;
  }

 private:
  /// Nothing where the skin has no such place, or none that a patch could be laid about.
  std::optional<Candidate> candidateAt(const Variant& variant) {
    const double moved = variant.uv_T.norm();
    if (moved > reach_m_ * (1.0 + 1e-9) || std::abs(variant.turn) > kPi) return std::nullopt;
    geometry::SurfacePoint root_S = present_.root_S;
    if (moved > 0.0) root_S = around_->at(variant.uv_T).point;
    if (!root_S.valid()) return std::nullopt;
    const geometry::TriangleMesh& skin_S = surfaces_.skin->mesh();
    Candidate candidate;
    candidate.variant = variant;
    Suggestion& suggestion = candidate.suggestion;
    suggestion.placement = turned(skin_S, movedTo(skin_S, present_, root_S), variant.turn);
    suggestion.moved_m = moved;
    suggestion.turned_rad = variant.turn;
    try {
      suggestion.transfer = staged_.lay(surfaces_, patch_, suggestion.placement, options_);
    } catch (const InvalidInput&) {
      return std::nullopt;  // the direction that came along is normal to the surface there
    }
    const double change = moved + std::abs(variant.turn) * staged_.patchChart()->reach();
    candidate.rank = {suggestion.transfer.lost.size(),
                      std::floor(suggestion.transfer.fidelity.distance_mean / kDistortionStep),
                      change};
    return candidate;
  }

  void keep(std::optional<Candidate> candidate) {
    if (candidate && std::get<0>(candidate->rank) < present_lost_)
      found_.push_back(std::move(*candidate));
  }

  void sort() {
    std::stable_sort(found_.begin(), found_.end(), [](const Candidate& a, const Candidate& b) {
      return a.rank < b.rank;
    });
  }

  /// Steps to a better neighbour while there is one, then halves the step.
  void refine(Candidate best, const Progress& progress) {
    double step = 0.5 * reach_m_ / kRings;
    double turn_step = 0.5 * kTurn;
    for (int halving = 0; halving < kHalvings; ++halving) {
      for (int i = 0; i < kMostSteps; ++i) {
        std::optional<Candidate> better;
        for (const Variant& variant : neighboursOf(best.variant, step, turn_step)) {
          progress.checkpoint();
          std::optional<Candidate> candidate = candidateAt(variant);
          if (candidate && candidate->rank < (better ? better->rank : best.rank))
            better = std::move(candidate);
        }
        if (!better) break;
        best = std::move(*better);
      }
      step *= 0.5;
      turn_step *= 0.5;
    }
    keep(std::move(best));
  }

  /// Six about it, one nearer to the present root, and two that turn.
  static std::vector<Variant> neighboursOf(const Variant& v, double step, double turn_step) {
    std::vector<Variant> all;
    const double far = v.uv_T.norm();
    if (far > 0.0) all.push_back({v.uv_T * std::max(0.0, 1.0 - step / far), v.turn});
    for (int k = 0; k < 6; ++k) {
      const double angle = kPi / 3.0 * k;
      all.push_back(
          {v.uv_T + step * Eigen::Vector2d(std::cos(angle), std::sin(angle)), v.turn});
    }
    for (const double side : {-1.0, 1.0}) {
      // Back to no turn exactly where that is nearer than a step.
      const double turn = v.turn + side * turn_step;
      all.push_back({v.uv_T, turn * v.turn < 0.0 ? 0.0 : turn});
    }
    return all;
  }

  const Surfaces& surfaces_;
  StagedTransfer staged_;
  const contact::Patch& patch_;
  const PatchPlacement& present_;
  double reach_m_;
  const TransferOptions& options_;
  std::size_t present_lost_;
  std::optional<SkinChart> around_;  ///< of the present root
  std::vector<Candidate> found_;
};

}  // namespace

void validate(const SuggestOptions& options) {
  if (!(options.reach_m >= kLeastReach && options.reach_m <= kMostReach)) {
    rejectInput("reach is {} m; permitted are {} to {}", options.reach_m, kLeastReach,
                kMostReach);
  }
  if (options.count < 1 || options.count > kMostSuggestions) {
    rejectInput("count of suggestions is {}; permitted are 1 to {}", options.count,
                kMostSuggestions);
  }
}

std::vector<Suggestion> suggestPlacements(const Surfaces& surfaces,
                                          StagedTransfer staged,
                                          const contact::Patch& patch,
                                          const PatchPlacement& present,
                                          const SuggestOptions& options,
                                          const TransferOptions& transfer_options,
                                          const Progress& progress) {
  validate(options);
  progress.checkpoint();
  Search search(surfaces, std::move(staged), patch, present, options.reach_m, transfer_options);
  if (search.presentLost() == 0) return {};
  std::vector<Suggestion> suggestions;
  search.run(progress);
  for (Candidate& candidate : search.distinct(options.count))
    suggestions.push_back(std::move(candidate.suggestion));
  return suggestions;
}

std::vector<Suggestion> suggestPlacements(const geometry::TriangleMesh& object_O,
                                          const contact::Patch& patch,
                                          const hand::Skin& skin,
                                          const PatchPlacement& present,
                                          const SuggestOptions& options,
                                          const TransferOptions& transfer_options,
                                          const Progress& progress) {
  return suggestPlacements(borrowedSurfaces(object_O, skin), StagedTransfer(), patch, present,
                           options, transfer_options, progress);
}

}  // namespace handgraft::transfer
