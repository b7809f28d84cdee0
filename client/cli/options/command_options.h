#pragma once

#include "client/cli/commands/commands.h"

namespace CLI {
class App;
}  // namespace CLI

/// The options of each command, grouped by subject. Each function adds its commands to `app`;
/// the command that the user gave writes its options into `chosen` at the end of the parsing.
namespace handgraft::client {

void addModelCommands(CLI::App& app, CommandOptions& chosen);    ///< models load unload
void addGraspCommand(CLI::App& app, CommandOptions& chosen);     ///< grasp
void addSessionCommands(CLI::App& app, CommandOptions& chosen);  ///< sessions transfer ...
void addEditorCommands(CLI::App& app, CommandOptions& chosen);   ///< edit export session
void addViewCommand(CLI::App& app, CommandOptions& chosen);      ///< view
void addStudyCommands(CLI::App& app, CommandOptions& chosen);    ///< sweep
void addMotionCommands(CLI::App& app, CommandOptions& chosen);   ///< motion
void addVary(CLI::App& hand, CommandOptions& chosen);            ///< hand vary
void addBridgeCommands(CLI::App& app, CommandOptions& chosen);   ///< bridge
void addKeysCommands(CLI::App& app, CommandOptions& chosen);     ///< keys
void addImportCommands(CLI::App& app, CommandOptions& chosen);   ///< hand skin contacts

}  // namespace handgraft::client
