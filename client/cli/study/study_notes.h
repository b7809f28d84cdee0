#pragma once

#include <string>
#include <vector>

#include "idl/models.h"

/// What is to be said of a study's hand and contacts before its values are believed.
namespace handgraft::client {

/// The contacts of one grasp, by the name that people are told it by.
struct StudyContacts {
  std::string label;
  v1::ContactsDescription described;
  std::vector<std::string> dealt = {};  ///< what was said of them on the hand
};

/// The notes that `grasp` tells of the same hand and contacts, each once: the hand's, those of
/// contacts, who touched with the other hand, and which finger took what. Where there are
/// several grasps, and a note is not of all of them, it begins with those that it is of.
std::vector<std::string> notesOn(const v1::HandDescription& hand,
                                 const std::vector<StudyContacts>& contacts);

}  // namespace handgraft::client
