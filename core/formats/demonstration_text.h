#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

/// What stands in files that the server and its clients read alike.
namespace handgraft::formats {

inline constexpr const char* kDemonstrationFormat = "handgraft-demonstration/1";

/// A human hand at one time.
struct DemonstrationFrame {
  double time_s = 0.0;
  /// 21 joints' places in W, x y z of each (m); or MANO's 48 pose parameters (rad), then its
  /// translation's three (m).
  std::vector<double> values;
  std::array<double, 7> object_pose{};  ///< X_WO: x y z (m), qw qx qy qz as they were written
};

/// A human hand over time, as `handgraft-demonstration/1` has it (core/io/FORMATS.md).
struct Demonstration {
  std::string object;  ///< as the file names it; empty: it does not
  bool is_left = false;
  bool is_mano = false;
  std::vector<DemonstrationFrame> frames;  ///< at least one; their times grow
  /// For whoever recorded it: frames that were left out, gaps in time, what is not read.
  std::vector<std::string> notes;
};

/// Of JSON, or of NumPy's `.npz` (demonstration_arrays.h). Frames that the tracker lost, `null`
/// or NaN in place of a number, are left out and noted.
/// Errors: InvalidInput naming the field and the frame, or where the JSON ends to be such.
Demonstration parseDemonstration(std::string_view bytes);

/// The same of JSON that was parsed, or made.
Demonstration demonstrationFrom(const nlohmann::json& root);

}  // namespace handgraft::formats
