#pragma once

#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "client/editor/words.h"
#include "client/present/interruption.h"

namespace handgraft::client::editor {

/// Where lines that were typed are kept: `$XDG_STATE_HOME/handgraft/edit_history`, else below
/// `~/.local/state`; empty where there is no home.
std::filesystem::path historyFile();

/// Reads lines at a terminal: history (arrows, Ctrl-R), completion (Tab), help (`?` where a
/// word could begin). The only place that sees libedit.
///
/// One at a time in a process. The terminal is in its own mode only while a line is read.
class Prompt {
 public:
  struct Help {
    /// Words that may follow and begin with a prefix.
    std::function<std::vector<std::string>(const Words&, const std::string&)> complete;
    /// What may follow, for people.
    std::function<std::string(const Words&)> explain;
    /// What happened meanwhile, a line each; asked every 50 ms.
    std::function<std::vector<std::string>()> news;
    /// What stands before the line; asked anew after news.
    std::function<std::string()> prompt;
  };

  enum class End {
    kLine,
    kInterrupted,  ///< by Ctrl-C or SIGTERM: what had been typed is dropped
    kEnd,          ///< Ctrl-D, or the terminal is gone
  };

  struct Input {
    End end = End::kEnd;
    std::string line;  ///< without its break
  };

  /// Writes to `out`. A history that cannot be read or written is done without.
  Prompt(Help help,
         Interruption& interruption,
         const std::filesystem::path& history,
         std::FILE* out);
  ~Prompt();
  Prompt(const Prompt&) = delete;
  Prompt& operator=(const Prompt&) = delete;

  Input readLine();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handgraft::client::editor
