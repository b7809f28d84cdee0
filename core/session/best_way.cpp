#include "core/session/best_way.h"

#include <algorithm>
#include <deque>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/base/parallel_for.h"
#include "core/session/derived_state.h"
#include "core/session/patch_matching.h"

namespace handgraft::session {
namespace {

constexpr int kShortStarts = 4;

std::ptrdiff_t askedPatches(const Document& document) {
  return std::count_if(document.patches.begin(), document.patches.end(),
                       [](const DocumentPatch& patch) {
                         return patch.enabled;
                       });
}

std::ptrdiff_t droppedPatches(const Document& document) {
  return std::count_if(document.patches.begin(), document.patches.end(),
                       [](const DocumentPatch& patch) {
                         return patch.enabled && !patch.placement;
                       });
}

/// What a document is solved as: itself, or of a motion each of its frames that count.
std::vector<Document> partsOf(const Document& document, const Models& models) {
  if (models.frames.empty()) return {document};
  std::vector<Document> parts;
  for (const FrameContacts& frame : models.frames)
    parts.push_back(atFrame(document, frame));
  return parts;
}

/// All of a document that a solve depends on.
std::string askedBy(Document document) {
  document.notes.clear();
  return bytesOf(document);
}

/// Of ways that were tried, how many patches the best lacks, and drops of them.
class Least {
 public:
  [[nodiscard]] bool mayBeBeatenBy(std::ptrdiff_t dropped) const {
    return std::pair(dropped, dropped) <= lacking_and_dropped_;
  }

  void add(std::ptrdiff_t lacking, std::ptrdiff_t dropped) {
    lacking_and_dropped_ = std::min(lacking_and_dropped_, std::pair(lacking, dropped));
  }

 private:
  static constexpr std::ptrdiff_t kMost = std::numeric_limits<std::ptrdiff_t>::max();
  std::pair<std::ptrdiff_t, std::ptrdiff_t> lacking_and_dropped_{kMost, kMost};
};

}  // namespace

/// What the parts of a way follow from.
class WayTrials::Problems {
 public:
  Problems(const Models& models, const Document& document) {
    const auto add = [&](const std::shared_ptr<const contact::ContactSet>& contacts) {
      derived_.emplace_back(std::make_shared<ModelCache>(
          modelsFor(document, *models.hand, models.object_O, contacts)));
    };
    if (models.frames.empty()) add(models.contacts);
    for (const FrameContacts& frame : models.frames)
      add(frame.contacts);
  }

  DerivedState& derived(std::size_t part) { return derived_[part]; }

 private:
  std::deque<DerivedState> derived_;
};

WayTrials::WayTrials(const Models& models) : models_(models) {}

WayTrials::~WayTrials() = default;

std::vector<WayTrials::Way> WayTrials::waysOf(std::span<const Document> laid) const {
  HANDGRAFT_REQUIRE(!laid.empty());
  std::vector<Way> ways(laid.size());
  for (std::size_t w = 0; w < laid.size(); ++w) {
    ways[w].index = w;
    ways[w].document = &laid[w];
    auto& [lacking, dropped, objective] = ways[w].worst.lack;
    objective = std::numeric_limits<double>::infinity();
    for (const Document& part : partsOf(laid[w], models_)) {
      lacking += askedPatches(part);
      dropped += droppedPatches(part);
    }
  }
  return ways;
}

/// By `solve(derived, document)`; a part that leaves no point comes to nothing.
template <class Solve>
WayTrials::Outcome WayTrials::outcomeOf(const Document& laid, const Solve& solve) {
  std::unique_ptr<Problems> problems;
  {
    const std::lock_guard lock(mutex_);
    if (!idle_.empty()) {
      problems = std::move(idle_.back());
      idle_.pop_back();
    }
  }
  if (problems == nullptr) problems = std::make_unique<Problems>(models_, laid);
  Outcome outcome;
  auto& [lacking, dropped, objective] = outcome.lack;
  std::size_t solved = 0;
  const std::vector<Document> parts = partsOf(laid, models_);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const std::ptrdiff_t laid_patches = askedPatches(parts[i]) - droppedPatches(parts[i]);
    dropped += droppedPatches(parts[i]);
    lacking += droppedPatches(parts[i]);
    // Of nothing that is laid nothing is missed but what is dropped.
    if (laid_patches == 0) continue;
    ++solved;
    try {
      Solution solution = solve(problems->derived(i), parts[i]);
      lacking += failedPatches(solution.problem, solution.report);
      objective += solution.report.terms.objective;
      if (models_.frames.empty())
        outcome.solution = std::make_shared<const Solution>(std::move(solution));
    } catch (const InvalidInput&) {
      lacking += laid_patches;
      objective = std::numeric_limits<double>::infinity();
    }
  }
  if (solved == 0) objective = std::numeric_limits<double>::infinity();
  outcome.reaches_all = solved > 0 && lacking == dropped;
  const std::lock_guard lock(mutex_);
  idle_.push_back(std::move(problems));
  return outcome;
}

/// Ways of which those before them show that they cannot win are left out where there is time
/// to: one that is tried beside them is so in vain.
template <class Solve>
void WayTrials::tryAll(std::vector<Way>& ways, bool until_all, const Solve& solve) {
  const auto is_decided = [&](std::size_t w) {
    const std::lock_guard lock(mutex_);
    if (ways[w].tried) return true;
    Least least;
    for (std::size_t before = 0; before < w; ++before) {
      if (!ways[before].tried) continue;
      const auto& [lacking, dropped, objective] = ways[before].tried->lack;
      if (until_all && ways[before].tried->reaches_all && dropped == 0) return true;
      least.add(lacking, dropped);
    }
    return !least.mayBeBeatenBy(std::get<1>(ways[w].worst.lack));
  };
  parallelFor(
      static_cast<int>(ways.size()),
      [&](int i) {
        const auto w = static_cast<std::size_t>(i);
        if (is_decided(w)) return;
        Outcome outcome = outcomeOf(*ways[w].document, solve);
        const std::lock_guard lock(mutex_);
        ways[w].tried = std::move(outcome);
      },
      models_.threads);
}

/// Tries all, and puts the best first: what one thread would have come to, way by way.
template <class Solve>
void WayTrials::judge(std::vector<Way>& ways, bool until_all, const Solve& solve) {
  tryAll(ways, until_all, solve);
  Least least;
  for (std::size_t w = 0; w < ways.size(); ++w) {
    Way& way = ways[w];
    if (!least.mayBeBeatenBy(std::get<1>(way.worst.lack))) way.tried.reset();
    if (!way.tried) continue;
    const auto& [lacking, dropped, objective] = way.tried->lack;
    least.add(lacking, dropped);
    if (until_all && way.tried->reaches_all && dropped == 0) {
      ways.resize(w + 1);
      break;
    }
  }
  std::stable_sort(ways.begin(), ways.end(), [](const Way& a, const Way& b) {
    return a.tried.value_or(a.worst).lack < b.tried.value_or(b.worst).lack;
  });
}

void WayTrials::judgeShortly(std::vector<Way>& ways, const Progress& progress) {
  SolverSettings solving = ways.front().document->solving;
  solving.starts = kShortStarts;
  judge(ways, false, [&](DerivedState& derived, const Document& document) {
    const Progress quiet(progress, {});
    derived.follow(document, quiet);
    return derived.solveRoughly(solving, quiet);
  });
}

void WayTrials::judgeInFull(std::vector<Way>& ways, bool until_all, const Progress& progress) {
  for (Way& way : ways) {
    way.tried.reset();
    way.asked_by = askedBy(*way.document);
    for (const Way& known : known_)
      if (known.asked_by == way.asked_by) way.tried = known.tried;
  }
  judge(ways, until_all, [&](DerivedState& derived, const Document& document) {
    const Progress quiet(progress, {});
    derived.follow(document, quiet);
    return derived.solve(document.solving, {}, quiet);
  });
  // Of those that are not taken their worth is enough: a solution holds charts.
  for (Way& known : known_)
    known.tried->solution.reset();
  for (const Way& way : ways) {
    if (!way.tried) continue;
    std::erase_if(known_, [&](const Way& known) {
      return known.asked_by == way.asked_by;
    });
    Way& known = known_.emplace_back(way);
    known.document = nullptr;
    if (&way != &ways.front()) known.tried->solution.reset();
  }
}

std::size_t WayTrials::best(const std::vector<Document>& laid,
                            bool until_all,
                            const Progress& progress) {
  std::vector<Way> ways = waysOf(laid);
  if (ways.size() == 1) return 0;
  judgeShortly(ways, progress);
  const Way& first = ways.front();
  if (!first.tried || !first.tried->reaches_all) judgeInFull(ways, until_all, progress);
  return ways.front().index;
}

std::size_t WayTrials::bestSolved(const std::vector<Document>& laid, const Progress& progress) {
  std::vector<Way> ways = waysOf(laid);
  judgeInFull(ways, false, progress);
  return ways.front().index;
}

std::vector<std::size_t> WayTrials::likely(const std::vector<Document>& laid,
                                           std::size_t most,
                                           const Progress& progress) {
  std::vector<Way> ways = waysOf(laid);
  judgeShortly(ways, progress);
  std::vector<std::size_t> likely;
  for (const Way& way : ways)
    if (likely.size() < most) likely.push_back(way.index);
  return likely;
}

std::ptrdiff_t WayTrials::missedBySearch(const Document& laid, const Progress& progress) {
  std::vector<Way> ways = waysOf({&laid, 1});
  judgeInFull(ways, false, progress);
  const auto& [lacking, dropped, objective] = ways.front().tried->lack;
  return lacking - dropped;
}

std::shared_ptr<const Solution> WayTrials::solutionOf(const Document& laid) const {
  const std::string asked_by = askedBy(laid);
  for (const Way& known : known_)
    if (known.asked_by == asked_by && known.tried->solution) return known.tried->solution;
  return nullptr;
}

}  // namespace handgraft::session
