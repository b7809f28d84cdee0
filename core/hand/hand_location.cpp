#include "core/hand/hand_location.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace handgraft::hand {

namespace {

bool isNumber(std::string_view text) {
  return !text.empty() && text.size() <= 9 && std::all_of(text.begin(), text.end(), [](char c) {
    return c >= '0' && c <= '9';
  });
}

bool isDigit(std::string_view text) {
  static constexpr std::array<std::string_view, 6> kNames{"thumb", "index",  "middle",
                                                          "ring",  "little", kPalmPart};
  if (std::find(kNames.begin(), kNames.end(), text) != kNames.end()) return true;
  return text.size() > 1 && text.front() == 'f' && isNumber(text.substr(1));
}

/// Cuts what follows the last '_' off `text`.
std::string_view lastWord(std::string_view& text) {
  const std::size_t at = text.rfind('_');
  if (at == std::string_view::npos) return {};
  const std::string_view word = text.substr(at + 1);
  text = text.substr(0, at);
  return word;
}

}  // namespace

std::string partName(const std::string& digit, const std::string& segment) {
  return segment.empty() ? digit : digit + "_" + segment;
}

std::optional<HandLocation> placeNamed(const std::string& name) {
  HandLocation place;
  std::string_view rest = name;
  std::string_view before = rest;
  const std::string_view number = lastWord(before);
  if (isNumber(number)) rest = before;
  if (rest == kPalmPart) {
    place.digit = rest;
    return place;
  }
  const std::string_view segment = lastWord(rest);
  const bool is_segment = segment == "proximal" || segment == "middle" || segment == "distal";
  if (!is_segment || !isDigit(rest) || rest == kPalmPart) return std::nullopt;
  place.digit = rest;
  place.segment = segment;
  return place;
}

}  // namespace handgraft::hand
