#include "core/contact/contact_map.h"

#include <array>
#include <cctype>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/base/error.h"

namespace handgraft::contact {
namespace {

bool isUpper(char c) {
  return std::isupper(static_cast<unsigned char>(c)) != 0;
}

bool isAlnum(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0;
}

bool isDigit(char c) {
  return std::isdigit(static_cast<unsigned char>(c)) != 0;
}

/// Words of a name in lower case, without the digits that number them: "right_Pinky2" gives
/// right and pinky; a word that starts with a digit ("4th") is no name.
std::vector<std::string> wordsOf(const std::string& name) {
  std::vector<std::string> words(1);
  for (std::size_t i = 0; i < name.size(); ++i) {
    const bool starts_word =
        i > 0 && isUpper(name[i]) && isAlnum(name[i - 1]) && !isUpper(name[i - 1]);
    if (!isAlnum(name[i]) || starts_word) words.emplace_back();
    if (isAlnum(name[i])) {
      words.back() += static_cast<char>(std::tolower(static_cast<unsigned char>(name[i])));
    }
  }
  for (std::string& word : words) {
    while (!word.empty() && isDigit(word.back()))
      word.pop_back();
  }
  return words;
}

}  // namespace

std::string fingerOfSegment(const std::string& segment_name) {
  using Names = std::pair<const char*, const char*>;
  static constexpr std::array<Names, 7> kFullNames = {
      Names{"thumb", "thumb"}, {"index", "index"},  {"middle", "middle"}, {"ring", "ring"},
      {"little", "little"},    {"pinky", "little"}, {"palm", "palm"}};
  static constexpr std::array<Names, 6> kTokens = {Names{"th", "thumb"}, {"ff", "index"},
                                                   {"mf", "middle"},     {"rf", "ring"},
                                                   {"lf", "little"},     {"mid", "middle"}};
  const std::vector<std::string> words = wordsOf(segment_name);
  for (const std::string& word : words) {
    // A word may go on ("thumbtip"), but not begin otherwise ("spring", "bearing").
    for (const auto& [name, finger] : kFullNames) {
      if (word.rfind(name, 0) == 0) return finger;
    }
  }
  for (const std::string& word : words) {
    for (const auto& [token, finger] : kTokens) {
      if (word == token) return finger;
    }
  }
  return "";
}

std::string partOfLabel(const ContactMap& map, int label) {
  if (label < 0) return "";
  const auto index = static_cast<std::size_t>(label);
  if (!map.segment_parts.empty())
    return index < map.segment_parts.size() ? map.segment_parts[index] : "";
  return index < map.segment_names.size() ? fingerOfSegment(map.segment_names[index]) : "";
}

void validate(const ContactMap& map) {
  const int vertex_count = map.mesh_O.vertexCount();
  if (map.value.size() != vertex_count) {
    rejectInput("contact map: {} values for {} vertices; one per vertex is needed",
                map.value.size(), vertex_count);
  }
  for (int v = 0; v < vertex_count; ++v) {
    if (!std::isfinite(map.value[v])) {
      rejectInput("contact map: the value of vertex {} is {}; it must be finite", v,
                  map.value[v]);
    }
  }
  if (!map.segment_parts.empty() && map.segment_parts.size() != map.segment_names.size()) {
    rejectInput("contact map: {} parts for {} segments; one per segment is needed",
                map.segment_parts.size(), map.segment_names.size());
  }
  if (map.label.empty()) return;
  if (std::ssize(map.label) != vertex_count) {
    rejectInput("contact map: {} labels for {} vertices; one per vertex is needed",
                map.label.size(), vertex_count);
  }
  const int name_count = static_cast<int>(map.segment_names.size());
  for (int v = 0; v < vertex_count; ++v) {
    const int label = map.label[v];
    if (label < -1 || (name_count > 0 && label >= name_count)) {
      rejectInput("contact map: the label of vertex {} is {}; permitted are -1 to {}", v, label,
                  name_count - 1);
    }
  }
}

}  // namespace handgraft::contact
