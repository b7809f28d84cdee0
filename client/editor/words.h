#pragma once

#include <string>
#include <vector>

/// A line of the editor, cut into words.
///
/// Words are separated by blanks; `;` ends a command, `#` at the start of a word ends the line.
/// Quotes, single or double, hold blanks and signs together; there is no escape character.
namespace handgraft::client::editor {

/// One command's words.
using Words = std::vector<std::string>;

/// The commands of a line; empty ones are left out.
/// Errors: InvalidInput for a quote that is not closed, naming where it opens.
std::vector<Words> commandsOf(const std::string& line);

/// What stands before the cursor, for completion.
struct Unfinished {
  Words words;         ///< of the last command, whole
  std::string prefix;  ///< what has been written of the next one
  char quote = 0;      ///< that the next one began with; 0: none
  bool comment = false;
};

Unfinished unfinishedOf(const std::string& line);

/// The word as it must be written to be read as it is.
std::string asWord(const std::string& text);

}  // namespace handgraft::client::editor
