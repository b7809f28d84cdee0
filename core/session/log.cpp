#include "core/session/log.h"

#include "core/base/error.h"

namespace handgraft::session {

Log::Log(LogStart first, std::vector<LogEntry> entries)
    : first_(std::move(first)), entries_(std::move(entries)) {
  if (entries_.size() > kMostEntries) {
    rejectInput("a log of {} entries; permitted are {}", entries_.size(), kMostEntries);
  }
}

void Log::add(LogEntry entry, const History& after, unsigned long long revision) {
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
  // A hundred sessions need not each keep room for twice what they have.
  constexpr std::size_t kGrowth = 128;
  if (entries_.size() == entries_.capacity()) entries_.reserve(entries_.size() + kGrowth);
  entries_.push_back(std::move(entry));
  if (middle_count_ == 0 && entries_.size() >= kMostEntries / 2) {
    middle_ = {after, revision};
    middle_count_ = entries_.size();
  }
}

}  // namespace handgraft::session
