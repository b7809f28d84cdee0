#include "client/cli/study/study_notes.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/side_note.h"

namespace handgraft::client {

namespace {

std::string nameOf(v1::Chirality side) {
  if (side == v1::CHIRALITY_UNKNOWN) return "";
  return side == v1::CHIRALITY_LEFT ? "left" : "right";
}

}  // namespace

std::vector<std::string> notesOn(const v1::HandDescription& hand,
                                 const std::vector<StudyContacts>& contacts) {
  std::vector<std::pair<std::string, std::vector<std::string>>> told;  // and of which grasps
  const auto tell = [&](const std::string& note, const std::string& label) {
    const auto known = std::find_if(told.begin(), told.end(), [&](const auto& one) {
      return one.first == note;
    });
    std::vector<std::string>& labels =
        known != told.end() ? known->second : told.emplace_back(note, 0).second;
    if (std::find(labels.begin(), labels.end(), label) == labels.end()) labels.push_back(label);
  };
  for (const StudyContacts& one : contacts) {
    for (const std::string& note : one.described.notes())
      tell(note, one.label);
    const std::string other =
        otherSideNote(nameOf(one.described.demonstrator()), nameOf(hand.chirality()));
    if (!other.empty()) tell(other, one.label);
    for (const std::string& note : one.dealt)
      tell(note, one.label);
  }
  std::vector<std::string> notes = hand.notes();
  for (const auto& [note, labels] : told) {
    notes.push_back(labels.size() == contacts.size()
                        ? note
                        : fmt::format("{}: {}", fmt::join(labels, ", "), note));
  }
  return notes;
}

}  // namespace handgraft::client
