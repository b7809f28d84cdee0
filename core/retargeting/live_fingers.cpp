#include "core/retargeting/live_fingers.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace handgraft::retargeting {

const std::string* LiveFingers::fingerFor(const std::string& digit) const {
  const auto dealt = dealing_.find(digit);
  return dealt == dealing_.end() ? nullptr : &dealt->second;
}

std::vector<session::Dealing> LiveFingers::waysFor(
    const std::vector<std::string>& touching) const {
  session::Dealing same;
  for (const std::string& digit : touching)
    if (anatomy_->maybeDigit(digit) != nullptr) same[digit] = digit;
  const bool has_all = same.size() == touching.size() && !session::lacksDigits(*anatomy_);
  if (has_all) return {std::move(same)};
  return session::waysToDeal(*anatomy_, touching);
}

void LiveFingers::choose(session::Dealing dealing, std::vector<std::string> touching) {
  dealing_ = std::move(dealing);
  chosen_for_ = std::move(touching);
}

void LiveFingers::take(const std::vector<std::string>& touching,
                       const std::vector<std::string>& present) {
  for (const std::string& digit : touching) {
    if (dealing_.contains(digit)) continue;
    std::optional<session::Dealing> more = session::extendedBy(*anatomy_, digit, dealing_);
    if (!more) {
      session::Dealing needed = dealing_;
      std::erase_if(needed, [&](const auto& dealt) {
        return std::find(present.begin(), present.end(), dealt.first) == present.end();
      });
      more = session::extendedBy(*anatomy_, digit, needed);
    }
    if (more) choose(std::move(*more), {});
  }
}

bool LiveFingers::lacksOneFor(const std::vector<std::string>& touching) const {
  return std::any_of(touching.begin(), touching.end(), [&](const std::string& digit) {
    return !dealing_.contains(digit);
  });
}

}  // namespace handgraft::retargeting
