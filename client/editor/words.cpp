#include "client/editor/words.h"

#include "core/base/error.h"

namespace handgraft::client::editor {

namespace {

bool isBlank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

struct Scan {
  std::vector<Words> commands{1};
  std::string word;
  bool in_word = false;
  bool comment = false;
  char quote = 0;               // open one
  std::size_t quote_place = 0;  // where it opened

  void endWord() {
    if (!in_word) return;
    commands.back().push_back(word);
    word.clear();
    in_word = false;
  }
};

Scan scan(const std::string& line) {
  Scan scan;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (scan.quote != 0) {
      if (c == scan.quote) {
        scan.quote = 0;
      } else {
        scan.word += c;
      }
    } else if (c == '\'' || c == '"') {
      scan.quote = c;
      scan.quote_place = i;
      scan.in_word = true;  // "" is a word, too
    } else if (isBlank(c)) {
      scan.endWord();
    } else if (c == ';') {
      scan.endWord();
      scan.commands.emplace_back();
    } else if (c == '#' && !scan.in_word) {
      scan.comment = true;
      break;
    } else {
      scan.word += c;
      scan.in_word = true;
    }
  }
  return scan;
}

}  // namespace

std::vector<Words> commandsOf(const std::string& line) {
  Scan all = scan(line);
  if (all.quote != 0) {
    rejectInput("the quote at column {} is not closed: {}", all.quote_place + 1,
                handgraft::quoted(line.substr(all.quote_place)));
  }
  all.endWord();
  std::vector<Words> commands;
  for (Words& words : all.commands) {
    if (!words.empty()) commands.push_back(std::move(words));
  }
  return commands;
}

Unfinished unfinishedOf(const std::string& line) {
  Scan all = scan(line);
  return {std::move(all.commands.back()), all.word, all.quote, all.comment};
}

std::string asWord(const std::string& text) {
  const bool plain = !text.empty() && text.find_first_of(" \t\r\n;'\"") == std::string::npos &&
                     text.front() != '#';
  if (plain) return text;
  const char quote = text.find('"') == std::string::npos ? '"' : '\'';
  return quote + text + quote;
}

}  // namespace handgraft::client::editor
