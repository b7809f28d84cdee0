#include "core/session/history.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"

namespace handgraft::session {
namespace {

constexpr const char* kSolveLabel = "solve";
constexpr std::size_t kLongestName = 64;

HistoryStep stepTo(const Document& from, const Document& to, std::string label) {
  return {std::move(label), changeBetween(from, to)};
}

/// The document that a stack's next step leads to stays when the one that it starts from
/// changes.
void rebase(History::Steps& steps, const Document& before, const Document& after) {
  if (steps.empty()) return;
  const auto next = steps.back();
  steps.popBack();
  steps.pushBack(stepTo(after, applyTo(before, next->change), next->label));
}

std::vector<std::string> labelsOf(const History::Steps& steps, std::size_t most) {
  std::vector<std::string> labels;
  for (auto step = steps.rbegin(); step != steps.rend() && labels.size() < most; ++step)
    labels.push_back((*step)->label);
  return labels;
}

void requireCount(int count, std::size_t there_are, const char* what) {
  if (there_are == 0) rejectInput("there is nothing to {}", what);
  if (count < 1 || static_cast<std::size_t>(count) > there_are) {
    rejectInput("{} {}: permitted are 1 to {}", what, count, there_are);
  }
}

void validateName(const std::string& name) {
  const bool is_plain = std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           c == '_' || c == '-' || c == '.';
  });
  if (name.empty() || name.size() > kLongestName || !is_plain) {
    rejectInput("snapshot {}: a name is 1 to {} letters, digits, '_', '-' and '.'",
                quoted(name), kLongestName);
  }
}

}  // namespace

void History::edit(Document document, std::string label) {
  undo_.pushBack(stepTo(document, present_, std::move(label)));
  if (undo_.size() > kMostSteps) undo_.popFront();
  redo_.clear();
  present_ = std::move(document);
}

void History::commit(Document document, bool is_step) {
  if (is_step) {
    undo_.pushBack(stepTo(document, present_, kSolveLabel));
    if (undo_.size() > kMostSteps) undo_.popFront();
  } else {
    rebase(undo_, present_, document);
  }
  rebase(redo_, present_, document);
  present_ = std::move(document);
}

void History::step(Steps& from, Steps& to) {
  const auto next = from.back();
  Document document = applyTo(present_, next->change);
  from.popBack();
  to.pushBack(stepTo(document, present_, next->label));
  present_ = std::move(document);
}

void History::undo(int count) {
  requireCount(count, undo_.size(), "undo");
  for (int i = 0; i < count; ++i)
    step(undo_, redo_);
}

void History::redo(int count) {
  requireCount(count, redo_.size(), "redo");
  for (int i = 0; i < count; ++i)
    step(redo_, undo_);
}

void History::takeSnapshot(const std::string& name, unsigned long long revision) {
  validateName(name);
  if (snapshots_.count(name) == 0 && snapshots_.size() >= kMostSnapshots) {
    rejectInput("snapshot {}: there are {} already, as many as a session may have",
                quoted(name), snapshots_.size());
  }
  snapshots_[name] = std::make_shared<const Snapshot>(Snapshot{present_, revision});
}

const Snapshot& History::snapshot(const std::string& name) const {
  const auto found = snapshots_.find(name);
  if (found == snapshots_.end()) {
    rejectInput(
        "there is no snapshot {}; there are {}", quoted(name),
        snapshots_.empty() ? "none" : fmt::format("{}", fmt::join(snapshotNames(), ", ")));
  }
  return *found->second;
}

std::vector<std::string> History::undoLabels(std::size_t most) const {
  return labelsOf(undo_, most);
}

std::vector<std::string> History::redoLabels(std::size_t most) const {
  return labelsOf(redo_, most);
}

std::vector<std::string> History::snapshotNames() const {
  std::vector<std::string> names;
  for (const auto& [name, snapshot] : snapshots_)
    names.push_back(name);
  return names;
}

History History::restored(Document present, Steps undo, Steps redo, Snapshots snapshots) {
  History history(std::move(present));
  if (undo.size() > kMostSteps || redo.size() > kMostSteps) {
    rejectInput("{} steps to undo and {} to redo; permitted are {} each", undo.size(),
                redo.size(), kMostSteps);
  }
  if (snapshots.size() > kMostSnapshots) {
    rejectInput("{} snapshots; permitted are {}", snapshots.size(), kMostSnapshots);
  }
  for (const auto& [name, snapshot] : snapshots)
    validateName(name);
  history.undo_ = std::move(undo);
  history.redo_ = std::move(redo);
  history.snapshots_ = std::move(snapshots);
  return history;
}

}  // namespace handgraft::session
