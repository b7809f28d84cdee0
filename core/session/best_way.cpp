#include "core/session/best_way.h"

#include <algorithm>
#include <deque>
#include <limits>
#include <memory>
#include <tuple>
#include <utility>

#include "core/base/error.h"
#include "core/session/derived_state.h"
#include "core/session/patch_matching.h"

namespace handgraft::session {
namespace {

constexpr int kShortStarts = 4;

/// Patches that an answer lacks, those that are dropped of them, and the objective: less is
/// better. Of as many, what is missed may be reached yet, what is dropped never.
using Lack = std::tuple<std::ptrdiff_t, std::ptrdiff_t, double>;

/// A way to lay patches, and what comes of it.
struct Way {
  std::size_t index = 0;
  const Document* document = nullptr;
  Lack lack;
  bool reaches_all = false;
};

/// What a document is solved as: itself, or of a motion each of its frames that count.
class Trials {
 public:
  Trials(const Models& models, const Document& document) : frames_(models.frames) {
    const auto add = [&](const std::shared_ptr<const contact::ContactSet>& contacts) {
      derived_.emplace_back(std::make_shared<ModelCache>(
          modelsFor(document, *models.hand, models.object_O, contacts)));
    };
    if (frames_.empty()) add(models.contacts);
    for (const FrameContacts& frame : frames_)
      add(frame.contacts);
  }

  [[nodiscard]] std::vector<Document> of(const Document& document) const {
    if (frames_.empty()) return {document};
    std::vector<Document> documents;
    for (const FrameContacts& frame : frames_)
      documents.push_back(atFrame(document, frame));
    return documents;
  }

  /// What that one of them follows from.
  DerivedState& derived(std::size_t index) { return derived_[index]; }

 private:
  const std::vector<FrameContacts>& frames_;
  std::deque<DerivedState> derived_;
};

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

/// What comes of each way by `solve(derived, document)`, the best of them put first; one that
/// leaves no point comes to nothing. Ways that at their best lack more, or as much and drop
/// more, than another one are not looked at.
template <class Solve>
void judge(Trials& trials, std::vector<Way>& ways, bool until_all, const Solve& solve) {
  constexpr std::ptrdiff_t kMost = std::numeric_limits<std::ptrdiff_t>::max();
  std::pair<std::ptrdiff_t, std::ptrdiff_t> least{kMost, kMost};  // lacking, dropped
  for (std::size_t w = 0; w < ways.size(); ++w) {
    Way& way = ways[w];
    const std::vector<Document> documents = trials.of(*way.document);
    auto& [lacking, dropped, objective] = way.lack;
    lacking = dropped = 0;
    objective = std::numeric_limits<double>::infinity();
    way.reaches_all = false;
    for (const Document& document : documents) {
      lacking += askedPatches(document);
      dropped += droppedPatches(document);
    }
    if (std::pair(dropped, dropped) > least) continue;
    lacking = dropped;
    objective = 0.0;
    int solved = 0;
    for (std::size_t i = 0; i < documents.size(); ++i) {
      // Of nothing that is laid nothing is missed but what is dropped.
      if (askedPatches(documents[i]) == droppedPatches(documents[i])) continue;
      ++solved;
      try {
        const Solution solution = solve(trials.derived(i), documents[i]);
        lacking += failedPatches(solution.problem, solution.report);
        objective += solution.report.terms.objective;
      } catch (const InvalidInput&) {
        lacking += askedPatches(documents[i]) - droppedPatches(documents[i]);
        objective = std::numeric_limits<double>::infinity();
      }
    }
    if (solved == 0) objective = std::numeric_limits<double>::infinity();
    way.reaches_all = solved > 0 && lacking == dropped;
    least = std::min(least, std::pair(lacking, dropped));
    if (until_all && way.reaches_all && dropped == 0) {
      ways.resize(w + 1);
      break;
    }
  }
  std::stable_sort(ways.begin(), ways.end(), [](const Way& a, const Way& b) {
    return a.lack < b.lack;
  });
}

std::vector<Way> waysOf(const std::vector<Document>& laid) {
  std::vector<Way> ways;
  for (const Document& document : laid)
    ways.push_back({ways.size(), &document, {}, false});
  return ways;
}

void judgeShortly(Trials& trials, std::vector<Way>& ways, const Progress& progress) {
  SolverSettings solving = ways.front().document->solving;
  solving.starts = kShortStarts;
  judge(trials, ways, false, [&](DerivedState& derived, const Document& document) {
    derived.follow(document, progress);
    return derived.solveRoughly(solving, progress);
  });
}

void judgeInFull(Trials& trials,
                 std::vector<Way>& ways,
                 bool until_all,
                 const Progress& progress) {
  judge(trials, ways, until_all, [&](DerivedState& derived, const Document& document) {
    derived.follow(document, progress);
    return derived.solve(document.solving, {}, progress);
  });
}

}  // namespace

std::size_t bestWay(const Models& models,
                    const std::vector<Document>& laid,
                    bool until_all,
                    const Progress& progress) {
  HANDGRAFT_REQUIRE(!laid.empty());
  if (laid.size() == 1) return 0;
  std::vector<Way> ways = waysOf(laid);
  Trials trials(models, laid.front());
  judgeShortly(trials, ways, progress);
  if (ways.front().reaches_all) return ways.front().index;
  judgeInFull(trials, ways, until_all, progress);
  return ways.front().index;
}

std::size_t bestSolvedWay(const Models& models,
                          const std::vector<Document>& laid,
                          const Progress& progress) {
  HANDGRAFT_REQUIRE(!laid.empty());
  std::vector<Way> ways = waysOf(laid);
  Trials trials(models, laid.front());
  judgeInFull(trials, ways, false, progress);
  return ways.front().index;
}

std::vector<std::size_t> likelyWays(const Models& models,
                                    const std::vector<Document>& laid,
                                    std::size_t most,
                                    const Progress& progress) {
  HANDGRAFT_REQUIRE(!laid.empty());
  std::vector<Way> ways = waysOf(laid);
  Trials trials(models, laid.front());
  judgeShortly(trials, ways, progress);
  std::vector<std::size_t> likely;
  for (const Way& way : ways)
    if (likely.size() < most) likely.push_back(way.index);
  return likely;
}

std::ptrdiff_t missedByShortSearch(const Models& models,
                                   const Document& laid,
                                   const Progress& progress) {
  std::vector<Way> ways{{0, &laid, {}, false}};
  Trials trials(models, laid);
  judgeShortly(trials, ways, progress);
  const auto [lacking, dropped, objective] = ways.front().lack;
  return lacking - dropped;
}

}  // namespace handgraft::session
