#pragma once

#include <string>
#include <vector>

#include "idl/models.h"
#include "idl/studies.h"

/// What `--vary` and `--set` say. Errors everywhere: InvalidInput naming the option's text,
/// what is wrong with it and what it may be.
namespace handgraft::client {

/// A property of a hand and the values that it takes.
struct StudyAxis {
  std::string name;  ///< as the user wrote it: `thumb_mcp.upper`
  v1::SweepAxis axis;
  bool in_degrees = false;  ///< the user wrote them so; `axis` has radians

  /// A value of `axis` as the user would write it.
  [[nodiscard]] double shown(double value) const;
};

/// `NAME.PROPERTY=FROM:TO:COUNT` (both ends included) or `NAME.PROPERTY=A,B,C`. NAME is a joint
/// for lower, upper, range, a link for length, size; `hand.size` is the whole hand's. Angles
/// may be in degrees: `30deg:90deg:7`.
StudyAxis axisFrom(const std::string& text);

/// `NAME.PROPERTY=VALUE`.
v1::HandChange changeFrom(const std::string& text);

/// A line for each axis whose limits are hardly meant: degrees taken for radians, or mm for m.
std::vector<std::string> notesOn(const std::vector<StudyAxis>& axes,
                                 const v1::HandDescription& hand);

}  // namespace handgraft::client
