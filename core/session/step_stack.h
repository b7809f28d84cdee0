#pragma once

#include <cstddef>
#include <deque>
#include <iterator>
#include <memory>
#include <string>

#include "core/session/document.h"

namespace handgraft::session {

/// One edit that can be undone, or redone.
struct HistoryStep {
  std::string label;      ///< of the edit (describe)
  DocumentChange change;  ///< from the document next to it to the one it leads to
};

/// Steps, the next one last. Kept as bytes, some 400 each with a pose, since a long past is the
/// larger part of what a session remembers; whoever looks at a step gets one of its own. Copies
/// share the bytes.
class StepStack {
 public:
  using SharedStep = std::shared_ptr<const HistoryStep>;

  /// Makes a step of its bytes at every look.
  class Iterator {
   public:
    // NOLINTBEGIN(readability-identifier-naming): the library's names
    using iterator_category = std::bidirectional_iterator_tag;
    using value_type = StepStack::SharedStep;
    using difference_type = std::ptrdiff_t;
    using pointer = const value_type*;
    using reference = value_type;

    // NOLINTEND(readability-identifier-naming)

    Iterator(const StepStack& stack, std::size_t place) : stack_(&stack), place_(place) {}

    value_type operator*() const { return stack_->at(place_); }

    Iterator& operator++() {
      ++place_;
      return *this;
    }

    Iterator& operator--() {
      --place_;
      return *this;
    }

    friend bool operator==(const Iterator& a, const Iterator& b) = default;

   private:
    const StepStack* stack_;
    std::size_t place_;
  };

  [[nodiscard]] std::size_t size() const { return steps_.size(); }

  [[nodiscard]] bool empty() const { return steps_.empty(); }

  [[nodiscard]] Iterator begin() const { return {*this, 0}; }

  [[nodiscard]] Iterator end() const { return {*this, size()}; }

  [[nodiscard]] auto rbegin() const { return std::reverse_iterator(end()); }

  [[nodiscard]] auto rend() const { return std::reverse_iterator(begin()); }

  [[nodiscard]] SharedStep at(std::size_t place) const;

  [[nodiscard]] SharedStep back() const { return at(size() - 1); }

  void pushBack(const HistoryStep& step);

  void pushBack(const SharedStep& step) { pushBack(*step); }

  void popBack() { steps_.pop_back(); }

  void popFront() { steps_.pop_front(); }

  void clear() { steps_.clear(); }

 private:
  std::deque<std::shared_ptr<const std::string>> steps_;
};

}  // namespace handgraft::session
