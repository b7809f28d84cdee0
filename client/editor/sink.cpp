#include "client/editor/sink.h"

#include <cstdio>

#include <fmt/format.h>

#include "client/present/text_output.h"

namespace handgraft::client::editor {

// Lines are read by other programs while this one runs.
void Sink::print(const std::string& text) const {
  progress_.clear();
  fmt::print("{}", text);
  std::fflush(stdout);
}

void Sink::echo(const std::string& command) const {
  if (!isJson()) print(fmt::format("> {}\n", command));
}

void Sink::begin(const std::string& text) const {
  if (!isJson()) print(text);
}

void Sink::done(const std::string& command, const CommandOutput& output) const {
  if (!isJson()) {
    print(output.text);
    return;
  }
  json::Json line = {{"command", command}, {"ok", true}};
  line.update(output.data);
  print(json::written(line, -1) + "\n");
}

void Sink::failed(const std::string& command, const Failure& failure) const {
  if (isJson()) {
    const json::Json line = {{"command", command},
                             {"ok", false},
                             {"error", failure.message},
                             {"exit_code", failure.exit_code}};
    print(json::written(line, -1) + "\n");
  } else {
    progress_.clear();
    fmt::print(stderr, "{}\n", failure.message);
  }
}

void Sink::event(const std::string& text, const std::string& json) const {
  print((isJson() ? json : text) + "\n");
}

void Sink::note(const std::string& line) const {
  if (!isJson()) print(line + "\n");
}

}  // namespace handgraft::client::editor
