#pragma once

#include <filesystem>
#include <string>

#include "core/base/error.h"
#include "idl/cyclone/requester.h"

namespace handgraft::client {

/// The whole of a session's file, to be sent in one request.
/// Errors: InvalidInput, naming the file, if it cannot be read, or its size and what a request
/// carries.
std::string readSessionText(const std::filesystem::path& path);

/// What `ask` brings, which sends the text of that file: where the server refuses it, its words
/// stand behind the file's name.
template <class Ask>
auto askAbout(const std::filesystem::path& path, const Ask& ask) {
  try {
    return ask();
  } catch (const idl::cyclone::Refused& refused) {
    throw idl::cyclone::Refused(refused.code(),
                                fmt::format("{}: {}", quoted(path.string()), refused.what()));
  }
}

}  // namespace handgraft::client
