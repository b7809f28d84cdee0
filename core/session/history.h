#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/session/document.h"
#include "core/session/step_stack.h"

namespace handgraft::session {

/// A snapshot and the revision it was taken at.
struct Snapshot {
  Document document;
  unsigned long long revision = 0;
};

/// A document with its past and its future: a value, cheap to copy (steps are shared).
///
/// A step leads to the document as it was before its edit, whatever solves were committed
/// since; a redo to the one that the undo left, those solves included. So undoing everything
/// ends at the first document, and redoing everything at the last, to the byte.
/// A solve belongs to the edit that it answers, and the first one to the first document, which
/// nobody wants to see without an answer. One that somebody asked for where an answer stood is
/// a step of its own, "solve".
class History {
 public:
  History() = default;

  explicit History(Document first) : present_(std::move(first)) {}

  [[nodiscard]] const Document& present() const { return present_; }

  /// Puts an edit's result in place. What could be redone is gone.
  void edit(Document document, std::string label);

  /// Puts the result of a solve in place, which answers the present document; as a step of its
  /// own or not.
  void commit(Document document, bool is_step);

  /// Errors: InvalidInput unless 1 <= count <= steps there are.
  void undo(int count);
  void redo(int count);

  /// Errors: InvalidInput for a bad or unknown name, or too many of them.
  void takeSnapshot(const std::string& name, unsigned long long revision);
  [[nodiscard]] const Snapshot& snapshot(const std::string& name) const;

  [[nodiscard]] std::size_t undoCount() const { return undo_.size(); }

  [[nodiscard]] std::size_t redoCount() const { return redo_.size(); }

  /// What would be undone or redone, the next first.
  [[nodiscard]] std::vector<std::string> undoLabels(std::size_t most) const;
  [[nodiscard]] std::vector<std::string> redoLabels(std::size_t most) const;
  [[nodiscard]] std::vector<std::string> snapshotNames() const;

  using Steps = StepStack;
  using Snapshots = std::map<std::string, std::shared_ptr<const Snapshot>>;

  [[nodiscard]] const Steps& undoSteps() const { return undo_; }

  [[nodiscard]] const Steps& redoSteps() const { return redo_; }

  [[nodiscard]] const Snapshots& snapshots() const { return snapshots_; }

  /// Of a file. Errors: InvalidInput where there is too much of it, or a step does not fit.
  static History restored(Document present, Steps undo, Steps redo, Snapshots snapshots);

 private:
  void step(Steps& from, Steps& to);

  Document present_;
  Steps undo_;
  Steps redo_;
  Snapshots snapshots_;
};

// Bounds of a session's memory; the oldest steps are forgotten.
inline constexpr std::size_t kMostSteps = 500;
inline constexpr std::size_t kMostSnapshots = 32;

}  // namespace handgraft::session
