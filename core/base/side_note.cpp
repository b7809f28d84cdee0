#include "core/base/side_note.h"

#include "core/base/error.h"

namespace handgraft {

std::string otherSideNote(const std::string& touched, const std::string& of_hand) {
  if (touched.empty() || of_hand.empty() || touched == of_hand) return "";
  // Whoever says --mirror already has the other hand by it.
  return fmt::format(
      "a {} hand touched, and this is a {} one: its mirror may reach more (give its URDF with "
      "--mirror, or without it if this hand is mirrored)",
      touched, of_hand);
}

}  // namespace handgraft
