#pragma once

#include <string>

namespace handgraft {

/// What to tell who has a `touched` hand's contacts on an `of_hand` one; both are "right",
/// "left", or "" where it is not known. Empty: nothing to tell.
std::string otherSideNote(const std::string& touched, const std::string& of_hand);

}  // namespace handgraft
