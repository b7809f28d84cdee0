#include "core/session/replay.h"

#include <utility>

#include "core/base/error.h"

namespace handgraft::session {
namespace {

/// The documents that a stack leads to, the next one first.
std::vector<Document> documentsOf(const Document& present, const History::Steps& steps) {
  std::vector<Document> documents;
  for (auto step = steps.rbegin(); step != steps.rend(); ++step)
    documents.push_back(
        applyTo(documents.empty() ? present : documents.back(), (*step)->change));
  return documents;
}

/// Where the two differ first; empty if nowhere.
std::string differenceOf(const Session& played, const SavedSession& saved) {
  if (played.revision() != saved.revision) {
    return fmt::format("it ended at revision {}, the file's at {}", played.revision(),
                       saved.revision);
  }
  const History& a = played.history();
  const History& b = saved.history;
  if (!(a.present() == b.present())) return "the last document differs from the file's";
  if (documentsOf(a.present(), a.undoSteps()) != documentsOf(b.present(), b.undoSteps()))
    return "what can be undone differs from the file's";
  if (documentsOf(a.present(), a.redoSteps()) != documentsOf(b.present(), b.redoSteps()))
    return "what can be redone differs from the file's";
  if (a.snapshotNames() != b.snapshotNames()) return "the snapshots differ from the file's";
  for (const auto& [name, snapshot] : a.snapshots()) {
    if (!(snapshot->document == b.snapshot(name).document))
      return fmt::format("snapshot {} differs from the file's", quoted(name));
  }
  return "";
}

}  // namespace

Replay replay(SessionModels models,
              const SavedSession& saved,
              bool solve_again,
              const Progress& progress) {
  Replay result{
      Session(std::move(models), {saved.first, {}, saved.first.history, saved.first.revision}),
      0, false, ""};
  Session& session = result.session;
  for (const LogEntry& entry : saved.log) {
    progress.checkpoint();
    std::string what = "a cancelled solve";
    try {
      if (const auto* edit = std::get_if<Edit>(&entry)) {
        what = describe(*edit);
        session.apply(*edit, progress);
      } else if (const auto* solve =
                     std::get_if<std::shared_ptr<const CommittedSolve>>(&entry)) {
        what = "a solve";
        if (solve_again) {
          const Solution solution = session.solve((*solve)->solving, SolveRun(), progress);
          if (!(solution.document == applyTo(session.document(), (*solve)->change))) {
            result.message = fmt::format(
                "entry {}, a solve: it ends elsewhere, at objective {:.9g} instead of {:.9g}",
                result.entries, solution.report.terms.objective, (*solve)->objective);
            return result;
          }
        }
        session.commit(**solve);
      } else if (const auto* followed = std::get_if<FollowedMotion>(&entry)) {
        session.noteFollowed(*followed);
      } else {
        session.noteCancelledSolve();
      }
    } catch (const InvalidInput& error) {
      result.message = fmt::format("entry {}, {}: {}", result.entries, what, error.what());
      return result;
    }
    ++result.entries;
  }
  result.message = differenceOf(session, saved);
  result.same = result.message.empty();
  return result;
}

}  // namespace handgraft::session
