#pragma once

#include <filesystem>
#include <string>

#include "client/link/client.h"
#include "client/present/contacts_picture.h"

namespace handgraft::client {

/// What the commands that make contacts bring out of them.
struct ContactsOutput {
  std::filesystem::path set;  ///< empty: not written; likewise the next
  std::filesystem::path png;
  bool json = false;
};

/// Has the server describe the contacts, writes the files, and returns what to print. The hand,
/// if it has links, is in the picture.
/// Errors: those of the server and of files that cannot be written.
std::string outputOf(Client& server,
                     const std::string& contacts,
                     const PosedLinks& hand,
                     const ContactsOutput& output);

}  // namespace handgraft::client
