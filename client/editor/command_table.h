#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "client/editor/edit_context.h"
#include "client/editor/grammar.h"
#include "idl/edits.h"

/// Every command of the editor, in one place.
namespace handgraft::client::editor {

/// What a command that is no edit does.
enum class Action {
  kEdit,
  kSolve,
  kTime,
  kShow,
  kCompare,
  kSave,
  kLoad,
  kReplay,
  kExport,
  kPicture,
  kSuggest,
  kWatch,
  kSessions,
  kJoin,
  kHelp,
  kScript,
  kQuit,
  kClose,
};

/// From a command's values to the edit that it asks for. Errors: InvalidInput.
using MakeEdit = v1::EditBody (*)(const Match& match, EditContext& context);

struct Command {
  std::string_view pattern;
  std::string_view help;
  Action action = Action::kEdit;
  MakeEdit make = nullptr;  ///< of edits alone
};

/// In the order in which help shows them; commands of one name stand together.
const std::vector<Command>& commandTable();

/// Their names, each once.
const std::vector<std::string>& commandNames();

/// A command as it was understood.
struct Parsed {
  const Command* command = nullptr;
  Match match;
};

/// `names.commands` need not be filled. Errors: InvalidInput, naming the word that is wrong and
/// what may stand there.
Parsed parse(const Words& words, const Names& names);

/// Patterns with their help, a line each, of the commands that `words` may still become; of all
/// for no words.
std::string helpFor(const Words& words, const Names& names);

/// Words that may follow `words` and begin with `prefix`, sorted, each once. File names are
/// looked up; those of folders end in `/`.
std::vector<std::string> completions(const Words& words,
                                     const std::string& prefix,
                                     const Names& names);

}  // namespace handgraft::client::editor
