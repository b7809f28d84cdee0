#include "core/contact/contact_map.h"

#include <cmath>
#include <iterator>

#include "core/base/error.h"
#include "core/hand/hand_location.h"
#include "core/hand/part_words.h"

namespace handgraft::contact {

std::string fingerOfSegment(const std::string& segment_name) {
  return hand::partWordsOf(segment_name).digit;
}

std::string partOfLabel(const ContactMap& map, int label) {
  if (label < 0) return "";
  const auto index = static_cast<std::size_t>(label);
  if (!map.segment_parts.empty())
    return index < map.segment_parts.size() ? map.segment_parts[index] : "";
  if (index >= map.segment_names.size()) return "";
  const hand::PartWords words = hand::partWordsOf(map.segment_names[index]);
  const bool has_segment =
      !words.digit.empty() && words.digit != hand::kPalmPart && words.segment != "metacarpal";
  return hand::partName(words.digit, has_segment ? words.segment : "");
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
