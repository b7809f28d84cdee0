#include "client/editor/grammar.h"

#include <algorithm>

#include "client/present/export_file.h"
#include "core/base/error.h"
#include "idl/fields.h"

namespace handgraft::client::editor {

namespace {

struct KindInfo {
  Kind kind;
  const char* name;
  const char* what;  // for complaints: "'x' is no ..."
};

constexpr KindInfo kKinds[] = {
    {Kind::kPatch, "PATCH", "patch"},
    {Kind::kJoint, "JOINT", "joint"},
    {Kind::kSite, "SITE", "site of the hand"},
    {Kind::kPoint, "POINT", "site or link of the hand"},
    {Kind::kSide, "SIDE", "side"},
    {Kind::kNumber, "NUMBER", "number"},
    {Kind::kCount, "COUNT", "whole number"},
    {Kind::kAngle, "ANGLE", "angle; write 0.3 (rad) or 15deg"},
    {Kind::kLength, "LENGTH", "length; write 0.02 (m) or 20mm"},
    {Kind::kValue, "VALUE", "joint value; write 0.3 (rad, or m if it slides), 15deg or 20mm"},
    {Kind::kFile, "FILE", "file"},
    {Kind::kHand, "HAND", "hand"},
    {Kind::kObject, "OBJECT", "object"},
    {Kind::kName, "NAME", "name"},
    {Kind::kSnapshot, "SNAPSHOT", "snapshot"},
    {Kind::kSession, "SESSION", "session's number"},
    {Kind::kCommand, "COMMAND", "command"},
    {Kind::kFormat, "FORMAT", "format"},
    {Kind::kTopic, "TOPIC", "topic"},
    {Kind::kSolver, "SOLVER", "solver"},
    {Kind::kNormalForm, "FORM", "form of the normals' term"},
};

const KindInfo& infoOf(Kind kind) {
  const auto* found = std::find_if(std::begin(kKinds), std::end(kKinds), [&](const auto& info) {
    return info.kind == kind;
  });
  HANDGRAFT_REQUIRE(found != std::end(kKinds));
  return *found;
}

bool isUpper(std::string_view word) {
  return !word.empty() && word.front() >= 'A' && word.front() <= 'Z';
}

Slot slotOf(const std::string& word) {
  if (!isUpper(word)) return {Kind::kLiteral, word};
  for (const KindInfo& info : kKinds) {
    if (word == info.name) return {info.kind, ""};
  }
  throw BrokenContract("a kind that the grammar does not know");
}

// The server judges these: a model that this program does not know may be one.
bool isOpen(Kind kind) {
  return kind == Kind::kHand || kind == Kind::kObject || kind == Kind::kSnapshot ||
         kind == Kind::kFile || kind == Kind::kName;
}

std::string listed(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 40;
  std::string line;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i)
    line += (i == 0 ? "" : ", ") + names[i];
  if (names.size() > kMost) line += fmt::format(" and {} more", names.size() - kMost);
  return line;
}

// Fills `value` and returns "", or says what is wrong with the word.
std::string read(const Slot& slot, const std::string& word, const Names& names, Value& value) {
  value.text = word;
  const auto no = [&] {
    return fmt::format("{} is no {}", handgraft::quoted(word), infoOf(slot.kind).what);
  };
  switch (slot.kind) {
    case Kind::kLiteral:
      return word == slot.literal ? "" : handgraft::quoted(word);
    case Kind::kCount:
    case Kind::kSession: {
      const auto count = countOf(word);
      if (!count) return no();
      value.count = *count;
      return "";
    }
    case Kind::kNumber:
    case Kind::kAngle:
    case Kind::kLength:
    case Kind::kValue: {
      const auto quantity = quantityOf(word);
      const bool fits =
          quantity && (quantity->unit == Unit::kNone || slot.kind == Kind::kValue ||
                       (slot.kind == Kind::kAngle && quantity->unit == Unit::kAngle) ||
                       (slot.kind == Kind::kLength && quantity->unit == Unit::kLength));
      if (!fits) return no();
      value.number = quantity->value;
      value.unit = quantity->unit;
      return "";
    }
    default:
      break;
  }
  if (word.empty()) return fmt::format("a {} cannot be empty", infoOf(slot.kind).what);
  if (isOpen(slot.kind)) return "";
  const std::vector<std::string>& known = choices(slot, names);
  if (std::find(known.begin(), known.end(), word) != known.end()) return "";
  if (const auto follower = names.followers.find(word);
      slot.kind == Kind::kJoint && follower != names.followers.end()) {
    return fmt::format("{} follows joint {} and cannot be moved by itself",
                       handgraft::quoted(word), handgraft::quoted(follower->second));
  }
  return fmt::format("{}; there {} {}", no(), known.size() == 1 ? "is" : "are",
                     known.empty() ? "none" : listed(known));
}

const OptionSlot* optionOf(const Pattern& pattern, const std::string& word) {
  const auto found =
      std::find_if(pattern.options.begin(), pattern.options.end(), [&](const auto& option) {
        return option.name == word;
      });
  return found == pattern.options.end() ? nullptr : &*found;
}

// Options that may still be given.
std::vector<Slot> optionsLeft(const Pattern& pattern, const Match& so_far) {
  std::vector<Slot> left;
  for (const OptionSlot& option : pattern.options) {
    if (so_far.options.count(option.name) == 0) left.push_back({Kind::kLiteral, option.name});
  }
  return left;
}

}  // namespace

Pattern patternOf(std::string_view text) {
  Pattern pattern;
  const Words words = commandsOf(std::string(text)).front();
  for (const std::string& word : words) {
    if (word.rfind("--", 0) == 0) {
      pattern.options.push_back({word, {}});
    } else if (!pattern.options.empty()) {
      HANDGRAFT_REQUIRE(isUpper(word) && pattern.options.back().value.empty());
      pattern.options.back().value.push_back(slotOf(word));
    } else {
      pattern.slots.push_back(slotOf(word));
    }
  }
  return pattern;
}

Match match(const Pattern& pattern, const Words& words, const Names& names) {
  Match result;
  std::size_t& place = result.place;
  const auto take = [&](const Slot& slot, Value& value) {
    result.expected = {slot};
    if (place >= words.size()) return false;
    const std::string objection = read(slot, words[place], names, value);
    if (!objection.empty()) {
      if (slot.kind != Kind::kLiteral) result.objection = objection;
      return false;
    }
    ++place;
    return true;
  };

  for (const Slot& slot : pattern.slots) {
    Value value;
    if (!take(slot, value)) return result;
    if (slot.kind != Kind::kLiteral) result.values.push_back(std::move(value));
  }
  while (place < words.size()) {
    const OptionSlot* option = optionOf(pattern, words[place]);
    if (option == nullptr || result.options.count(option->name) != 0) {
      result.expected = optionsLeft(pattern, result);
      if (option != nullptr) result.objection = option->name + " is given twice";
      return result;
    }
    ++place;
    Value value;
    for (const Slot& slot : option->value) {
      if (!take(slot, value)) return result;
    }
    result.options.emplace(option->name, std::move(value));
  }
  result.complete = true;
  result.expected = optionsLeft(pattern, result);
  return result;
}

std::vector<Slot> following(const Pattern& pattern, const Words& words, const Names& names) {
  const Match so_far = match(pattern, words, names);
  if (so_far.complete) return so_far.expected;
  return so_far.place == words.size() ? so_far.expected : std::vector<Slot>();
}

std::string nameOf(const Slot& slot) {
  return slot.kind == Kind::kLiteral ? slot.literal : infoOf(slot.kind).name;
}

const std::vector<std::string>& choices(const Slot& slot, const Names& names) {
  static const std::vector<std::string> none;
  static const std::vector<std::string> sides = idl::namesOf(idl::typeOf<v1::PatchSide>());
  static const std::vector<std::string> topics = {"session",  "patches",   "joints",
                                                  "settings", "minima",    "history",
                                                  "transfer", "snapshots", "times"};
  static const std::vector<std::string> solvers = idl::namesOf(idl::typeOf<v1::Solver>());
  static const std::vector<std::string> forms = idl::namesOf(idl::typeOf<v1::NormalForm>());
  switch (slot.kind) {
    case Kind::kNormalForm:
      return forms;
    case Kind::kPatch:
      return names.patches;
    case Kind::kJoint:
      return names.joints;
    case Kind::kSite:
      return names.sites;
    case Kind::kPoint:
      return names.points;
    case Kind::kHand:
      return names.hands;
    case Kind::kObject:
      return names.objects;
    case Kind::kSnapshot:
      return names.snapshots;
    case Kind::kSession:
      return names.sessions;
    case Kind::kCommand:
      return names.commands;
    case Kind::kSide:
      return sides;
    case Kind::kFormat:
      return exportFormats();
    case Kind::kTopic:
      return topics;
    case Kind::kSolver:
      return solvers;
    default:
      return none;
  }
}

}  // namespace handgraft::client::editor
