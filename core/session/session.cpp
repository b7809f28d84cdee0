#include "core/session/session.h"

#include <utility>

#include "core/base/error.h"
#include "core/session/apply_edit.h"
#include "core/session/edit_checks.h"
#include "core/session/patch_matching.h"

namespace handgraft::session {
namespace {

bool isOfHistory(const Edit& edit) {
  return std::holds_alternative<UndoEdit>(edit) || std::holds_alternative<RedoEdit>(edit) ||
         std::holds_alternative<SnapshotEdit>(edit) ||
         std::holds_alternative<RestoreEdit>(edit);
}

void validateDocument(const Document& document, ModelCache& cache) {
  if (document.contacts != cache.first().contacts_name) {
    rejectInput("contacts {}; the session was opened with {}", quoted(document.contacts),
                quoted(cache.first().contacts_name));
  }
  validate(document, cache.find(document.hand, document.object, Progress()));
}

/// All documents that it leads to.
void validateHistory(const History& history, ModelCache& cache) {
  validateDocument(history.present(), cache);
  for (const History::Steps* steps : {&history.undoSteps(), &history.redoSteps()}) {
    Document document = history.present();
    for (auto step = steps->rbegin(); step != steps->rend(); ++step) {
      document = applyTo(std::move(document), (*step)->change);
      validateDocument(document, cache);
    }
  }
  for (const auto& [name, snapshot] : history.snapshots())
    validateDocument(snapshot->document, cache);
}

}  // namespace

Session::Session(SessionModels models,
                 const Pose& X_WO,
                 const optimize::Weights& weights,
                 const transfer::TransferOptions& transfer_options,
                 const Progress& progress)
    : cache_(std::make_shared<ModelCache>(std::move(models))), derived_(cache_) {
  requireRigid(X_WO, "the object's pose");
  validateWeights(weights);
  FirstDocument first = firstDocument(*cache_, X_WO, weights, transfer_options, progress);
  history_ = History(std::move(first.document));
  derived_.follow(document(), Progress());
  derived_.expect(std::move(first.solution));
  log_ = Log({history_, revision_});
}

Session::Session(hand::Hand hand,
                 std::shared_ptr<const geometry::TriangleMesh> object_O,
                 const contact::ContactSet& contacts,
                 const Pose& X_WO,
                 const optimize::Weights& weights,
                 const transfer::TransferOptions& transfer_options)
    : Session(modelsOf(std::move(hand), std::move(object_O), contacts),
              X_WO,
              weights,
              transfer_options) {}

Session::Session(SessionModels models, SavedSession saved)
    : cache_(std::make_shared<ModelCache>(std::move(models))),
      derived_(cache_),
      history_(std::move(saved.history)),
      log_(std::move(saved.first), saved.log),
      revision_(saved.revision) {
  validateHistory(history_, *cache_);
  validateHistory(log_.first().history, *cache_);
  derived_.follow(document(), Progress());
}

Session::~Session() = default;
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;

// === Edits

EditResult Session::apply(const Edit& edit, const Progress& progress, const Keep& keep) {
  Edit logged = edit;
  if (auto* choice = std::get_if<ChoiceEdit>(&logged); choice != nullptr && !choice->pose) {
    if (minima_.empty()) rejectInput("there is no solution to choose a minimum of");
    if (choice->rank < 0 || static_cast<std::size_t>(choice->rank) >= minima_.size()) {
      rejectInput("minimum {}: permitted are 0 to {}", choice->rank, minima_.size() - 1);
    }
    choice->pose = minima_[static_cast<std::size_t>(choice->rank)].pose;
  }
  EditResult result;
  History next = history_;
  if (isOfHistory(logged)) {
    result.message = travel(logged, next);
  } else {
    std::string label = describe(logged, *hand().model);
    Edited edited = applied(logged, derived_, *cache_, progress);
    result.message = std::move(edited.message);
    next.edit(std::move(edited.document), std::move(label));
  }
  derived_.follow(next.present(), progress);
  result.revision = revision_ + 1;
  if (keep) {
    try {
      keep(logged, result);
    } catch (...) {
      derived_.follow(document(), Progress());
      throw;
    }
  }

  // === Nothing fails from here on
  if (next.present().hand != document().hand) minima_.clear();
  if (const auto* choice = std::get_if<ChoiceEdit>(&logged)) {
    chosen_minimum_ = choice->rank;
  } else if (!std::holds_alternative<SnapshotEdit>(logged)) {
    chosen_minimum_ = 0;
  }
  history_ = std::move(next);
  ++revision_;
  log_.add(std::move(logged), history_, revision_);
  return result;
}

std::string Session::travel(const Edit& edit, History& history) const {
  std::string message;
  if (const auto* undo = std::get_if<UndoEdit>(&edit)) {
    const auto labels = history.undoLabels(1);
    history.undo(undo->count);
    if (undo->count == 1) message = "undone: " + labels.front();
  } else if (const auto* redo = std::get_if<RedoEdit>(&edit)) {
    const auto labels = history.redoLabels(1);
    history.redo(redo->count);
    if (redo->count == 1) message = "redone: " + labels.front();
  } else if (const auto* snapshot = std::get_if<SnapshotEdit>(&edit)) {
    const auto before = history.snapshots().find(snapshot->name);
    if (before != history.snapshots().end())
      message = fmt::format("replaces the one of revision {}", before->second->revision);
    history.takeSnapshot(snapshot->name, revision_);
  } else if (const auto* restore = std::get_if<RestoreEdit>(&edit)) {
    history.edit(history.snapshot(restore->name).document, describe(edit));
  }
  return message;
}

SavedSession Session::saved() const {
  return {log_.first(), log_.entries(), history_, revision_};
}

std::vector<Difference> Session::compare(const std::string& a,
                                         const std::string& b,
                                         const Progress& progress) {
  struct Judged {
    const Document* document = nullptr;
    std::vector<std::string> joints;
    std::optional<Solution> solution;
  };

  const auto judged = [&](const std::string& name) {
    Judged result;
    result.document = name.empty() ? &document() : &history_.snapshot(name).document;
    result.joints = cache_->hand(result.document->hand, progress).model->dofNames();
    DerivedState derived = aside();
    derived.follow(*result.document, progress);
    try {
      result.solution = derived.judge(progress);
    } catch (const InvalidInput&) {
      // No patch has a point: there is no fit to compare.
    }
    return result;
  };
  const Judged of_a = judged(a);
  const Judged of_b = judged(b);
  return differencesBetween(*of_a.document, *of_b.document, of_a.joints, of_b.joints,
                            of_a.solution ? &of_a.solution->report : nullptr,
                            of_b.solution ? &of_b.solution->report : nullptr);
}

// === Solves

void Session::transferPatches(const Progress& progress) {
  derived_.transfer(progress);
}

Solution Session::solve(const SolverSettings& solving,
                        const SolveRun& run,
                        const Progress& progress) {
  Solution solution = derived_.solve(solving, run, progress);
  solution.revision = revision_;
  return solution;
}

std::shared_ptr<const CommittedSolve> Session::commit(Solution solution) {
  HANDGRAFT_REQUIRE(solution.revision == revision_);
  auto entry = std::make_shared<CommittedSolve>();
  entry->solving = solution.solving;
  entry->objective = solution.report.terms.objective;
  entry->change = changeBetween(document(), solution.document);
  entry->is_step = document().is_solved && !(solution.document == document());
  history_.commit(std::move(solution.document), *entry->is_step);
  derived_.adopt(std::move(solution.patches));
  derived_.follow(document(), Progress());
  minima_ = std::move(solution.report.minima);
  chosen_minimum_ = 0;
  solved_ = std::move(solution.problem);
  log_.add(std::shared_ptr<const CommittedSolve>(entry), history_, revision_);
  return entry;
}

void Session::commit(const CommittedSolve& solve) {
  Document after = applyTo(document(), solve.change);
  validateDocument(after, *cache_);
  derived_.follow(after, Progress());
  history_.commit(std::move(after), solve.is_step.value_or(history_.undoCount() == 0));
  minima_.clear();
  chosen_minimum_ = 0;
  log_.add(std::make_shared<const CommittedSolve>(solve), history_, revision_);
}

void Session::noteCancelledSolve() {
  log_.add(CancelledSolve(), history_, revision_);
}

void Session::noteFollowed(const FollowedMotion& motion) {
  log_.add(motion, history_, revision_);
}

Solution Session::standing(const Progress& progress) {
  Solution solution = derived_.judge(progress);
  solution.revision = revision_;
  for (const optimize::Minimum& minimum : minima_) {
    const bool is_start = minimum.pose.q == document().start.q &&
                          minimum.pose.X_WH.matrix() == document().start.X_WH.matrix();
    if (is_start) solution.report.minima = minima_;
  }
  return solution;
}

bool Session::needsSolve() const {
  return !document().is_solved && history_.undoCount() + history_.redoCount() > 0;
}

optimize::SolveReport Session::optimize(const optimize::SolveOptions& options,
                                        const Progress& progress) {
  SolverSettings solving = document().solving;
  solving.paper = options.from_prior;
  if (!solving.paper) {
    solving.solver = options.solver;
    solving.starts = options.starts;
  }
  solving.seed = options.seed;
  solving.max_evaluations = options.max_evaluations;
  Solution solution =
      solve(solving, {options.threads, false, options.on_improvement}, progress);
  optimize::SolveReport report = solution.report;
  commit(std::move(solution));
  return report;
}

// === What follows from the document

optimize::PoseProblem Session::problem() const {
  return derived_.problem(document().solving);
}

std::vector<transfer::Suggestion> Session::suggest(const std::string& patch,
                                                   const transfer::SuggestOptions& options,
                                                   const Progress& progress) {
  validate(options);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < document().patches.size(); ++i) {
    const DocumentPatch& item = document().patches[i];
    names.push_back(item.name);
    if (item.name != patch) continue;
    if (!item.placement) rejectInput("patch {} is dropped: {}", quoted(patch), item.dropped);
    return derived_.suggest(i, options, progress);
  }
  rejectInput("there is no patch {}; there are {}", quoted(patch), fmt::join(names, ", "));
}

}  // namespace handgraft::session
