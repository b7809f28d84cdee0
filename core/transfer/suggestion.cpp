#include "core/transfer/suggestion.h"

#include "core/base/error.h"

namespace handgraft::transfer {
namespace {

constexpr double kLeastReach = 1e-4;  // m
constexpr double kMostReach = 0.1;    // m
constexpr int kMostSuggestions = 100;

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

std::vector<Suggestion> suggestPlacements(const geometry::TriangleMesh& /*object_O*/,
                                          const contact::Patch& /*patch*/,
                                          const hand::Skin& /*skin*/,
                                          const Placement& /*present*/,
                                          const SuggestOptions& options,
                                          const TransferOptions& transfer_options,
                                          const Progress& progress) {
  validate(options);
  validate(transfer_options);
  progress.checkpoint();
  return {};
}

}  // namespace handgraft::transfer
