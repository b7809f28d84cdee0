#pragma once

#include <string>
#include <vector>

#include "client/present/render/image.h"
#include "idl/hardware.h"

namespace handgraft::client {

/// What a bridge told of one hand for a while. Rad, m of joints that slide, a row a sample, a
/// column a joint; NaN where nothing was told (no power: no command).
struct BridgeRun {
  std::vector<std::string> joints;
  std::vector<bool> slides;    ///< one per joint
  std::vector<double> time_s;  ///< since the first sample
  std::vector<std::string> state;
  std::vector<std::vector<double>> measured;
  std::vector<std::vector<double>> command;
  std::vector<std::vector<double>> target;
  std::vector<std::vector<double>> residual;
  std::size_t cut_line = 0;  ///< of a file read, a last line that is not whole; 0: none

  [[nodiscard]] std::size_t size() const { return time_s.size(); }

  /// Adds a sample; false, and nothing changes, if it has no joints, is not newer than the last
  /// one, or is of another hand.
  bool add(const v1::JointState& sample);

 private:
  std::int64_t first_ns_ = 0;
  std::int64_t last_ns_ = 0;
};

/// CSV with a heading: time_s, state, and of each joint `NAME measured_rad`, command, target
/// and residual, `_m` of one that slides. What was not told is an empty field.
std::string toCsv(const BridgeRun& run);

/// What `toCsv` wrote. A last line without its end was cut off, as by a full disk: it is left
/// out and noted. Errors: InvalidInput naming the line and what is wrong with it.
BridgeRun bridgeRunOf(const std::string& csv);

/// Measured against commanded: the joints that moved most (a jaw by 1 cm as much as a finger by
/// 0.1 rad), at most `most` of them, and below them the largest difference of all that turn and
/// of all that slide. Errors: InvalidInput without samples.
render::Image drawRun(const BridgeRun& run, std::size_t most = 4);

}  // namespace handgraft::client
