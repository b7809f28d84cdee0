#include "core/session/document.h"

#include <utility>

#include "core/base/error.h"
#include "core/session/field_bytes.h"

namespace handgraft::session {
namespace {

template <class T>
bool same(const T& a, const T& b) {
  FieldWriter of_a;
  FieldWriter of_b;
  of_a.add(a);
  of_b.add(b);
  return of_a.take() == of_b.take();
}

template <class T>
void note(const T& from, const T& to, std::optional<T>& change) {
  if (!same(from, to)) change = to;
}

template <class T>
void take(const std::optional<T>& change, T& value) {
  if (change) value = *change;
}

template <class T>
void noteList(const std::vector<T>& from,
              const std::vector<T>& to,
              std::optional<std::size_t>& count,
              std::vector<std::pair<std::size_t, T>>& entries) {
  if (from.size() != to.size()) count = to.size();
  for (std::size_t i = 0; i < to.size(); ++i) {
    if (count || !same(from[i], to[i])) entries.emplace_back(i, to[i]);
  }
}

template <class T>
void takeList(const std::optional<std::size_t>& count,
              const std::vector<std::pair<std::size_t, T>>& entries,
              const char* what,
              std::vector<T>& list) {
  if (count) {
    if (*count != entries.size()) {
      rejectInput("change of {} {}: it brings {}", *count, what, entries.size());
    }
    list.assign(*count, T());
  }
  for (const auto& [index, entry] : entries) {
    if (index >= list.size()) {
      rejectInput("change of number {} of the {}: there are {}", index, what, list.size());
    }
    list[index] = entry;
  }
}

}  // namespace

std::string bytesOf(const Document& document) {
  FieldWriter bytes;
  bytes.add(document);
  return bytes.take();
}

bool operator==(const Document& a, const Document& b) {
  return same(a, b);
}

DocumentChange changeBetween(const Document& from, const Document& to) {
  DocumentChange change;
  note(from.hand, to.hand, change.hand);
  note(from.object, to.object, change.object);
  note(from.contacts, to.contacts, change.contacts);
  note(from.X_WO, to.X_WO, change.X_WO);
  noteList(from.patches, to.patches, change.patch_count, change.patches);
  noteList(from.joints, to.joints, change.joint_count, change.joints);
  note(from.held, to.held, change.held);
  note(from.start, to.start, change.start);
  if (!same(from.prior, to.prior)) {
    change.prior_is_start = change.start.has_value() && same(to.prior, to.start);
    if (!change.prior_is_start) change.prior = to.prior;
  }
  note(from.start_is_known, to.start_is_known, change.start_is_known);
  note(from.is_solved, to.is_solved, change.is_solved);
  note(from.weights, to.weights, change.weights);
  note(from.prior_shares, to.prior_shares, change.prior_shares);
  note(from.solving, to.solving, change.solving);
  note(from.transfer, to.transfer, change.transfer);
  note(from.timed, to.timed, change.timed);
  note(from.notes, to.notes, change.notes);
  return change;
}

Document applyTo(Document document, const DocumentChange& change) {
  take(change.hand, document.hand);
  take(change.object, document.object);
  take(change.contacts, document.contacts);
  take(change.X_WO, document.X_WO);
  takeList(change.patch_count, change.patches, "patches", document.patches);
  takeList(change.joint_count, change.joints, "joints", document.joints);
  take(change.held, document.held);
  take(change.start, document.start);
  take(change.prior, document.prior);
  if (change.prior_is_start) document.prior = document.start;
  take(change.start_is_known, document.start_is_known);
  take(change.is_solved, document.is_solved);
  take(change.weights, document.weights);
  take(change.prior_shares, document.prior_shares);
  take(change.solving, document.solving);
  take(change.transfer, document.transfer);
  take(change.timed, document.timed);
  take(change.notes, document.notes);
  return document;
}

}  // namespace handgraft::session
