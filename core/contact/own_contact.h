#pragma once

#include <string>
#include <vector>

#include "core/contact/contact_map.h"
#include "core/contact/finger_assignment.h"

namespace handgraft::contact {

/// The mean distance of a region to a hand's bones beyond which the hand did not make it. A
/// finger is 7 to 10 mm from its bones to its skin; recorded joints are some millimetres off.
inline constexpr double kFarthestBone = 0.04;  // m

/// Sets contact to 0 where another hand made it: a region above `threshold` that hangs together
/// is of the hand whose bones are nearest on average, and of none beyond kFarthestBone_m.
/// Says what it left out.
///
/// `others` may be empty. Errors: InvalidInput if nothing is left although something touches:
/// joints of another object or frame, and how far they are. Cost: O(V hands).
std::vector<std::string> keepOwnContact(ContactMap& map,
                                        double threshold,
                                        const HandJoints& own,
                                        const std::vector<HandJoints>& others);

}  // namespace handgraft::contact
