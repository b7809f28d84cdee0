#include "client/editor/command_table.h"

#include "client/editor/edit_builders.h"

namespace handgraft::client::editor {

namespace {

std::span<const Command> otherCommands() {
  // clang-format off
  static constexpr Command kRows[] = {
      // === Looking
      {"show", "the last solution, patch by patch; of a motion, the hand over time, and after `at TIME` that frame", Action::kShow},
      {"show TOPIC", "what a session is made of", Action::kShow},
      {"suggest PATCH --reach LENGTH --count COUNT --apply COUNT", "places on the hand nearby where a patch loses fewer points; --apply takes one", Action::kSuggest},
      {"watch", "follow the session until Ctrl-C", Action::kWatch},
      {"watch NUMBER", "so many seconds", Action::kWatch},
      {"png FILE", "draw the last solution from two sides; of a motion, a strip of frames and a plot", Action::kPicture},
      // === Files
      {"export FORMAT FILE", "write the last solution for other programs", Action::kExport},
      {"save FILE", "write all of the session: state, history, snapshots, log", Action::kSave},
      {"load FILE", "open a session of such a file and go on there", Action::kLoad},
      {"replay FILE", "play its log again and say whether it ends the same", Action::kReplay},
      {"!script FILE", "run the commands of a file; the first that fails ends it", Action::kScript},
      // === Sessions
      {"sessions", "all sessions of the server", Action::kSessions},
      {"join", "go back to the session before this one", Action::kJoin},
      {"join SESSION", "go on in another session", Action::kJoin},
      {"close", "end the session and leave", Action::kClose},
      {"quit", "leave; so does Ctrl-D", Action::kQuit},
      {"help", "all commands", Action::kHelp},
      {"help COMMAND", "one of them", Action::kHelp},
  };
  // clang-format on
  return kRows;
}

}  // namespace

const std::vector<Command>& commandTable() {
  static const std::vector<Command> every_command = [] {
    std::vector<Command> table;
    for (const auto& commands :
         {patchCommands(), jointCommands(), poseCommands(), motionCommands(), modelCommands(),
          historyCommands(), otherCommands()})
      table.insert(table.end(), commands.begin(), commands.end());
    return table;
  }();
  return every_command;
}

}  // namespace handgraft::client::editor
