#pragma once

#include <string>

#include "client/editor/command_output.h"
#include "client/present/failure.h"
#include "client/present/progress_line.h"

namespace handgraft::client::editor {

/// Where the editor writes: lines for people, or one JSON object a line.
///
/// Objects: {"command", "ok": true, ...} of each command done, {"command", "ok": false,
/// "error", "exit_code"} of one that failed, {"event", ...} of what happens meanwhile.
class Sink {
 public:
  enum class Form { kText, kJson };

  /// Clears `progress` before it writes.
  Sink(Form form, ProgressLine& progress) : form_(form), progress_(progress) {}

  [[nodiscard]] bool isJson() const { return form_ == Form::kJson; }

  /// Of a script's command, before it runs; nothing in JSON, whose objects name it.
  void echo(const std::string& command) const;
  /// What is known of a command's answer before all of it is: the beginning of its text.
  /// Nothing in JSON.
  void begin(const std::string& text) const;
  void done(const std::string& command, const CommandOutput& output) const;
  /// In text, on standard error.
  void failed(const std::string& command, const Failure& failure) const;
  /// Something that happens while a command runs, or between two. `json` is one object on a
  /// line.
  void event(const std::string& text, const std::string& json) const;
  /// For people alone.
  void note(const std::string& line) const;

 private:
  void print(const std::string& text) const;

  Form form_;
  ProgressLine& progress_;
};

}  // namespace handgraft::client::editor
