#pragma once

#include <string>
#include <vector>

#include "core/contact/patch.h"

namespace handgraft::contact {

/// The patches of one grasp on one object.
struct ContactSet {
  std::string name;
  /// What the object is called; empty when the file does not say.
  std::string object;
  std::vector<Patch> patches;
  /// Remarks of whoever made it ("dropped 2 specks below 30 mm2"), shown to the user.
  std::vector<std::string> notes;
};

}  // namespace handgraft::contact
