#pragma once

#include <string>

#include "client/present/json_parts.h"

namespace handgraft::client::editor {

/// Of what a command has to say: lines for people, each ended, and an object for programs.
struct Told {
  std::string text;
  json::Json data = json::Json::object();
};

/// A document of json_output.h, to add to.
inline json::Json dataOf(const std::string& document) {
  return json::Json::parse(document, nullptr, false);
}

}  // namespace handgraft::client::editor
