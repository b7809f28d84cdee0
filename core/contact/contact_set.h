#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/contact/patch.h"

namespace handgraft::contact {

// Bounds of memory: what a file or a map asks for must not grow without end.
inline constexpr std::size_t kMostPatches = 1000;
inline constexpr std::size_t kMostPoints = 100'000;  ///< interpolation points of all patches

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
