#include "core/session/log.h"

#include <utility>

#include "core/base/error.h"
#include "core/session/field_bytes.h"

namespace handgraft::session {
namespace {

// Of `LogEntry`, by place.
constexpr std::size_t kEdit = 0;
constexpr std::size_t kSolve = 1;
constexpr std::size_t kFollowed = 3;

std::string packed(const LogEntry& entry) {
  FieldWriter bytes;
  bytes.add(static_cast<unsigned char>(entry.index()));
  if (const auto* edit = std::get_if<kEdit>(&entry)) {
    bytes.add(static_cast<unsigned char>(edit->index()));
    std::visit(
        [&](const auto& one) {
          bytes.add(one);
        },
        *edit);
  } else if (const auto* solve = std::get_if<kSolve>(&entry)) {
    bytes.add(**solve);
  } else if (const auto* followed = std::get_if<kFollowed>(&entry)) {
    bytes.add(*followed);
  }
  return bytes.take();
}

template <std::size_t Kind = 0>
Edit editOf(FieldReader& bytes, std::size_t kind) {
  if constexpr (Kind < std::variant_size_v<Edit>) {
    if (kind != Kind) return editOf<Kind + 1>(bytes, kind);
    return bytes.value<std::variant_alternative_t<Kind, Edit>>();
  } else {
    throw BrokenContract("an edit of no kind");
  }
}

LogEntry unpacked(const std::string& entry) {
  FieldReader bytes(entry);
  switch (bytes.value<unsigned char>()) {
    case kEdit:
      return editOf(bytes, bytes.value<unsigned char>());
    case kSolve:
      return std::make_shared<const CommittedSolve>(bytes.value<CommittedSolve>());
    case kFollowed:
      return bytes.value<FollowedMotion>();
    default:
      return CancelledSolve();
  }
}

}  // namespace

Log::Log(LogStart first, const std::vector<LogEntry>& entries) : first_(std::move(first)) {
  if (entries.size() > kMostEntries) {
    rejectInput("a log of {} entries; permitted are {}", entries.size(), kMostEntries);
  }
  for (const LogEntry& entry : entries)
    entries_.push_back(packed(entry));
}

std::vector<LogEntry> Log::entries() const {
  std::vector<LogEntry> list;
  list.reserve(entries_.size());
  for (const std::string& entry : entries_)
    list.push_back(unpacked(entry));
  return list;
}

void Log::add(const LogEntry& entry, const History& after, unsigned long long revision) {
  if (entries_.size() >= kMostEntries) {
    if (middle_count_ == 0) {  // it came from a file, full: it begins anew
      first_ = {after, revision};
      entries_.clear();
      return;
    }
    first_ = std::move(middle_);
    entries_.erase(entries_.begin(),
                   entries_.begin() + static_cast<std::ptrdiff_t>(middle_count_));
    middle_count_ = 0;
  }
  entries_.push_back(packed(entry));
  if (middle_count_ == 0 && entries_.size() >= kMostEntries / 2) {
    middle_ = {after, revision};
    middle_count_ = entries_.size();
  }
}

}  // namespace handgraft::session
