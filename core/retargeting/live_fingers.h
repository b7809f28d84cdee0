#pragma once

#include <string>
#include <vector>

#include "core/hand/anatomy.h"
#include "core/session/dealing.h"

namespace handgraft::retargeting {

/// Which of a hand's fingers shows which of a demonstrator's digits, while these come and go.
///
/// Digits are named as touches name them; lists of them are in order (session::inOrder).
class LiveFingers {
 public:
  /// Keeps a reference.
  explicit LiveFingers(const hand::Anatomy& anatomy) : anatomy_(&anatomy) {}

  [[nodiscard]] const session::Dealing& dealing() const { return dealing_; }

  /// Null: none shows it.
  [[nodiscard]] const std::string* fingerFor(const std::string& digit) const;

  /// To choose among while these touch, one at least: each to the finger of its name where the
  /// hand has all of a human's.
  [[nodiscard]] std::vector<session::Dealing> waysFor(
      const std::vector<std::string>& touching) const;

  /// From now on, and the best that is known while these touch.
  void choose(session::Dealing dealing, std::vector<std::string> touching);

  [[nodiscard]] bool isChosenFor(const std::vector<std::string>& touching) const {
    return touching == chosen_for_;
  }

  /// Gives fingers to those of `touching` that have none: free ones, if need be of digits that
  /// are not among `present`, whose touches have faded.
  void take(const std::vector<std::string>& touching, const std::vector<std::string>& present);

  /// Whether one of these has none.
  [[nodiscard]] bool lacksOneFor(const std::vector<std::string>& touching) const;

 private:
  const hand::Anatomy* anatomy_;
  session::Dealing dealing_;  ///< of the digits that have touched
  std::vector<std::string> chosen_for_;
};

}  // namespace handgraft::retargeting
