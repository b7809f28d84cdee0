#pragma once

#include <string>
#include <variant>

#include "client/cli/commands/commands.h"

namespace handgraft::client {

/// What the user asked for.
struct Invocation {
  CommonOptions common;
  CommandOptions command;
};

/// Text to print instead: `--help`, `--version`.
struct Printout {
  std::string text;
};

/// How long a command may take where no `--timeout` says otherwise, s; 0: for ever, where it
/// follows what others do or is a study.
double longestOf(const CommandOptions& command);

/// Reads the command line. `argv[0]` is the program's name.
/// Errors: InvalidInput, naming the option, its value and what it may be.
std::variant<Invocation, Printout> parseCommandLine(int argc, const char* const* argv);

}  // namespace handgraft::client
