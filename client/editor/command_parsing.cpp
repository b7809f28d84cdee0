#include <algorithm>
#include <filesystem>
#include <numeric>

#include "client/editor/command_table.h"
#include "client/editor/quantity.h"
#include "core/base/error.h"

namespace handgraft::client::editor {

namespace fs = std::filesystem;

namespace {

struct Entry {
  const Command* command;
  Pattern pattern;
};

const std::vector<Entry>& entries() {
  static const std::vector<Entry> all_entries = [] {
    std::vector<Entry> all;
    for (const Command& command : commandTable())
      all.push_back({&command, patternOf(command.pattern)});
    return all;
  }();
  return all_entries;
}

const std::string& nameOf(const Entry& entry) {
  return entry.pattern.slots.front().literal;
}

// Levenshtein's: changes, insertions and deletions of a letter.
std::size_t editsBetween(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t changed = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({row[j] + 1, row[j + 1] + 1, changed});
    }
  }
  return row.back();
}

[[noreturn]] void rejectName(const std::string& word) {
  constexpr std::size_t kMostSlips = 2;
  std::string near;
  std::size_t least = kMostSlips + 1;
  for (const std::string& name : commandNames()) {
    const std::size_t slips = editsBetween(word.substr(0, 64), name);
    if (slips < least) {
      least = slips;
      near = name;
    }
  }
  rejectInput("{} is no command{} (help lists them)", handgraft::quoted(word),
              near.empty() ? "" : fmt::format("; did you mean {}?", near));
}

bool same(const Slot& a, const Slot& b) {
  return a.kind == b.kind && a.literal == b.literal;
}

// "lower, upper, SIDE (object, hand)"
std::string listed(const std::vector<Slot>& slots, const Names& names) {
  constexpr std::size_t kFew = 12;
  std::string line;
  for (const Slot& slot : slots) {
    line += (line.empty() ? "" : ", ") + nameOf(slot);
    const std::vector<std::string>& known = choices(slot, names);
    if (known.empty() || known.size() > kFew) continue;
    line += " (";
    for (std::size_t i = 0; i < known.size(); ++i)
      line += (i == 0 ? "" : ", ") + known[i];
    line += ")";
  }
  return line;
}

/// `30 deg` in place of `30deg`.
bool isPartedUnit(const std::string& number, const std::string& unit) {
  return quantityOf(number) && !quantityOf(unit) && quantityOf(number + unit);
}

// The complaint of the patterns that fit furthest, taken together.
[[noreturn]] void rejectWords(const Words& words,
                              const std::vector<Match>& matches,
                              const Names& names) {
  std::size_t furthest = 0;
  for (const Match& match : matches)
    furthest = std::max(furthest, match.place);
  std::vector<Slot> expected;
  std::string objection;
  for (const Match& match : matches) {
    if (match.place != furthest) continue;
    for (const Slot& slot : match.expected) {
      const bool known = std::any_of(expected.begin(), expected.end(), [&](const Slot& other) {
        return same(slot, other);
      });
      if (!known) expected.push_back(slot);
    }
    if (objection.empty()) objection = match.objection;
  }
  std::string begun;
  for (std::size_t i = 0; i < std::min(furthest, words.size()); ++i)
    begun += (i == 0 ? "" : " ") + asWord(words[i]);
  if (furthest >= words.size()) {
    rejectInput("{}: there must follow {}", begun, listed(expected, names));
  }
  if (furthest > 0 && isPartedUnit(words[furthest - 1], words[furthest])) {
    const std::string whole = words[furthest - 1] + words[furthest];
    rejectInput("{}: {} may not stand alone; write {}", begun,
                handgraft::quoted(words[furthest]), whole);
  }
  if (expected.empty()) {
    rejectInput("{}: nothing may follow, but there is {}", begun,
                handgraft::quoted(words[furthest]));
  }
  if (expected.size() == 1 && !objection.empty()) rejectInput("{}: {}", begun, objection);
  rejectInput("{}: {} may not stand here, but {}", begun, handgraft::quoted(words[furthest]),
              listed(expected, names));
}

std::vector<std::string> filesThatBegin(const std::string& prefix) {
  const std::size_t slash = prefix.rfind('/');
  const std::string folder =
      slash == std::string::npos ? std::string() : prefix.substr(0, slash + 1);
  const std::string begin = prefix.substr(folder.size());
  std::vector<std::string> found;
  std::error_code error;
  for (fs::directory_iterator file(folder.empty() ? "." : folder, error), end;
       !error && file != end; file.increment(error)) {
    const std::string name = file->path().filename().string();
    if (name.rfind(begin, 0) != 0 || (begin.empty() && name.front() == '.')) continue;
    std::error_code unknown;
    found.push_back(folder + name + (file->is_directory(unknown) ? "/" : ""));
  }
  return found;
}

}  // namespace

const std::vector<std::string>& commandNames() {
  static const std::vector<std::string> command_names = [] {
    std::vector<std::string> names;
    for (const Entry& entry : entries()) {
      if (names.empty() || names.back() != nameOf(entry)) names.push_back(nameOf(entry));
    }
    return names;
  }();
  return command_names;
}

Parsed parse(const Words& words, const Names& names) {
  HANDGRAFT_REQUIRE(!words.empty());
  Names all = names;
  all.commands = commandNames();
  std::vector<Match> matches;
  for (const Entry& entry : entries()) {
    if (nameOf(entry) != words.front()) continue;
    matches.push_back(match(entry.pattern, words, all));
    if (matches.back().complete) return {entry.command, std::move(matches.back())};
  }
  if (matches.empty()) rejectName(words.front());
  rejectWords(words, matches, all);
}

std::string helpFor(const Words& words, const Names& names) {
  Names all = names;
  all.commands = commandNames();
  std::vector<const Entry*> fitting;
  for (const Entry& entry : entries()) {
    const Match so_far = match(entry.pattern, words, all);
    if (so_far.complete || so_far.place == words.size()) fitting.push_back(&entry);
  }
  std::string text;
  for (const Entry* entry : fitting) {
    text += fmt::format("{}\n    {}\n", entry->command->pattern, entry->command->help);
    for (const Slot& slot : entry->pattern.slots) {
      if (slot.kind != Kind::kFormat) continue;
      text += fmt::format("    FORMAT: {}\n", fmt::join(choices(slot, all), ", "));
    }
  }
  return text;
}

std::vector<std::string> completions(const Words& words,
                                     const std::string& prefix,
                                     const Names& names) {
  Names all = names;
  all.commands = commandNames();
  std::vector<std::string> candidates;
  const auto offer = [&](const std::string& word) {
    if (word.rfind(prefix, 0) == 0) candidates.push_back(word);
  };
  for (const Entry& entry : entries()) {
    for (const Slot& slot : following(entry.pattern, words, all)) {
      if (slot.kind == Kind::kLiteral) offer(slot.literal);
      for (const std::string& word : choices(slot, all))
        offer(word);
      if (slot.kind != Kind::kFile) continue;
      for (const std::string& file : filesThatBegin(prefix))
        offer(file);
    }
  }
  std::sort(candidates.begin(), candidates.end());
  candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
  return candidates;
}

}  // namespace handgraft::client::editor
