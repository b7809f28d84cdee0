#include "hardware/bridge/pose_refusal.h"

#include <algorithm>
#include <array>
#include <string_view>

#include <fmt/format.h>

namespace handgraft::bridge {

namespace {

using safety::SampleVerdict;

/// A name from elsewhere: nothing unprintable, nothing endless.
class PrintableName {
 public:
  explicit PrintableName(std::string_view name) : size_(std::min(name.size(), chars_.size())) {
    std::transform(name.begin(), name.begin() + static_cast<std::ptrdiff_t>(size_),
                   chars_.begin(), [](char c) {
                     return c < ' ' || c == '\x7F' ? '?' : c;
                   });
  }

  [[nodiscard]] std::string_view view() const { return {chars_.data(), size_}; }

 private:
  std::array<char, 48> chars_{};
  std::size_t size_;
};

/// Appends to a text of bounded length.
class Draft {
 public:
  template <class... Parts>
  void add(fmt::format_string<Parts...> format, Parts&&... parts) {
    const auto end = fmt::format_to_n(chars_.data() + size_, chars_.size() - size_, format,
                                      std::forward<Parts>(parts)...);
    size_ = std::min(size_ + end.size, chars_.size());
  }

  [[nodiscard]] FixedText text() const {
    FixedText text;
    text.set({chars_.data(), size_});
    return text;
  }

 private:
  std::array<char, 200> chars_{};
  std::size_t size_ = 0;
};

const std::string* firstBeyond(std::span<const std::string> names,
                               std::span<const std::string> known) {
  const auto found = std::find_if(names.begin(), names.end(), [known](const std::string& name) {
    return std::find(known.begin(), known.end(), name) == known.end();
  });
  return found == names.end() ? nullptr : &*found;
}

const std::string* firstTwice(std::span<const std::string> names) {
  for (std::size_t i = 1; i < names.size(); ++i) {
    const auto before = names.first(i);
    if (std::find(before.begin(), before.end(), names[i]) != before.end()) return &names[i];
  }
  return nullptr;
}

}  // namespace

FixedText describeRefusal(SampleVerdict verdict,
                          std::span<const std::string> names,
                          std::span<const std::string> told,
                          std::size_t number_count) {
  Draft draft;
  draft.add("{}", safety::toString(verdict));
  if (verdict != SampleVerdict::kWrongLength && verdict != SampleVerdict::kWrongNames)
    return draft.text();
  const char* separator = ": ";
  if (told.size() != names.size() || number_count != names.size()) {
    draft.add("{}{} for the hand's {}", separator, number_count, names.size());
    separator = ", ";
  }
  if (const std::string* missing = firstBeyond(names, told)) {
    draft.add("{}'{}' is missing", separator, PrintableName(*missing).view());
    separator = ", ";
  }
  if (const std::string* extra = firstBeyond(told, names)) {
    draft.add("{}'{}' is none of its joints", separator, PrintableName(*extra).view());
  } else if (const std::string* twice = firstTwice(told)) {
    draft.add("{}'{}' is there twice", separator, PrintableName(*twice).view());
  }
  return draft.text();
}

}  // namespace handgraft::bridge
