#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "core/contact/finger_assignment.h"

namespace handgraft::io {

/// Reads the joints of the hand that touched: JSON, 21 places `[x, y, z]` in the object's
/// frame, metres, wrist first, then thumb, index, middle, ring, little, each from base to tip.
///
/// Understands the bare list, an object that holds it as `joints`, and
/// ContactPose's annotations, whose `hands` say which of two are `valid`; other fields are
/// passed over. `hand` picks one of several: 0 left, 1 right in ContactPose. Errors:
/// InvalidInput naming the file and what is wrong; if there are two valid hands and `hand` is
/// not given.
contact::HandJoints readHandJoints(const std::filesystem::path& path,
                                   std::optional<int> hand = std::nullopt);

/// The hand that `readHandJoints` gives, and the other valid ones of the file.
struct HandsOfFile {
  contact::HandJoints joints;
  std::vector<contact::HandJoints> others;
};

HandsOfFile readHands(const std::filesystem::path& path,
                      std::optional<int> hand = std::nullopt);

}  // namespace handgraft::io
