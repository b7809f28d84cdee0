#pragma once

#include <optional>

namespace handgraft::retargeting {

/// s; frames that are farther apart do not follow each other.
constexpr double kLivePause = 0.25;

/// When a hand that follows a demonstrator's is posed for the first time.
///
/// Three touches leave a hand free to turn about the object, and others come within a tenth of
/// a second of them: a hand that did not wait stood where it could not reach those, and was
/// led about the object when it should have held it.
class LiveBeginning {
 public:
  static constexpr int kTouchesToBegin = 3;
  static constexpr int kTouchesToPinch = 2;

  /// Frame by frame: whether as many touch, of two digits or more (the palm is one), and no
  /// more have come for 75 ms, or as many have touched for 250 ms. In the first frame, and
  /// behind a pause, nothing tells that more come. It stays due while as many touch.
  ///
  /// Two of two digits, a pinch, are enough where they have touched for 250 ms, or in the first
  /// frame: about the line through both the hand is then held as the demonstrator's is.
  bool isDue(double time_s, int touches, int digits);

  /// No good pose was found: it is due again 0.1 s later. False where as many have touched for
  /// a second: then any pose will do.
  bool putOff(double time_s);

 private:
  std::optional<double> last_s_;
  std::optional<double> enough_s_;  ///< since when there are as many
  std::optional<double> pinch_s_;   ///< since when two digits touch
  double grew_s_ = 0.0;
  int touches_ = 0;
  bool is_due_ = false;
  bool is_pinch_due_ = false;
  double not_before_s_ = 0.0;
};

}  // namespace handgraft::retargeting
