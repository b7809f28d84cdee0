#pragma once

#include <string>

#include "client/present/json_output.h"

namespace handgraft::client::editor {

/// Of what a command has to say: lines for people, each ended, and an object for programs.
struct CommandOutput {
  std::string text;
  json::Json data = json::Json::object();
};

}  // namespace handgraft::client::editor
